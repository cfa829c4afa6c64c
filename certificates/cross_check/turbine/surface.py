r"""Ranges of the turbine's torque coefficient over rectangles, and arithmetic with ranges.

    s(x, y) = sum_ij c_ij N_i(x) N_j(y)      N_i cubic B-splines on clamped knots

On a patch between knots the basis functions are polynomials, which the recursion of Cox and
de Boor gives in powers of the distance u from the patch's left end,

    N_{i,p}(x) = (x - t_i) / (t_{i+p} - t_i) N_{i,p-1} + (t_{i+p+1} - x) / (...) N_{i+1,p-1} .

With u = u_0 + h t, t in [0, 1], a polynomial sum_k a_k t^k of degree n lies between the least and
the greatest of b_i = sum_{k <= i} C(i, k) / C(n, k) a_k, its Bernstein coefficients.  All steps are
exact; only the ends of a range are rounded, and outward.

Source: de Boor (2001), A Practical Guide to Splines, ch. IX and X; Farin (2002), Curves and
Surfaces for CAGD, ch. 5; recalled.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from dataclasses import dataclass
from functools import cache
from math import comb, prod
from typing import Any

from flint import fmpq, fmpq_mat, fmpq_poly, fmpz, fmpz_mat

from takagi.certificates.cross_check.kernel.reading import NotReplayed, Refusal, rationals, table

DEGREE, BITS, MOST_PATCHES = 3, 80, 400
MOST_FUNCTIONS = 128  # basis functions in one direction
# A matrix as integers over their common denominator: products need no greatest common divisors.
Ratio = tuple[fmpz_mat, fmpz]
# What the format allows: knots at least a thousandth apart, and coefficients up to 1024, far more
# than a torque coefficient, which is below 1.
NARROWEST, LARGEST = fmpq(1, 1000), 1024


class Outside(Exception):
    """A range that leaves the table."""


@dataclass(frozen=True, slots=True)
class NumberRange:
    """The numbers from ``low`` to ``high``; sums, products, quotients contain all exact results."""

    low: fmpq
    high: fmpq

    @classmethod
    def of(cls, *values: fmpq) -> NumberRange:
        """Return the least span that holds some numbers."""
        return cls(min(values), max(values))

    def hull(self, other: NumberRange) -> NumberRange:
        return NumberRange(min(self.low, other.low), max(self.high, other.high))

    def __add__(self, other: NumberRange) -> NumberRange:
        return NumberRange(self.low + other.low, self.high + other.high)

    def __neg__(self) -> NumberRange:
        return NumberRange(-self.high, -self.low)

    def __sub__(self, other: NumberRange) -> NumberRange:
        return self + (-other)

    def __mul__(self, other: NumberRange) -> NumberRange:
        if other.low == other.high:
            return self.times(other.low)
        return NumberRange.of(
            *(a * b for a in (self.low, self.high) for b in (other.low, other.high))
        )

    def times(self, factor: fmpq) -> NumberRange:
        ends = self.low * factor, self.high * factor
        return NumberRange(*ends) if factor >= 0 else NumberRange(*ends[::-1])

    def __truediv__(self, other: NumberRange) -> NumberRange:
        if other.low <= 0 <= other.high:
            raise Outside("a denominator that may be zero")
        return self * NumberRange(1 / other.high, 1 / other.low)

    def squared(self) -> NumberRange:
        ends = NumberRange.of(self.low**2, self.high**2)
        return NumberRange(fmpq(0), ends.high) if self.low < 0 < self.high else ends

    def rounded(self) -> NumberRange:
        """Return the span with ends that are multiples of 2^-80, rounded outward."""
        one = 1 << BITS
        down = (int(self.low.p) * one) // int(self.low.q)
        up = -((-int(self.high.p) * one) // int(self.high.q))
        return NumberRange(fmpq(down, one), fmpq(up, one))

    @property
    def size(self) -> fmpq:
        return max(abs(self.low), abs(self.high))


class _Side:
    """The knots of one direction, and for each patch the basis functions in powers of u."""

    def __init__(self, owner: Any, key: str) -> None:
        knots = rationals(owner, key)
        breaks = knots[DEGREE : len(knots) - DEGREE]
        clamped = len(set(knots[: DEGREE + 1])) == 1 == len(set(knots[-DEGREE - 1 :]))
        rises = all(a < b for a, b in zip(breaks, breaks[1:], strict=False))
        if len(knots) < 2 * DEGREE + 2 or not clamped or not rises:
            raise Refusal(f"{key}: clamped knots of a cubic spline that increase are needed")
        if any(b - a < NARROWEST for a, b in zip(breaks, breaks[1:], strict=False)):
            raise Refusal(f"{key}: knots closer than a thousandth")
        self.knots, self.breaks = knots, breaks
        self.count = len(knots) - DEGREE - 1
        if self.count > MOST_FUNCTIONS:
            raise NotReplayed(f"{key}: a surface with more than {MOST_FUNCTIONS} functions a side")
        self._bases: dict[int, fmpq_mat] = {}

    def patches(self, over: NumberRange) -> list[tuple[int, fmpq, fmpq]]:
        """Return (patch, u_0, h) of every patch that a span touches, with u = u_0 + h t."""
        if over.low < self.breaks[0] or over.high > self.breaks[-1]:
            raise Outside("a range that leaves the coefficient table")
        found, wider = [], over.rounded()
        # A patch that shares only an end with the span counts: the span contains that point.
        first = max(0, bisect_left(self.breaks, wider.low) - 1)
        last = min(len(self.breaks) - 1, bisect_right(self.breaks, wider.high))
        for k in range(first, last):
            a, b = self.breaks[k], self.breaks[k + 1]
            low, high = max(a, wider.low), min(b, wider.high)
            if low <= high:
                found.append((k, low - a, high - low))
        return found

    def basis(self, patch: int) -> fmpq_mat:
        """Return (4, 4): row i has the coefficients of N_{patch + i} by powers of u."""
        if patch not in self._bases:
            a, t, at = self.breaks[patch], self.knots, patch + DEGREE
            u = fmpq_poly([0, 1])
            level = {at: fmpq_poly([1])}
            for p in range(1, DEGREE + 1):
                risen = {}
                for i in range(at - p, at + 1):
                    total = fmpq_poly([0])
                    if i in level:
                        total += (u + (a - t[i])) * (1 / (t[i + p] - t[i])) * level[i]
                    if i + 1 in level:
                        share = 1 / (t[i + p + 1] - t[i + 1])
                        total += (-u + (t[i + p + 1] - a)) * share * level[i + 1]
                    risen[i] = total
                level = risen
            rows = [[level[i][k] for k in range(DEGREE + 1)] for i in range(patch, at + 1)]
            self._bases[patch] = fmpq_mat(rows)
        return self._bases[patch]


@cache
def _shares(order: int) -> list[list[list[tuple[int, int, fmpq]]]]:
    """Return the terms (power of start, power of width, share) of each entry of the map below.

    (d/du)^order u^j = j!/(j - order)! u^m with m = j - order, and
    u^m = sum_k C(m, k) start^(m-k) (h t)^k.
    """
    n = DEGREE - order
    return [
        [
            [
                (m - k, k, fmpq(comb(i, k) * comb(m, k) * prod(range(m + 1, j + 1)), comb(n, k)))
                for k in range(min(i, m) + 1)
            ]
            for j in range(DEGREE + 1)
            for m in (j - order,)
        ]
        for i in range(n + 1)
    ]


def _to_bernstein(order: int, start: fmpq, width: fmpq) -> Ratio:
    """Return the map from powers of u to the Bernstein coefficients of a derivative."""
    of_start, of_width = ([x**k for k in range(DEGREE + 1)] for x in (start, width))
    entries = [
        [
            sum((share * of_start[p] * of_width[q] for p, q, share in parts), fmpq(0))
            for parts in row
        ]
        for row in _shares(order)
    ]
    found: Ratio = fmpq_mat(entries).numer_denom()
    return found


class CoefficientSurface:
    """The bicubic spline c_Q(lambda, beta) of a turbine's certificate."""

    def __init__(self, owner: Any) -> None:
        self.x, self.y = _Side(owner, "tip_speed_ratio_knots"), _Side(owner, "pitch_knots")
        self.c = table(owner, "coefficients", (self.x.count, self.y.count))
        if any(abs(c) > LARGEST for c in self.c.entries()):
            raise Refusal(f"coefficients: one beyond {LARGEST} in size")
        self._patches: dict[tuple[int, int], fmpq_mat] = {}
        self._integers: dict[tuple[int, int], Ratio] = {}

    def over(self, x: NumberRange, y: NumberRange, dx: int = 0, dy: int = 0) -> NumberRange:
        """Return a span that holds d^(dx+dy) s / dx^dx dy^dy over a rectangle.

        Raises
        ------
        Outside : the rectangle leaves the table.
        """
        return Band(self, y, dy).over(x, dx)

    def _patch(self, i: int, j: int) -> fmpq_mat:
        """Return the coefficients of the patch's polynomial by powers of u (rows) and of v."""
        if (i, j) not in self._patches:
            n = DEGREE + 1
            local = fmpq_mat([[self.c[i + k, j + m] for m in range(n)] for k in range(n)])
            self._patches[i, j] = self.x.basis(i).transpose() * local * self.y.basis(j)
        return self._patches[i, j]

    def integers(self, i: int, j: int) -> Ratio:
        """Return the coefficients of a patch's polynomial by powers of u (rows) and of v."""
        if (i, j) not in self._integers:
            self._integers[i, j] = self._patch(i, j).numer_denom()
        return self._integers[i, j]


