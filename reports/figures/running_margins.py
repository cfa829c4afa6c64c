"""Margins of the loop that runs over wind: as its file says, and the least of all plants."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.reports.figures.style import COLOURS, columns, house_style, new_figure, wind_axis

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Where a margin has no bound its line ends; more than these is more than enough.
PANELS = {
    "gain": ("gain may grow by [-]", (1.0, 10.0)),
    "phase": ("phase [°]", (0.0, 120.0)),
    "delay": ("delay [s]", (0.01, 20.0)),
    "disk": ("disk $\\alpha$ [-]", (0.0, 2.0)),
}
LOGARITHMIC = ("gain", "delay")


@dataclass(frozen=True, slots=True, eq=False)
class MarginLine:
    """One loop over wind; arrays (n,), nan where it does not act.

    Attributes
    ----------
    label : such as ``"torque"``.
    nominal, least : panel -> margins, of the machine as its file says and the least of all; nan
        where the others were not examined.
    """

    label: str
    nominal: dict[str, Floats]
    least: dict[str, Floats]


def running_margins_figure(winds: Floats, lines: Sequence[MarginLine]) -> Figure:
    """Return four panels over wind: gain, phase, delay, disk; bands reach to the least.

    Raises
    ------
    ModelError : no lines, or arrays of another length than the winds.
    """
    if not lines:
        raise ModelError("no loops were given; at least one line is needed")
    with house_style():
        figure, panels = new_figure(2, 2, height=5.2, share_x=True)
        for axes, (name, (label, (low, high))) in zip(panels, PANELS.items(), strict=True):
            for line, colour in zip(lines, COLOURS, strict=False):
                both = [line.nominal[name], line.least[name]]
                shown, least = columns(f"{line.label}, {name}", both, len(winds))
                known = ~np.isnan(least)
                axes.plot(winds, np.clip(shown, low, high), color=colour, label=line.label)
                axes.fill_between(
                    winds[known],
                    np.clip(least[known], low, high),
                    np.clip(shown[known], low, high),
                    color=colour,
                    alpha=0.25,
                    linewidth=0,
                )
            axes.set_ylabel(label)
            if name in LOGARITHMIC:
                axes.set_yscale("log")
            axes.set_ylim(low, high)
            wind_axis(axes, ticks=6)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels))
    return figure
