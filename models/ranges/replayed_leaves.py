"""The enclosures on the leaves of a tree of boxes, computed again without a search."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, TypeVar

from takagi.models.errors import ModelError
from takagi.models.intervals.box_search import SIDES, Ends
from takagi.models.ranges.cell import Cell
from takagi.models.ranges.cell_enclosures import enclosed_by_letter, halve
from takagi.models.ranges.cell_search import cell_root, fraction

if TYPE_CHECKING:
    import sympy as sp

Place = TypeVar("Place")


def replayed_bounds(
    expression: sp.Expr,
    cells: Sequence[Cell],
    symbols: Sequence[tuple[str, ...]],
    trees: Sequence[str],
    precision: int,
) -> tuple[Fraction, Fraction]:
    """Return the hull of the enclosures on the leaves of all trees; see ``Evidence.replay``."""
    import flint

    if not len(cells) == len(trees) == len(symbols):
        raise ModelError(f"evidence for {len(trees)} cells was given; the domain has {len(cells)}")
    ends: list[tuple[Fraction, Fraction]] = []
    with flint.ctx.workprec(precision):
        parts = zip(cells, trees, symbols, strict=True)
        for number, (cell, tree, names) in enumerate(parts, start=1):
            root = cell_root(expression, cell)
            if root.names != names:
                raise ModelError(
                    f"the trees of cell {number} halve {', '.join(names) or 'nothing'}; the "
                    f"expression has the sides {', '.join(root.names) or 'none'}"
                )
            start = root.start("b" in tree)
            for low, high in leaves_of(
                tree, (root, start), len(root.symbols), halve, enclosed_by_letter
            ):
                ends.append((fraction(low), fraction(high)))
    return min(low for low, _ in ends), max(high for _, high in ends)


def leaves_of(
    tree: str,
    root: Place,
    sides: int,
    halve: Callable[[Place, int], tuple[Place, Place]],
    enclose: Callable[[str, Place], Ends | None],
) -> list[Ends]:
    """Return the enclosure on each leaf of a tree.

    Raises
    ------
    ModelError : a letter that is unknown, a tree that ends early or late, a leaf without bound.
    """
    found, left = [], [root]
    for position, letter in enumerate(tree, start=1):
        if not left:
            raise ModelError(f"a tree of boxes goes on after its end, at character {position}")
        place = left.pop()
        number = SIDES.find(letter)
        if number >= 0:
            if number >= sides:
                raise ModelError(
                    f"a tree of boxes halves side {number} at character {position}; there are "
                    f"{sides} sides"
                )
            left += reversed(halve(place, number))
            continue
        ends = enclose(letter, place)
        if ends is None:
            raise ModelError(f"the leaf {letter!r} at character {position} of a tree has no bound")
        found.append(ends)
    if left:
        raise ModelError(f"a tree of boxes ends early: {len(left)} boxes are missing")
    return found
