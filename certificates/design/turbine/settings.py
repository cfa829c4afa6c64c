"""The settings of a turbine's design: the law, its numbers, and what its certificate covers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from takagi.certificates.claims.turbine.effort_sharing import DEFAULT_BOX, DEFAULT_UNCERTAINTY
from takagi.certificates.design.turbine.effort_sharing_gains import SYNTHESES, Synthesis
from takagi.lmi.turbine.one_step.objective import OBJECTIVES, Objective
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import DEFAULT_WIND_FILTER
from takagi.models.laws.effort_sharing.loop_cell import LoopBox, LoopUncertainty
from takagi.models.laws.effort_sharing.schedule import DEFAULT_EFFECTIVENESS_SHARE

if TYPE_CHECKING:
    from takagi.lmi.turbine.effort import EffortSettings
    from takagi.models.ramps import Shape

# The band-stop's frequency relative to the drivetrain's torsion mode, which is at 10.3 rad/s for
# 5 MW. At the mode a band-stop below it adds phase lead, a band-stop above it adds phase lag
# (docs/laws.md); hence a little below.
TORSION_SHARE = 0.9
DEFAULT_TORSION_FILTER = 9.3
# Corners in rad/s. With the band-stop the low-pass only has to remove noise. Without the band-stop
# (a turbine without a torsion mode) a corner of 8 rad/s for 5 MW saves pitch travel.
DEFAULT_SPEED_FILTER = 30.0
SPEED_FILTER_ALONE = 8.0
LAWS = ("coherent", "paper", "paper-two-integrators")


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignSettings:
    """The settings of a design; the defaults suit the NREL 5-MW turbine.

    ``takagi.certificates.design.turbine.scale.default_settings`` scales them to another turbine.

    Attributes
    ----------
    law : "coherent", "paper" or "paper-two-integrators".
    overlap : eps of the effort ramp [rad/s^2] (coherent).
    speed_overlap : eps_omega of the coupling filter [rad/s] (published laws).
    torque_overlap : eps_T of the coupling filter [N m] (published laws).
    speed_setpoint : de-rated rotor speed [rad/s]; None takes the rated speed.
    torque_setpoint : de-rated torque [N m, high-speed shaft]; None takes the rated torque.
    wind_filter : tau_f, of the effort-sharing law's low-pass on the wind estimate [s].
    effectiveness_share : b of the effort-sharing law divided by the frozen wake's pitch
        effectiveness [-].
    speed_filter : corner of the low-pass on the measured speed, which the gain file of the
        effort-sharing law contains [rad/s]; 0 for none.
    torsion_filter : frequency of the band-stop before that low-pass [rad/s]; 0 for none.
    ramp_shape, ramp_placement : shape and place of the coupling filter's ramp in speed, see
        ``coupling_filter`` (published laws).
    tracking_time : time constant of the anti-windup [s] (paper-two-integrators).
    effort : requirements on the effort-sharing gains; None takes the defaults.
    synthesis : "two-step" finds the gains wind by wind, and the loop's quadratic functions
        afterwards; "one-step" changes the gains together with the functions, for a larger claim.
    objective : the quantity that the one-step synthesis improves.
    box, uncertainty : what the effort-sharing certificate covers.
    """

    law: str = "coherent"
    overlap: float = 0.01
    speed_overlap: float = 0.1
    torque_overlap: float = 2000.0
    speed_setpoint: float | None = None
    torque_setpoint: float | None = None
    wind_filter: float = DEFAULT_WIND_FILTER
    effectiveness_share: float = DEFAULT_EFFECTIVENESS_SHARE
    speed_filter: float = DEFAULT_SPEED_FILTER
    torsion_filter: float = DEFAULT_TORSION_FILTER
    ramp_shape: Shape = "smooth"
    ramp_placement: float = 0.5
    tracking_time: float = 5.0
    effort: EffortSettings | None = None
    synthesis: Synthesis = "two-step"
    objective: Objective = OBJECTIVES["balanced"]
    box: LoopBox = DEFAULT_BOX
    uncertainty: LoopUncertainty = DEFAULT_UNCERTAINTY

    def __post_init__(self) -> None:
        if self.law not in LAWS:
            raise ModelError(f"law {self.law!r} was given; choose one of {', '.join(LAWS)}")
        if self.synthesis not in SYNTHESES:
            raise ModelError(
                f"synthesis {self.synthesis!r} was given; choose one of {', '.join(SYNTHESES)}"
            )
        overlaps = ("overlap", "speed_overlap", "torque_overlap")
        for name in (*overlaps, "wind_filter", "effectiveness_share", "tracking_time"):
            if not getattr(self, name) > 0:
                raise ModelError(f"{name} = {getattr(self, name)!r} was given; it must be positive")
        if not 0 <= self.speed_filter < math.inf:
            raise ModelError(
                f"speed_filter = {self.speed_filter!r} rad/s was given; a corner above 0 is "
                "needed, or 0 for none"
            )
        if not 0 <= self.torsion_filter < math.inf:
            raise ModelError(
                f"torsion_filter = {self.torsion_filter!r} rad/s was given; a frequency above 0 is "
                "needed, or 0 for none"
            )
        if self.torsion_filter and not self.speed_filter:
            raise ModelError(
                "speed_filter = 0 was given with a torsion_filter of "
                f"{self.torsion_filter:g} rad/s, which needs a low-pass behind it; give one, such "
                "as 30 rad/s, or torsion_filter = 0"
            )
