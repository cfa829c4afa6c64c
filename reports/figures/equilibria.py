"""The number of equilibria over constant wind: one bar per law, one colour and hatch per answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from takagi.certificates.equilibrium.answers import EquilibriumCell
from takagi.models.errors import ModelError
from takagi.reports.figures.style import COLOURS, house_style, new_figure, wind_axis

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.figure import Figure

# Answer -> (colour, hatch), in the order of the legend; what is not known stays white.
LOOKS = {
    "one at the trim": (COLOURS[0], ""),
    "one": (COLOURS[4], ""),
    "one off the trim": (COLOURS[5], "//"),
    "none": (COLOURS[6], ""),
    "several": (COLOURS[1], "xx"),
    "continuum": (COLOURS[3], ".."),
}


def equilibria_figure(found: Mapping[str, Sequence[EquilibriumCell]]) -> Figure:
    """Return the answers of each law over constant wind [m/s].

    Parameters
    ----------
    found : name of a loop -> its cells, as ``ClosedLoopEquilibria.spans`` returns them.

    Raises
    ------
    ModelError : nothing to draw.
    """
    cells = [cell for row in found.values() for cell in row]
    if not cells:
        raise ModelError("no loop was given; a figure of rests needs the cells of one at least")
    with house_style():
        figure, (axes,) = new_figure(1, 1, height=1.3 + 0.32 * len(found))
        handles: dict[str, Artist] = {}
        for place, row in enumerate(found.values()):
            for cell in (c for c in row if c.rests in LOOKS):
                colour, hatch = LOOKS[cell.rests]
                low, high = cell.wind
                bars = axes.barh(
                    place, high - low, left=low, height=0.62, color=colour, hatch=hatch,
                    edgecolor="white", linewidth=0,
                )  # fmt: skip
                handles[cell.rests] = bars[0]
        axes.set_yticks(range(len(found)), list(found))
        axes.set_ylim(len(found) - 0.5, -0.5)
        axes.grid(visible=False, axis="y")
        wind_axis(axes)
        axes.set_xlabel("constant wind [m/s]")
        axes.set_xlim(min(c.wind[0] for c in cells), max(c.wind[1] for c in cells))
        order = [name for name in LOOKS if name in handles]
        figure.legend([handles[n] for n in order], order, loc="outside lower center", ncols=3)
    return figure
