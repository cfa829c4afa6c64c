"""The files of a finished sweep: a page with a table, the points as CSV, and a figure."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.sweep.sweep import Sweep
from takagi.models.laws.protocol import law_words
from takagi.reports.figures.style import figure_to_svg, house_style, new_figure, shades
from takagi.reports.output import markdown_table, rows_csv

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# The columns that page and figure show, and the one that the figure draws in decades.
PUBLISHED = (
    *("proved_windows", "proved_at_trim", "first_failing_wind [m/s]"),
    "least_decay_rate [1/s]",
)
EFFORT_SHARING = (
    *("overspeed [%]", "common_decay [1/s]", "mean_wind_error [m/s]", "mean_wind_rate [m/s^2]"),
)
DECADES = "least_decay_rate [1/s]"
MOST_LABELS = 8
OF_EFFORT_SHARING = (
    "PROVED means that the independent checker has verified the emitted decimals. The wind error "
    "is |v - v_s|, the distance of the wind from the law's schedule wind, and the wind rate "
    "|v_s'|, the rate of the schedule wind; the table has their means over all winds. Both may "
    "occur at the same time, in every wind cell; the rotor speed then never exceeds the overspeed "
    "bound."
)
OF_PUBLISHED = (
    "At each point some windows of constant wind are examined. A window is PROVED when the "
    "independent checker has verified the emitted decimals: in a set around its equilibrium the "
    "loop has exactly one, and every motion from the set tends to it at the stated rate. Winds "
    "between the windows are not claimed. windows.csv has a row a window."
)


def sweep_files(sweep: Sweep) -> dict[str, bytes | str]:
    """Return file name -> content: map.md, points.csv, for published laws windows.csv, a figure."""
    heads = [axis.label for axis in sweep.axes]
    points = [{k: v for k, v in row.items() if k != "windows"} for row in sweep.rows]
    windows = [
        {head: row[head] for head in heads} | window
        for row in sweep.rows
        for window in row.get("windows", ())
    ]
    files: dict[str, bytes | str] = {"points.csv": rows_csv(points)}
    if windows:
        files["windows.csv"] = rows_csv(windows)
    picture, figure = "", sweep_figure(sweep)
    if figure is not None:
        words = f"{law_words(sweep.law)} over " + " and ".join(axis.name for axis in sweep.axes)
        files["figures/map.svg"] = figure_to_svg(figure, name="sweep-map", description=words)
        picture = f"![{words}](figures/map.svg)\n\n"
    shown = [*heads, "verdict", *_columns(sweep), "reason"]
    counted = ", ".join(f"{number} {verdict}" for verdict, number in sweep.counted().items())
    files["map.md"] = (
        f"# {sweep.model}: the {law_words(sweep.law)}\n\n{len(points)} points: {counted}. "
        f"{OF_EFFORT_SHARING if sweep.law == 'coherent' else OF_PUBLISHED}\n\n{picture}"
        + markdown_table([{head: row.get(head) for head in shown} for row in sweep.rows])
    )
    return files


def sweep_figure(sweep: Sweep) -> Figure | None:
    """Return a panel for each column, over the last axis; a line for each value of the others.

    A point without a number is a gap.  None if the last axis has one value, or without a number.
    """
    if not sweep.axes or len(sweep.axes[-1].values) < 2:
        return None
    axis, drawn = sweep.axes[-1], {}
    for column in _columns(sweep):
        values = np.array([row.get(column) for row in sweep.rows], dtype=np.float64)
        if np.isfinite(values).any():
            drawn[column] = values.reshape(-1, len(axis.values))
    if not drawn:
        return None
    starts = sweep.rows[:: len(axis.values)]
    with house_style():
        figure, panels = new_figure(2, 2, height=5.6)
        for panel, (column, lines) in zip(panels, drawn.items(), strict=False):
            for line, colour in zip(lines, shades(len(lines)), strict=True):
                panel.plot(axis.values, line, color=colour, marker="o", markersize=4)
            margin = 0.03 * (axis.values[-1] - axis.values[0])
            limits = (axis.values[0] - margin, axis.values[-1] + margin)
            panel.set(title=column.replace("_", " "), xlabel=axis.label, xlim=limits)
            if column == DECADES:
                panel.set_yscale("log")
            else:
                panel.set_ylim(0.0, 1.08 * float(np.nanmax(lines)) or 1.0)
        for panel in panels[len(drawn) :]:
            panel.set_axis_off()
        for k in range(0, len(starts), -(-len(starts) // MOST_LABELS)) if len(starts) > 1 else ():
            at = (f"{other.name} {starts[k][other.label]:g}" for other in sweep.axes[:-1])
            panels[0].lines[k].set_label(", ".join(at))
        if len(starts) > 1:
            figure.legend(loc="outside upper center", ncols=4)
    return figure


def _columns(sweep: Sweep) -> Sequence[str]:
    return EFFORT_SHARING if sweep.law == "coherent" else PUBLISHED
