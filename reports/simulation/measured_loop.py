"""The margins and simulated runs of a turbine's design, found once and kept in ``design.json``;
and whether the law of a gain file has the margins that are asked.

All in floating point: measured and simulated, and nothing of it is proved.

Runs are those of the validation plant with the wind observer in the loop, in steps, gusts and
turbulence, beside the reference controller.  Each says how long it is inside the proved wind
limits, since its bounds hold there alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from takagi.certificates.design.turbine.result import TurbineDesign, claim_summary
from takagi.models.arrays import Floats
from takagi.models.laws.protocol import Law, law_words
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.closed_loop import History
from takagi.models.simulation.scenario import Metrics, measure
from takagi.models.simulation.turbine_plant import validation_plant
from takagi.models.simulation.wind import (
    WindSeries,
    class_turbulence,
    gust_wind,
    ramp_wind,
    step_wind,
)
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.loader import load_turbine
from takagi.models.turbine.trim import rated_wind
from takagi.reports.figures.response import QUANTITIES, ResponseLine
from takagi.reports.margins.running_loop import RunningLoops
from takagi.reports.margins.running_over_wind import SearchedMargins, searched_margins, wind_ranges
from takagi.reports.margins.thresholds import RAISED_BY, AskedMargins, failed, measured
from takagi.reports.page.text import powers
from takagi.reports.simulation.compiled_law import SampledLoop, in_threads
from takagi.reports.simulation.laws import filed_laws

STEP = 1.5
DURATION, BEGIN = 90.0, 15.0
# Further gusts, by their distance from rated wind [m/s]; they last this long [s].
GUSTS = (-2.5, 2.5, 4.5, 8.5)
GUST_DURATION, GUST_BEGIN = 40.0, 5.0
# Means of class-B turbulence [m/s], simulated for this long [s], with one seed.
TURBULENT = (5.0, 8.0, 11.0, 14.0, 19.0)
TURBULENT_DURATION, SEED = 200.0, 1
# Of a run that is drawn every third sample is kept, in so many digits.
THINNED, DIGITS = 3, 7


@dataclass(frozen=True, slots=True, eq=False)
class LawRun:
    """One law in one wind: its name, its metrics, and its line where it is drawn."""

    label: str
    metrics: Metrics
    line: ResponseLine | None


@dataclass(frozen=True, slots=True, eq=False)
class DesignRun:
    """One wind: the design's law, and the reference controller where the turbine has one.

    Attributes
    ----------
    name : "step-up", "step-down", "ramp", "gust" (at rated wind); of others "" or "turbulence".
    wind : mean wind [m/s].
    words : the wind in words, e.g. ``"gust at 11.45 m/s"``.
    share_inside : share of time inside the proved wind limits [-]; nan without them.
    time [s], schedule : of a run that is drawn, (n,); schedule is the schedule wind v_s of the
        effort-sharing law [m/s], else the wind estimate.
    """

    name: str
    wind: float
    words: str
    law: LawRun
    reference: LawRun | None
    share_inside: float
    time: Floats
    schedule: Floats


def design_runs(design: TurbineDesign) -> tuple[DesignRun, ...]:
    """Return a design's law in steps, a ramp, gusts and turbulence of class B, simulated now.

    Class B has sigma_1 = 0.14 (0.75 V + 5.6 m/s).
    """
    turbine = design.turbine
    rated = round(rated_wind(turbine, speed_setpoint=design.settings.speed_setpoint), 2)
    low, high = round(rated - STEP, 2), round(rated + STEP, 2)
    radius = turbine.rotor_radius
    winds = [
        ("step-up", rated, step_wind(low, high, DURATION, begin=BEGIN)),
        ("step-down", rated, step_wind(high, low, DURATION, begin=BEGIN)),
        ("gust", rated, gust_wind(rated, DURATION, rotor_radius=radius, begin=BEGIN)),
        ("ramp", rated, ramp_wind(low - 2, high + 2, DURATION, rate=0.2, begin=BEGIN)),
    ]
    for mean in (round(rated + distance, 2) for distance in GUSTS):
        if turbine.cut_in < mean < turbine.cut_out:
            gust = gust_wind(mean, GUST_DURATION, rotor_radius=radius, begin=GUST_BEGIN)
            winds.append(("", mean, gust))
    for mean in TURBULENT:
        if turbine.cut_in < mean < turbine.cut_out:
            turbulent = class_turbulence(
                mean, TURBULENT_DURATION, SEED, rotor_radius=radius, hub_height=turbine.hub_height
            )
            winds.append(("turbulence", mean, turbulent))
    plant = validation_plant(turbine)
    filtered = replace(plant, speed_filter=design.speed_filter)
    loops = [SampledLoop(filtered, design.law, design.observer.observer)]
    if turbine.baseline is not None:
        loops.append(SampledLoop(plant, BaselineLaw(turbine), None))
    tasks = [partial(loop.run, wind) for _, _, wind in winds for loop in loops]
    histories = iter(in_threads(tasks))
    return tuple(_run(design, *each, [next(histories) for _ in loops]) for each in winds)


def _run(
    design: TurbineDesign, name: str, mean: float, wind: WindSeries, histories: Sequence[History]
) -> DesignRun:
    """Return the run of the design's law, and of the reference controller if it is there."""
    drawn, reference = name not in ("", "turbulence"), None
    history, *beside = histories
    if beside:
        baseline = BaselineLaw(design.turbine)
        reference = _law_run(baseline, beside[0], design.turbine, drawn=drawn)
    time, schedule = history.time, _schedule(design, history)
    inside = in_wind_class(design, time, history.wind, schedule)
    return DesignRun(
        name,
        mean,
        wind.name.partition(",")[0].replace("turbulent", "turbulence of"),
        _law_run(design.law, history, design.turbine, drawn=drawn),
        reference,
        float("nan") if inside is None else float(inside.mean()),
        *((_thinned(time), _thinned(schedule)) if drawn else (np.empty(0), np.empty(0))),
    )


