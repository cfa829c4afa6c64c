"""Check that two expressions are the same function, symbolically or at points."""

from __future__ import annotations

import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.large_powers import with_exponentials_as_symbols
from takagi.models.sector.terms import terms_of

if TYPE_CHECKING:
    import sympy as sp

POINTS = 12
DENOMINATOR = 997  # of the points' coordinates; a prime avoids special angles
SMALLEST = Fraction(1, 10**20)  # the widest ball that is evidence for zero
LONGEST = 150  # most operations for sympy's simplify: about a second


@dataclass(frozen=True, slots=True)
class Exactness:
    """How it is known that the rows agree: ``symbolic`` of all rows, and that in ``words``."""

    symbolic: bool
    words: str


def check_exact(
    rows: Sequence[tuple[str, sp.Expr, sp.Expr]], sides: Mapping[sp.Symbol, Interval]
) -> Exactness:
    """Return how wanted = written was checked, in every row (place, wanted, written).

    First by expansion, over a common denominator too; then at random rational points in ball
    arithmetic, where a ball without 0 refutes; then by sympy's ``simplify`` if the difference is
    short.  The remaining entries agree at the points, and the sentence says that this is no proof.

    Parameters
    ----------
    sides : range of each variable; a variable without one is tried in [-1, 1].

    Raises
    ------
    ModelError : a row that is refuted, or one that can neither be shown nor tried at points.
    """
    tried = [place for place, wanted, written in rows if not _row(place, wanted, written, sides)]
    if not tried:
        return Exactness(True, "checked symbolically")
    return Exactness(
        False,
        f"{', '.join(tried)} checked in ball arithmetic at {POINTS} random rational points only, "
        "which is no proof; the others symbolically",
    )


def _row(
    place: str, wanted: sp.Expr, written: sp.Expr, sides: Mapping[sp.Symbol, Interval]
) -> bool:
    """Return whether the row is shown symbolically; False when it only agrees at the points."""
    import sympy as sp

    rest = sp.expand(wanted - written)
    # The sum of terms keeps each denominator in one piece, so that long ones cancel too.
    if rest == 0 or not terms_of(wanted - written):
        return True
    if rest.count_ops() <= 4 * LONGEST:
        joined = with_exponentials_as_symbols(sp.together, rest)
        if sp.expand(sp.fraction(joined)[0]) == 0:
            return True
    agrees = _agrees(place, rest, sides)
    short = rest.count_ops() <= LONGEST or agrees is None
    simple = with_exponentials_as_symbols(sp.simplify, rest) if short else rest
    if simple == 0:
        return True
    if agrees is None or not simple.free_symbols:
        raise ModelError(
            f"{place}: the factored form misses the plant by {simple}, which does not simplify to "
            "0; correct the entries of that row"
        )
    return False


def _agrees(place: str, rest: sp.Expr, sides: Mapping[sp.Symbol, Interval]) -> bool | None:
    """Return True when the balls at the points contain 0 and are small; None if none could tell."""
    from takagi.models.ranges.expression_range import expression_range

    chance = random.Random(rest.count_ops())  # the same points each time
    symbols = sorted(rest.free_symbols, key=str)
    told = 0
    for _ in range(POINTS):
        point = {s: _point(sides.get(s, Interval.of(-1, 1)), chance) for s in symbols}
        try:
            ball = expression_range(rest, {s: Interval(v, v) for s, v in point.items()}).outer
        except ModelError:
            continue
        if not ball.contains(0):
            at = ", ".join(f"{s} = {float(v):.4g}" for s, v in point.items())
            raise ModelError(
                f"{place}: the factored form misses the plant by {rest}, which is "
                f"{float(ball.centre):.4g} at {at or 'every point'}; correct the entries of that "
                "row"
            )
        told += ball.width <= SMALLEST
    return True if told == POINTS else None


def _point(side: Interval, chance: random.Random) -> Fraction:
    return side.lower + side.width * Fraction(chance.randrange(1, DENOMINATOR), DENOMINATOR)
