"""The files of a study of the overlap: table, data, and figures with the spread over seeds."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from math import pi
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from takagi.models.simulation.scenario import BLADE_EXPONENT, TOWER_EXPONENT
from takagi.reports.figures.style import COLOURS, GREY, figure_to_svg, house_style, new_figure
from takagi.reports.output import markdown_page, read_words, rows_csv
from takagi.reports.study.overlap import SERIES, TURBULENCE, OverlapStudy, Point

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FILES = ("study.md", "study.csv", "study.json")
# Mean of the Rayleigh distribution that weighs the winds, IEC 61400-1 class I [m/s].
YEAR = 10.0
DELS = {"tower_del": TOWER_EXPONENT, "blade_del": BLADE_EXPONENT, "shaft_del": TOWER_EXPONENT}
MEANS = ("mean_power", "pitch_rate", "both_active")
LARGEST = ("overspeed", "torque_change")
TITLES: Mapping[str, str] = read_words("study/words.toml")["overlap"]
PANELS = ("tower_del", "blade_del", "shaft_del", "mean_power")
# A factor between the largest and the smallest load from which an axis is in decades.
DECADES = 5.0
# The front's figure ends at so many times the least load; numbers keep this distance [-].
NEAR, CLOSE = 2.0, (0.07, 0.032)


class Spread(NamedTuple):
    """A figure over the seeds."""

    mean: float
    least: float
    largest: float


class Row(NamedTuple):
    """A point in numbers; ``figures`` is empty where a run diverged or failed."""

    point: Point
    proof: Mapping[str, Any] | None
    figures: Mapping[str, Spread]
    front: bool = False

    @property
    def label(self) -> str:
        """The series in words."""
        return str(self.point.words["law"])

    @property
    def proved(self) -> bool:
        """Whether everything that was examined is proved."""
        return self.proof is not None and self.proof.get("verdict") == "PROVED"


def study_rows(study: OverlapStudy) -> list[Row]:
    """Return a row a point, with the winds weighed together."""
    weights = np.array([v * np.exp(-pi / 4 * (v / YEAR) ** 2) for v in study.means])
    weights /= weights.sum()
    rows = []
    for point, proved, runs in zip(study.points, study.proofs, study.runs, strict=True):
        figures = {}
        if not any(run["reason"] for run in runs):
            for name in TITLES:
                values = np.array([run[name] for run in runs]).reshape(len(study.means), -1)
                seeds = _over_winds(name, values, weights)
                figures[name] = Spread(float(seeds.mean()), float(seeds.min()), float(seeds.max()))
        rows.append(Row(point, proved, figures))
    return [row._replace(front=_on_front(row, rows)) for row in rows]


def _over_winds(name: str, values: Any, weights: Any) -> Any:
    """Return (seeds,) from (winds, seeds)."""
    if name in LARGEST:
        return values.max(axis=0)
    if name in DELS:
        return (weights @ values ** DELS[name]) ** (1 / DELS[name])
    return weights @ values


def _on_front(row: Row, rows: Sequence[Row]) -> bool:
    if not row.figures:
        return False
    load, power = row.figures["tower_del"].mean, row.figures["mean_power"].mean
    others = [
        (r.figures["tower_del"].mean, r.figures["mean_power"].mean) for r in rows if r.figures
    ]
    return not any((x < load and y >= power) or (x <= load and y > power) for x, y in others)


def study_files(study: OverlapStudy) -> dict[str, bytes | str]:
    """Return file name -> content: ``FILES`` and two figures; the same runs, the same bytes."""
    rows = study_rows(study)
    files: dict[str, bytes | str] = {"study.csv": _csv(study), "study.json": _json(study, rows)}
    pictures = []
    for name, words, figure in (
        ("overlap", "fatigue and power over the overlap", overlap_figure(study, rows)),
        ("front", "tower load and power of every overlap", front_figure(rows)),
    ):
        if figure is not None:
            file = f"figures/{name}.svg"
            title = f"{study.turbine.name}: {words}"
            files[file] = figure_to_svg(figure, name=f"study-{name}", description=title)
            pictures.append((title, file))
    files["study.md"] = markdown_page(
        "study",
        "overlap",
        study=study,
        turbulence=TURBULENCE,
        year=YEAR,
        pictures=pictures,
        rows=[_cells(row) for row in rows],
        panels=[(f"{TITLES[name]}", _by_wind(study, name)) for name in PANELS],
    )
    return files


def _cells(row: Row) -> dict[str, object]:
    proof = row.proof or {}
    cells = dict(row.point.words)
    for name, title in TITLES.items():
        spread = row.figures.get(name)
        cells[title] = spread and spread.mean
        if spread and name == "tower_del":
            cells[title] = f"{spread.mean:.4g} ({spread.least:.3g} to {spread.largest:.3g})"
    if "windows" in proof:
        cells["proved"] = f"{proof['proved_windows']} of {proof['windows']} winds"
    else:
        cells["proved"] = proof.get("verdict", proof.get("error", "nothing can be"))
    cells["decay [1/s]"] = proof.get("least_decay_rate [1/s]", proof.get("least_decay [1/s]"))
    cells["wind error [m/s]"] = proof.get("mean_wind_error [m/s]")
    cells["front"] = "yes" if row.front else ""
    return cells


def _by_wind(study: OverlapStudy, name: str) -> list[dict[str, object]]:
    """Return the mean over the seeds, a row a point and a column a wind."""
    rows = []
    for point, runs in zip(study.points, study.runs, strict=True):
        row = dict(point.words)
        for wind in study.means:
            of_wind = [run for run in runs if run["wind"] == wind]
            failed = any(run["reason"] for run in of_wind)
            mean = None if failed else float(np.mean([run[name] for run in of_wind]))
            row[f"{wind:g} m/s"] = mean
        rows.append(row)
    return rows


def _csv(study: OverlapStudy) -> str:
    table = []
    for point, runs in zip(study.points, study.runs, strict=True):
        series = point.series
        head = {
            "series": point.name,
            "unit": series.kind.unit if series else "",
            "overlap": point.value if series else None,
            "law": point.asked["law"],
        }
        table += [{**head, **run} for run in runs]
    return rows_csv(table)


def _json(study: OverlapStudy, rows: Sequence[Row]) -> str:
    data = {
        "model": study.turbine.name,
        "winds": list(study.means),
        "turbulence": TURBULENCE,
        "seeds": study.seeds,
        "duration": study.duration,
        "points": [
            {
                "series": row.point.name,
                "value": row.point.value if row.point.series else None,
                **row.point.asked,
                "front": row.front,
                "figures": {name: spread._asdict() for name, spread in row.figures.items()},
                "proof": row.proof,
            }
            for row in rows
        ],
    }
    return json.dumps(data, indent=2, allow_nan=False) + "\n"


# Name of a series -> the column of the figure, and what its values are divided by, with the unit.
COLUMNS = {
    "speed-overlap": (0, 1.0, "overlap in speed [rad/s]"),
    "centred-overlap": (0, 1.0, "overlap in speed [rad/s]"),
    "torque-overlap": (1, 1e3, "torque window [kN m]"),
    "overlap": (2, 1.0, "effort overlap [rad/s²]"),
}
MARKERS = ("o", "s", "^", "D", "*")


def overlap_figure(study: OverlapStudy, rows: Sequence[Row]) -> Figure | None:
    """Return loads and power over each overlap; None if no series has two points with figures."""
    lines = {
        series.kind.name: [row for row in rows if row.point.series is series and row.figures]
        for series in SERIES
    }
    drawn = [name for name, line in lines.items() if len(line) > 1]
    if not drawn:
        return None
    places = sorted({COLUMNS[name][0] for name in drawn})
    with house_style():
        height = 1.9 * len(PANELS) + 0.5
        figure, panels = new_figure(len(PANELS), len(places), height=height)
        for k, quantity in enumerate(PANELS):
            of_row = panels[k * len(places) : (k + 1) * len(places)]
            for name in drawn:
                axes = of_row[places.index(COLUMNS[name][0])]
                number = [series.kind.name for series in SERIES].index(name)
                _line(axes, lines[name], quantity, COLUMNS[name][1], number)
            _finish(of_row, rows, quantity)
        for axes, place in zip(panels[-len(places) :], places, strict=True):
            axes.set_xlabel(next(words for at, _, words in COLUMNS.values() if at == place))
        handles = {text: handle for axes in panels for handle, text in zip(
            *axes.get_legend_handles_labels(), strict=True)}  # fmt: skip
        figure.legend(handles.values(), handles.keys(), loc="outside upper center", ncols=2)
    return figure


def _line(axes: Axes, line: Sequence[Row], quantity: str, scale: float, number: int) -> None:
    colour, marker = COLOURS[number], MARKERS[number]
    x = [row.point.value / scale for row in line]
    spreads = [row.figures[quantity] for row in line]
    axes.fill_between(
        x, [s.least for s in spreads], [s.largest for s in spreads],
        color=colour, alpha=0.2, linewidth=0,
    )  # fmt: skip
    axes.plot(x, [s.mean for s in spreads], color=colour, label=line[0].label)
    for place, row in zip(x, line, strict=True):
        face = colour if row.proved else "white"
        mean = row.figures[quantity].mean
        axes.plot(place, mean, marker, color=colour, markerfacecolor=face, markersize=5)


def _finish(of_row: Sequence[Axes], rows: Sequence[Row], quantity: str) -> None:
    """Give the panels of a quantity one scale, and the reference controller's line."""
    spreads = [row.figures[quantity] for row in rows if row.figures]
    least, largest = min(s.least for s in spreads), max(s.largest for s in spreads)
    decades = largest > DECADES * least > 0
    for axes in of_row:
        for row in rows:
            if row.point.series is None and row.figures:
                mean = row.figures[quantity].mean
                axes.axhline(mean, color=GREY, linestyle="--", linewidth=1.0, label=row.label)
        if decades:
            axes.set_yscale("log")
            axes.set_ylim(least / 1.1, largest * 1.1)
            ticks = [k * 10.0**n for n in range(-3, 4) for k in (1, 2, 3, 5)]
            shown = [tick for tick in ticks if least / 1.1 <= tick <= largest * 1.1]
            axes.set_yticks(shown, [f"{tick:g}" for tick in shown])
            axes.set_yticks([], minor=True)
        else:
            margin = 0.06 * (largest - least)
            axes.set_ylim(least - margin, largest + margin)
        axes.tick_params(labelleft=axes is of_row[0])
    of_row[0].set_ylabel(TITLES[quantity])


