"""Two actuators that share one effort, handed over by a ramp, for any plant.

blending Actuator, Blending: where each actuator acts, and its uncertainty
substitution         the plant behind the blend: one input, the rate of the effort
actuator_authority whether the actuators can deliver the commanded effort on the box
modelling            its Takagi-Sugeno model
run_time             shares, commands and actuators over a motion, in floating point
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.models.blending.blending import Blending as Blending
    from takagi.models.blending.blending import blending_of as blending_of
    from takagi.models.blending.modelling import blended_model as blended_model
    from takagi.models.blending.run_time import RunTimeBlending as RunTimeBlending
    from takagi.models.ramps.effort_ramp import ramp as ramp
    from takagi.models.ramps.effort_ramp import ramp_slope as ramp_slope
    from takagi.models.ramps.effort_ramp import share_range as share_range
    from takagi.models.ramps.effort_ramp import share_value as share_value

__getattr__, __dir__ = lazy_names(__name__)
