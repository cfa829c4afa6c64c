"""Robustness of linear loops: classical and disk margins, and the turbine's loops at a trim.

margins, disk       one loop: ``loop_margins``; several at once: ``mimo_disk_margins``
response            L(j omega), on a grid fine where the loop is lively
turbine_dynamics    the turbine linearised at a trim
turbine_loops       its two loops, each broken at its actuator with the other closed
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.reports.margins.disk import (
        DiskMargin,
        MimoDiskMargins,
        disk_margin,
        mimo_disk_margins,
    )
    from takagi.reports.margins.margins import Margins, loop_margins
    from takagi.reports.margins.response import LoopResponse, loop_response
    from takagi.reports.margins.turbine_dynamics import (
        FirstOrderDrive,
        SecondOrderDrive,
        Tower,
        linear_plant,
    )
    from takagi.reports.margins.turbine_loops import (
        LocalGains,
        Loops,
        break_loops,
        closed_loop_poles,
        loops_at_trim,
        pitch_loop,
        plant_at_trim,
        torque_loop,
    )

__all__ = [
    "DiskMargin",
    "FirstOrderDrive",
    "LocalGains",
    "LoopResponse",
    "Loops",
    "Margins",
    "MimoDiskMargins",
    "SecondOrderDrive",
    "Tower",
    "break_loops",
    "closed_loop_poles",
    "disk_margin",
    "linear_plant",
    "loop_margins",
    "loop_response",
    "loops_at_trim",
    "mimo_disk_margins",
    "pitch_loop",
    "plant_at_trim",
    "torque_loop",
]

_HOME = {
    "DiskMargin": "disk",
    "FirstOrderDrive": "turbine_dynamics",
    "LocalGains": "turbine_loops",
    "LoopResponse": "response",
    "Loops": "turbine_loops",
    "Margins": "margins",
    "MimoDiskMargins": "disk",
    "SecondOrderDrive": "turbine_dynamics",
    "Tower": "turbine_dynamics",
    "break_loops": "turbine_loops",
    "closed_loop_poles": "turbine_loops",
    "disk_margin": "disk",
    "linear_plant": "turbine_dynamics",
    "loop_margins": "margins",
    "loop_response": "response",
    "loops_at_trim": "turbine_loops",
    "mimo_disk_margins": "disk",
    "pitch_loop": "turbine_loops",
    "plant_at_trim": "turbine_loops",
    "torque_loop": "turbine_loops",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.reports.margins.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
