r"""Double sums whose truth is a quadratic form on the simplex, decided by its stationary values.

Decoupled scalar modes in disguise, x = T z with integers T,

    A_i = T diag(a_i) T^-1,   B_i = T diag(b_i),   K_j = diag(k_j) T^-1,

have for each mode g(h) = sum_ij h_i h_j (a_i - b_i k_j).  V = x'Px with P = T^-T T^-1 falls along
every blend exactly when every g(h) < -alpha for all h (|g(h)| < 1 in discrete time); and where one
g(h) is not, G(h) itself is unstable there, so that no P serves.  The least value of a quadratic
form on the simplex is at a stationary point of a face: h'Mh = mu with M h = mu 1, 1'h = 1, all
rational.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import combinations
from typing import Any

import numpy as np
from exact_truth import Floats, Rows, diagonal, inverse, times, transposed
from known_loops import HAIRS, Problem, Random, unimodular
from modes import Known, claim_of, law_of, model_of

STEP = Fraction(1, 10)


def least_on_simplex(M: Rows) -> Fraction:
    """Return the least h'Mh for h >= 0, sum h = 1; M symmetric, of order 3 at most."""
    found = []
    for size in range(1, len(M) + 1):
        for face in combinations(range(len(M)), size):
            # [M -1; 1' 0] (h, mu) = (0, 1); a singular one has no value that no smaller face has.
            rows = [[*(M[i][j] for j in face), Fraction(-1)] for i in face]
            rows.append([*(Fraction(1) for _ in face), Fraction(0)])
            solved = _solved(rows, [*(Fraction(0) for _ in face), Fraction(1)])
            if solved is not None and min(solved[:-1]) >= 0:
                found.append(solved[-1])
    return min(found)


def _solved(rows: Rows, right: list[Fraction]) -> list[Fraction] | None:
    try:
        back = inverse(rows)
    except StopIteration:
        return None
    return [sum((a * b for a, b in zip(row, right, strict=True)), Fraction(0)) for row in back]


class Modes:
    """Numbers a_i, b_i, k_j of some modes, rules by modes."""

    def __init__(self, rng: Random) -> None:
        r, modes = int(rng.integers(2, 4)), int(rng.integers(1, 3))
        self.a, self.b, self.k = (
            [[Fraction(int(v), 10) for v in row] for row in rng.integers(-60, 61, size=(r, modes))]
            for _ in range(3)
        )
        self.T, self.back = unimodular(rng, modes)

    @property
    def count(self) -> int:
        return len(self.a[0])

    def sums(self, mode: int) -> Rows:
        """Return the symmetric matrix of g(h) of one mode."""
        r = range(len(self.a))
        G = [[self.a[i][mode] - self.b[i][mode] * self.k[j][mode] for j in r] for i in r]
        return [[(G[i][j] + G[j][i]) / 2 for j in r] for i in r]

    def largest(self, mode: int) -> Fraction:
        """Return the largest g(h)."""
        return -least_on_simplex([[-v for v in row] for row in self.sums(mode)])

    def least(self, mode: int) -> Fraction:
        return least_on_simplex(self.sums(mode))

    def move(self, mode: int, by: Fraction) -> None:
        """Add to every a_i, and so to g(h) everywhere."""
        for row in self.a:
            row[mode] += by

    def matrices(self) -> tuple[list[Rows], list[Rows], list[Rows]]:
        """Return A, B, K in disguise."""
        A = [times(times(self.T, diagonal(row)), self.back) for row in self.a]
        B = [times(self.T, diagonal(row)) for row in self.b]
        return A, B, [times(diagonal(row), self.back) for row in self.k]

    def sampled(self, step: Fraction) -> None:
        """Turn x' into x+ = x + step x'."""
        for i, row in enumerate(self.a):
            self.a[i] = [1 + step * v for v in row]
        for i, row in enumerate(self.b):
            self.b[i] = [step * v for v in row]

    def holds(self, rate: Fraction, step: Fraction | None) -> bool:
        """Return whether V falls along every blend, and so whether any function does."""
        modes = range(self.count)
        if step is None:
            return all(self.largest(m) < -rate for m in modes)
        return all(self.largest(m) < 1 and self.least(m) > -1 for m in modes)


def drawn(rng: Random, step: Fraction | None) -> tuple[Modes, Fraction]:
    """Return modes whose slowest blends are at the rate, or a hair to either side, and the rate."""
    modes = Modes(rng)
    rate = Fraction(0) if step is not None else Fraction(int(rng.integers(0, 20)), 10)
    for mode in range(modes.count):
        hair = Fraction(repr(float(rng.choice(HAIRS)))) * int(rng.choice((-1, 1)))
        spare = Fraction(int(rng.integers(0, 30)), 100) if rng.random() < 0.4 else Fraction(0)
        wanted = -rate - spare + hair
        modes.move(mode, Fraction(round((wanted - modes.largest(mode)) * 10**9), 10**9))
    if step is not None:
        modes.sampled(step)
    return modes, rate


