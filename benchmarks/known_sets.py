"""Families of claims about sets and functions of order 2, decided by minors written out.

For symmetric M of order 2: M >= 0 iff M_11 >= 0, M_22 >= 0 and det M >= 0; and the reach of
{x'Px <= c} along a row k is the root of c (k_1^2 P_22 - 2 k_1 k_2 P_12 + k_2^2 P_11) / det P.  The
claim is about the very P, so P decides its truth as well: no P of these is right for another one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any

from exact_truth import Rows, is_hurwitz, minus, pair_has_function, times, transposed
from known_loops import Random
from modes import Known, beside, claim_of, law_of, model_of, short, signs, some

Row = Sequence[Fraction]
STEP = Fraction(1, 10)
ONE: Rows = [[Fraction(1), Fraction(0)], [Fraction(0), Fraction(1)]]


def is_definite(M: Rows) -> bool:
    return M[0][0] > 0 and M[0][0] * M[1][1] - M[0][1] * M[1][0] > 0


def is_semidefinite(M: Rows) -> bool:
    return min(M[0][0], M[1][1]) >= 0 and M[0][0] * M[1][1] - M[0][1] * M[1][0] >= 0


def is_symmetric(M: Rows) -> bool:
    return M[0][1] == M[1][0]


def reach(P: Rows, level: Fraction, row: Row) -> Fraction:
    """Return the square of the largest |row x| on the set."""
    k, m = row
    size = P[0][0] * P[1][1] - P[0][1] ** 2
    return level * (k**2 * P[1][1] - 2 * k * m * P[0][1] + m**2 * P[0][0]) / size


def loss(P: Rows, G: Rows, step: Fraction | None) -> Rows:
    """Return F of V' (or V(x+) - V) = -x'Fx."""
    PG = times(P, G)
    if step is not None:
        return minus(P, times(transposed(G), PG))
    return [[-PG[i][j] - PG[j][i] for j in range(2)] for i in range(2)]


def falls(P: Rows, loops: Sequence[Rows], step: Fraction | None, s: Fraction) -> bool:
    """Return whether V falls at the rate s along every one of the loops."""
    scaled = [[s * entry for entry in row] for row in P]
    return is_definite(P) and all(is_semidefinite(minus(loss(P, G, step), scaled)) for G in loops)


def square(rng: Random) -> Rows:
    """Return a symmetric matrix of order 2, positive definite more often than not."""
    p, q, r = some(rng), some(rng), some(rng, -150, 150)
    return [[p, r], [r, q]]


def loops_of(rng: Random, step: Fraction | None) -> list[Rows]:
    """Return one or two matrices that are stable more often than not."""
    found = []
    for _ in range(int(rng.integers(1, 3))):
        p, q, u, v = some(rng), some(rng), some(rng, -100, 100), some(rng, -100, 100)
        G = [[-p, u], [v, -q]]
        if step is not None:
            G = [[(i == j) + step * G[i][j] for j in range(2)] for i in range(2)]
        found.append(G)
    return found


def at_its_limit(rng: Random, P: Rows, loops: Sequence[Rows], step: Fraction | None) -> Fraction:
    """Return the largest rate s of P, by bisection to 40 digits, and a hair beside it."""
    low, high = Fraction(0), Fraction(1) if step is not None else Fraction(16)
    if not falls(P, loops, step, low):
        return Fraction(1, 10)
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if falls(P, loops, step, middle) else (low, middle)
    found = beside(rng, short(low, 18))
    return min(max(found, Fraction(1, 10**9)), Fraction(1) if step is not None else found)


def invariant_ellipsoid(rng: Random) -> list[Known]:
    """One or two loops of order 2 and a box: rate, level or side at its limit."""
    step = STEP if rng.random() < 0.5 else None
    P, loops = square(rng), loops_of(rng, step)
    sides = [some(rng), some(rng)]
    s = at_its_limit(rng, P, loops, step)
    if rng.random() < 0.5:
        s = short(s * Fraction(9, 10), 18)
    rows = ([Fraction(1), Fraction(0)], [Fraction(0), Fraction(1)])
    level = Fraction(1)
    if is_definite(P):
        reaches = [reach(P, Fraction(1), row) for row in rows]
        level = min(b**2 / r for b, r in zip(sides, reaches, strict=True))
    level = beside(rng, short(level, 40))
    box = {f"x{k}": [-b, b] for k, b in enumerate(sides)}
    truth = falls(P, loops, step, s) and all(
        reach(P, level, row) <= b**2 for row, b in zip(rows, sides, strict=True)
    )
    claim = claim_of("invariant-ellipsoid", P=P, level=level, multiplier=s)
    lopsided = [[P[0][0], P[0][1] + Fraction(1, 10**9)], P[1]]
    wrong = claim | {"P": lopsided}
    model = model_of(loops, step, box=box)
    return [Known(model, None, claim, truth), Known(model, None, wrong, False, False)]


def disturbed_set(rng: Random) -> list[Known]:
    """z' = -a z + b w, |w| <= v: {p z^2 <= c} is invariant iff a^2 c >= (b v)^2 p."""
    step = STEP if rng.random() < 0.5 else None
    a, b, v = some(rng, 1, 99), some(rng), some(rng)
    p = some(rng)
    level = beside(rng, short((b * v / a) ** 2 * p, 40))
    G = -a if step is None else 1 - a
    model = model_of([[[G]]], step, E=[[[b]]])
    bounds: dict[str, Any] = (
        {"disturbance_norm": v} if rng.random() < 0.5 else {"disturbance_bounds": [v]}
    )
    found = []
    for multiplier in (a, short(a * some(rng, 1, 100), 10)):
        claim = claim_of(
            "invariant-ellipsoid",
            P=[[p]],
            level=level,
            multiplier=min(multiplier, Fraction(1)),
            disturbance="disturbances",
            **bounds,
        )
        truth = a**2 * level >= (b * v) ** 2 * p
        found.append(Known(model, None, claim, truth, multiplier == a))
    return found


