r"""Where the published law comes to rest, and whether that is the turbine's trim.

Shared integrator.  x_I' = 0 forces omega = omega_ref.  With f_1 = f_1(omega_ref) > 0 the pitch
channel at rest says

    x_I = (1 + f_1 k^c_p) b / (f_1 k^c_I)                                              (1)

and one balance is left, T_r(omega_ref, b, v) = n_g T(k^b_I x_I(b)).  Below rated torque (1) spends
pitch that nobody asked for, in proportion to f_1; with f_1 = 0 no pitch is given at all, and above
rated wind there is no equilibrium.  A placement with f_1(omega_rated) of a few thousandths comes
near the trim in both regions on paper, but by (1) its integral must then travel some 1/f_1 as far:
so none serves regions 2.5 and 3 at once.

Two integrators.  At rest each tracks what its channel carries out:

    e = (u_1 - T)/(tau |k^b_I|) = (u_2 - beta_ref)/(tau |k^c_I|),

so both channels carry a small overspeed e together, found from the same balance (a small
underspeed, where ``sector`` raises torque above its command).  Where
f_1(omega_ref) = 1 both are content with e = 0 and any split of torque and pitch: a continuum.

All this is floating point, for a constant wind with v_hat = v.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from takagi.models.laws.published.coupling_filter import coupling_filter
from takagi.models.laws.published.equilibrium_point import Equilibrium
from takagi.models.laws.published.law import PaperLaw, PaperLawName, paper_law
from takagi.models.laws.published.one_integrator import one_integrator_rest
from takagi.models.laws.published.two_integrators import two_integrators_rest

__all__ = ["Equilibrium", "PlacementRow", "equilibria", "equilibrium", "placement_rows"]


@dataclass(frozen=True, slots=True)
class PlacementRow:
    """Which regions one placement of the ramp serves.

    Attributes
    ----------
    placement : share of the overlap above rated speed.
    kinds : region -> (winds at the intended equilibrium, winds tried), for "1.5", "2", "2.5", "3".
    worst_pitch : largest pitch offset [rad]; worst_power : smallest power ratio, where it rests.
    integral_travel : how far an integral moves over the winds that were tried [rad].
    """

    placement: float
    kinds: dict[str, tuple[int, int]]
    worst_pitch: float
    worst_power: float
    integral_travel: float

    @property
    def served(self) -> tuple[str, ...]:
        """Regions in which every wind that was tried has the intended equilibrium."""
        return tuple(region for region, (good, tried) in self.kinds.items() if good == tried)


def equilibrium(law: PaperLaw, wind: float) -> Equilibrium:
    """Return where the law rests at a constant wind [m/s], estimate exact.

    Of several equilibria of the shared integrator the one with least pitch is returned.

    Raises
    ------
    ModelError : no trim at this wind.
    """
    return (
        one_integrator_rest(law, wind) if law.name == "paper" else two_integrators_rest(law, wind)
    )


def equilibria(law: PaperLaw, winds: Iterable[float]) -> tuple[Equilibrium, ...]:
    """Return ``equilibrium`` at every wind."""
    return tuple(equilibrium(law, float(v)) for v in winds)


def placement_rows(
    law: PaperLaw,
    *,
    placements: Sequence[float] = (0.0, 0.25, 0.5, 0.75, 1.0),
    winds: Sequence[float],
    speed_overlap: float | None = None,
    name: PaperLawName | None = None,
) -> tuple[PlacementRow, ...]:
    """Return which regions each placement of the speed ramp serves.

    Parameters
    ----------
    law : everything but the placement is taken from it.
    placements : shares of the overlap above rated speed.
    winds : [m/s].
    speed_overlap : [rad/s]; None takes the law's.
    name : None takes the law's.
    """
    coupling = law.coupling
    rows = []
    for placement in placements:
        moved = coupling_filter(
            law.turbine,
            speed_overlap=coupling.speed_ramp.width if speed_overlap is None else speed_overlap,
            torque_overlap=coupling.torque_overlap,
            variant=coupling.variant,
            placement=placement,
            minimum_torque=coupling.minimum_torque,
            shape=coupling.speed_ramp.shape,
            torque_shape=coupling.shape,
            speed_setpoint=law.speed_setpoint,
        )
        tried = paper_law(
            law.turbine,
            partial=law.partial,
            full=law.full,
            coupling=moved,
            name=law.name if name is None else name,
            tracking_time=5.0 if law.tracking_time is None else law.tracking_time,
            speed_setpoint=law.speed_setpoint,
        )
        rows.append(_row(placement, equilibria(tried, winds)))
    return tuple(rows)


def _row(placement: float, found: Sequence[Equilibrium]) -> PlacementRow:
    kinds = {}
    for region in ("1.5", "2", "2.5", "3"):
        here = [point for point in found if point.trim.region == region]
        if here:
            kinds[region] = (sum(point.kind == "intended" for point in here), len(here))
    resting = [point for point in found if point.kind != "none"]
    pitches = [abs(point.pitch_offset) for point in resting]
    powers = [point.power_ratio for point in resting]
    travel = max(
        (np.ptp(x) for x in zip(*(p.integrals for p in resting), strict=True)), default=0.0
    )
    worst = max(pitches, default=0.0), min(powers, default=1.0)
    return PlacementRow(placement, kinds, *worst, float(travel))
