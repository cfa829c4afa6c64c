"""The gains of the multi-region wind-turbine controller.

regional_condition, regional   gains of partial and full load: decay rate, actuator limits
effort                         gains of the coherent law
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.lmi.turbine.effort import EffortDesign, EffortSettings, effort_gains
    from takagi.lmi.turbine.regional import (
        FULL_LOAD,
        PARTIAL_LOAD,
        RegionalGains,
        RegionGains,
        Requirement,
        region_gains,
        regional_gains,
    )
    from takagi.lmi.turbine.regional_condition import ActuatorBound, regional_gain_condition

__all__ = [
    "FULL_LOAD",
    "PARTIAL_LOAD",
    "ActuatorBound",
    "EffortDesign",
    "EffortSettings",
    "RegionGains",
    "RegionalGains",
    "Requirement",
    "effort_gains",
    "region_gains",
    "regional_gain_condition",
    "regional_gains",
]

_HOME = {
    "ActuatorBound": "regional_condition",
    "EffortDesign": "effort",
    "EffortSettings": "effort",
    "FULL_LOAD": "regional",
    "PARTIAL_LOAD": "regional",
    "RegionGains": "regional",
    "RegionalGains": "regional",
    "Requirement": "regional",
    "effort_gains": "effort",
    "region_gains": "regional",
    "regional_gain_condition": "regional_condition",
    "regional_gains": "regional",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.lmi.turbine.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
