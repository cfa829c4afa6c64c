"""Families of loops for which it is known, exactly, whether one quadratic function shows a rate.

Each function draws one problem; most lie on the threshold or a hair to either side of it.  The
truth is found from the decimals that ``certify`` writes, by the theorems of ``exact_truth``.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import NamedTuple

import numpy as np
from exact_truth import (
    Floats,
    Rows,
    cayley,
    determinant,
    exact,
    inverse,
    is_hurwitz,
    is_schur,
    minus,
    pair_has_function,
    plus,
    rank_one_pair_has_function,
    times,
)

Random = np.random.Generator
HAIRS = (0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3)


class Problem(NamedTuple):
    """Vertices, rate and sample time, perhaps with inputs and gains, and the truth."""

    A: Floats
    truth: bool
    rate: float = 0.0
    step: float | None = None
    B: Floats | None = None
    K: Floats | None = None


def hair(rng: Random) -> float:
    """Return a factor near 1, or 1."""
    return 1.0 + float(rng.choice((-1, 1))) * float(rng.choice(HAIRS))


def sizes(rng: Random, n: int) -> Floats:
    """Return powers of ten from 1e-8 to 1e8, (n,)."""
    return np.asarray(np.power(10.0, rng.integers(-8, 9, size=n).astype(float)))


def single(A: Floats, rate: float = 0.0, step: float | None = None) -> Problem:
    """Return a problem of one matrix."""
    if step is not None:
        return Problem(A[None], is_schur(exact(A)), 0.0, step)
    return Problem(A[None], is_hurwitz(exact(A), Fraction(repr(rate))), rate)


def couple(A: Floats, step: float | None = None) -> Problem:
    """Return a problem of two matrices of order 2."""
    first, second = (exact(M) for M in A)
    if step is None:
        return Problem(A, pair_has_function(first, second))
    if any(determinant(plus(M, Fraction(1))) == 0 for M in (first, second)):
        return Problem(A, False, 0.0, step)
    turned = cayley(first), cayley(second)
    if any(determinant(M) == 0 for M in turned):
        return Problem(A, False, 0.0, step)
    return Problem(A, pair_has_function(*turned), 0.0, step)


def one_matrix(rng: Random) -> Problem:
    """Return a matrix with its rate at, or a hair beside, its slowest eigenvalue."""
    n = int(rng.integers(1, 6))
    A = np.round(rng.normal(size=(n, n)), 3) - np.eye(n)
    slowest = -float(np.linalg.eigvals(A).real.max())
    return single(A, max(slowest * hair(rng), 0.0))


def scaled_matrix(rng: Random) -> Problem:
    """Return the same in states of very different size."""
    plain = one_matrix(rng)
    s = sizes(rng, plain.A.shape[1])
    return single(plain.A[0] * s / s[:, None], plain.rate)


def edge_matrix(rng: Random) -> Problem:
    """Return integers with an eigenvalue on the edge, or a repeated one beside it."""
    n = int(rng.integers(2, 5))
    values = -rng.integers(0, 3, size=n).astype(float)
    values[0] = float(rng.choice((0.0, -1e-12, 1e-12, -1e-6)))
    jordan = np.diag(values) + np.diag(rng.integers(0, 2, size=n - 1).astype(float), 1)
    T, back = unimodular(rng, n)
    found = times(times(T, exact(jordan)), back)
    return single(np.array([[float(entry) for entry in row] for row in found]))


def sampled_matrix(rng: Random) -> Problem:
    """Return a matrix whose largest eigenvalue is on the unit circle, or a hair beside it."""
    n = int(rng.integers(1, 5))
    A = rng.normal(size=(n, n))
    return single(A * hair(rng) / np.abs(np.linalg.eigvals(A)).max(), step=1.0)


def deficient_matrices(rng: Random) -> Problem:
    """Return vertices of rank n - 1 with different kernels: none is stable by itself."""
    n, r = int(rng.integers(2, 5)), int(rng.integers(2, 5))
    left, right = rng.integers(-3, 4, size=(2, r, n, n - 1))
    A = -(left @ right.transpose(0, 2, 1)).astype(float)
    A[0] -= np.eye(n) * float(rng.choice((0, 10)))
    return Problem(A, False)


def stable_pair(rng: Random) -> Floats:
    """Return two random stable matrices of order 2; many have unstable blends."""
    found: list[Floats] = []
    while len(found) < 2:
        entries = np.power(10.0, rng.integers(-1, 2, size=(2, 2)).astype(float))
        A = np.round(rng.normal(size=(2, 2)) * entries, 3)
        if np.linalg.eigvals(A).real.max() < 0:
            found.append(A)
    return np.array(found)


def pair(rng: Random) -> Problem:
    """Return two stable matrices of order 2."""
    return couple(stable_pair(rng))


def pair_with_unstable_blend(rng: Random) -> Problem:
    """Return two stable matrices of order 2 with an unstable mean."""
    while True:
        A = stable_pair(rng)
        if np.linalg.eigvals(A.mean(axis=0)).real.max() > 0:
            return couple(A)


def pair_at_its_threshold(rng: Random) -> Problem:
    """Return a pair whose second matrix is turned until the function is lost, and a hair off."""
    while True:
        A, B = stable_pair(rng)

        def at(t: float, A: Floats = A, B: Floats = B) -> Floats:
            turned = np.array([[B[0, 0], B[0, 1] * t], [B[1, 0] / t, B[1, 1]]])
            return np.array([A, turned])

        def holds(t: float, at: Callable[[float], Floats] = at) -> bool:
            first, second = at(t)
            products = first @ second, first @ np.linalg.inv(second)
            return not any(_may_be_negative(M) for M in products)

        limit = _last(holds, 1.0, 1e4)
        if limit is not None:
            return couple(at(limit * hair(rng)))


def scaled_pair(rng: Random) -> Problem:
    """Return a pair at its threshold in states of very different size."""
    plain = pair_at_its_threshold(rng)
    s = sizes(rng, 2)
    return couple(plain.A * s / s[:, None])


def published_pair(rng: Random) -> Problem:
    """Return [[-1, -1], [1, -1]] and [[-1, -a], [1/a, -1]]: a in 3 +- sqrt(8), at the edges."""
    edge = 3 + float(rng.choice((-1, 1))) * np.sqrt(8)
    a = edge * hair(rng)
    return couple(np.array([[[-1, -1], [1, -1]], [[-1, -a], [1 / a, -1]]]))


def sampled_pair(rng: Random) -> Problem:
    """Return the discrete counterpart of a pair at its threshold: I + A by Cayley's transform."""
    plain = pair_at_its_threshold(rng)
    one = np.eye(2)
    return couple(np.array([(one + M) @ np.linalg.inv(one - M) for M in plain.A]), step=0.5)


