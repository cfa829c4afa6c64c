"""The trade-off curve: overspeed bound against wind class, one panel a range of winds."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from takagi.certificates.sweep.grid import SweepResult
from takagi.reports.figures.style import GREY, SEQUENTIAL, house_style, new_figure
from takagi.reports.maps.effort_sharing_rows import Line, front, guaranteed_pairs, wind_words

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def claim_winds(result: SweepResult) -> dict[str, tuple[float, float]]:
    """Return name -> winds [m/s] of the claims that a trade-off makes, the widest first."""
    found: dict[str, tuple[float, float]] = {}
    for point in result.points:
        for name, claim in point.result.get("claims", {}).items():
            if "winds [m/s]" in claim:
                low, high = claim["winds [m/s]"]
                found.setdefault(name, (low, high))
    return dict(sorted(found.items(), key=lambda item: (item[1][0], -item[1][1])))


def trade_off_figure(result: SweepResult) -> Figure:
    """Return a panel per claim: mean |v - v_s| over overspeed, shaded by the mean |v_s'|.

    Ringed: no other point has less overspeed, no smaller error and no smaller rate; the line joins
    those whose error is the largest yet, whatever their rate.
    """
    from matplotlib.colors import Normalize

    winds = claim_winds(result)
    across = 2
    rows = max((len(winds) + 1) // across, 1)
    with house_style():
        figure, panels = new_figure(rows, across, width=8.0, height=3.2 * rows)
        for panel in panels[len(winds) :]:
            panel.set_axis_off()
        for panel, (name, (low, high)) in zip(panels, winds.items(), strict=False):
            lines = guaranteed_pairs(result, name)
            best = front(lines)
            rates = np.array([line.mean_rate for line in lines])
            shade = Normalize(0.0, max(rates.max(initial=0.0), 1e-3))
            drawn = panel.scatter(
                *_places(lines), c=rates, cmap=SEQUENTIAL, norm=shade, s=22, edgecolors=GREY, lw=0.4
            )
            panel.scatter(*_places(best), s=75, facecolors="none", edgecolors="#D55E00", lw=1.4)
            panel.plot(*_places(_upper(best)), color="#D55E00", lw=1.0)
            figure.colorbar(drawn, ax=panel, label="mean |v$_s$'| [m/s\u00b2]")
            panel.set_title(f"{name}, {wind_words(low, high)}")
            panel.set_xlabel("overspeed bound [%]")
            panel.set_ylabel("mean |v \u2212 v$_s$| [m/s]")
    return figure


def _places(lines: list[Line]) -> tuple[list[float], list[float]]:
    return [line.overspeed for line in lines], [line.mean_error for line in lines]


def _upper(lines: list[Line]) -> list[Line]:
    """Return the points along which the error grows with the overspeed, whatever the rate."""
    kept: list[Line] = []
    for line in lines:
        if not kept or line.mean_error > kept[-1].mean_error:
            kept.append(line)
    return kept
