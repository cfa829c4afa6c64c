"""The margins and simulated runs of a turbine's design, found once and kept in ``design.json``;
and whether the law of a gain file has the margins that are asked.

All in floating point: measured and simulated, and nothing of it is proved.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from takagi.models.turbine.loader import load_turbine
from takagi.reports.margins.running_loop import RunningLoops
from takagi.reports.margins.running_search import SearchedMargins, searched_margins, wind_ranges
from takagi.reports.margins.thresholds import RAISED_BY, AskedMargins, failed, measured
from takagi.reports.simulation.design_runs import DesignRun, design_runs
from takagi.reports.simulation.laws import filed_laws

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


class MarginsFound(NamedTuple):
    """What is below a threshold, a sentence each, and lines that say what was measured."""

    failures: tuple[str, ...]
    lines: tuple[str, ...]


def filed_margins(asked: AskedMargins, gains: Path, model: Path) -> MarginsFound:
    """Return what the law of a gain file has, on the validation plant of its turbine.

    gains : a turbine's gain file.   model : its turbine's file.

    Raises CertificateError: a file that is no turbine's gain file, or has no observer.
    Raises ModelError: no turbine file, or what ``running_margins`` refuses.
    """
    turbine, chosen = filed_laws(load_turbine(model), gains)
    ((name, law),) = chosen.laws.items()
    assert chosen.observer is not None  # filed_laws refuses a file without one
    loops = RunningLoops.of(
        turbine,
        law,
        chosen.observer,
        speed_filter=chosen.speed_filters.get(name),
        sample_time=asked.sample,
        computation_time=asked.computing,
    )
    found = searched_margins(loops)
    below = failed(found.rows, asked)
    if found.none:
        every = [*found.none, *(row.wind for row in found.rows)]
        below = (f"the loop has no rest at {wind_ranges(found.none, every)}", *below)
    if below:
        below = (*below, RAISED_BY)
    return MarginsFound(below, measured(found.rows, asked, str(gains)) if found.rows else ())
