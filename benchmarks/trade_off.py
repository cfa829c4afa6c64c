"""Makes the maps of docs/trade-off.md: what limits the law's wind class, and the trade-off.

    python benchmarks/trade_off.py [--journals DIR] [--workers N]

Every map is one of `takagi sweep nrel5mw --law effort-sharing`; finished points stay in the
journals, so that a run that was stopped goes on.  Figures and data are written into docs/figures.
Nothing is asserted; every number in the maps comes from a claim that the checker says is PROVED.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from takagi.certificates.sweep import effort_sharing_map as coherent_map
from takagi.certificates.sweep import trade_off
from takagi.certificates.sweep.axis import parse_axes  # noqa: E402
from takagi.certificates.sweep.grid import SweepResult  # noqa: E402
from takagi.certificates.sweep.runner import run_sweep  # noqa: E402
from takagi.models.turbine.loader import model_files, nrel5mw  # noqa: E402
from takagi.reports.figures.writing import figure_to_svg  # noqa: E402
from takagi.reports.maps.effort_sharing_effects import effect_figure, side_by_side_figure  # noqa: E402
from takagi.reports.maps.effort_sharing_rows import flat  # noqa: E402
from takagi.reports.maps.effort_sharing_trade_off import trade_off_figure  # noqa: E402
from takagi.reports.maps.table import rows_csv  # noqa: E402
from takagi.reports.output import write_folder  # noqa: E402

FIGURES = Path(__file__).parent.parent / "docs" / "figures"

OVERLAP = "overlap=0.002,0.003,0.005,0.0075,0.01,0.015,0.02,0.03,0.04,0.06"
EFFECTS = (
    "inertia=0,0.05,0.1,0.15,0.2,0.25,0.3,0.4",
    "power-coefficient=0,0.005,0.01,0.02,0.03,0.05",
    "frozen-wake=0,0.5,0.75,1,1.25,1.5,2",
    "pitch-lag=0.05,0.1,0.15,0.2,0.3,0.4,0.5,0.6",
    "wind-rate=0,0.25,0.5,1,1.5,2,3",
    "bandwidth=0.3,0.45,0.6,0.75,0.9",
)
TRADE_OFF = (
    "overlap=0.005,0.01,0.02",
    "bandwidth=0.45,0.6,0.75",
    "speed-error=0.02,0.03,0.04,0.05,0.08",
)


def main() -> None:
    """Run the maps, and write figures and data."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--journals", type=Path, default=Path("build") / "trade-off")
    parser.add_argument("--workers", type=int)
    given = parser.parse_args()
    overlap = swept(coherent_map, given, OVERLAP)
    effects = [swept(coherent_map, given, effect) for effect in EFFECTS]
    write_folder(FIGURES, pictures(overlap, effects, swept(trade_off, given, *TRADE_OFF)))


def swept(maker: Any, given: argparse.Namespace, *over: str) -> SweepResult:
    """Return the finished map over the axes."""
    turbine = nrel5mw()
    axes = parse_axes(over, maker.AXES)
    asked = maker.build("coherent", turbine, model_files("nrel5mw"), axes, None)
    name = "-".join(axis.name for axis in axes)
    return run_sweep(
        asked,
        given.journals / name,
        workers=given.workers,
        tell=lambda words, done=None: print(name, words, flush=True),
    )


def pictures(
    overlap: SweepResult, effects: list[SweepResult], traded: SweepResult
) -> dict[str, bytes | str]:
    """Return file name -> content: three figures, and a table for each."""
    figures = {
        "trade-off-overlap": (effect_figure(overlap), "class, overspeed and decay over overlap"),
        "trade-off-effects": (side_by_side_figure(effects), "wind class over six parameters"),
        "trade-off": (trade_off_figure(traded), "wind class against overspeed, by range"),
    }
    found: dict[str, bytes | str] = {
        f"{name}.svg": figure_to_svg(figure, name=name, description=words)
        for name, (figure, words) in figures.items()
    }
    found["trade-off-effects.csv"] = rows_csv(
        [row for result in (overlap, *effects) for row in rows(result)]
    )
    found["trade-off.csv"] = rows_csv(rows(traded))
    return found


def rows(result: SweepResult) -> list[dict[str, Any]]:
    """Return a row a point; the axes of a map of one axis stand in two columns."""
    units = {axis.name: axis.unit for axis in result.map.axes}
    found = [flat(point, units) for point in result.points]
    if len(units) > 1:
        return found
    (name, unit), *_ = units.items()
    key = f"{name} [{unit}]"
    return [
        {"axis": key, "value": row[key]} | {k: v for k, v in row.items() if k != key}
        for row in found
    ]


if __name__ == "__main__":
    main()
