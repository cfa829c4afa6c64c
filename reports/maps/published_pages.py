"""The files of the published law's map: figures, tables, data and a page."""

from __future__ import annotations

from collections.abc import Sequence

from takagi.certificates.sweep.grid import PointResult, SweepResult
from takagi.models.laws.law_words import law_words
from takagi.reports.figures.writing import figure_to_svg
from takagi.reports.maps.published_overlaps import overlap_map_figure
from takagi.reports.maps.published_rows import grid, of_windows, reason_counts, windows_of
from takagi.reports.maps.published_winds import wind_slices_figure
from takagi.reports.maps.table import map_json, points_csv, rows_csv


def pages(result: SweepResult) -> dict[str, bytes | str]:
    """Return file name -> content: map.md, map.json, points.csv, windows.csv, figures/."""
    return {**tables(result), **figures(result)}


def tables(result: SweepResult) -> dict[str, bytes | str]:
    """Return the page, and the data as JSON and CSV."""
    return {
        "map.md": _page(result),
        "map.json": map_json(result),
        "points.csv": points_csv(result, of_windows),
        "windows.csv": _windows_csv(result),
    }


def figures(result: SweepResult) -> dict[str, bytes | str]:
    """Return the figures as SVG."""
    overlaps, winds = overlap_map_figure(grid(result)), wind_slices_figure(result)
    return {
        "figures/overlaps.svg": figure_to_svg(
            overlaps,
            name="sweep-overlaps",
            description="winds proved, first wind not proved, least decay rate over both overlaps",
        ),
        "figures/winds.svg": figure_to_svg(
            winds, name="sweep-winds", description="proved winds over the speed overlap"
        ),
    }


def _windows_csv(result: SweepResult) -> str:
    """Return a row a window and point; the law that is compared with has no overlaps."""
    units = {axis.name: axis.unit for axis in result.map.axes}
    rows = []
    for part in (result, *result.beside):
        for point in part.points:
            at = {f"{name} [{unit}]": point.at.get(name) for name, unit in units.items()}
            for window in windows_of(point):
                low, high = window["wind [m/s]"]
                rest = {k: v for k, v in window.items() if k != "wind [m/s]"}
                rows.append(
                    {"law": part.map.name, **at, "from [m/s]": low, "to [m/s]": high} | rest
                )
    return rows_csv(rows)


def _page(result: SweepResult) -> str:
    windows = result.map.settings["windows"]
    name = result.map.settings["model"]["name"]
    sizes = result.map.settings["sets [rad/s]"]
    lines = [
        f"# {name}: where the {law_words(result.map.name)} is proved",
        "",
        f"{len(result.points)} pairs of overlaps; at each, {len(windows)} windows of constant wind "
        f"from {windows[0][0]:g} to {windows[-1][1]:g} m/s, each "
        f"{windows[0][1] - windows[0][0]:.3g} m/s wide. PROVED is the independent checker's "
        "word on the emitted decimals: in a set around its rest point the loop with the design "
        "model's pitch drive has exactly one equilibrium, and every motion from the set tends to "
        f"it at the stated rate. Sets of {max(sizes):g} down to {min(sizes):g} rad/s in rotor "
        "speed were tried. Winds between the windows are not claimed.",
        "",
        *_counts(result),
        "",
        "![over both overlaps](figures/overlaps.svg)",
        "",
        "![over wind](figures/winds.svg)",
        "",
        *_beside(result),
        "## What is not proved, and why",
        "",
        *_reasons(result),
        "",
        "`points.csv` has a row a pair of overlaps, `windows.csv` a row a window, `map.json` "
        "everything with the settings. `points.jsonl` is the journal.",
        "",
    ]
    return "\n".join(lines)


def _counts(result: SweepResult) -> list[str]:
    words = {
        "PROVED": "all winds proved",
        "PARTLY": "some winds proved",
        "UNDECIDED": "no wind proved, or no such law",
        "FAILED": "ended in an error; run the same sweep again",
    }
    rows = [f"| {words[v]} | {n} |" for v, n in sorted(result.counted().items())]
    return ["| pairs of overlaps | number |", "|---|---|", *rows]


def _beside(result: SweepResult) -> list[str]:
    return [
        line
        for other in result.beside
        for line in (
            f"The effort-sharing law (`{other.map.name}`), with gains found in two steps, at the "
            "same winds: "
            f"{_said(other.points[0])}.",
            "",
        )
    ]


def _said(point: PointResult) -> str:
    proved = [w for w in windows_of(point) if w["decay_rate [1/s]"] is not None]
    if not proved:
        return f"{point.result['verdict']}: {point.result['reason']}"
    rates = [w["decay_rate [1/s]"] for w in proved]
    return (
        f"{len(proved)} of {len(windows_of(point))} proved, decay {min(rates):.3g} to "
        f"{max(rates):.3g} 1/s"
    )


def _reasons(result: SweepResult) -> list[str]:
    lost: Sequence[PointResult] = [p for p in result.points if not windows_of(p)]
    rows = [
        f"| {words} | {count} | {low:g} to {high:g} |"
        for words, count, low, high in reason_counts(result)
    ]
    rows += [f"| {p.result['reason']} | a whole point | |" for p in lost]
    if not rows:
        return ["Everything is proved."]
    return ["| reason | windows | winds [m/s] |", "|---|---|---|", *rows]
