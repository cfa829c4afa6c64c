"""Whether the law of a gain file has the margins that are asked, on the plant that runs it."""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from takagi.models.turbine.loader import load_turbine
from takagi.reports.margins.running_loop import RunningLoops
from takagi.reports.margins.running_search import searched_margins, wind_ranges
from takagi.reports.margins.thresholds import AskedMargins, failed, measured
from takagi.reports.simulation.laws import filed_laws


class MarginsFound(NamedTuple):
    """What is below a threshold, a sentence each, and lines that say what was measured."""

    failures: tuple[str, ...]
    lines: tuple[str, ...]


def filed_margins(asked: AskedMargins, gains: Path, model: Path) -> MarginsFound:
    """Return what the law of a gain file has, on the validation plant of its turbine.

    Parameters
    ----------
    gains : a turbine's gain file.   model : its turbine's file.

    Raises
    ------
    CertificateError : a file that is no turbine's gain file, or has no observer.
    ModelError : no turbine file, or what ``running_margins`` refuses.
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
    return MarginsFound(below, measured(found.rows, asked, str(gains)) if found.rows else ())
