"""The gains of the multi-region wind-turbine controller.

regional_condition, regional    gains of partial and full load: decay rate, actuator limits
region_request, region_diagnosis    the request for a region; the reason why it has no gains
effort                          gains of the effort-sharing law, wind by wind
one_step/                       the same gains and the loop's quadratic functions found together
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.turbine.effort import EffortDesign, EffortSettings, effort_gains
    from takagi.lmi.turbine.one_step.design import OneStepDesign, effort_loop_reach, one_step_gains
    from takagi.lmi.turbine.one_step.loop_of_gains import LoopFamily, LoopOfGains
    from takagi.lmi.turbine.one_step.objective import Objective
    from takagi.lmi.turbine.region_request import FULL_LOAD, PARTIAL_LOAD, Requirement
    from takagi.lmi.turbine.regional import RegionalGains, RegionGains, region_gains, regional_gains
    from takagi.lmi.turbine.regional_condition import ActuatorBound, regional_gain_condition

__all__ = [
    "ActuatorBound",
    "EffortDesign",
    "EffortSettings",
    "FULL_LOAD",
    "LoopFamily",
    "LoopOfGains",
    "Objective",
    "OneStepDesign",
    "PARTIAL_LOAD",
    "RegionGains",
    "RegionalGains",
    "Requirement",
    "effort_gains",
    "effort_loop_reach",
    "one_step_gains",
    "region_gains",
    "regional_gain_condition",
    "regional_gains",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
