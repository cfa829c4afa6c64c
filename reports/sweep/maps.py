"""The files of a finished sweep: a page with a table, the points as CSV, and a figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.sweep.sweep import Row, Sweep
from takagi.models.arrays import Floats
from takagi.models.laws.protocol import law_words
from takagi.reports.figures.style import figure_to_svg, house_style, new_figure, shades
from takagi.reports.output import csv_text
from takagi.reports.page.markdown_table import markdown_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# The columns that page and figure show, and the one that the figure draws in decades.
PUBLISHED = (
    *("proved_windows", "proved_at_trim", "first_failing_wind [m/s]"),
    "least_decay_rate [1/s]",
)
EFFORT_SHARING = ("overspeed [%]", "common_decay [1/s]")
BY_WIND = ("mean_wind_error [m/s]", "mean_wind_rate [m/s^2]")
DECADES = "least_decay_rate [1/s]"
MOST_LABELS = 8
PROVED_HERE = {
    "coherent": "PROVED means that the independent checker has verified the emitted decimals. The "
    "wind error is |v - v_s|, the distance of the wind from the law's schedule wind, and the wind "
    "rate |v_s'|, the rate of the schedule wind. Both may occur at the same time, in every wind "
    "cell; the rotor speed then never exceeds the overspeed bound.",
    "paper": "At each point some windows of constant wind are examined. A window is PROVED when "
    "the independent checker has verified the emitted decimals: in a set around its equilibrium "
    "the loop has exactly one, and every motion from the set tends to it at the stated rate. "
    "Winds between the windows are not claimed. windows.csv has a row a window.",
}


def sweep_files(sweep: Sweep) -> dict[str, bytes | str]:
    """Return file name -> content: map.md, points.csv, for published laws windows.csv, a figure."""
    heads = [axis.label for axis in sweep.axes]
    points = [{k: v for k, v in row.items() if k != "windows"} for row in sweep.rows]
    files: dict[str, bytes | str] = {"points.csv": _csv(points)}
    windows = [
        {head: row[head] for head in heads} | window
        for row in sweep.rows
        for window in row.get("windows", ())
    ]
    if windows:
        files["windows.csv"] = _csv(windows)
    picture, figure = "", sweep_figure(sweep)
    if figure is not None:
        words = f"{law_words(sweep.law)} over " + " and ".join(axis.name for axis in sweep.axes)
        files["figures/map.svg"] = figure_to_svg(figure, name="sweep-map", description=words)
        picture = f"![{words}](figures/map.svg)\n\n"
    shown = [*heads, "verdict", *_columns(sweep), "reason"]
    counted = ", ".join(f"{number} {verdict}" for verdict, number in sweep.counted().items())
    files["map.md"] = (
        f"# {sweep.model}: the {law_words(sweep.law)}\n\n{len(points)} points: {counted}. "
        f"{PROVED_HERE['coherent' if sweep.law == 'coherent' else 'paper']}\n\n{picture}"
        + markdown_table([{head: row.get(head) for head in shown} for row in sweep.rows])
    )
    return files


def sweep_figure(sweep: Sweep) -> Figure | None:
    """Return a panel for each column, over the last axis; a line for each value of the others.

    A point without a number is a gap.  None if the last axis has one value, or without a number.
    """
    drawn = [column for column in _columns(sweep) if np.isfinite(_numbers(sweep, column)).any()]
    if not drawn or not sweep.axes or len(sweep.axes[-1].values) < 2:
        return None
    axis, (lines, _) = sweep.axes[-1], _numbers(sweep, drawn[0]).shape
    rows = -(-len(drawn) // 3)
    with house_style():
        figure, panels = new_figure(rows, 3, width=9.5, height=2.7 * rows + 0.5)
        for panel, column in zip(panels, drawn, strict=False):
            for k, colour in enumerate(shades(lines)):
                values = _numbers(sweep, column)[k]
                panel.plot(axis.values, values, color=colour, marker="o", markersize=4)
            panel.set(title=column.replace("_", " ").replace(": ", ",\n"), xlabel=axis.label)
            margin = 0.03 * (axis.values[-1] - axis.values[0])
            panel.set_xlim(axis.values[0] - margin, axis.values[-1] + margin)
            if column == DECADES:
                panel.set_yscale("log")
            else:
                panel.set_ylim(0.0, 1.08 * float(np.nanmax(_numbers(sweep, column))) or 1.0)
        for panel in panels[len(drawn) :]:
            panel.set_axis_off()
        for k in range(0, lines, -(-lines // MOST_LABELS)) if lines > 1 else ():
            row = sweep.rows[k * len(axis.values)]
            words = ", ".join(f"{other.name} {row[other.label]:g}" for other in sweep.axes[:-1])
            panels[0].lines[k].set_label(words)
        if lines > 1:
            figure.legend(loc="outside upper center", ncols=4)
    return figure


def _columns(sweep: Sweep) -> list[str]:
    if sweep.law != "coherent":
        return list(PUBLISHED)
    ranges = [key for row in sweep.rows for key in row if key.endswith(BY_WIND)]
    return [*EFFORT_SHARING, *sorted(dict.fromkeys(ranges), key=lambda key: key.partition(": ")[2])]


def _numbers(sweep: Sweep, column: str) -> Floats:
    """Return a column as (lines, points of the last axis), nan where a point has no such number."""
    values = np.array([row.get(column) for row in sweep.rows], dtype=np.float64)
    return values.reshape(-1, len(sweep.axes[-1].values)) if sweep.axes else values[None]


def _csv(rows: Sequence[Row]) -> str:
    """Return rows as CSV; columns are the keys, in the order in which they first appear."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    return csv_text(names, ([row.get(name, "") for name in names] for row in rows))
