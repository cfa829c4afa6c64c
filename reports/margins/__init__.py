"""Robustness of linear loops: classical and disk margins, and the turbine's loops at a trim.

``loop_margins`` speaks of one loop, ``mimo_disk_margins`` of several at once; ``loops_at_trim``
builds the turbine's two loops, each broken at its actuator with the other closed.
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
    from takagi.reports.margins.loops import (
        LocalGains,
        Loops,
        break_loops,
        closed_loop_poles,
        loops_at_trim,
        pitch_loop,
        plant_at_trim,
        torque_loop,
    )
    from takagi.reports.margins.margins import Margins, loop_margins
    from takagi.reports.margins.plant import (
        FirstOrderDrive,
        SecondOrderDrive,
        Tower,
        linear_plant,
    )
    from takagi.reports.margins.response import LoopResponse, loop_response

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
    "FirstOrderDrive": "plant",
    "LocalGains": "loops",
    "LoopResponse": "response",
    "Loops": "loops",
    "Margins": "margins",
    "MimoDiskMargins": "disk",
    "SecondOrderDrive": "plant",
    "Tower": "plant",
    "break_loops": "loops",
    "closed_loop_poles": "loops",
    "disk_margin": "disk",
    "linear_plant": "plant",
    "loop_margins": "margins",
    "loop_response": "response",
    "loops_at_trim": "loops",
    "mimo_disk_margins": "disk",
    "pitch_loop": "loops",
    "plant_at_trim": "loops",
    "torque_loop": "loops",
}


def __getattr__(name: str) -> object:
    if name in _HOME:
        return getattr(import_module(f"takagi.reports.margins.{_HOME[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted(__all__)
