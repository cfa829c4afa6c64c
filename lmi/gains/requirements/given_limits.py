"""Further requirements on gains, as the keywords of ``pdc`` give them."""

from __future__ import annotations

from dataclasses import dataclass

from numpy.typing import ArrayLike

from takagi.lmi.condition.region import EigenvalueRegion
from takagi.lmi.condition.uncertainty import Uncertainty
from takagi.lmi.gains.requirements.limits import Limits, limits_of
from takagi.lmi.gains.requirements.requirements import Requirements, requirements_of


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class GivenLimits:
    """Limits in the model's units, not checked yet; None where nothing is asked.

    The members are those arguments of ``pdc`` that have the same names.
    """

    input_limit: ArrayLike | None = None
    initial_box: ArrayLike | None = None
    initial_ball: ArrayLike | None = None
    state_box: ArrayLike | None = None
    gain_bound: float | None = None
    scales: ArrayLike | None = None
    sample_time: float | None = None
    region: EigenvalueRegion | None = None
    uncertainty: Uncertainty | None = None
    overlap: ArrayLike | None = None
    active_rules: int | None = None

    def limits(self, n: int, m: int) -> Limits:
        """Return the checked limits on n states, m inputs and the gains.

        Raises
        ------
        ModelError : as ``limits_of``.
        """
        return limits_of(
            n,
            m,
            input_limit=self.input_limit,
            initial_box=self.initial_box,
            initial_ball=self.initial_ball,
            state_box=self.state_box,
            gain_bound=self.gain_bound,
        )

    def requirements(self, r: int, n: int, m: int) -> Requirements:
        """Return the checked requirements on the blends of r rules.

        Raises
        ------
        ModelError : as ``requirements_of``.
        """
        return requirements_of(
            r,
            n,
            m,
            region=self.region,
            uncertainty=self.uncertainty,
            overlap=self.overlap,
            active_rules=self.active_rules,
        )
