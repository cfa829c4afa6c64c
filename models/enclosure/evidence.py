"""Evidence of a proved range: the tree of boxes and how each leaf is enclosed.

A tree is text in preorder.  A digit or capital letter is the number of the side that is halved
(0-9, A-Z), followed by the lower and the upper half; a small letter ends a branch:

    p   plain evaluation in ball arithmetic
    s   with slopes: monotone variables at their ends, mean-value form in the others
    b   Bernstein coefficients, exact

Replaying needs no search: one enclosure for each leaf.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeVar

from takagi.models.box_search import SIDES, Ends
from takagi.models.enclosure.interval import Interval
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    import sympy as sp

    from takagi.models.enclosure.domain import DomainLike

__all__ = ["LONGEST", "Evidence", "replay"]

Place = TypeVar("Place")
LONGEST = 100_000  # characters of all trees together that a reader accepts


@dataclass(frozen=True, slots=True)
class Evidence:
    """That a function's values lie in ``bounds``.

    Attributes
    ----------
    bounds : the claim, with rational ends.
    symbols : names of the sides in the order in which the trees number them, for each cell.
    trees : one for each cell of the domain.
    precision : bits of the ball arithmetic; Bernstein leaves are exact.
    """

    bounds: Interval
    symbols: tuple[tuple[str, ...], ...]
    trees: tuple[str, ...]
    precision: int

    @property
    def boxes(self) -> int:
        """Number of leaves."""
        return sum(letter.islower() for tree in self.trees for letter in tree)

    @property
    def words(self) -> str:
        """Return how the bounds were proved, e.g. ``"ball arithmetic, 12 boxes"``."""
        letters = {letter for tree in self.trees for letter in tree if letter.islower()}
        used = [
            name
            for name, of in (("Bernstein form", "b"), ("ball arithmetic", "ps"))
            if letters & set(of)
        ]
        return f"{' and '.join(used)}, {self.boxes} box{'' if self.boxes == 1 else 'es'}"


def replay(evidence: Evidence, expression: sp.Expr, domain: DomainLike) -> Interval:
    """Return the hull of the enclosures on the evidence's leaves, which lies inside its bounds.

    Parameters
    ----------
    expression, domain : what the evidence is about.

    Raises
    ------
    ModelError : a leaf that leaves the bounds or has none (a wrong or foreign evidence), a tree
        that is not well formed or too long, or another number of cells or symbols.
    """
    from takagi.models.sector.ball import replayed_ends

    if sum(map(len, evidence.trees)) > LONGEST:
        raise ModelError(
            f"evidence of {sum(map(len, evidence.trees))} characters; at most {LONGEST} are read"
        )
    lower, upper = replayed_ends(evidence, expression, domain)
    found = Interval(lower, upper)
    if not evidence.bounds.contains(found):
        raise ModelError(
            f"the bounds {evidence.bounds} of {expression} are not proved by their evidence: its "
            f"boxes give {found}; bound the expression again"
        )
    return found


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