class Band:
    """The surface, or a derivative by y, over one range of y: what all ranges of x share."""

    def __init__(self, surface: CoefficientSurface, y: NumberRange, dy: int = 0) -> None:
        self.surface = surface
        self._columns = [(j, _to_bernstein(dy, *part)) for j, *part in surface.y.patches(y)]
        self._whole: dict[tuple[int, int], NumberRange] = {}

    def over(self, x: NumberRange, dx: int = 0) -> NumberRange:
        """Return a span that holds the derivative by x of this order over a range of x.

        Raises
        ------
        Outside : the rectangle leaves the table.
        """
        rows = self.surface.x.patches(x)
        if len(self._columns) * len(rows) > MOST_PATCHES:
            raise NotReplayed("a range over more patches of the surface than are enclosed here")
        spans = [self._on_row(*row, dx) for row in rows]
        return NumberRange(
            min(span.low for span in spans), max(span.high for span in spans)
        ).rounded()

    def _on_row(self, i: int, start: fmpq, width: fmpq, dx: int) -> NumberRange:
        """Return the span over the patches (i, j), where u goes from start to start + width."""
        a, b = self.surface.x.breaks[i : i + 2]
        whole = start == 0 and width == b - a
        if whole and (i, dx) in self._whole:
            return self._whole[i, dx]
        (along, p), ends = _to_bernstein(dx, start, width), []
        for j, (across, q) in self._columns:
            c, r = self.surface.integers(i, j)
            found = (along * c * across.transpose()).entries()
            ends += [fmpq(min(found), p * q * r), fmpq(max(found), p * q * r)]
        span = NumberRange.of(*ends)
        if whole:
            self._whole[i, dx] = span
        return span
