"""Robustness of linear loops: classical and disk margins, and the turbine's loops at a trim.

margins, disk       one loop: ``loop_margins``; several at once: ``mimo_disk_margins``
response            L(j omega), on a grid fine where the loop is lively
turbine_dynamics    the turbine linearised at a trim
turbine_loops       its two loops, each broken at its actuator with the other closed
running_over_wind   the loop that runs: validation plant, observer, filters and sampling in it
running_loop        its linearisation, at the rest of running_rest, by the differences of slopes
running_search      over all winds, and all plants where a margin is least
sampled_response    L(e^(j omega T)) of it
thresholds          margins that ``takagi check --margins`` asks for
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.margins.disk import (
        DiskMargin,
        MimoDiskMargins,
        disk_margin,
        mimo_disk_margins,
    )
    from takagi.reports.margins.margins import Margins, loop_margins
    from takagi.reports.margins.response import LoopResponse, loop_response
    from takagi.reports.margins.running_loop import (
        WAKES,
        RunningLoop,
        linearised_loop,
        with_inertia,
    )
    from takagi.reports.margins.running_over_wind import (
        Mode,
        RunningMargins,
        plant_modes,
        running_margins,
        worst_of_sides,
    )
    from takagi.reports.margins.running_rest import LoopRest, NoRest, loop_rest
    from takagi.reports.margins.running_search import (
        SearchedMargins,
        searched_margins,
        wind_ranges,
        winds_between,
    )
    from takagi.reports.margins.sampled_response import broken_loops
    from takagi.reports.margins.thresholds import (
        AskedMargins,
        asked_margins,
        failed,
        measured,
        modes_met,
    )
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
    "WAKES",
    "AskedMargins",
    "DiskMargin",
    "FirstOrderDrive",
    "LocalGains",
    "LoopResponse",
    "LoopRest",
    "Loops",
    "Margins",
    "MimoDiskMargins",
    "Mode",
    "NoRest",
    "RunningLoop",
    "RunningMargins",
    "SearchedMargins",
    "SecondOrderDrive",
    "Tower",
    "asked_margins",
    "break_loops",
    "broken_loops",
    "closed_loop_poles",
    "disk_margin",
    "failed",
    "linear_plant",
    "linearised_loop",
    "loop_margins",
    "loop_response",
    "loop_rest",
    "loops_at_trim",
    "measured",
    "mimo_disk_margins",
    "modes_met",
    "pitch_loop",
    "plant_at_trim",
    "plant_modes",
    "running_margins",
    "searched_margins",
    "torque_loop",
    "wind_ranges",
    "winds_between",
    "with_inertia",
    "worst_of_sides",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
