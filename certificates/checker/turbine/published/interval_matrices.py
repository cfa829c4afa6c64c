r"""One exact inequality for all matrices of an interval matrix.

For A = M + D, |D_ij| <= R_ij, and any w_i > 0:

    P D + D'P <= E = sum_i w_i r_i P e_i e_i' P + sum_j diag(c_j),
                 r_i = sum_j R_ij,   c_j = sum_i R_ij / w_i

since 2 |D_ij a b| <= R_ij (w_i a^2 + b^2 / w_i).  With N = -(M'P + PM) - E then

    N - 2 rho P > 0                             V = y'Py decays at 2 rho for every such A
    [[N - alpha P, -P d], [-d'P, alpha]] > 0    V' < 0 where V >= 1, at each corner d of its box

Everything is an integer: A over UNIT, P over its own scale, w over 2^20 and rounded upward.
"""

from __future__ import annotations

from fractions import Fraction
from itertools import product
from math import isqrt, lcm

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, positive
from takagi.certificates.checker.kernel.refusal import CertificateError

UNIT = 10**7
SHIFT = 20
Rows = list[list[Fraction]]
Integers = list[list[int]]


def contraction(
    P: Rows,
    corners: list[tuple[Rows, Rows]],
    disturbance: list[Fraction],
    rate: Fraction,
    multiplier: Fraction,
    where: str,
) -> Obligations:
    """Yield the inequalities.

    Parameters
    ----------
    P : (n, n), symmetric.
    corners : (low, high) of A, entries over UNIT.
    disturbance : bounds of |d_i|, over UNIT.
    rate, multiplier : rho and alpha, above 0.
    """
    scale = lcm(*(entry.denominator for row in P for entry in row))
    whole, n = [[int(entry * scale) for entry in row] for row in P], len(P)
    # {V <= 1} within |y_i| <= 1 says P - e_i e_i' >= 0 for each i.
    for i in range(n):
        inside = [[whole[j][k] - scale * (i == j == k) for k in range(n)] for j in range(n)]
        yield positive(Matrix(inside), "the set is not inside its box")
    delta = [_over_unit(d, where) for d in disturbance]
    for low, high in corners:
        least, most = (
            [[_over_unit(a, where) for a in row] for row in rows] for rows in (low, high)
        )
        spare, factor = _spare(whole, scale, least, most)
        decayed = _minus(spare, whole, 2 * rate, factor // scale)
        yield positive(Matrix(decayed), "the decay inequality fails at a corner")
        yield from _invariance(spare, whole, scale, factor, delta, multiplier)


def _spare(P: Integers, scale: int, low: Integers, high: Integers) -> tuple[Integers, int]:
    """Return N times a factor, and the factor: 2 UNIT 2^SHIFT scale^2."""
    n, one = len(P), 1 << SHIFT
    middle = [[a + b for a, b in zip(*rows, strict=True)] for rows in zip(low, high, strict=True)]
    radius = [[b - a for a, b in zip(*rows, strict=True)] for rows in zip(low, high, strict=True)]
    # w_i = 1 / sqrt(P_ii) gives a tight bound if the set touches its box; any w_i > 0 is sound.
    weight = [max(isqrt((scale << 2 * SHIFT) // P[i][i]), 1) for i in range(n)]
    inverse = [-(-one * one // w) for w in weight]
    PM = [[sum(P[i][k] * middle[k][j] for k in range(n)) for j in range(n)] for i in range(n)]
    rows = [weight[i] * sum(radius[i]) for i in range(n)]
    columns = [sum(radius[i][j] * inverse[i] for i in range(n)) for j in range(n)]
    found = [
        [
            -(PM[i][j] + PM[j][i]) * one * scale
            - sum(rows[k] * P[i][k] * P[k][j] for k in range(n))
            for j in range(n)
        ]
        for i in range(n)
    ]
    for j in range(n):
        found[j][j] -= columns[j] * scale * scale
    return found, 2 * UNIT * one * scale * scale


def _minus(spare: Integers, P: Integers, rate: Fraction, factor: int) -> Integers:
    """Return (N - rate P) times the denominator of the rate."""
    top, bottom = rate.numerator * factor, rate.denominator
    return [
        [s * bottom - top * p for s, p in zip(*rows, strict=True)]
        for rows in zip(spare, P, strict=True)
    ]


def _invariance(
    spare: Integers, P: Integers, scale: int, factor: int, delta: list[int], alpha: Fraction
) -> Obligations:
    base = _minus(spare, P, alpha, factor // scale)
    whole = factor * alpha.denominator
    # d is over UNIT and P over its scale; both divide the factor, so the result is an integer.
    border = whole // (scale * UNIT)
    # Opposite signs of d give the same inequality, so the first sign can be fixed.
    for signs in product((1, -1), repeat=len(P) - 1):
        d = [s * x for s, x in zip((1, *signs), delta, strict=True)]
        Pd = [-sum(p * x for p, x in zip(row, d, strict=True)) * border for row in P]
        rows = [[*row, edge] for row, edge in zip(base, Pd, strict=True)]
        matrix = Matrix([*rows, [*Pd, alpha.numerator * factor]])
        yield positive(matrix, "the invariance inequality fails at a corner")


def _over_unit(value: Fraction, where: str) -> int:
    scaled = value * UNIT
    if scaled.denominator != 1:
        raise CertificateError(f"{where}: ranges and bounds have at most seven decimals")
    return int(scaled)
