r"""Weights of single blends: one rule alone, or shares in whole numbers.

If the weights are products over the premises, a point has one row of shares for each premise;
otherwise it has one row for all rules.  A row divided by its sum gives the weights.  The claim
``no-common-decay`` names its blends in this way.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields
from fractions import Fraction
from itertools import combinations_with_replacement, product
from math import comb, lcm, prod
from typing import Any, TypeAlias

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.loop.polytopic_loop import Blend, PolytopicLoop, Stack

Point: TypeAlias = tuple[tuple[int, ...], ...]
# For each premise, the weights at the corners of a piece.
Corners: TypeAlias = tuple[tuple[tuple[Fraction, ...], ...], ...]


def points_of(exact: PolytopicLoop) -> list[Point]:
    """Return the point of every rule alone, in order."""
    if exact.corners is None:
        return [(_unit(exact.rules, i),) for i in range(exact.rules)]
    return [tuple(_unit(2, c) for c in row) for row in exact.corners]


def grid(exact: PolytopicLoop, parts: int, most: int) -> list[Point]:
    """Return all points with shares in multiples of 1/parts; none if they exceed ``most``.

    If some combination of corners has no rule, only the rules alone are returned.
    """
    if exact.corners is None:
        sizes = [exact.rules]
    else:
        sizes = [2] * len(exact.corners[0])
        if 2 ** len(sizes) != exact.rules:
            return points_of(exact)
    if prod(comb(size + parts - 1, parts) for size in sizes) > most:
        return []
    return list(product(*(list(_shares(size, parts)) for size in sizes)))


def corners_of(exact: PolytopicLoop) -> Corners:
    """Return the corners of the whole: of all rules, or of each premise."""
    sizes = [exact.rules] if exact.corners is None else [2] * len(exact.corners[0])
    return tuple(
        tuple(tuple(Fraction(i == j) for j in range(size)) for i in range(size)) for size in sizes
    )


def halved_corners(corners: Corners, premise: int, kept: int, moved: int) -> Corners:
    """Return the corners of the half whose corner ``moved`` is in the middle of the two."""
    rows = list(corners[premise])
    rows[moved] = tuple((a + b) / 2 for a, b in zip(rows[kept], rows[moved], strict=True))
    return (*corners[:premise], tuple(rows), *corners[premise + 1 :])


def point_at(exact: PolytopicLoop, corners: Corners, rule: int) -> Point:
    """Return the corner of a piece that replaces a rule."""
    own = (rule,) if exact.corners is None else exact.corners[rule]
    rows = [rows[c] for rows, c in zip(corners, own, strict=True)]
    return tuple(tuple(int(v * lcm(*(w.denominator for w in row))) for v in row) for row in rows)


def weights_at(exact: PolytopicLoop, point: Point) -> list[Fraction]:
    """Return h, (rules,)."""
    corners = exact.corners or [(i,) for i in range(exact.rules)]
    return [
        prod(
            (Fraction(row[c], sum(row)) for row, c in zip(point, rule, strict=True)),
            start=Fraction(1),
        )
        for rule in corners
    ]


def _shares(size: int, parts: int) -> Iterator[tuple[int, ...]]:
    for chosen in combinations_with_replacement(range(size), parts):
        yield tuple(chosen.count(c) for c in range(size))


def _unit(size: int, place: int) -> tuple[int, ...]:
    return tuple(int(c == place) for c in range(size))


def seen_at(exact: PolytopicLoop, rows: Sequence[Sequence[Fraction]]) -> PolytopicLoop:
    """Return a exact whose blends are those of the weights h in ``rows`` alone."""
    own = {one.name: getattr(exact, one.name) for one in fields(PolytopicLoop)}
    return _Seen(**own, weights_seen=tuple(map(tuple, rows)))


@dataclass(frozen=True)
class _Seen(PolytopicLoop):
    """The loop at some weights; no proof uses it, because it does not enclose the loop."""

    weights_seen: tuple[tuple[Fraction, ...], ...] = ()

    def groups(self) -> list[tuple[str, tuple[tuple[int, int], ...]]]:
        return [(f"point {k + 1}", ((0, 0),)) for k in range(len(self.weights_seen))]

    def blends(self, claim: Any = (), where: str = "") -> list[Blend]:
        return [_At(self, f"point {k + 1}", (), h) for k, h in enumerate(self.weights_seen)]


@dataclass(frozen=True)
class _At(Blend):
    h: tuple[Fraction, ...] = ()

    def of(self, stack: Stack, side: int = 0) -> Matrix:
        if len(stack) <= 1:
            return stack[0]
        parts = [share * X for share, X in zip(self.h, stack, strict=True) if share]
        return sum(parts[1:], parts[0]).reduced()

    def _closed(self, X: Stack, Y: Stack) -> Matrix:
        K = self.loop.K
        return self.of(X) - self.of(Y) @ self.of(K) if K and Y else self.of(X)
