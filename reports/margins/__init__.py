"""Robustness of linear loops: classical and disk margins, and the turbine's loops at a trim.

margins, disk       one loop: ``loop_margins``; several at once: ``disk_of``
response            L(j omega), on a grid fine where the loop is lively
turbine_dynamics    the turbine linearised at a trim
turbine_loops       its two loops, each broken at its actuator with the other closed
running_over_wind   the loop that runs: validation plant, observer, filters and sampling in it
running_loop        its linearisation, at running_equilibrium, by the differences of slopes
running_stability   whether it is stable, what makes it unstable, and small margins
loops_over_wind     the loop at many winds and for some plants
least_margins       whether a loop keeps the least margins, by eigenvalues
running_search      over all winds, and all plants where a margin is least
sampled_response    L(e^(j omega T)) of it
thresholds          margins that ``takagi check --margins`` asks for
kept_margins        margins as constraints of a design, by moving what design_levers names
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.reports.margins.design_levers import LEVERS as LEVERS
    from takagi.reports.margins.design_levers import effort_of as effort_of
    from takagi.reports.margins.design_levers import free_levers as free_levers
    from takagi.reports.margins.design_levers import lever_changes as lever_changes
    from takagi.reports.margins.kept_margins import KeptMargins as KeptMargins
    from takagi.reports.margins.kept_margins import MarginSearch as MarginSearch
    from takagi.reports.margins.kept_margins import NoMargins as NoMargins
    from takagi.reports.margins.kept_margins import check_margins_asked as check_margins_asked
    from takagi.reports.margins.kept_margins import settings_with_margins as settings_with_margins
    from takagi.reports.margins.margins import DiskMargin as DiskMargin
    from takagi.reports.margins.margins import Margins as Margins
    from takagi.reports.margins.margins import disk_margin as disk_margin
    from takagi.reports.margins.margins import disk_of as disk_of
    from takagi.reports.margins.margins import loop_margins as loop_margins
    from takagi.reports.margins.response import LoopResponse as LoopResponse
    from takagi.reports.margins.response import broken_loops as broken_loops
    from takagi.reports.margins.response import loop_response as loop_response
    from takagi.reports.margins.running_loop import WAKES as WAKES
    from takagi.reports.margins.running_loop import LoopEquilibrium as LoopEquilibrium
    from takagi.reports.margins.running_loop import NoEquilibrium as NoEquilibrium
    from takagi.reports.margins.running_loop import RunningLoop as RunningLoop
    from takagi.reports.margins.running_loop import linearised_loop as linearised_loop
    from takagi.reports.margins.running_loop import loop_equilibrium as loop_equilibrium
    from takagi.reports.margins.running_loop import with_inertia as with_inertia
    from takagi.reports.margins.running_over_wind import Mode as Mode
    from takagi.reports.margins.running_over_wind import RunningMargins as RunningMargins
    from takagi.reports.margins.running_over_wind import plant_modes as plant_modes
    from takagi.reports.margins.running_over_wind import running_margins as running_margins
    from takagi.reports.margins.running_over_wind import worst_of_sides as worst_of_sides
    from takagi.reports.margins.running_search import SearchedMargins as SearchedMargins
    from takagi.reports.margins.running_search import searched_margins as searched_margins
    from takagi.reports.margins.running_search import wind_ranges as wind_ranges
    from takagi.reports.margins.running_search import winds_between as winds_between
    from takagi.reports.margins.running_stability import require_stable as require_stable
    from takagi.reports.margins.running_stability import unstable_loop as unstable_loop
    from takagi.reports.margins.thresholds import AskedMargins as AskedMargins
    from takagi.reports.margins.thresholds import asked_margins as asked_margins
    from takagi.reports.margins.thresholds import failed as failed
    from takagi.reports.margins.thresholds import measured as measured
    from takagi.reports.margins.thresholds import modes_met as modes_met
    from takagi.reports.margins.thresholds import shares_of as shares_of
    from takagi.reports.margins.turbine_loops import FirstOrderDrive as FirstOrderDrive
    from takagi.reports.margins.turbine_loops import LocalGains as LocalGains
    from takagi.reports.margins.turbine_loops import Loops as Loops
    from takagi.reports.margins.turbine_loops import SecondOrderDrive as SecondOrderDrive
    from takagi.reports.margins.turbine_loops import Tower as Tower
    from takagi.reports.margins.turbine_loops import break_loops as break_loops
    from takagi.reports.margins.turbine_loops import closed_loop_poles as closed_loop_poles
    from takagi.reports.margins.turbine_loops import linear_plant as linear_plant
    from takagi.reports.margins.turbine_loops import loops_at_trim as loops_at_trim
    from takagi.reports.margins.turbine_loops import plant_at_trim as plant_at_trim

__getattr__, __dir__ = lazy_names(__name__)
