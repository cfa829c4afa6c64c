"""Draws how probable an overspeed is in turbulence: Rice's bound of the linear loop, beside runs.

    python benchmarks/turbulence_crossing_curve.py             docs/figures/turbulence-crossing.svg
    python benchmarks/turbulence_crossing_curve.py GAINS.json  computes its numbers first (minutes)

The numbers stand in docs/figures/turbulence-crossing.csv.  ``bound`` is Rice's formula for the loop
of ``turbulence_exit_loop``, linearised at the mean wind, with nominal parameters, ``worst`` the
largest of its 32 vertices; ``runs`` is the share of 400 simulated runs of the nonlinear loop of
``turbulence_exit_about_schedule``.  All are for ten minutes from rest and floating point.
Turbulence of class A is that of class B times 16/14 (IEC 61400-1, reference intensities 0.16 and
0.14), so its bounds are those of class B at 14/16 of the room.
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterator
from math import log10
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.linalg import solve_continuous_lyapunov
from turbulence_exit_about_schedule import RATED, Loop
from turbulence_exit_comparison import HORIZON, crossed
from turbulence_exit_loop import E, Law, room, system

from takagi.reports.csv_text import csv_text
from takagi.reports.figures.style import COLOURS, STYLES, house_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FIGURES = Path(__file__).parent.parent / "docs" / "figures"
PANELS = ((8.0, 10.0, 11.0), (11.4, 12.0, 13.0), (15.0, 18.0, 23.0))  # m/s
SIMULATED, RUNS = (11.0, 12.0, 13.0, 15.0, 18.0, 23.0), 400
CLASSES = {"B": 1.0, "A": 16 / 14}
OVERSPEEDS = np.arange(3.0, 31.0)  # per cent
LEAST = 1e-9
LEGEND = (
    (STYLES[0], "", "bound of the linear loop"),
    (STYLES[3], "", "its worst vertex"),
    (STYLES[1], "", "bound, class A"),
    ("", "o", "nonlinear loop, 400 runs"),
)

Row = tuple[float, str, str, float, float]


def bounds(law: Law, wind: float) -> Iterator[Row]:
    """Yield Rice's bounds at one mean wind: both classes, nominal and the worst vertex."""
    for kind, uncertain in (("bound", False), ("worst", True)):
        one = system(law, wind, 0.1, uncertain=uncertain)
        spreads = []
        for A, S in zip(one.A, one.S, strict=True):
            X = solve_continuous_lyapunov(A, -S @ S.T)
            spreads.append((X[E, E] ** 0.5, (A @ X @ A.T)[E, E] ** 0.5))
        for name, scale in CLASSES.items():
            for over in OVERSPEEDS.tolist():
                b = room(law, wind, over / 100) / scale
                found = max(crossed(b, float(s), float(moved)) for s, moved in spreads)
                yield wind, name, kind, over, min(1.0, float(f"{found:.4g}"))


def runs(law: Law, wind: float) -> Iterator[Row]:
    """Yield the share of simulated runs of the nonlinear loop beyond each overspeed."""
    over = 100 * (Loop(law, wind).simulated(HORIZON, RUNS) / RATED - 1)
    for level in OVERSPEEDS.tolist():
        if (share := float((over > level).mean())) > 0:
            yield wind, "B", "runs", level, share


def draw(rows: list[Row]) -> None:
    """Draw a panel for each group of winds."""
    from matplotlib.lines import Line2D

    with house_style():
        figure, axes = new_figure(1, len(PANELS), width=9.0, height=3.7)
        for axis, winds in zip(axes, PANELS, strict=True):
            for wind, colour in zip(winds, COLOURS, strict=False):
                own = [row[1:] for row in rows if row[0] == wind]
                _lines(axis, own, colour, f"{wind:g} m/s")
            axis.set_ylim(log10(LEAST), 0.3)
            axis.set_xlim(OVERSPEEDS[0], OVERSPEEDS[-1])
            axis.set_yticks(range(-9, 1, 3), [f"$10^{{{k}}}$" for k in range(-9, 1, 3)])
            axis.set_xlabel("overspeed [% of rated]")
            axis.legend(loc="lower left")
        axes[0].set_ylabel("probability in ten minutes [-]")
        told = [
            Line2D([], [], color="#000000", ls=style, marker=marker, ms=3, label=label)
            for style, marker, label in LEGEND
        ]
        figure.legend(handles=told, loc="outside lower center", ncols=len(LEGEND))
        figure.savefig(FIGURES / "turbulence-crossing.svg", metadata={"Date": None})


def _lines(axis: Axes, rows: list[tuple[str, str, float, float]], colour: str, label: str) -> None:
    drawn: dict[tuple[str, str], dict[str, Any]] = {
        ("B", "bound"): {"ls": STYLES[0], "label": label},
        ("A", "bound"): {"ls": STYLES[1], "lw": 1.0},
        ("B", "worst"): {"ls": STYLES[3], "lw": 1.2},
        ("B", "runs"): {"ls": "", "marker": "o", "ms": 3},
    }
    for key, style in drawn.items():
        points = [(over, log10(p)) for kind, which, over, p in rows if (kind, which) == key]
        if points:
            x, y = zip(*points, strict=True)
            axis.plot(x, y, color=colour, **style)


def main() -> None:
    reader = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    reader.add_argument("gains", type=Path, nargs="?")
    given = reader.parse_args()
    path = FIGURES / "turbulence-crossing.csv"
    if given.gains is not None:
        law = Law.read(given.gains)
        rows = [row for winds in PANELS for wind in winds for row in bounds(law, wind)]
        rows += [row for wind in SIMULATED for row in runs(law, wind)]
        names = ("mean_wind_mps", "class", "kind", "overspeed_percent", "probability")
        path.write_text(csv_text(names, rows), encoding="utf-8")
    with path.open(encoding="utf-8") as file:
        found = list(csv.reader(line for line in file if not line.startswith("#")))[1:]
    draw([(float(r[0]), r[1], r[2], float(r[3]), float(r[4])) for r in found])


if __name__ == "__main__":
    main()