def input_limits(rng: Random) -> list[Known]:
    """u = -Kx on {x'Px <= c}, one loop: amplitude and rate by reaches, each at its limit."""
    step = STEP if rng.random() < 0.5 else None
    P, (G, *_) = square(rng), loops_of(rng, step)
    K = [[some(rng, -200, 200), some(rng, -200, 200)]]
    B = [[Fraction(int(rng.integers(-2, 3)))], [Fraction(1)]]
    A = [
        [g + b[0] * k for g, k in zip(row, K[0], strict=True)] for row, b in zip(G, B, strict=True)
    ]
    s, level = Fraction(1, 10**9), some(rng)
    move = times(K, G) if step is None else minus(times(K, G), K)
    squares = [Fraction(1), Fraction(1)]
    if is_definite(P):
        squares = [reach(P, level, row) for row in (K[0], move[0])]
    top, rate = (beside(rng, short(Fraction(str(float(x) ** 0.5)), 17)) for x in squares)
    truth = falls(P, [G], step, s) and top**2 >= squares[0] and rate**2 >= squares[1]
    found: dict[str, Any] = {"P": P, "level": level, "multiplier": s, "input_limits": [top]}
    found |= {"rate_limits": [rate], "rate_shares": {"motion": [rate]}}
    if min(top, rate) <= 0:
        return []
    model = model_of([A], step, B=[B])
    return [Known(model, law_of([K], step), claim_of("input-limits", **found), truth)]


