"""The files of a finished sweep: a page with a table, the points as CSV, and a figure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.sweep.axis import Axis
from takagi.certificates.sweep.sweep import Row, Sweep
from takagi.models.arrays import Floats
from takagi.models.laws.law_words import law_words
from takagi.reports.csv_text import csv_text
from takagi.reports.figures.style import COLOURS, GREY, SEQUENTIAL, STYLES, house_style, new_figure
from takagi.reports.figures.writing import figure_to_svg
from takagi.reports.page.markdown_table import markdown_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

OVERSPEED = "overspeed [%]"
ERROR, RATE = "mean_wind_error [m/s]", "mean_wind_rate [m/s^2]"
HATCH = "////"


@dataclass(frozen=True, slots=True)
class Panel:
    """One quantity of a figure: its label, and line's label -> column; ``log`` scales it."""

    label: str
    columns: Mapping[str, str]
    log: bool = False


PUBLISHED = (
    Panel("winds", {"proved": "proved_windows", "at the trim": "proved_at_trim"}),
    Panel("first wind not proved [m/s]", {"": "first_failing_wind [m/s]"}),
    Panel("least proved decay [1/s]", {"": "least_decay_rate [1/s]"}, log=True),
)
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
    shown = [*heads, "verdict", *_columns(_panels(sweep)), "reason"]
    counted = ", ".join(f"{number} {verdict}" for verdict, number in sweep.counted().items())
    files["map.md"] = (
        f"# {sweep.model}: the {law_words(sweep.law)}\n\n{len(points)} points: {counted}. "
        f"{PROVED_HERE['coherent' if sweep.law == 'coherent' else 'paper']}\n\n{picture}"
        + markdown_table([{head: row.get(head) for head in shown} for row in sweep.rows])
    )
    return files


def sweep_figure(sweep: Sweep) -> Figure | None:
    """Return lines over one axis, or maps over two; else, or if nothing is proved, None."""
    axes = [axis for axis in sweep.axes if len(axis.values) > 1]
    panels = _panels(sweep)
    if not axes or not any(np.isfinite(_numbers(sweep, c)).any() for c in _columns(panels)):
        return None
    with house_style():
        if len(axes) == 1:
            return _lines(sweep, axes[0], panels)
        return _maps(sweep, axes, panels) if len(axes) == 2 else None


def _panels(sweep: Sweep) -> Sequence[Panel]:
    if sweep.law != "coherent":
        return PUBLISHED
    winds = _ranges(sweep)[1:]
    return (
        Panel("mean wind error [m/s]", {each: f"{each}: {ERROR}" for each in winds}),
        Panel("mean wind rate [m/s\u00b2]", {each: f"{each}: {RATE}" for each in winds}),
        Panel(OVERSPEED, {"": OVERSPEED}),
        Panel("common decay [1/s]", {"": "common_decay [1/s]"}, log=True),
    )


def _ranges(sweep: Sweep) -> list[str]:
    """Return the ranges of winds that columns are about; the first is all winds."""
    keys = (key for row in sweep.rows for key in row if key.endswith(ERROR))
    return list(dict.fromkeys(key.partition(": ")[0] for key in keys))


def _columns(panels: Sequence[Panel]) -> list[str]:
    return [column for panel in panels for column in panel.columns.values()]


def _numbers(sweep: Sweep, column: str) -> Floats:
    """Return a column of the points, nan where a point has no such number."""
    return np.array([row.get(column) for row in sweep.rows], dtype=np.float64)


def _lines(sweep: Sweep, axis: Axis, panels: Sequence[Panel]) -> Figure:
    x = np.array(axis.values)
    proved = np.isfinite([_numbers(sweep, column) for column in _columns(panels)]).any(axis=0)
    figure, drawn = new_figure(-(-len(panels) // 2), 2, width=8.0, height=5.6)
    for axes, panel in zip(drawn, panels, strict=False):
        for colour, style, (label, column) in zip(
            COLOURS, STYLES, panel.columns.items(), strict=False
        ):
            y = _numbers(sweep, column)
            axes.plot(x, y, label=label, color=colour, linestyle=style, marker="o", markersize=4)
        axes.set(xlabel=axis.label, ylabel=panel.label)
        if panel.log:
            shown = [y for line in axes.lines for y in np.asarray(line.get_ydata()) if y > 0]
            axes.set(yscale="log", ylim=(min(shown) / 2, 2 * max(shown)) if shown else None)
        if not proved.all():
            ground, missing = axes.get_xaxis_transform(), x[~proved]
            cross: dict[str, Any] = {"color": GREY, "marker": "x", "linestyle": "none"}
            axes.plot(missing, 0 * missing, transform=ground, clip_on=False, **cross)
        axes.set_xlim(x[0] - 0.03 * (x[-1] - x[0]), x[-1] + 0.03 * (x[-1] - x[0]))
        if len(panel.columns) > 1:
            axes.legend(fontsize=8)
    for axes in drawn[len(panels) :]:
        axes.set_axis_off()
    return figure


def _maps(sweep: Sweep, axes: Sequence[Axis], panels: Sequence[Panel]) -> Figure:
    """Return a map for each column; hatched: nothing is proved, or no wind fails."""
    from matplotlib.colors import LogNorm, Normalize

    x, y = (edges(np.array(axis.values)) for axis in reversed(axes))
    shown = [(panel, *line) for panel in panels for line in panel.columns.items()]
    figure, drawn = new_figure(2, -(-len(shown) // 2), width=2.9 * len(shown) / 2, height=6.4)
    for field, (panel, label, column) in zip(drawn, shown, strict=False):
        values = _numbers(sweep, column).reshape(len(y) - 1, len(x) - 1)
        field.grid(visible=False)
        field.patch.set(hatch=HATCH, edgecolor=GREY)
        field.set(title=f"{panel.label}\n{label}", xlabel=axes[1].label, ylabel=axes[0].label)
        finite = values[np.isfinite(values)]
        if len(finite):
            # A scale that begins at 0 does not show nearly constant values as different.
            scale = LogNorm(finite.min(), finite.max()) if panel.log else Normalize(0, finite.max())
            seen = np.ma.masked_invalid(values)
            mesh = field.pcolormesh(x, y, seen, cmap=SEQUENTIAL, norm=scale)
            figure.colorbar(mesh, ax=field, orientation="horizontal", pad=0.02, aspect=30)
    for field in drawn[len(shown) :]:
        field.set_axis_off()
    return figure


def edges(values: Floats) -> Floats:
    """Return n + 1 borders half-way between n increasing values; the outer ones as far out."""
    middle = (values[1:] + values[:-1]) / 2
    ends = 1.5 * values[[0, -1]] - 0.5 * values[[1, -2]]
    return np.array([ends[0], *middle, ends[1]], dtype=np.float64)


def _csv(rows: Sequence[Row]) -> str:
    """Return rows as CSV; columns are the keys, in the order in which they first appear."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    return csv_text(names, ([row.get(name, "") for name in names] for row in rows))
