"""Evidence of a proved range: the tree of boxes and how each leaf is enclosed.

A tree is text in preorder.  A digit or capital letter is the number of the side that is halved
(0-9, A-Z), followed by the lower and the upper half; a small letter ends a branch:

    p   plain evaluation in ball arithmetic
    s   with slopes: monotone variables at their ends, mean-value form in the others
    q   p, with the Taylor form towards removable poles on every box, not only near them
    t   s, likewise
    b   Bernstein coefficients, exact

Replaying needs no search: one enclosure for each leaf.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import TYPE_CHECKING, TypeVar

from takagi.models.errors import ModelError
from takagi.models.intervals.box_search import SIDES, Ends
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.cell_search import (
    Cell,
    cell_root,
    enclosed_by_letter,
    fraction,
    halve,
    parts_by_sign,
)
from takagi.models.ranges.domain import Domain, DomainLike, as_domain

if TYPE_CHECKING:
    import sympy as sp

Box = TypeVar("Box")


def replayed_bounds(
    expression: sp.Expr,
    cells: Sequence[Cell],
    symbols: Sequence[tuple[str, ...]],
    trees: Sequence[str],
    precision: int,
    by_sign: bool = False,
) -> tuple[Fraction, Fraction]:
    """Return the hull of the enclosures on the leaves of all trees; see ``Evidence.replay``."""
    import flint

    pieces_by_sign = (
        parts_by_sign(expression, cells) if by_sign else [(expression, c) for c in cells]
    )
    if not len(pieces_by_sign) == len(trees) == len(symbols):
        raise ModelError(
            f"evidence for {len(trees)} cells was given; the domain has {len(pieces_by_sign)}"
        )
    ends: list[tuple[Fraction, Fraction]] = []
    with flint.ctx.workprec(precision):
        listed = zip(pieces_by_sign, trees, symbols, strict=True)
        for number, (piece_by_sign, tree, names) in enumerate(listed, start=1):
            root = cell_root(*piece_by_sign)
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
    root: Box,
    sides: int,
    halve: Callable[[Box, int], tuple[Box, Box]],
    enclose: Callable[[str, Box], Ends | None],
) -> list[Ends]:
    """Return the enclosure on each leaf of a tree.

    Raises
    ------
    ModelError : a letter that is unknown, a tree that ends early or late, a leaf without bound.
    """
    enclosures, waiting = [], [root]
    for position, letter in enumerate(tree, start=1):
        if not waiting:
            raise ModelError(f"a tree of boxes goes on after its end, at character {position}")
        box = waiting.pop()
        number = SIDES.find(letter)
        if number >= 0:
            if number >= sides:
                raise ModelError(
                    f"a tree of boxes halves side {number} at character {position}; there are "
                    f"{sides} sides"
                )
            waiting += reversed(halve(box, number))
            continue
        ends = enclose(letter, box)
        if ends is None:
            raise ModelError(f"the leaf {letter!r} at character {position} of a tree has no bound")
        enclosures.append(ends)
    if waiting:
        raise ModelError(f"a tree of boxes ends early: {len(waiting)} boxes are missing")
    return enclosures


LONGEST = 100_000  # characters of all trees together that a reader accepts


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """Evidence that the values of an expression over a domain lie in ``bounds``.

    Attributes
    ----------
    bounds : the claim, with rational ends.
    expression, domain : what the claim is about.
    symbols : names of the sides in the order in which the trees number them, for each cell.
    trees : one for each cell of the domain.
    by_sign : the cells are those of ``parts_by_sign``.
    precision : bits of the ball arithmetic; Bernstein leaves are exact.
    """

    bounds: Interval
    expression: sp.Expr = field(repr=False)
    domain: Domain = field(repr=False)
    symbols: tuple[tuple[str, ...], ...]
    trees: tuple[str, ...]
    precision: int
    by_sign: bool = False

    def replay(self) -> Interval:
        """Return the hull of the enclosures on the leaves; it lies inside ``bounds``.

        Raises
        ------
        ModelError : a leaf that leaves the bounds or has none (a wrong or foreign evidence), a
            tree that is not well formed or too long, other cells or symbols than the domain's.
        """
        if sum(map(len, self.trees)) > LONGEST:
            raise ModelError(
                f"evidence of {sum(map(len, self.trees))} characters; at most {LONGEST} are read"
            )
        hull = Interval(
            *replayed_bounds(
                self.expression,
                self.domain.cells,
                self.symbols,
                self.trees,
                self.precision,
                self.by_sign,
            )
        )
        if not self.bounds.contains(hull):
            raise ModelError(
                f"the bounds {self.bounds} of {self.expression} are not proved by their evidence: "
                f"its boxes give {hull}; bound the expression again"
            )
        return hull

    def claiming(self, bounds: Interval) -> Evidence:
        """Return the same trees as evidence of other bounds; ``replay`` decides if they hold."""
        return replace(self, bounds=bounds)

    @property
    def boxes(self) -> int:
        """Number of leaves."""
        return sum(letter.islower() for tree in self.trees for letter in tree)

    @property
    def words(self) -> str:
        """Return how the bounds were proved, e.g. ``"ball arithmetic, 12 boxes"``."""
        letters = {letter for tree in self.trees for letter in tree if letter.islower()}
        methods = [
            name
            for name, of in (("Bernstein form", "b"), ("ball arithmetic", "psqt"))
            if letters & set(of)
        ]
        return f"{' and '.join(methods)}, {self.boxes} box{'' if self.boxes == 1 else 'es'}"


def replay(evidence: Evidence, expression: sp.Expr, domain: DomainLike) -> Interval:
    """Return what the evidence gives for that expression over that domain.

    Raises
    ------
    ModelError : as ``Evidence.replay``.
    """
    return replace(evidence, expression=expression, domain=as_domain(domain)).replay()
