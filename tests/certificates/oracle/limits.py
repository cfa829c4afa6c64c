r"""``input-limits``: bounds of u = -sum_j g_j K_j x on a set, and of the rate of u.

Amplitude: |row of K_j times x| is at most the input's limit on the set, for each row of each K_j.
Rate, with G_il = A_i - B_i K_l:

    continuous   u' = -sum h_j h_i h_l K_j G_il x - sum h_j' K_j x - sum h_j h_i K_j E_i w
    discrete     u(x+) - u(x) = -sum h+_l h_i h_j (K_l G_ij - K_j) x - sum h+_l h_i K_l E_i w

The first sum is in the convex hull of the means over all orders of (j, i, l).  The second is in the
hull of the corners of {|d_j| <= phi_j, sum d_j = 0}, at which all entries but one are at a bound.
The third is at most the largest sum over a row of |K_j E_i| times the bounds of w.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import permutations, product
from typing import Any

from flint import fmpq, fmpq_mat

from tests.certificates.oracle.disturbed import (
    InvariantSet,
    invariant_set_of,
    largest_extent,
    set_is_invariant,
)
from tests.certificates.oracle.exact import (
    Fact,
    Obligations,
    entries,
    identity,
    mean,
    scaled,
)
from tests.certificates.oracle.loop import VertexLoop, pick, pieces
from tests.certificates.oracle.reading import Refusal, entry, rationals

MOST_RULES, MOST_MOVING = 24, 10


def input_limits(claim: Any, loop: VertexLoop) -> Obligations:
    """The state stays in the set; there the inputs and their rates keep the stated limits."""
    if not loop.K:
        raise Refusal("limits of inputs need gains")
    m = loop.K[0].nrows()
    limits, invariant = rationals(claim, "input_limits", m), invariant_set_of(claim, loop)
    yield from set_is_invariant(invariant, loop)
    for j, K in enumerate(loop.K):
        yield from _rows(invariant, K, limits, f"amplitude by gain {j + 1}")
    if "rate_limits" in claim:
        yield from _rates(claim, loop, invariant, rationals(claim, "rate_limits", m))


def _rows(invariant: InvariantSet, matrix: fmpq_mat, limits: list[fmpq], label: str) -> Obligations:
    for k, (row, limit) in enumerate(zip(entries(matrix), limits, strict=True)):
        yield from largest_extent(
            invariant.P, invariant.c, fmpq_mat([row]), limit, f"{label}, input {k + 1}"
        )


def _rates(
    claim: Any, loop: VertexLoop, invariant: InvariantSet, limits: list[fmpq]
) -> Obligations:
    m, shares = len(limits), entry(claim, "rate_shares")
    motion = rationals(shares, "motion", m)
    for piece in pieces(claim, loop):
        for matrix in _motions(piece, loop.K):
            yield from _rows(invariant, matrix, motion, "rate with the state")
    total = list(motion)
    if len(loop.K) > 1 and loop.step is None:
        moving = rationals(shares, "memberships", m)
        phi = rationals(claim, "membership_rates", len(loop.K))
        for speeds in _extremes(phi):
            matrix = scaled(speeds[0], loop.K[0])
            for speed, K in zip(speeds[1:], loop.K[1:], strict=True):
                matrix = matrix + scaled(speed, K)
            yield from _rows(invariant, matrix, moving, "rate with memberships")
        total = [a + b for a, b in zip(total, moving, strict=True)]
    pushed = [fmpq(0)] * m
    for K, E in product(loop.K, invariant.E):
        for k, row in enumerate(entries(K * E)):
            size = sum((abs(v) * b for v, b in zip(row, invariant.by_entry, strict=True)), fmpq(0))
            pushed[k] = max(pushed[k], size)
    for k in range(m):
        yield Fact(f"rate of input {k + 1}", total[k] + pushed[k] <= limits[k])


def _motions(loop: VertexLoop, next_gains: Sequence[fmpq_mat]) -> Iterator[fmpq_mat]:
    """Yield the matrices of which u', or u(x+) - u(x), is a blend.

    ``next_gains`` are those of all rules: the weights at x+ may lie in another piece than the
    weights at x.
    """
    if len(loop.K) == 1:
        still = identity(loop.n) if loop.step is not None else scaled(0, identity(loop.n))
        for mixture in loop.mixtures():
            yield loop.K[0] * (mixture.A - still)
        return
    if loop.rules > MOST_RULES:
        raise Refusal("too many rules for a claim about rates")
    if loop.step is not None:
        for K in next_gains:
            for mixture in loop.mixtures():
                yield K * mixture.A - mixture.K
        return
    if not loop.together:
        raise Refusal("rates of a law with weights of its own")
    r = range(loop.rules)
    for j, i, k in product(r, r, r):
        if j <= i <= k:
            yield mean(
                pick(loop.K, a) * (pick(loop.A, b) - pick(loop.B, b) * pick(loop.K, c))
                for a, b, c in set(permutations((j, i, k)))
            )


def _extremes(phi: list[fmpq]) -> Iterator[list[fmpq]]:
    """Yield the corners of {|d_j| <= phi_j, sum d_j = 0}, some of them more than once."""
    if len(phi) > MOST_MOVING or min(phi) < 0:
        raise Refusal("membership_rates: not negative, and not too many")
    for free in range(len(phi)):
        for signs in product((-1, 1), repeat=len(phi) - 1):
            rest = iter(signs)
            speeds = [fmpq(0) if j == free else next(rest) * p for j, p in enumerate(phi)]
            speeds[free] = -sum(speeds, fmpq(0))
            if abs(speeds[free]) <= phi[free]:
                yield speeds
