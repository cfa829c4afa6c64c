"""The files of the effort-sharing law's maps: figures, tables, data and a page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.certificates.sweep.grid import SweepResult
from takagi.models.laws.law_words import law_words
from takagi.reports.figures.writing import figure_to_pdf, figure_to_svg
from takagi.reports.maps.effort_sharing_effects import effect_figure, pair_figure
from takagi.reports.maps.effort_sharing_rows import (
    ERROR,
    OVERSPEED,
    RATE,
    flat,
    front,
    guaranteed_pairs,
    wind_words,
)
from takagi.reports.maps.effort_sharing_trade_off import claim_winds, trade_off_figure
from takagi.reports.maps.table import map_json, rows_csv
from takagi.reports.page.rounded_bounds import at_least, at_least_to, at_most_to

if TYPE_CHECKING:
    from matplotlib.figure import Figure

KEPT = (
    "PROVED means that the independent checker has verified the emitted decimals. |v - v_s| is the "
    "distance of the wind from the law's schedule wind and |v_s'| the rate of the schedule wind. "
    "Both may occur at the same time, in every wind cell; the rotor speed then never exceeds the "
    "overspeed bound."
)


def pages(result: SweepResult) -> dict[str, bytes | str]:
    """Return file name -> content: map.md, map.json, points.csv, figures/."""
    units = {axis.name: axis.unit for axis in result.map.axes}
    found: dict[str, bytes | str] = {
        "map.json": map_json(result),
        "points.csv": rows_csv([flat(point, units) for point in result.points]),
    }
    drawn = _figure(result)
    name = result.map.settings["model"]["name"]
    lines = [f"# {name}: the {law_words(result.map.name)}", "", f"{_counts(result)}. {KEPT}", ""]
    if drawn is not None:
        figure, stem, description = drawn
        found[f"figures/{stem}.svg"] = figure_to_svg(
            figure, name=f"sweep-{stem}", description=description
        )
        found[f"figures/{stem}.pdf"] = figure_to_pdf(figure)
        lines += [f"![{description}](figures/{stem}.svg)", ""]
    lines += _table(result)
    lines += ["", "## What is not proved, and why", "", *_reasons(result), ""]
    found["map.md"] = "\n".join(lines)
    return found


def _figure(result: SweepResult) -> tuple[Figure, str, str] | None:
    """Return the figure that suits the axes, its file's stem and what it shows; None for others."""
    if not any(point.result["verdict"] in ("PROVED", "PARTLY") for point in result.points):
        return None
    if claim_winds(result):
        return trade_off_figure(result), "trade-off", "wind class against overspeed bound, by range"
    sizes = [len(axis.values) for axis in result.map.axes]
    if len(sizes) == 1 and sizes[0] > 1:
        axis = result.map.axes[0].name
        return effect_figure(result), "effect", f"wind class, overspeed and decay over {axis}"
    if len(sizes) == 2 and min(sizes) > 1:
        names = " and ".join(axis.name for axis in result.map.axes)
        return pair_figure(result), "pair", f"wind class, overspeed and decay over {names}"
    return None


def _counts(result: SweepResult) -> str:
    counted = ", ".join(f"{n} {verdict}" for verdict, n in sorted(result.counted().items()))
    count = len(result.points)
    return f"{count} point{'s' if count > 1 else ''}: {counted}"


def _table(result: SweepResult) -> list[str]:
    if claim_winds(result):
        return _front_table(result)
    heads = [f"{axis.name} [{axis.unit}]" for axis in result.map.axes]
    columns = ("verdict", OVERSPEED, "common_decay [1/s]", "energy_cost [%]")
    rows = []
    for point in result.points:
        classes = [
            f"{each[ERROR]:.3g} at {each[RATE]:.3g}" for each in point.result.get("ranges", [])
        ]
        own = [_shown(point.result.get(key)) for key in columns]
        rows.append([*(f"{value:g}" for value in point.at.values()), *own, "; ".join(classes)])
    heads += [*columns, "mean |v - v_s| [m/s] at mean |v_s'| [m/s^2], by range"]
    return _markdown(heads, rows)


def _front_table(result: SweepResult) -> list[str]:
    """Return, per range, the claims that no other beats."""
    axes = [f"{axis.name} [{axis.unit}]" for axis in result.map.axes]
    heads = [
        "winds",
        *axes,
        "overspeed [%]",
        "|v - v_s| mean, least [m/s]",
        "|v_s'| mean, least [m/s^2]",
        "common decay [1/s]",
    ]
    rows = [
        [
            f"{name}, {wind_words(low, high)}",
            *(f"{line.at[axis.name]:g}" for axis in result.map.axes),
            at_most_to(line.overspeed, 2),
            f"{at_least_to(line.mean_error, 3)}, {at_least_to(line.least_error, 3)}",
            f"{at_least(line.mean_rate)}, {at_least(line.least_rate, 2)}",
            at_least(line.decay),
        ]
        for name, (low, high) in claim_winds(result).items()
        for line in front(guaranteed_pairs(result, name))
    ]
    return _markdown(heads, rows)


def _reasons(result: SweepResult) -> list[str]:
    """Return a row a reason: at how many points it is given, and at the first of them."""
    found: dict[tuple[str, str], list[str]] = {}
    for point in result.points:
        at = ", ".join(f"{name} {value:g}" for name, value in point.at.items())
        claims = point.result.get("claims", {"": point.result})
        for name, claim in claims.items():
            if claim["reason"]:
                found.setdefault((name, claim["reason"]), []).append(at)
    rows = [[name, why, str(len(at)), at[0]] for (name, why), at in found.items()]
    heads = ["claim", "reason", "points", "first at"]
    return _markdown(heads, rows) if rows else ["Everything is proved."]


def _markdown(heads: list[str], rows: list[list[str]]) -> list[str]:
    lines = [_line(heads), "|" + "---|" * len(heads)]
    return [*lines, *(_line(row) for row in rows)]


def _line(cells: list[str]) -> str:
    # A vertical bar would end the table cell.
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def _shown(value: object) -> str:
    if isinstance(value, float | int):
        return f"{value:.4g}"
    return "" if value is None else str(value)
