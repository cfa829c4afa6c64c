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

from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.domain import Domain, DomainLike, as_domain
from takagi.models.ranges.replayed_leaves import replayed_bounds

if TYPE_CHECKING:
    import sympy as sp

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
    precision : bits of the ball arithmetic; Bernstein leaves are exact.
    """

    bounds: Interval
    expression: sp.Expr = field(repr=False)
    domain: Domain = field(repr=False)
    symbols: tuple[tuple[str, ...], ...]
    trees: tuple[str, ...]
    precision: int

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
        found = Interval(
            *replayed_bounds(
                self.expression, self.domain.cells, self.symbols, self.trees, self.precision
            )
        )
        if not self.bounds.contains(found):
            raise ModelError(
                f"the bounds {self.bounds} of {self.expression} are not proved by their evidence: "
                f"its boxes give {found}; bound the expression again"
            )
        return found

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
        used = [
            name
            for name, of in (("Bernstein form", "b"), ("ball arithmetic", "psqt"))
            if letters & set(of)
        ]
        return f"{' and '.join(used)}, {self.boxes} box{'' if self.boxes == 1 else 'es'}"


def replay(evidence: Evidence, expression: sp.Expr, domain: DomainLike) -> Interval:
    """Return what the evidence gives for that expression over that domain.

    Raises
    ------
    ModelError : as ``Evidence.replay``.
    """
    return replace(evidence, expression=expression, domain=as_domain(domain)).replay()