def _law_run(law: Law, history: History, turbine: Turbine, *, drawn: bool) -> LawRun:
    line = None
    if drawn:
        full = ResponseLine.of(powers(law_words(law.name)), history)
        thinned: dict[str, Any] = {name: _thinned(getattr(full, name)) for name in QUANTITIES}
        line = replace(full, **thinned)
    return LawRun(law.name, measure(history, turbine), line)


def _thinned(values: Floats) -> Floats:
    return np.array([float(f"{value:.{DIGITS}g}") for value in values[::THINNED]])


def _schedule(design: TurbineDesign, history: History) -> Floats:
    law = design.effort_sharing_law
    if law is not None and law.wind_filter > 0:
        return history.law_states[:, 1]
    return history.wind_estimate


def in_wind_class(
    design: TurbineDesign, time: Floats, wind: Floats, schedule: Floats
) -> NDArray[np.bool_] | None:
    """Return whether |v - v_s| and |v_s'| are within the proved bounds of the wind cell, (n,).

    None of a design without such a claim.
    """
    summary = claim_summary(design)
    if summary is None or design.effort_sharing_law is None:
        return None
    cell = np.clip(np.searchsorted(summary.edges, schedule) - 1, 0, len(summary.winds) - 1)

    def of_cell(values: ArrayLike) -> NDArray[np.float64]:
        return np.asarray(values, dtype=np.float64)[cell]

    inside = np.array(summary.proved)[cell]
    inside &= np.abs(wind - schedule) <= of_cell(summary.wind_error)
    inside &= np.abs(np.gradient(schedule, time)) <= of_cell(summary.wind_rate)
    return inside


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
    if below:
        below = (*below, RAISED_BY)
    return MarginsFound(below, measured(found.rows, asked, str(gains)) if found.rows else ())
