"""Two actuators that share one effort, handed over by a ramp, for any plant.

blending             Actuator, Blending: who acts where, and how well it is known
substitution         the plant behind the blend: one input, the rate of the effort
actuator_authority   whether the actuators can deliver what is asked of them on the box
modelling            its Takagi-Sugeno model
run_time             shares, commands and actuators over a motion, in floating point
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.models.blending.blending import Actuator, Blending
    from takagi.models.blending.modelling import blended_model
    from takagi.models.blending.run_time import RunningBlend, RunTimeBlending
    from takagi.models.blending.substitution import blended_plant
    from takagi.models.ramps.exact_effort_ramp import (
        ramp,
        ramp_slope,
        share_range,
        share_value,
    )

__all__ = [
    "Actuator",
    "Blending",
    "RunTimeBlending",
    "RunningBlend",
    "blended_model",
    "blended_plant",
    "ramp",
    "ramp_slope",
    "share_range",
    "share_value",
]

_HOME = {
    "Actuator": "takagi.models.blending.blending",
    "Blending": "takagi.models.blending.blending",
    "RunTimeBlending": "takagi.models.blending.run_time",
    "RunningBlend": "takagi.models.blending.run_time",
    "blended_model": "takagi.models.blending.modelling",
    "blended_plant": "takagi.models.blending.substitution",
    "ramp": "takagi.models.ramps.exact_effort_ramp",
    "ramp_slope": "takagi.models.ramps.exact_effort_ramp",
    "share_range": "takagi.models.ramps.exact_effort_ramp",
    "share_value": "takagi.models.ramps.exact_effort_ramp",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