def _floats(stack: list[Rows]) -> Floats:
    return np.array([[[float(v) for v in row] for row in M] for M in stack])


def opposed_rules(rng: Random) -> Problem:
    """Return rules with gains of their own, whose pairs may fail where no blend does."""
    modes, rate = drawn(rng, None)
    return _problem(modes, rate, None)


def sampled_rules(rng: Random) -> Problem:
    """Return the same in discrete time."""
    modes, rate = drawn(rng, STEP)
    return _problem(modes, rate, STEP)


def _problem(modes: Modes, rate: Fraction, step: Fraction | None) -> Problem:
    A, B, K = map(_floats, modes.matrices())
    truth = modes.holds(rate, step)
    return Problem(A, truth, float(rate), None if step is None else float(step), B, K)


def on_pieces(rng: Random) -> list[Known]:
    """Return decay on pieces of the weights, with the right P: the truth is that of the blends."""
    step = STEP if rng.random() < 0.5 else None
    modes, rate = drawn(rng, step)
    A, B, K = modes.matrices()
    P = times(transposed(modes.back), modes.back)
    model, law = model_of(A, step, B=B), law_of(K, step)
    truth, found = modes.holds(rate, step), []
    for depth in (0, 1, 2, 4):
        cut = tree(rng, len(A), depth)
        claim = claim_of("decay", decay_rate=rate, P=P, halvings=cut)
        # Which trees are fine enough is not known beforehand.
        found.append(Known(model, law, claim, truth, depth == 4))
    return found


def scheduled_on_pieces(rng: Random) -> list[Known]:
    """Return P(h) on pieces of the weights: the right P at every rule, and P that change with h.

    The weights may rest, so that a blend that does not fall by itself leaves no P(h) either.
    """
    step = STEP if rng.random() < 0.5 else None
    modes, rate = drawn(rng, step)
    A, B, K = modes.matrices()
    P = times(transposed(modes.back), modes.back)
    model, law = model_of(A, step, B=B), law_of(K, step)
    truth, r, found = modes.holds(rate, step), len(A), []
    for depth, size in ((0, 0), (3, 0), (3, 10), (4, 0)):
        listed = [
            {
                "powers": [[int(i == j) for j in range(r)]],
                "matrix": [[(1 + Fraction(size * i, 100)) * v for v in row] for row in P],
            }
            for i in range(r)
        ]
        evidence: dict[str, Any] = {"decay_rate": rate, "degrees": [1], "P": listed}
        evidence |= {"polya": Fraction(int(rng.integers(0, 3)))}
        if step is None:
            evidence |= {"rates": [[Fraction(int(rng.integers(0, 3)), 10)] * r]}
        claim = claim_of("fuzzy-decay", **evidence, halvings=tree(rng, r, depth))
        found.append(Known(model, law, claim, truth, depth == 4))
    return found


def at_blends(rng: Random) -> list[Known]:
    """Return refutations by one blend, with the multiplier of a mode that may grow there."""
    step = STEP if rng.random() < 0.5 else None
    modes, rate = drawn(rng, step)
    A, B, K = modes.matrices()
    model, law = model_of(A, step, B=B), law_of(K, step)
    truth, found = modes.holds(rate, step), []
    for _ in range(4):
        shares: Any = [[Fraction(int(v)) for v in rng.integers(0, 4, size=len(A))]]
        if not sum(shares[0]):
            shares = Fraction(int(rng.integers(len(A))))
        factor = [[row[int(rng.integers(modes.count))]] for row in modes.T]
        listed = [{"blend": shares, "factor": factor}]
        claim = claim_of("no-common-decay", decay_rate=rate, multipliers=listed)
        found.append(Known(model, law, claim, truth, False))
    return found


def tree(rng: Random, rules: int, depth: int) -> list[Any]:
    """Return halvings: all edges of the rules in turn, or edges by chance."""
    if depth == 0:
        return [[]]
    i, j = (int(v) for v in rng.choice(rules, size=2, replace=False))
    below = [tree(rng, rules, depth - 1) for _ in range(2)]
    return [[Fraction(0), Fraction(i), Fraction(j)], *below[0], *below[1]]


RULES: dict[str, Callable[[Random], Problem]] = {
    "rules whose pairs may fail": opposed_rules,
    "the same, sampled": sampled_rules,
}
PIECES: dict[str, Callable[[Random], list[Known]]] = {
    "decay on pieces of the weights": on_pieces,
    "functions of the weights on pieces": scheduled_on_pieces,
    "single blends against decay": at_blends,
}
