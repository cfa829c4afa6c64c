"""Margins of the loop as it runs: with observer, filters, sampling, wake, flap, tower, torsion."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.reports.figures.loops import PANELS, MarginLine, running_margins_figure
from takagi.reports.figures.style import captioned_figure
from takagi.reports.margins.margins import Margins
from takagi.reports.margins.running_over_wind import RunningMargins
from takagi.reports.margins.running_search import SearchedMargins, design_margins, wind_ranges
from takagi.reports.margins.thresholds import modes_met
from takagi.reports.page.text import Section, Table, significant, with_decimals

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.result import TurbineDesign

LOOPS = ("torque", "pitch")
RESTS = {"torque": "torque stays at rated", "pitch": "pitch stays at its lower stop"}


def running_section(design: TurbineDesign) -> Section:
    """Return the section about the loop with the program that a controller runs."""
    found = design_margins(design)
    rows, filters = found.rows, design.speed_filter
    winds = np.array(sorted({row.wind for row in rows}))
    lines = [_line(loop, winds, found) for loop in (*LOOPS, "both")]
    figures = []
    if len(winds):
        figures = [
            captioned_figure(
                running_margins_figure(winds, lines),
                "running-margins",
                caption="Margins of the loop that runs, over wind. Line: the machine as its file "
                "says, every 0.2 m/s; the band reaches to the least of all plants (inertia 0.9 and "
                "1.1, wake in equilibrium, as it is, and frozen), at whole winds and where a "
                "margin is locally least. Both: torque and pitch at once, disk alone. A line ends "
                "where that command does not answer.",
                alternative="Gain, phase, delay and disk margins of the torque and the pitch loop "
                "over wind",
            )
        ]
    return Section(
        "running",
        "Margins of the loop that runs",
        {
            "figures": figures,
            "table": _table(found),
            "unstable": _unstable(rows),
            "modes": modes_met(rows),
            "none": wind_ranges(found.none, [*found.none, *winds]) if found.none else "",
            "speed_filter": significant(filters.corner) if filters else "",
            "torsion_filter": significant(filters.stop) if filters and filters.stop else "",
        },
    )


def _unstable(rows: Sequence[RunningMargins]) -> list[str]:
    """Return where the loop is unstable: for the nominal plant, and for other plants alone."""
    every = [row.wind for row in rows]
    nominal = {row.wind for row in rows if row.nominal and row.decay_rate <= 0}
    others = {row.wind for row in rows if row.decay_rate <= 0} - nominal
    found = []
    if nominal:
        found.append(f"at {wind_ranges(sorted(nominal), every)}")
    if others:
        found.append(f"with another inertia or wake at {wind_ranges(sorted(others), every)}")
    return found


def _line(loop: str, winds: Floats, found: SearchedMargins) -> MarginLine:
    nominal = {name: np.full(len(winds), np.nan) for name in PANELS}
    least = {name: np.full(len(winds), np.nan) for name in PANELS}
    all_plants = {*found.whole, *found.least}
    for row in found.rows:
        at = int(np.searchsorted(winds, row.wind))
        margins = dict(row.loops).get(loop)
        for name, value in _figures(row, margins, loop).items():
            if row.nominal:
                nominal[name][at] = value
            if row.wind in all_plants:
                least[name][at] = np.fmin(least[name][at], value)
    return MarginLine(loop, nominal, least)


def _figures(row: RunningMargins, m: Margins | None, loop: str) -> dict[str, float]:
    """Return the values of one plant in the figure, by panel."""
    if loop == "both":
        return {"disk": row.both.alpha}
    if m is None:
        return {}
    phase = float(np.degrees(m.phase))
    return {"gain": m.gain_increase, "phase": phase, "delay": m.delay, "disk": m.disk.alpha}


def _table(found: SearchedMargins) -> Table:
    cells = []
    for wind in sorted((*found.whole, *found.least)):
        plants = [row for row in found.rows if row.wind == wind]
        cells += [_cells(plants[0], loop, plants) for loop in LOOPS]
    return Table(
        "Margins of the loop that runs; in brackets the least of all plants",
        (
            ("wind", "m/s"),
            ("loop", ""),
            ("crossover", "rad/s"),
            ("gain may grow", "dB"),
            ("and fall", "dB"),
            ("phase", "°"),
            ("delay", "s"),
            ("disk α", "-"),
            ("both: α", "-"),
        ),
        tuple(cells),
        note="At whole winds, and where a margin is the least around. Loops broken where the "
        "command leaves the program, the other closed. Crossover: the highest frequency with "
        "|L| = 1. Delay beyond what is in the loop, exact in whole samples. Floating point: "
        "measured, not proved.",
    )


def _cells(row: RunningMargins, loop: str, plants: Sequence[RunningMargins]) -> tuple[str, ...]:
    found = dict(row.loops)
    if loop not in found:
        return (f"{row.wind:g}", loop, RESTS[loop], *["–"] * 6)
    if not found[loop].stable:
        return (f"{row.wind:g}", loop, "unstable", *["–"] * 6)
    every = [found[loop], *(one for p in plants if (one := dict(p.loops).get(loop)) is not None)]
    return (
        f"{row.wind:g}",
        loop,
        significant(every[0].crossover),
        _with_least([20 * np.log10(one.gain_increase) for one in every], 1),
        _with_least([_fall(one) for one in every], 1),
        _with_least([float(np.degrees(one.phase)) for one in every], 0),
        _with_least([one.delay for one in every], 3),
        _with_least([one.disk.alpha for one in every], 2),
        _with_least([row.both.alpha, *(plant.both.alpha for plant in plants)], 2),
    )


def _fall(margins: Margins) -> float:
    """Return by how many dB the gain may fall; inf where it may fall to 0."""
    least = margins.gain_decrease
    return float(-20 * np.log10(least)) if least > 0 else float("inf")


def _with_least(values: Sequence[float], digits: int) -> str:
    """Return the first of some values, and the least of them in brackets."""
    return f"{with_decimals(values[0], digits)} ({with_decimals(min(values), digits)})"