def rank_one_pair(rng: Random) -> Problem:
    """Return A and A - t b c' of order 3 or 4, t where the function is lost, and a hair off."""
    n = int(rng.integers(3, 5))
    while True:
        A = np.round(rng.normal(size=(n, n)), 2) - np.eye(n)
        b, c = rng.integers(-2, 3, size=(2, n)).astype(float)

        step = np.outer(b, c)

        def holds(t: float, A: Floats = A, step: Floats = step) -> bool:
            second = A - t * step
            return np.linalg.eigvals(second).real.max() < 0 and not _may_be_negative(A @ second)

        limit = _last(holds, 0.0, 64.0) if np.linalg.eigvals(A).real.max() < 0 else None
        if limit is None:
            continue
        moved = _moved(A, step, float(np.round(limit * hair(rng), 12)))
        B = np.array([[float(entry) for entry in row] for row in moved])
        # The difference has rank one as it is written, or the theorem does not apply.
        if exact(B) == moved:
            return Problem(np.array([A, B]), rank_one_pair_has_function(exact(A), moved))


def _may_be_negative(M: Floats) -> bool:
    values = np.linalg.eigvals(M)
    return bool(np.any((values.imag == 0) & (values.real < 0)))


def _last(holds: Callable[[float], bool], low: float, high: float) -> float | None:
    """Return where something is lost, in floats; None where it never holds or always does."""
    if not holds(low) or holds(high):
        return None
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def _moved(A: Floats, step: Floats, t: float) -> Rows:
    shift = [[Fraction(repr(t)) * entry for entry in row] for row in exact(step)]
    return minus(exact(A), shift)


def triangular_vertices(rng: Random) -> Problem:
    """Return matrices that one change of states makes triangular: each has to be stable alone."""
    n, r = int(rng.integers(2, 5)), int(rng.integers(2, 5))
    T, back = unimodular(rng, n)
    vertices = []
    for _ in range(r):
        U = np.triu(rng.integers(-3, 4, size=(n, n)).astype(float), 1)
        U -= np.diag(rng.choice((1.0, 2.0, 0.5), size=n))
        vertices.append(exact(U))
    edge = Fraction(str(rng.choice(("0", "1e-12", "-1e-12", "1e-6", "-1e-6", "-0.001"))))
    vertices[0][0][0] = edge
    found = [times(times(T, U), back) for U in vertices]
    A = np.array([[[float(entry) for entry in row] for row in M] for M in found])
    return Problem(A, all(is_hurwitz(exact(M)) for M in A) and edge < 0)


def closed_pair(rng: Random) -> Problem:
    """Return two rules with one B and their own gains, closed to a pair at its threshold."""
    plain = pair_at_its_threshold(rng)
    B = np.round(rng.normal(size=(2, 1)), 2)
    K = np.round(rng.normal(size=(2, 1, 2)), 2)
    A = plain.A + B @ K
    closed = [minus(exact(A[i]), times(exact(B), exact(K[i]))) for i in range(2)]
    return Problem(A, pair_has_function(*closed), B=np.array([B, B]), K=K)


def unimodular(rng: Random, n: int) -> tuple[Rows, Rows]:
    """Return an integer matrix with an integer inverse, and that."""
    T = plus([[Fraction(0)] * n for _ in range(n)], Fraction(1))
    for _ in range(4 if n > 1 else 0):
        i, j = (int(k) for k in rng.choice(n, size=2, replace=False))
        step = plus([[Fraction(0)] * n for _ in range(n)], Fraction(1))
        step[i][j] = Fraction(int(rng.integers(-2, 3)))
        T = times(T, step)
    return T, inverse(T)


LOOPS: dict[str, Callable[[Random], Problem]] = {
    "one matrix, rate at its limit": one_matrix,
    "the same, badly scaled": scaled_matrix,
    "eigenvalues on the edge": edge_matrix,
    "sampled, on the unit circle": sampled_matrix,
    "vertices of deficient rank": deficient_matrices,
    "pairs of order 2": pair,
    "pairs with unstable blends": pair_with_unstable_blend,
    "pairs at their threshold": pair_at_its_threshold,
    "the same, badly scaled pairs": scaled_pair,
    "the planar pair at 3 +- sqrt 8": published_pair,
    "sampled pairs at their threshold": sampled_pair,
    "pairs of order 3 and 4, rank one apart": rank_one_pair,
    "jointly triangular vertices": triangular_vertices,
    "gains that close to a pair": closed_pair,
}
