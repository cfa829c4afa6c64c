"""The turbine's reference controller as a program, in the language of gain files.

Its equations are those of ``takagi.models.simulation.baseline``, one Euler step per sample, then
the rate limits of the actuators.  It starts from the measurements of the first sample: if the
turbine is at its trim then, so is the controller.  Nothing is proved about it.
"""

from __future__ import annotations

import json
from collections.abc import Collection, Mapping
from decimal import Decimal
from typing import Any

from takagi.certificates.checker.controller.language import LANGUAGE
from takagi.certificates.checker.controller.turbine_programs import rate_limit_program
from takagi.models.simulation.baseline import REGION_3_PITCH
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import trim
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import controller_program
from takagi.reports.output import read_words

NOT_PROVED = "not proved (the reference controller, to compare with)"
_STATED = read_words("code/baseline.toml")
_UNITS: Mapping[str, str] = _STATED["units"]


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
    names = {name: {"value": f"law.{name}", "unit": unit} for name, unit in _UNITS.items()}
    return {"name": "law", "names": names, **_STATED["law"]}
