"""The margins and simulated runs of a turbine's design, found once and kept in ``design.json``.

All in floating point: measured and simulated, and nothing of it is proved.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from takagi.reports.margins.running_loop import RunningLoops
from takagi.reports.margins.running_search import SearchedMargins, searched_margins
from takagi.reports.simulation.design_runs import DesignRun, design_runs

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredLoop:
    """The margins of the loop that runs, and the runs of ``design_runs``."""

    margins: SearchedMargins
    runs: tuple[DesignRun, ...]

    @property
    def drawn(self) -> dict[str, DesignRun]:
        """The runs that are drawn, by name."""
        return {run.name: run for run in self.runs if run.law.line is not None}

    @property
    def turbulent(self) -> dict[float, DesignRun]:
        """Mean wind [m/s] -> the run in turbulence."""
        return {run.wind: run for run in self.runs if run.name == "turbulence"}


NOTHING = MeasuredLoop(SearchedMargins((), (), (), ()), ())


def measured_loop(design: TurbineDesign) -> MeasuredLoop:
    """Return what ``design.json`` keeps of a design that was read; else it is found now."""
    kept = design.measured
    return kept if isinstance(kept, MeasuredLoop) else _measured_now(design)


@lru_cache(maxsize=2)
def _measured_now(design: TurbineDesign) -> MeasuredLoop:
    observer, speed_filter = design.observer.observer, design.speed_filter
    loops = RunningLoops.of(design.turbine, design.law, observer, speed_filter=speed_filter)
    return MeasuredLoop(searched_margins(loops), design_runs(design))