def front_figure(rows: Sequence[Row]) -> Figure | None:
    """Return power over tower load, a mark an overlap and the front as a line.

    Laws with more than ``NEAR`` times the least load would hide the others: the title says how many
    they are.
    """
    finished = [row for row in rows if row.figures]
    if len(finished) < 2:
        return None
    limit = NEAR * min(row.figures["tower_del"].mean for row in finished)
    shown = [row for row in finished if row.figures["tower_del"].mean <= limit]
    with house_style():
        figure, (axes,) = new_figure(height=4.6)
        front = sorted((r.figures["tower_del"].mean, r.figures["mean_power"].mean)
                       for r in shown if r.front)  # fmt: skip
        axes.plot(*zip(*front, strict=True), color=GREY, linewidth=1.0, label="front")
        for number, series in enumerate((*SERIES, None)):
            line = [row for row in shown if row.point.series is series]
            colour = COLOURS[number] if series else GREY
            for row in line:
                load, power = row.figures["tower_del"], row.figures["mean_power"]
                axes.errorbar(
                    load.mean, power.mean,
                    xerr=[[load.mean - load.least], [load.largest - load.mean]],
                    color=colour, marker=MARKERS[number], linewidth=0.5, markersize=6,
                    markerfacecolor=colour if row.proved or series is None else "white",
                    label=row.label if row is line[0] else None,
                )  # fmt: skip
        _mark_values(axes, shown)
        if len(shown) < len(finished):
            words = f"{len(finished) - len(shown)} laws with more than {limit:.3g} MN m not shown"
            axes.set_title(words)
        axes.set(xlabel=TITLES["tower_del"], ylabel=TITLES["mean_power"])
        figure.legend(loc="outside upper center", ncols=2)
    return figure


def _mark_values(axes: Axes, shown: Sequence[Row]) -> None:
    """Write each overlap beside its mark, unless one is written there already."""
    written: list[tuple[float, float]] = []
    axes.autoscale_view()
    to_axes = axes.transData + axes.transAxes.inverted()
    for row in shown:
        if row.point.series is None:
            continue
        value = row.point.value / COLUMNS[row.point.series.kind.name][1]
        place = (row.figures["tower_del"].mean, row.figures["mean_power"].mean)
        x, y = to_axes.transform(place)
        if all(abs(x - a) > CLOSE[0] or abs(y - b) > CLOSE[1] for a, b in written):
            written.append((x, y))
            colour = COLOURS[SERIES.index(row.point.series)]
            axes.annotate(f"{value:g}", place, fontsize=8, color=colour,
                          xytext=(5, 4), textcoords="offset points")  # fmt: skip
