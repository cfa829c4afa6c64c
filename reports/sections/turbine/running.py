"""The loop as it runs: its margins with all that the plant has, and its responses in winds."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.design.turbine.result import TurbineDesign
from takagi.models.arrays import Floats
from takagi.models.laws.protocol import law_words
from takagi.models.simulation.turbine_plant import validation_plant
from takagi.reports.figures.loops import (
    PANELS,
    MarginLine,
    bode_figure,
    bode_line,
    running_margins_figure,
)
from takagi.reports.figures.response import response_figure
from takagi.reports.figures.style import captioned_figure
from takagi.reports.margins.margins import Margins, loop_margins
from takagi.reports.margins.response import BrokenLoops, broken_loops
from takagi.reports.margins.running_loop import RunningLoops
from takagi.reports.margins.running_over_wind import RunningMargins, SearchedMargins, wind_ranges
from takagi.reports.margins.thresholds import modes_met
from takagi.reports.page.text import (
    CaptionedFigure,
    Section,
    Table,
    powers,
    significant,
    table,
    with_decimals,
)
from takagi.reports.sections.turbine.summary import (
    USUAL_GAIN,
    USUAL_PHASE,
    gain_margin,
    phase_margin,
    slowest_mode,
    summary_rows,
)
from takagi.reports.simulation.measured_loop import TURBULENT_DURATION, DesignRun, measured_loop

if TYPE_CHECKING:
    from matplotlib.figure import Figure


LOOPS = ("torque", "pitch")
BODE_LINES = 6
FREQUENCY = np.geomspace(1e-2, 30.0, 700)


def running_section(design: TurbineDesign) -> Section:
    """Return the section about the loop with the program that a controller runs."""
    searched = measured_loop(design).margins
    rows, filters = searched.rows, design.speed_filter
    winds = np.array(sorted({row.wind for row in rows}))
    figures = [drawn for loop in LOOPS if (drawn := _bode(design, loop, searched)) is not None]
    if len(winds):
        figures.insert(0, captioned_figure(margins_drawing(searched), "running-margins"))
    return Section(
        "running",
        "Margins of the loop that runs",
        {
            "figures": figures,
            "table": _table(searched),
            "least": [*_least(design), *_weak(rows)],
            "unstable": _unstable(rows),
            "modes": modes_met(rows),
            "none": wind_ranges(searched.none, [*searched.none, *winds]) if searched.none else "",
            "speed_filter": significant(filters.corner) if filters else "",
            "torsion_filter": significant(filters.stop) if filters and filters.stop else "",
        },
    )


def margins_drawing(searched: SearchedMargins) -> Figure:
    """Return the margins over wind; only where there are some."""
    winds = np.array(sorted({row.wind for row in searched.rows}))
    lines = [_line(loop, winds, searched) for loop in (*LOOPS, "both")]
    return running_margins_figure(winds, lines)


def _least(design: TurbineDesign) -> list[str]:
    """Return sentences on the least margins, which the summary has too, and the slowest mode."""
    slowest = slowest_mode(design)
    sentences = [
        f"The least margins of all plants and winds are {' and '.join(row.parts[:2])}."
        for row in summary_rows(design)
        if row.name == "margins" and row.numbers
    ]
    return [*sentences, f"The slowest mode falls to 2 % in {slowest}."] if slowest else sentences


def _weak(rows: Sequence[RunningMargins]) -> list[str]:
    """Return where a loop has less than the margins that are usual."""
    every, phrases = [row.wind for row in rows], []
    for loop in LOOPS:
        acting = [(row.wind, dict(row.loops)[loop]) for row in rows if _acts(row, loop)]
        weak = [
            wind
            for wind, m in acting
            if gain_margin(m) < USUAL_GAIN or phase_margin(m) < USUAL_PHASE
        ]
        if weak:
            phrases.append(f"the {loop} loop at {wind_ranges(weak, every)}")
    if not phrases:
        return []
    return [
        f"Less than the usual {USUAL_GAIN:g} dB or {USUAL_PHASE:g}° have {' and '.join(phrases)}."
    ]


def _bode(design: TurbineDesign, loop: str, searched: SearchedMargins) -> CaptionedFigure | None:
    """Return the Bode plot of one loop, at winds where it acts; None where it never does."""
    acting = [row.wind for row in searched.rows if row.nominal and _acts(row, loop)]
    if not acting:
        return None
    count = min(BODE_LINES, len(acting))
    winds = [acting[k] for k in np.unique(np.linspace(0, len(acting) - 1, count).astype(int))]
    lines = []
    for wind in winds:
        response = getattr(running_response(design, wind), loop)
        lines.append(bode_line(f"{wind:g} m/s", response, loop_margins(response), FREQUENCY))
    turbine = design.turbine
    tower = float(np.sqrt(turbine.tower_stiffness / turbine.tower_mass))
    speed = design.settings.speed_setpoint or turbine.rated_rotor_speed
    marks = {f"tower {tower / 2 / np.pi:.2f} Hz": tower, "3P": 3 * speed}
    command = "torque command" if loop == "torque" else "pitch reference"
    return captioned_figure(
        bode_figure(FREQUENCY, lines, marks=marks), f"bode-{loop}", "turbine-bode", command=command
    )


def running_response(design: TurbineDesign, wind: float) -> BrokenLoops:
    """Return the responses of the loop that runs at a wind [m/s], of the machine in its file."""
    observer, speed_filter = design.observer.observer, design.speed_filter
    loops = RunningLoops.of(design.turbine, design.law, observer, speed_filter=speed_filter)
    return broken_loops(loops.at(wind))


def _unstable(rows: Sequence[RunningMargins]) -> list[str]:
    """Return where the loop is unstable: for the nominal plant, and for other plants alone."""
    every = [row.wind for row in rows]
    nominal = {row.wind for row in rows if row.nominal and row.decay_rate <= 0}
    perturbed = {row.wind for row in rows if row.decay_rate <= 0} - nominal
    phrases = []
    if nominal:
        phrases.append(f"at {wind_ranges(sorted(nominal), every)}")
    if perturbed:
        phrases.append(f"with another inertia or wake at {wind_ranges(sorted(perturbed), every)}")
    return phrases


def _line(loop: str, winds: Floats, searched: SearchedMargins) -> MarginLine:
    nominal = {name: np.full(len(winds), np.nan) for name in PANELS}
    lowest = {name: np.full(len(winds), np.nan) for name in PANELS}
    all_plants = {*searched.whole, *searched.least}
    for row in searched.rows:
        at = int(np.searchsorted(winds, row.wind))
        margins = dict(row.loops).get(loop)
        for name, value in _figures(row, margins, loop).items():
            if row.nominal:
                nominal[name][at] = value
            if row.wind in all_plants:
                lowest[name][at] = np.fmin(lowest[name][at], value)
    return MarginLine(loop, nominal, lowest)


def _figures(row: RunningMargins, m: Margins | None, loop: str) -> dict[str, float]:
    """Return the values of one plant in the figure, by panel."""
    if loop == "both":
        return {"disk": row.both.alpha}
    if m is None:
        return {}
    phase = float(np.degrees(m.phase))
    return {"gain": m.gain_increase, "phase": phase, "delay": m.delay, "disk": m.disk.alpha}


def _table(searched: SearchedMargins) -> Table:
    cells = []
    for wind in sorted((*searched.whole, *searched.least)):
        plants = [row for row in searched.rows if row.wind == wind]
        cells += [_cells(plants[0], loop, plants) for loop in LOOPS if _acts(plants[0], loop)]
    return table("running", cells)


def _acts(row: RunningMargins, loop: str) -> bool:
    return loop in dict(row.loops)


def _cells(row: RunningMargins, loop: str, plants: Sequence[RunningMargins]) -> tuple[str, ...]:
    margins = dict(row.loops)
    if not margins[loop].stable:
        return (f"{row.wind:g}", loop, "unstable", *["–"] * 6)
    every = [margins[loop], *(m for p in plants if (m := dict(p.loops).get(loop)) is not None)]
    return (
        f"{row.wind:g}",
        loop,
        significant(every[0].crossover),
        _with_least([20 * np.log10(m.gain_increase) for m in every], 1),
        _with_least(
            [-20 * np.log10(m.gain_decrease) if m.gain_decrease else np.inf for m in every], 1
        ),  # fmt: skip
        _with_least([float(np.degrees(m.phase)) for m in every], 0),
        _with_least([m.delay for m in every], 3),
        _with_least([m.disk.alpha for m in every], 2),
        _with_least([row.both.alpha, *(plant.both.alpha for plant in plants)], 2),
    )


def _with_least(values: Sequence[float], digits: int) -> str:
    """Return the first of some values, and the least of them in brackets."""
    return f"{with_decimals(values[0], digits)} ({with_decimals(min(values), digits)})"


# Metric -> its words and unit, and whether a law's value is clearly worse than the reference's.
WORSE: dict[str, tuple[str, str, Callable[[float, float], bool]]] = {
    "overspeed": ("Overspeed", "%", lambda law, reference: law > max(reference, 0.0) + 1.0),
    "tower_del": ("Tower load", "MN m", lambda law, reference: law > 1.05 * reference),
    "pitch_travel": ("Pitch travel", "°", lambda law, reference: law > 1.05 * reference + 1.0),
    "energy": ("Energy", "kWh", lambda law, reference: law < 0.995 * reference),
}


def responses_section(design: TurbineDesign) -> Section:
    """Return the section with the simulated responses."""
    plant, measured = validation_plant(design.turbine), measured_loop(design)
    return Section(
        "responses",
        "Responses",
        {
            "figures": [_figure(design, name, run) for name, run in measured.drawn.items()],
            "table": _metrics_table(measured.runs),
            "worse": [words for name in WORSE if (words := _worse(measured.runs, name))],
            "torque_rate": with_decimals(plant.torque_rate_limit / 1e3, 0),
            "pitch_rate": with_decimals(float(np.degrees(plant.pitch_rate_limit)), 0),
            "turbulent": f"{TURBULENT_DURATION:g}",
            "reference": design.turbine.baseline is not None,
        },
    )


def _worse(runs: Sequence[DesignRun], metric: str) -> str:
    """Return where a metric is clearly worse than the reference controller's; "" for nowhere."""
    name, unit, is_worse = WORSE[metric]
    worse = []
    for run in runs:
        if run.reference is not None:
            law, reference = (
                getattr(result.metrics, metric) for result in (run.law, run.reference)
            )
            if is_worse(law, reference):
                worse.append(f"{powers(run.words)} ({law:.4g} against {reference:.4g} {unit})")
    return f"{name}: {', '.join(worse)}." if worse else ""


