r"""Linearisation of any law at its trims.

Effort-sharing law, u = gamma (e - x), x' = -nu e, F = psi'(q*): with x = nu x_I and
x_I' = omega_ref - omega,

    dT/domega        = (J/n_g) (1 - F) gamma      dT/dx_I        = -(J/n_g) (1 - F) gamma nu
    dbeta_ref/domega = F gamma / b                dbeta_ref/dx_I = -F gamma nu / b

taken at the law's own trim (psi is in it).  Paper laws: derivatives at the law's equilibrium, as a
state space, since their integrators may track each other.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.laws.effort_sharing.schedule import frozen_wake_effectiveness
from takagi.models.turbine.aerodynamics import rotor_torque_gradient
from takagi.models.turbine.trim import TrimPoint, trim
from takagi.reports.margins.turbine_loops import LocalGains

if TYPE_CHECKING:
    from control import StateSpace

    from takagi.certificates.design.turbine.result import TurbineDesign
    from takagi.models.laws.effort_sharing.law import EffortSharingLaw
    from takagi.models.laws.published.law import PublishedLaw

# A loop is left out if its share or gain is below this value.
SILENT = 1e-6


@dataclass(frozen=True, slots=True, eq=False)
class LoopPoint:
    """The loop at one wind.

    Attributes
    ----------
    point : where the law rests.   controller : its derivatives there.
    torque_acts, pitch_acts : whether each actuator answers to speed or integral.
    frozen_wake : factor on dT_r/dbeta that makes it the frozen-wake value; nan where the table's
        slope is not negative, or pitch does not act.
    """

    point: TrimPoint
    controller: LocalGains | StateSpace
    torque_acts: bool
    pitch_acts: bool
    frozen_wake: float

    @property
    def wind(self) -> float:
        """Wind [m/s]."""
        return self.point.wind


def loop_points(
    design: TurbineDesign, winds: Sequence[float]
) -> tuple[tuple[LoopPoint, ...], tuple[float, ...]]:
    """Return the loop at each wind, and the winds at which the law has no rest point."""
    found, none = [], []
    for wind in winds:
        point = _point(design, float(wind))
        if point is None:
            none.append(float(wind))
        else:
            found.append(point)
    return tuple(found), tuple(none)


def _point(design: TurbineDesign, wind: float) -> LoopPoint | None:
    law = design.effort_sharing_law
    return _effort_sharing(design, law, wind) if law is not None else _published(design, wind)


def _effort_sharing(design: TurbineDesign, law: EffortSharingLaw, wind: float) -> LoopPoint:
    turbine, table = design.turbine, law.schedule
    gamma, gamma_i = law.gain_pair(wind)
    share = law.pitch_share(wind)
    b = float(np.interp(wind, table.wind, table.effectiveness))
    gains = LocalGains(
        torque_by_speed=law.effort_torque * (1 - share) * gamma,
        torque_by_integral=-law.effort_torque * (1 - share) * gamma_i,
        pitch_by_speed=share * gamma / b,
        pitch_by_integral=-share * gamma_i / b,
    )
    region = trim(turbine, wind, speed_setpoint=design.settings.speed_setpoint).region
    speed = float(np.interp(wind, table.wind, table.rotor_speed))
    point = TrimPoint(wind, speed, table.pitch(wind, turbine), table.torque(wind, turbine), region)
    frozen = _frozen(design, point) if share > SILENT else float("nan")
    return LoopPoint(point, gains, 1 - share > SILENT, share > SILENT, frozen)


def _published(design: TurbineDesign, wind: float) -> LoopPoint | None:
    import control

    from takagi.models.laws.published.linearisation import local_loop

    law: PublishedLaw = design.law  # type: ignore[assignment]
    loop = local_loop(law, wind)
    if loop.gains is None:
        return None
    rest, gains = loop.point, loop.gains
    point = TrimPoint(wind, rest.rotor_speed, rest.pitch, rest.torque, rest.trim.region)
    rows = np.stack([gains.torque, gains.pitch])
    controller = control.ss(
        gains.integrals[:, 2:], gains.integrals[:, :2], rows[:, 2:], rows[:, :2]
    )
    torque, pitch = (bool(np.any(np.abs(row) > SILENT)) for row in rows)
    frozen = _frozen(design, point) if pitch else float("nan")
    return LoopPoint(point, controller, torque, pitch, frozen)


def _frozen(design: TurbineDesign, point: TrimPoint) -> float:
    turbine = design.turbine
    slope = rotor_torque_gradient(turbine, point.rotor_speed, point.pitch, point.wind)[1]
    static = -float(slope) / turbine.inertia
    limit = frozen_wake_effectiveness(turbine, point.wind)
    return max(limit / static, 1.0) if static > SILENT else float("nan")
