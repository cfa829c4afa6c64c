"""The turbine's reference controller as a program, in the language of gain files.

Its equations are those of ``takagi.models.simulation.baseline``, one Euler step per sample, then
the rate limits of the actuators.  It starts from the measurements of the first sample: if the
turbine is at its trim then, so is the controller.  Nothing is proved about it.
"""

from __future__ import annotations

import json
from collections.abc import Collection
from decimal import Decimal
from typing import Any

from takagi.certificates.checker.controller.language import (
    LANGUAGE,
    keep,
    program,
    read,
    send,
    step,
)
from takagi.certificates.checker.controller.turbine_programs import rate_limit_program
from takagi.models.simulation.baseline import REGION_3_PITCH
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import trim
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import controller_program

NOT_PROVED = "not proved (the reference controller, to compare with)"
_UNITS = {
    "gear_ratio": "-",
    "rated_speed": "rad/s",
    "speed_filter": "rad/s",
    "rated_torque": "N m",
    "maximum_torque": "N m",
    "pitch_min": "rad",
    "pitch_max": "rad",
    "region_3_pitch": "rad",
    "proportional_gain": "s",
    "integral_gain": "-",
    "schedule_pitch": "rad",
    "optimal_torque_constant": "N m s^2/rad^2",
    "region_15_speed": "rad/s",
    "region_2_speed": "rad/s",
    "region_25_speed": "rad/s",
    "region_3_speed": "rad/s",
}
_STEPS = [
    step("gain", "-", "1/(1 + max(pitch, 0)/schedule_pitch)", "schedule on the measured pitch"),
    step("scale", "-", "gain*integral_gain"),
    step("x_low", "rad", "pitch_min/scale"),
    step("x_high", "rad", "pitch_max/scale"),
    step("error", "rad/s", "w_f - gear_ratio*rated_speed", "of the filtered generator speed"),
    step("pitch_held", "rad",
         "limit(gain*(proportional_gain*error + integral_gain*limit(x, x_low, x_high)), "
         "pitch_min, pitch_max)"),
    step("region_3", "N m",
         "min(rated_torque*gear_ratio*rated_speed/max(w_f, 0.000001), maximum_torque)",
         "constant power"),
    step("torque_25", "N m", "optimal_torque_constant*region_25_speed^2"),
    step("region_25", "N m",
         "torque_25 + (rated_torque - torque_25)*(w_f - region_25_speed)"
         "/(region_3_speed - region_25_speed)"),
    step("region_2", "N m", "optimal_torque_constant*w_f^2"),
    step("region_15", "N m",
         "optimal_torque_constant*region_2_speed^2*(w_f - region_15_speed)"
         "/(region_2_speed - region_15_speed)"),
    step("region_1", "N m", "choose(region_15_speed - w_f, region_15, 0)"),
    step("by_speed", "N m",
         "choose(w_f - region_25_speed, choose(w_f - region_2_speed, region_1, region_2), "
         "region_25)"),
    step("torque_wanted", "N m",
         "choose(pitch - region_3_pitch, choose(w_f - region_3_speed, by_speed, region_3), "
         "region_3)", "by speed, and that of region 3 above a pitch"),
    step("rate_up", "rad/s", "choose(x - x_high, error, min(error, 0))",
         "the integral does not leave its range"),
    step("rate", "rad/s", "choose(x_low - x, rate_up, max(rate_up, 0))"),
]  # fmt: skip


def baseline_program(turbine: Turbine, *, without: Collection[str] = ()) -> ControllerProgram:
    """Return the baseline law of a turbine; ``without`` names programs to leave out."""
    text = json.dumps(_document(turbine))
    document = json.loads(text, parse_float=Decimal, parse_int=Decimal)
    return controller_program(document, without=without)


def _document(turbine: Turbine) -> dict[str, Any]:
    figures = turbine.reference_controller
    computed = {
        "rated_speed": turbine.rated_rotor_speed,
        "region_3_pitch": turbine.pitch_min + REGION_3_PITCH,
    }
    numbers = {
        name: computed[name] if name in computed else getattr(
            figures if hasattr(figures, name) else turbine, name)
        for name in _UNITS
    }  # fmt: skip
    points = [trim(turbine, wind) for wind in (turbine.cut_in, turbine.cut_out)]
    return {
        "format": "takagi-gains",
        "version": 3,
        "name": f"{turbine.name}, baseline law",
        "turbine": turbine.name,
        "law": {"name": "baseline", **numbers},
        "trim": {
            "wind": [turbine.cut_in, turbine.cut_out],
            "rotor_speed": [point.rotor_speed for point in points],
            "pitch": [point.pitch for point in points],
        },
        "limits": {
            "torque": [0, turbine.maximum_torque],
            "torque_rate": turbine.torque_rate_limit,
            "pitch": [turbine.pitch_min, turbine.pitch_max],
            "pitch_rate": turbine.pitch_rate_limit,
        },
        "language": LANGUAGE,
        "programs": [_law(), rate_limit_program()],
        "certificate": {"verdict": NOT_PROVED, "sha256": {}},
    }


def _law() -> dict[str, Any]:
    return program(
        "law",
        {name: (f"law.{name}", unit) for name, unit in _UNITS.items()},
        reads=[
            read("speed", "rad/s", "measured rotor speed"),
            read("pitch", "rad", "measured pitch"),
        ],
        keeps=[
            keep("w_f", "rad/s", "gear_ratio*speed",
                 "w_f + sample_time*(speed_filter*(gear_ratio*speed - w_f))",
                 "filtered generator speed"),
            keep("x", "rad", "pitch/(integral_gain/(1 + max(pitch, 0)/schedule_pitch))",
                 "x + sample_time*rate", "integral of the speed error"),
        ],
        steps=_STEPS,
        sends=[
            send("torque", "N m", "torque_wanted", "to the generator, high-speed shaft"),
            send("pitch_reference", "rad", "pitch_held", "to the pitch drive"),
        ],
    )  # fmt: skip
