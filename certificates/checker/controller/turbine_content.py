"""The computed part of a turbine's gain file: programs, limits, observer, rotor."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from takagi.certificates.checker.controller.decimals import exact, short
from takagi.certificates.checker.controller.texts import EQUATIONS, RAMP
from takagi.certificates.checker.controller.turbine_programs import (
    observer_program,
    rate_limit_program,
    speed_filter_program,
    torsion_filter_program,
)
from takagi.certificates.checker.kernel.reader import Number


def turbine_content(model: Any, law: Any, controller: Mapping[str, Any]) -> dict[str, Any]:
    effort_sharing = law["name"] == "coherent"
    # Imported here: only one of the two is needed.
    if effort_sharing:
        from takagi.certificates.checker.controller.effort_sharing_program import (
            effort_sharing_program,
        )

        written = effort_sharing_program(law)
    else:
        from takagi.certificates.checker.controller.published_program import published_program

        written = published_program(law)
    # A file without this member is of a law that reads the measured speed itself.
    filter_programs = []
    if "measurement" in controller:
        stopped = "torsion_filter" in controller["measurement"]
        filter_programs = [torsion_filter_program() if stopped else speed_filter_program()]
    return {
        "programs": [*filter_programs, observer_program(), written, rate_limit_program()],
        "ramp": {"overlap": law["overlap"], "formula": RAMP} if effort_sharing else None,
        "limits": {
            "torque": [Number("0"), law["rated_torque"]],
            "torque_rate": model["torque_rate_limit"],
            "pitch": [model["pitch_min"], model["pitch_max"]],
            "pitch_rate": model["pitch_rate_limit"],
            "pitch_time_constant": model["pitch_time_constant"],
        },
        "start": None if effort_sharing else controller["start"],
        "observer": {**controller["observer"], "equations": EQUATIONS},
        "rotor": _rotor(model),
    }


def _rotor(model: Any) -> dict[str, Any]:
    inertia = exact(model["rotor_inertia"])
    inertia += exact(model["gear_ratio"]) ** 2 * exact(model["generator_inertia"])
    surface = model["torque_surface"]
    return {
        "torque_constant": model["torque_constant"],
        "radius": model["rotor_radius"],
        "rotor_inertia": model["rotor_inertia"],
        "generator_inertia": model["generator_inertia"],
        "gear_ratio": model["gear_ratio"],
        "inertia": short(inertia),
        "torque_coefficient": {
            "knots": [surface["tip_speed_ratio_knots"], surface["pitch_knots"]],
            "coefficients": surface["coefficients"],
        },
    }
