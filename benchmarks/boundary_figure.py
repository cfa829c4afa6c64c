"""The published laws over wind and overlap: proved cells, and simulated starts and gusts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from disturbance_trials import CYCLES, LOST, STAYS
from numpy.typing import NDArray

from takagi.models.arrays import Floats
from takagi.reports.csv_text import csv_text
from takagi.reports.figures.style import COLOURS, house_style, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

WORDS = {STAYS: "stays", CYCLES: "cycles", LOST: "loses the trim"}
MARKS = {STAYS: ("o", COLOURS[4]), CYCLES: ("s", COLOURS[5]), LOST: ("X", COLOURS[6])}
RING = "proved for the first-order drive"


@dataclass(frozen=True, slots=True, eq=False)
class Boundary:
    """The proved and the simulated results of one law.

    Attributes
    ----------
    winds [m/s], overlaps [rad/s], disturbances : the axes.
    proved : (overlaps, winds);  codes, overspeed [-] : pitch drive -> (overlaps, winds,
        disturbances).
    """

    law: str
    winds: Sequence[float]
    overlaps: Sequence[float]
    disturbances: Sequence[str]
    proved: NDArray[np.bool_]
    codes: Mapping[str, NDArray[np.int64]]
    overspeed: Mapping[str, Floats]

    def summary(self) -> dict[str, Any]:
        """Return counts: proved places; per drive, runs by outcome, inside and outside of them."""
        found: dict[str, Any] = {"places": int(self.proved.size), "proved": int(self.proved.sum())}
        for drive, codes in self.codes.items():
            for name, where in (("where proved", self.proved), ("elsewhere", ~self.proved)):
                counts = np.bincount(codes[where].ravel(), minlength=3)
                found[f"{drive}, {name}"] = {
                    WORDS[code]: int(counts[code]) for code in (STAYS, CYCLES, LOST)
                }
            found[f"{drive}, largest overspeed [%]"] = float(100 * self.overspeed[drive].max())
        return found


def boundary_figure(found: Boundary) -> Figure:
    """Return per drive the worst outcome at each wind and overlap, ringed where it is proved."""
    with house_style():
        figure, panels = new_figure(1, len(found.codes), width=7.4, height=4.2)
        for axes, (drive, codes) in zip(panels, found.codes.items(), strict=True):
            _panel(axes, found, codes.max(axis=2))
            axes.set_title(drive)
        panels[0].set_ylabel("speed overlap $\\epsilon_\\omega$ [rad/s]")
        figure.legend(*_legend(panels), loc="outside lower center", ncols=4)
    return figure


def _panel(axes: Axes, found: Boundary, worst: NDArray[np.int64]) -> None:
    for code, (marker, colour) in MARKS.items():
        places = np.argwhere(worst == code)
        if len(places):
            axes.scatter(
                [found.winds[j] for _, j in places],
                [i for i, _ in places],
                s=70,
                marker=marker,
                color=colour,
                label=WORDS[code],
                zorder=2,
            )
    held = np.argwhere(found.proved)
    axes.scatter(
        [found.winds[j] for _, j in held],
        [i for i, _ in held],
        s=260,
        facecolors="none",
        edgecolors=COLOURS[0],
        linewidths=1.6,
        label=RING,
        zorder=3,
    )
    axes.set_yticks(range(len(found.overlaps)), [f"{x:g}" for x in found.overlaps])
    axes.set_xticks(list(found.winds), [f"{x:g}" for x in found.winds])
    axes.set_xlabel("wind [m/s]")
    axes.set_ylim(-0.6, len(found.overlaps) - 0.4)


def _legend(panels: Sequence[Axes]) -> tuple[list[Any], list[str]]:
    """Return each kind of mark once, wherever it occurs, the ring last."""
    seen: dict[str, Any] = {}
    for axes in panels:
        handles, labels = axes.get_legend_handles_labels()
        seen |= dict(zip(labels, handles, strict=True))
    order = [name for name in (*WORDS.values(), RING) if name in seen]
    return [seen[name] for name in order], order


def boundary_csv(found: Boundary) -> str:
    """Return one line per drive, overlap, wind and disturbance."""
    head = (
        "pitch drive", "speed overlap [rad/s]", "wind [m/s]", "disturbance", "outcome",
        "largest overspeed [%]", "proved",
    )  # fmt: skip
    rows: list[tuple[object, ...]] = []
    for drive, codes in found.codes.items():
        for (i, j, k), code in np.ndenumerate(codes):
            over = 100 * found.overspeed[drive][i, j, k]
            place = (found.overlaps[i], found.winds[j], found.disturbances[k])
            held = "yes" if found.proved[i, j] else "no"
            rows.append((drive, *place, WORDS[int(code)], f"{over:.2f}", held))
    return csv_text(head, rows)
