"""A domain that is not a box, in LaTeX."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.equations.step import Step

if TYPE_CHECKING:
    from takagi.models.intervals.interval import Interval
    from takagi.models.ranges.cell import Cell
    from takagi.models.ranges.domain import Domain

MOST_SHOWN = 4


def domain_steps(domain: Domain | None) -> tuple[Step, ...]:
    """Return the steps of the derivation about a band or a union of cells; none for a box."""
    if domain is None:
        return ()
    count = len(domain.cells)
    shown = [_cell(cell) for cell in domain.cells[:MOST_SHOWN]]
    title = "Domain: the bounds hold there, not on the whole box around it"
    title += f"; {count} cells" if count > 1 else ""
    title += f", the first {MOST_SHOWN} of them are shown." if count > MOST_SHOWN else "."
    return (Step(title, r"\begin{gathered}" + r" \\ ".join(shown) + r"\end{gathered}"),)


def _cell(cell: Cell) -> str:
    import sympy as sp

    parts = [rf"{sp.latex(s)} \in {_ends(side)}" for s, side in cell.box.items()]
    parts += [f"{sp.latex(s)} = {sp.latex(place)}" for s, place in cell.places.items()]
    return r",\ ".join(parts)


def _ends(side: Interval) -> str:
    return rf"[{float(side.lower):.6g},\ {float(side.upper):.6g}]"
