"""Exact answers by theorems that use no Lyapunov function: the truth to hold verdicts against.

    eigenvalues left of a line     the minors of Hurwitz's matrix of the characteristic polynomial
    inside the unit circle         the same of (A - I)(A + I)^-1
    number of negative real roots  Sturm's sequence
    e^-x against a rational        sixty digits of the standard library's decimal numbers

All of it is rational arithmetic of its own; nothing here is shared with the package.
"""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Rows = list[list[Fraction]]
Polynomial = list[Fraction]
DIGITS = 60


def exact(M: Floats) -> Rows:
    """Return the decimals that are written for floats."""
    return [[Fraction(repr(float(entry))) for entry in row] for row in M]


def times(X: Rows, Y: Rows) -> Rows:
    columns = list(zip(*Y, strict=True))
    return [
        [sum((a * b for a, b in zip(row, c, strict=True)), Fraction(0)) for c in columns]
        for row in X
    ]


def minus(X: Rows, Y: Rows) -> Rows:
    return [[a - b for a, b in zip(p, q, strict=True)] for p, q in zip(X, Y, strict=True)]


def transposed(X: Rows) -> Rows:
    return [list(column) for column in zip(*X, strict=True)]


def plus(A: Rows, number: Fraction) -> Rows:
    """Return A + number I."""
    return [[a + number * (i == j) for j, a in enumerate(row)] for i, row in enumerate(A)]


def diagonal(values: Sequence[Fraction]) -> Rows:
    n = len(values)
    return [[values[i] if i == j else Fraction(0) for j in range(n)] for i in range(n)]


def inverse(A: Rows) -> Rows:
    """Return the inverse by Gauss and Jordan."""
    n = len(A)
    rows = [[*row, *(Fraction(int(i == j)) for j in range(n))] for i, row in enumerate(A)]
    for k in range(n):
        pivot = next(i for i in range(k, n) if rows[i][k])
        rows[k], rows[pivot] = rows[pivot], rows[k]
        rows[k] = [entry / rows[k][k] for entry in rows[k]]
        for i in range(n):
            if i != k and rows[i][k]:
                factor = rows[i][k]
                rows[i] = [a - factor * b for a, b in zip(rows[i], rows[k], strict=True)]
    return [row[n:] for row in rows]


def characteristic(A: Rows) -> Polynomial:
    """Return 1, c_1, ..., c_n of s^n + c_1 s^(n-1) + ... by Faddeev and LeVerrier."""
    n = len(A)
    found, M = [Fraction(1)], plus([[Fraction(0)] * n for _ in range(n)], Fraction(1))
    for k in range(1, n + 1):
        AM = times(A, M)
        found.append(-sum((AM[i][i] for i in range(n)), Fraction(0)) / k)
        M = plus(AM, found[-1])
    return found


def determinant(A: Rows) -> Fraction:
    last = characteristic(A)[-1]
    return -last if len(A) % 2 else last


def is_hurwitz(A: Rows, rate: Fraction = Fraction(0)) -> bool:
    """Return whether every eigenvalue of A has a real part below -rate."""
    c = characteristic(plus(A, rate))
    n = len(A)
    hurwitz = [
        [c[2 * j - i + 1] if 0 <= 2 * j - i + 1 <= n else Fraction(0) for j in range(n)]
        for i in range(n)
    ]
    return all(determinant([row[:k] for row in hurwitz[:k]]) > 0 for k in range(1, n + 1))


def cayley(A: Rows) -> Rows:
    """Return (A - I)(A + I)^-1: P shows it in continuous time as it shows A in discrete time."""
    return times(plus(A, Fraction(-1)), inverse(plus(A, Fraction(1))))


def is_schur(A: Rows) -> bool:
    """Return whether all eigenvalues are inside the unit circle."""
    return determinant(plus(A, Fraction(1))) != 0 and is_hurwitz(cayley(A))


def pair_has_function(A: Rows, B: Rows) -> bool:
    """Return whether x'Px falls along both of two matrices of order 2, for one P > 0.

    Both are Hurwitz, and neither AB nor AB^-1 has a negative real eigenvalue: Shorten and Narendra
    (2002), recalled.
    """
    if not (is_hurwitz(A) and is_hurwitz(B)):
        return False
    return not any(negative_roots(characteristic(times(A, X))) for X in (B, inverse(B)))


def rank_one_pair_has_function(A: Rows, B: Rows) -> bool:
    """Return the same for matrices of any order whose difference has rank one.

    Both are Hurwitz, and AB has no negative real eigenvalue: Shorten, Mason, O'Cairbre, Curran
    (2004), King and Nathanson (2006), recalled.
    """
    return is_hurwitz(A) and is_hurwitz(B) and not negative_roots(characteristic(times(A, B)))


def negative_roots(p: Polynomial) -> int:
    """Return how many different real roots are negative, by Sturm; p is highest power first."""
    rows = [_trimmed(p)]
    n = len(rows[0]) - 1
    rows.append([c * (n - i) for i, c in enumerate(rows[0][:-1])])
    while len(rows[-1]) > 1:
        rest = _remainder(rows[-2], rows[-1])
        if not rest:
            break
        rows.append([-c for c in rest])
    # Common factors change no sign of a quotient; a root at 0 is counted out by looking below it.
    low = [row[0] * (-1) ** (len(row) - 1) for row in rows]
    near = [next(c * (-1) ** k for k, c in enumerate(reversed(row)) if c) for row in rows]
    return _changes(low) - _changes(near)


def _trimmed(p: Polynomial) -> Polynomial:
    first = next((i for i, c in enumerate(p) if c), len(p))
    return p[first:]


def _remainder(a: Polynomial, b: Polynomial) -> Polynomial:
    rest = list(a)
    while len(rest) >= len(b):
        factor = rest[0] / b[0]
        rest = [c - factor * (b[i] if i < len(b) else 0) for i, c in enumerate(rest)][1:]
    return _trimmed(rest)


def _changes(values: Sequence[Fraction]) -> int:
    signs = [v > 0 for v in values if v]
    return sum(a != b for a, b in zip(signs, signs[1:], strict=False))


def is_at_most_exp(value: Fraction, x: Fraction) -> bool:
    """Return whether value <= e^-x; a tie to fifty digits has to be a rational one, x = 0."""
    with localcontext() as context:
        context.prec = DIGITS
        exponential = (-_decimal(x)).exp()
        gap = exponential - _decimal(value)
        if abs(gap) <= exponential.scaleb(-50):
            if x == 0:
                return value <= 1
            raise ArithmeticError(f"{value} and e^-{x} agree to fifty digits")
        return gap > 0


def logarithm(value: Fraction, digits: int) -> Fraction:
    """Return -ln(value), 0 < value <= 1, to so many digits; rounding goes to either side."""
    with localcontext() as context:
        context.prec = DIGITS
        found = -_decimal(value).ln()
        context.prec = digits
        return Fraction(+found)


def _decimal(value: Fraction) -> Decimal:
    return Decimal(value.numerator) / Decimal(value.denominator)
