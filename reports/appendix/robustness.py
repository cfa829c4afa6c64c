"""Loops at the trims on the validation plant: margins for the table, responses for the figures."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from takagi.certificates.turbine_design import TurbineDesign
from takagi.models.law.coherent import CoherentLaw
from takagi.models.law.effort import effort_ramp_slope
from takagi.models.law.paper import PaperLaw
from takagi.models.turbine.trim import TrimPoint, trim
from takagi.reports.appendix.plant import DEGREES, table_winds
from takagi.reports.appendix.tex import NONE, Tex, escape, fixed
from takagi.reports.margins import LocalGains, Loops, Margins, loop_margins, loops_at_trim

if TYPE_CHECKING:
    from control import StateSpace

__all__ = ["TrimLoops", "local_controller", "margins_context", "trim_loops"]


@dataclass(frozen=True, slots=True, eq=False)
class TrimLoops:
    """The loops at one trim: where, the two broken loops, and which actuators act there.

    ``loops`` is None where the law has no equilibrium.
    """

    point: TrimPoint
    loops: Loops | None
    torque_acts: bool
    pitch_acts: bool


def trim_loops(design: TurbineDesign) -> list[TrimLoops]:
    """Return the loops at the winds of the trim table, where the law itself rests."""
    return [_at(design, v) for v in table_winds(design.turbine)]


def _at(design: TurbineDesign, wind: float) -> TrimLoops:
    point, controller = local_controller(design, wind)
    if controller is None:
        return TrimLoops(point, None, False, False)
    law = controller.controller() if isinstance(controller, LocalGains) else controller
    acts = [bool(abs(law.C[row]).max(initial=0) + abs(law.D[row]).max() > 0) for row in (0, 1)]
    return TrimLoops(point, loops_at_trim(design.turbine, point, controller), *acts)


def local_controller(
    design: TurbineDesign, wind: float
) -> tuple[TrimPoint, LocalGains | StateSpace | None]:
    """Return where the law rests at a constant wind [m/s] and its derivatives there.

    None in place of the derivatives: the law has no equilibrium at this wind.
    """
    if isinstance(design.law, PaperLaw):
        return _paper(design.law, wind)
    law = design.coherent
    if law is None:
        return trim(design.turbine, wind, speed_setpoint=design.settings.speed_setpoint), None
    return _coherent(design, law, wind)


def _coherent(
    design: TurbineDesign, law: CoherentLaw, wind: float
) -> tuple[TrimPoint, LocalGains]:
    """Return T = T_rated - E psi(-U), beta = psi(U)/b with dU = gamma d(omega) - gamma_I dx_I."""
    import numpy as np

    table, turbine = law.schedule, design.turbine
    q, b, speed = (
        float(np.interp(wind, table.wind, column))
        for column in (table.trim_effort, table.effectiveness, table.rotor_speed)
    )
    share = float(effort_ramp_slope(q, table.overlap))
    gamma_e, gamma_i = law.gain_pair(wind)
    region = trim(turbine, wind, speed_setpoint=design.settings.speed_setpoint).region
    point = TrimPoint(wind, speed, table.pitch(wind, turbine), table.torque(wind, turbine), region)
    return point, LocalGains(
        torque_by_speed=law.effort_torque * (1 - share) * gamma_e,
        torque_by_integral=-law.effort_torque * (1 - share) * gamma_i,
        pitch_by_speed=share * gamma_e / b,
        pitch_by_integral=-share * gamma_i / b,
    )


def _paper(law: PaperLaw, wind: float) -> tuple[TrimPoint, StateSpace | None]:
    import control
    import numpy as np

    from takagi.models.law.paper_linearisation import local_loop

    found = local_loop(law, wind)
    rest = found.point
    if found.gains is None:
        return rest.trim, None
    gains = found.gains
    both = np.stack([gains.torque, gains.pitch])
    controller = control.ss(
        gains.integrals[:, 2:], gains.integrals[:, :2], both[:, 2:], both[:, :2]
    )
    point = TrimPoint(wind, rest.rotor_speed, rest.pitch, rest.torque, rest.trim.region)
    return point, controller


def margins_context(loops: list[TrimLoops]) -> dict[str, Any]:
    """Return the margins table, and in which winds the law does not rest at all."""
    resting = [item for item in loops if item.loops is not None]
    lost = [f"{item.point.wind:g}" for item in loops if item.loops is None]
    return {
        "margin_rows": [_row(item, item.loops) for item in resting if item.loops is not None],
        "without_equilibrium": ", ".join(lost),
    }


def _row(item: TrimLoops, loops: Loops) -> list[Tex]:
    torque = loop_margins(loops.torque) if item.torque_acts else None
    pitch = loop_margins(loops.pitch) if item.pitch_acts else None
    return [
        fixed(item.point.wind, 1),
        escape(item.point.region),
        *_cells(torque),
        *_cells(pitch),
        fixed(loops.decay_rate, 4),
    ]


def _cells(margins: Margins | None) -> list[Tex]:
    """Return gain [dB], phase [deg], delay [s], disk alpha and M_s of one loop."""
    if margins is None:
        return [NONE] * 5
    return [
        _decibels(margins.gain_increase),
        fixed(margins.phase * DEGREES, 1),
        fixed(margins.delay, 2),
        fixed(margins.disk.alpha, 2),
        fixed(margins.sensitivity_peak, 2),
    ]


def _decibels(factor: float) -> Tex:
    return fixed(20 * math.log10(factor) if 0 < factor < math.inf else factor, 1)
