"""The gains of the multi-region wind-turbine controller.

regional, region_request        gains of partial and full load; the request for a region, its LMIs
effort                          gains of the effort-sharing law, wind by wind
one_step/                       the same gains and the loop's quadratic functions found together
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.lmi.turbine.effort import GROWN as GROWN
    from takagi.lmi.turbine.effort import EffortDesign as EffortDesign
    from takagi.lmi.turbine.effort import EffortSettings as EffortSettings
    from takagi.lmi.turbine.effort import effort_gains as effort_gains
    from takagi.lmi.turbine.one_step.design import OneStepDesign as OneStepDesign
    from takagi.lmi.turbine.one_step.design import one_step_gains as one_step_gains
    from takagi.lmi.turbine.one_step.loop_of_gains import LoopOfGains as LoopOfGains
    from takagi.lmi.turbine.one_step.objective import Objective as Objective
    from takagi.lmi.turbine.region_request import FULL_LOAD as FULL_LOAD
    from takagi.lmi.turbine.region_request import PARTIAL_LOAD as PARTIAL_LOAD
    from takagi.lmi.turbine.region_request import Requirement as Requirement
    from takagi.lmi.turbine.regional import RegionalGains as RegionalGains
    from takagi.lmi.turbine.regional import RegionGains as RegionGains
    from takagi.lmi.turbine.regional import region_gains as region_gains
    from takagi.lmi.turbine.regional import regional_gains as regional_gains

__getattr__, __dir__ = lazy_names(__name__)