def fuzzy_decay(rng: Random) -> list[Known]:
    """Two loops of order 2 with P(h): no blend at rest may be unstable, nor slower than claimed."""
    step = STEP if rng.random() < 0.3 else None
    loops = loops_of(rng, step)
    loops = [loops[0], loops_of(rng, step)[0]]
    scale = short(Fraction(str(10.0 ** float(rng.uniform(-1, 1)))), 4)
    # Couplings of opposite size: each is stable, and their mean is often not.
    if step is None and rng.random() < 0.7:
        u, v = some(rng, 100, 900), some(rng, 1, 60)
        sign = signs(rng, 1)[0]
        loops = [
            [[-scale, u], [-sign * v, -scale]],
            [[-scale, -v], [sign * u, -scale]],
        ]
    rate = Fraction(0) if rng.random() < 0.5 else some(rng, 1, 40) / 10
    if step is None:
        shift = [_sum(G, [[rate, Fraction(0)], [Fraction(0), rate]]) for G in loops]
        truth = blends_are_hurwitz(*shift)
    else:
        rate = Fraction(0)
        truth = all(is_hurwitz(times(minus(G, ONE), _inverse(_sum(G, ONE)))) for G in loops)
    phi = [Fraction(0)] * 2 if rng.random() < 0.5 else [some(rng, 0, 100)] * 2
    found = []
    for _ in range(4):
        P = [square(rng), square(rng)]
        if step is None:
            P = [_lyapunov(G) or other for G, other in zip(shift, P, strict=True)]
        listed = [{"powers": [[1 - k, k]], "matrix": P[k]} for k in (0, 1)]
        evidence: dict[str, Any] = {"decay_rate": rate, "degrees": [1], "P": listed}
        evidence |= {"rates": [phi], "polya": Fraction(int(rng.integers(0, 4)))}
        found.append(Known(model_of(loops, step), None, claim_of("fuzzy-decay", **evidence), truth))
    return found


def no_common_decay(rng: Random) -> list[Known]:
    """Random multipliers against a pair of order 2; DISPROVED is false where it has a function."""
    loops = [loops_of(rng, None)[0] for _ in range(2)]
    exists = pair_has_function(*loops)
    found = []
    for _ in range(6):
        factors = rng.integers(-9, 10, size=(2, 2, 2)).tolist()
        listed = [
            {"blend": Fraction(k), "factor": [[Fraction(v) for v in row] for row in factors[k]]}
            for k in (0, 1)
        ]
        claim = claim_of("no-common-decay", decay_rate=Fraction(0), multipliers=listed)
        found.append(Known(model_of(loops), None, claim, exists, False))
        alone = {"blend": Fraction(int(rng.integers(2))), "P": square(rng)}
        claim = claim_of("no-common-decay", decay_rate=Fraction(0), **alone)
        found.append(Known(model_of(loops), None, claim, exists, False))
    return found


def blends_are_hurwitz(X: Rows, Y: Rows) -> bool:
    """Return whether every h X + (1 - h) Y is: a linear trace, a quadratic determinant of h."""
    if not (is_hurwitz(X) and is_hurwitz(Y)):
        return False
    first, last = _size(X), _size(Y)
    bend = _size(minus(X, Y))
    slope = first - last - bend
    h = -slope / (2 * bend) if bend else Fraction(-1)
    return not 0 < h < 1 or last + slope * h + bend * h**2 > 0


def _size(A: Rows) -> Fraction:
    return A[0][0] * A[1][1] - A[0][1] * A[1][0]


def _lyapunov(A: Rows) -> Rows | None:
    """Return P with A'P + PA = -I for order 2, to short decimals; None where det or trace is 0."""
    (a, b), (c, d) = A
    trace, size = a + d, a * d - b * c
    if trace == 0 or size == 0:
        return None
    below = -2 * trace * size
    P = [[size + c * c + d * d, -(a * c + b * d)], [-(a * c + b * d), size + a * a + b * b]]
    return [[short(entry / below, 12) for entry in row] for row in P]


def _inverse(A: Rows) -> Rows:
    (a, b), (c, d) = A
    size = a * d - b * c
    return [[d / size, -b / size], [-c / size, a / size]]


def _sum(X: Rows, Y: Rows) -> Rows:
    return [[x + y for x, y in zip(p, q, strict=True)] for p, q in zip(X, Y, strict=True)]


SETS: dict[str, Callable[[Random], list[Known]]] = {
    "ellipsoid in a box": invariant_ellipsoid,
    "ellipsoid under disturbance": disturbed_set,
    "amplitude and rate of inputs": input_limits,
    "functions of the weights": fuzzy_decay,
    "multipliers against pairs": no_common_decay,
}
