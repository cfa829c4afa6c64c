r"""Weights of single blends, and pieces of the weights on each of which a claim is proved.

A point has shares in whole numbers: a row for each premise if the weights are products over the
premises, else one row for all rules.  A row divided by its sum gives the weights.  The claim
``no-common-decay`` names its blends in this way.

The checker's functions show which mean of pairs fails on a piece.  The corners are tested first: if
one fails, the claim is wrong for a blend of the loop, and no pieces help.  The pairs come next,
those with the largest |(B_i - B_j)(K_i - K_j)| first.  The piece is cut between the two corners of
a pair that fails, which reduces this difference to a quarter.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, fields
from fractions import Fraction
from itertools import combinations_with_replacement, product
from math import comb, lcm, prod
from typing import Any, TypeAlias

import numpy as np

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.checker.loop.halvings import halved
from takagi.certificates.checker.loop.polytopic_loop import Blend, PolytopicLoop, Stack
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.document.model_data import stack_of
from takagi.models.arrays import Floats

Point: TypeAlias = tuple[tuple[int, ...], ...]
# For each premise, the weights at the corners of a piece.
Corners: TypeAlias = tuple[tuple[tuple[Fraction, ...], ...], ...]


def points_of(exact: PolytopicLoop) -> list[Point]:
    """Return the point of every rule alone, in order."""
    if exact.corners is None:
        return [(_unit(exact.rules, i),) for i in range(exact.rules)]
    return [tuple(_unit(2, c) for c in row) for row in exact.corners]


def grid(exact: PolytopicLoop, denominator: int, most_points: int) -> list[Point]:
    """Return all points with shares in multiples of 1/parts; none if they exceed ``most``.

    If some combination of corners has no rule, only the rules alone are returned.
    """
    if exact.corners is None:
        sizes = [exact.rules]
    else:
        sizes = [2] * len(exact.corners[0])
        if 2 ** len(sizes) != exact.rules:
            return points_of(exact)
    if prod(comb(size + denominator - 1, denominator) for size in sizes) > most_points:
        return []
    return list(product(*(list(_shares(size, denominator)) for size in sizes)))


def corners_of(exact: PolytopicLoop) -> Corners:
    """Return the corners of the whole: of all rules, or of each premise."""
    sizes = [exact.rules] if exact.corners is None else [2] * len(exact.corners[0])
    return tuple(
        tuple(tuple(Fraction(i == j) for j in range(size)) for i in range(size)) for size in sizes
    )


def halved_corners(corners: Corners, premise: int, fixed: int, halved: int) -> Corners:
    """Return the corners of the half whose corner ``moved`` is in the middle of the two."""
    rows = list(corners[premise])
    rows[halved] = tuple((a + b) / 2 for a, b in zip(rows[fixed], rows[halved], strict=True))
    return (*corners[:premise], tuple(rows), *corners[premise + 1 :])


def point_at(exact: PolytopicLoop, corners: Corners, rule: int) -> Point:
    """Return the corner of a piece that replaces a rule."""
    corner = (rule,) if exact.corners is None else exact.corners[rule]
    rows = [rows[c] for rows, c in zip(corners, corner, strict=True)]
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


def _shares(size: int, denominator: int) -> Iterator[tuple[int, ...]]:
    for drawn in combinations_with_replacement(range(size), denominator):
        yield tuple(drawn.count(c) for c in range(size))


def _unit(size: int, index: int) -> tuple[int, ...]:
    return tuple(int(c == index) for c in range(size))


def loop_at(exact: PolytopicLoop, rows: Sequence[Sequence[Fraction]]) -> PolytopicLoop:
    """Return the loop whose blends are those of the weights h in ``rows`` alone."""
    return _LoopAtPoints(**_members(exact), point_weights=tuple(map(tuple, rows)))


def _members(loop: PolytopicLoop) -> dict[str, Any]:
    return {member.name: getattr(loop, member.name) for member in fields(PolytopicLoop)}


@dataclass(frozen=True)
class _LoopAtPoints(PolytopicLoop):
    """The loop at some weights; no proof uses it, because it does not enclose the loop."""

    point_weights: tuple[tuple[Fraction, ...], ...] = ()

    def groups(self) -> list[tuple[str, tuple[tuple[int, int], ...]]]:
        return [(f"point {k + 1}", ((0, 0),)) for k in range(len(self.point_weights))]

    def blends(self) -> list[Blend]:
        return [_At(self, f"point {k + 1}", (), h) for k, h in enumerate(self.point_weights)]


@dataclass(frozen=True)
class _At(Blend):
    h: tuple[Fraction, ...] = ()

    def of(self, stack: Stack, side: int = 0) -> Matrix:
        if len(stack) <= 1:
            return stack[0]
        terms = [share * X for share, X in zip(self.h, stack, strict=True) if share]
        return sum(terms[1:], terms[0]).reduced()

    def _closed(self, X: Stack, Y: Stack) -> Matrix:
        K = self.loop.K
        return self.of(X) - self.of(Y) @ self.of(K) if K and Y else self.of(X)


FAILED = re.compile(r"rules? (\d+)(?: and (\d+))?$")
# The largest number of pieces for one request. MOST_WORK bounds it further for large loops:
# WORK_OF_A_BLEND is a blend's constant part, to which the fourth power of the order is added.
MOST_PIECES, MOST_WORK, WORK_OF_A_BLEND = 2000, 3e7, 2000


@dataclass(slots=True)
class Cuts:
    """How many pieces may still be examined, half of them for one claim.

    ``failed`` : blends of the loop at which a claim failed; the next claim is tested there first.
    """

    pieces_left: int
    failed: list[Point] = field(default_factory=list)

    @classmethod
    def of(cls, exact: PolytopicLoop) -> Cuts:
        """Return the number of pieces for a loop of this size."""
        work = len(exact.groups()) * (exact.order**4 + WORK_OF_A_BLEND)
        return cls(min(MOST_PIECES, int(MOST_WORK / work)))

    def halvings(self, claim: Any, exact: PolytopicLoop) -> list[list[int]]:
        """Return the tree of ``halvings`` that proves a claim; empty if none was found."""
        most_entries = self.pieces_left - self.pieces_left // 2
        if self.failed:
            loop_at_failed = loop_at(exact, [weights_at(exact, point) for point in self.failed])
            if replay(claim, None, loop_at_failed, [], "claim").verdict is not Verdict.PROVED:
                return []
        tree: list[list[int]] = []
        open_pieces = [(_piece(exact, ()), corners_of(exact))]
        while open_pieces and len(tree) < most_entries:
            piece, corners = open_pieces.pop()
            outcome = replay(claim, None, piece, [], "claim")
            if outcome.verdict is Verdict.PROVED:
                tree.append([])
                continue
            pair = FAILED.search(outcome.failure)
            if pair is not None and pair[2] is None:
                self.failed.append(point_at(exact, corners, int(pair[1]) - 1))
            if pair is None or pair[2] is None:
                break
            premise, i, j = piece.between(int(pair[1]) - 1, int(pair[2]) - 1)
            tree.append([premise, i, j])
            for step in ((premise, j, i), (premise, i, j)):
                half = _piece(exact, (*piece.path, step))
                open_pieces.append((half, halved_corners(corners, *step)))
        else:
            self.pieces_left -= len(tree)
            return [] if open_pieces else tree
        self.pieces_left -= len(tree) + 1
        return []


@dataclass(frozen=True)
class _Piece(PolytopicLoop):
    """A loop whose blends are those of one piece of its weights, in the order of the tests.

    It has the same matrices as the whole loop, so a claim's matrices have the right sizes.
    """

    path: tuple[tuple[int, int, int], ...] = ()

    @property
    def loop(self) -> PolytopicLoop:
        """The loop on the piece."""
        loop = PolytopicLoop(**_members(self))
        for step in self.path:
            loop = halved(loop, *step)
        return loop

    def blends(self) -> list[Blend]:
        loop = self.loop
        B, K, D = map(stack_of, (loop.B, loop.K, loop.D))

        def straight(blend: Blend) -> float:
            i, j = blend.pairs[0]
            return -np.inf if i == j else -(_bend(B, K, i, j) + _bend(D, K, i, j))

        return sorted(loop.blends(), key=straight)

    def between(self, first: int, second: int) -> tuple[int, int, int]:
        """Return the premise of a pair's largest difference, and its corners; or the two rules."""
        if self.corners is None:
            return 0, first, second
        loop = self.loop
        B, K, D = map(stack_of, (loop.B, loop.K, loop.D))
        rule_of = {corner: i for i, corner in enumerate(self.corners)}
        bend_of = {}
        for p, sides in enumerate(zip(self.corners[first], self.corners[second], strict=True)):
            if sides[0] != sides[1]:
                across = [
                    (i, rule_of[(*corner[:p], 1 - corner[p], *corner[p + 1 :])])
                    for corner, i in rule_of.items()
                ]
                cuts = sum(step[0] == p for step in self.path)
                bend = sum(_bend(B, K, i, j) + _bend(D, K, i, j) for i, j in across)
                bend_of[p] = bend, -cuts
        return max(bend_of, key=lambda p: bend_of[p]), 0, 1


def _piece(exact: PolytopicLoop, path: tuple[tuple[int, int, int], ...]) -> _Piece:
    return _Piece(**_members(exact), path=path)


def _bend(B: Floats, K: Floats, i: int, j: int) -> float:
    """Return |(B_i - B_j)(K_i - K_j)|, the distance of a mean of pairs from a blend."""
    if len(B) <= 1 or len(K) <= 1:
        return 0.0
    return float(np.linalg.norm((B[i] - B[j]) @ (K[i] - K[j])))
