r"""The size of {x'Px <= c}, rounded so that each statement stays true.

    reach along x_k    the largest |x_k| in it:  sqrt(c (P^-1)_kk)        rounded up
    volume             V_n c^(n/2) / sqrt(det P),  V_n of the unit ball    rounded down

(P^-1)_kk is the minor of P without row and column k over det P.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from math import factorial, isqrt

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.words.rounded import at_least, at_most

PI_BELOW = Fraction(31415926535897932, 10**16)
LARGEST = 12  # states of which sizes are shown; minors of more take long
BITS = 64


def rounded_size(P: Matrix, level: Fraction, states: tuple[str, ...]) -> str:
    """Return reach by state and volume in words; empty for more than twelve states."""
    if len(P.rows) > LARGEST:
        return ""
    reach = ", ".join(
        f"{at_most(bound, 4)} in {name}"
        for bound, name in zip(reaches(P, level), states, strict=True)
    )
    return f"; it reaches {reach}; volume at least {at_least(volume_below(P, level), 4)}"


def reaches(P: Matrix, level: Fraction) -> list[Fraction]:
    """Return (n,) upper bounds, to 19 digits, on |x_k| where x'Px <= level, for P > 0."""
    squares = squared_reaches(P, range(len(P.rows)))
    return [square_root_above(level * square) for square in squares]


def squared_reaches(P: Matrix, states: Iterable[int]) -> list[Fraction]:
    """Return (P^-1)_kk for each of the states k, the largest x_k^2 on x'Px <= 1, for P > 0."""
    determinant, squares = _determinant(P), []
    for k in states:
        minor_rows = [
            [v for j, v in enumerate(row) if j != k] for i, row in enumerate(P.rows) if i != k
        ]
        minor = _determinant(Matrix(minor_rows, P.below)) if minor_rows else Fraction(1)
        squares.append(minor / determinant)
    return squares


def volume_below(P: Matrix, level: Fraction) -> Fraction:
    """Return a lower bound, to 15 digits, on the volume of {x'Px <= level} in R^n, for P > 0."""
    n = len(P.rows)
    half = n // 2
    if n % 2 == 0:
        ball = PI_BELOW**half / factorial(half)
    else:
        ball = 2 * factorial(half) * (4 * PI_BELOW) ** half / factorial(n)
    return ball * square_root_below(level**n / _determinant(P))


def square_root_below(value: Fraction) -> Fraction:
    """Return a rational at most sqrt(value), for value >= 0."""
    return _root(value, 0)


def square_root_above(value: Fraction) -> Fraction:
    """Return a rational above sqrt(value), for value >= 0."""
    return _root(value, 1)


def _root(value: Fraction, rounding: int) -> Fraction:
    inside = value.numerator * value.denominator
    shift = max(0, BITS - inside.bit_length() // 2)
    return Fraction(isqrt(inside << 2 * shift) + rounding, value.denominator << shift)


def _determinant(P: Matrix) -> Fraction:
    """Return det P of a positive definite matrix: the last pivot of Bareiss' elimination."""
    rows, previous, size = [list(row) for row in P.rows], 1, len(P.rows)
    for k in range(size - 1):
        for i in range(k + 1, size):
            for j in range(k + 1, size):
                rows[i][j] = (rows[i][j] * rows[k][k] - rows[i][k] * rows[k][j]) // previous
        previous = rows[k][k]
    return Fraction(rows[-1][-1], P.below**size)