def response_drawing(design: TurbineDesign, run: DesignRun) -> Figure:
    """Return the run over time, beside the reference controller's where there is one."""
    turbine = design.turbine
    lines = [result.line for result in (run.law, run.reference) if result and result.line]
    speed = design.settings.speed_setpoint or turbine.rated_rotor_speed
    rated = {"rotor_speed": speed, "torque": turbine.rated_torque}
    return response_figure(run.time, lines, rated=rated)


def response_words(run: DesignRun) -> str:
    """Return the caption of a run: the wind, and the overspeed of each law."""
    sentence = f"Overspeed {with_decimals(run.law.metrics.overspeed, 1)} %"
    if run.reference:
        reference = with_decimals(run.reference.metrics.overspeed, 1)
        sentence += f", reference controller {reference} %"
    return f"{powers(run.words).capitalize()}. {sentence}. Dotted: rated."


def _figure(design: TurbineDesign, name: str, run: DesignRun) -> CaptionedFigure:
    return captioned_figure(
        response_drawing(design, run),
        f"response-{name}",
        "response",
        words=response_words(run),
        wind=powers(run.words),
    )


def _metrics_table(runs: Sequence[DesignRun]) -> Table:
    rows = []
    for run in runs:
        for result in filter(None, (run.law, run.reference)):
            of_design = result is run.law
            rows.append(
                (
                    run.words,
                    law_words(result.label),
                    with_decimals(result.metrics.energy, 1),
                    with_decimals(result.metrics.overspeed, 1),
                    with_decimals(result.metrics.pitch_travel, 1),
                    with_decimals(result.metrics.tower_del, 1),
                    with_decimals(100 * run.share_inside if of_design else float("nan"), 0),
                )
            )
    return table("runs", rows)
