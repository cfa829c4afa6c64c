"""Rigorous ranges of a bicubic B-spline and its partial derivatives over rectangles.

On each cell between knots the spline is a polynomial.  Its Bernstein net comes from the B-spline
coefficients by blossoming; derivatives are differences of the net; a net is restricted to a
rectangle by de Casteljau's averaging; and a polynomial lies between the least and the greatest
entry of its net. All numbers are integers over 10^36. Each step has an error of at most one unit,
the nets are bounded by 2^20, and there are fewer than 2^12 steps. A difference over a cell's width
amplifies each error at most 2^20 fold. The padding of 2^-40 therefore covers every rounding.

Source: Farin (2002), Curves and Surfaces for CAGD, ch. 5 (restriction) and 8 (B-splines).
"""

from __future__ import annotations

from bisect import bisect_right
from fractions import Fraction
from itertools import pairwise
from math import lcm

from takagi.certificates.checker.arithmetic.interval import ONE, Interval
from takagi.certificates.checker.kernel.reader import increasing
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused

DEGREE = 3
PAD = ONE >> 40
LARGEST_ENTRY = ONE << 20
NARROWEST = Fraction(1, 1000)
MOST_KNOTS = 1000
Row = list[Fraction]
Net = list[list[int]]


class _Axis:
    """One direction: knots, and per cell the map from B-spline to Bernstein coefficients."""

    def __init__(self, knots: list[Fraction], where: str) -> None:
        inner = knots[DEGREE : len(knots) - DEGREE]
        ends = (knots[: DEGREE + 1], knots[-DEGREE - 1 :])
        if len(knots) < 2 * DEGREE + 2 or any(len(set(end)) != 1 for end in ends):
            raise CertificateError(f"{where}: clamped cubic knots are needed")
        if len(knots) > MOST_KNOTS:
            raise CertificateError(f"{where}: {len(knots)} knots; at most {MOST_KNOTS}")
        increasing(inner, where)
        if any(b - a < NARROWEST for a, b in pairwise(inner)):
            raise CertificateError(f"{where}: cells narrower than {NARROWEST}")
        self.knots, self.breaks = knots, inner
        self.breaks_fixed = [_fixed(knot) for knot in inner]
        # Over one denominator knots are integers, which need no greatest common divisors.
        self._over = lcm(*(knot.denominator for knot in knots))
        self._integers = [int(knot * self._over) for knot in knots]
        self._maps: dict[int, list[list[int]]] = {}

    def cells(self, low: int, high: int) -> range:
        """Return the cells that meet [low, high] (over 10^36); refuses one outside the table."""
        # The true knots lie within one unit of breaks_fixed.
        if low < self.breaks_fixed[0] or high > self.breaks_fixed[-1]:
            raise Refused("a range that leaves the coefficient table")
        last = len(self.breaks) - 2
        first = min(max(bisect_right(self.breaks_fixed, low - 1) - 1, 0), last)
        final = min(max(bisect_right(self.breaks_fixed, high + 1) - 1, 0), last)
        return range(first, final + 1)

    def map(self, cell: int) -> list[list[int]]:
        """Return (4, 4): row i maps the cell's coefficients to Bernstein ordinate i."""
        if cell not in self._maps:
            local = self._integers[cell + 1 : cell + 7]
            a, b = local[DEGREE - 1 : DEGREE + 1]
            ends = [(a,) * (DEGREE - i) + (b,) * i for i in range(DEGREE + 1)]
            self._maps[cell] = [_blossom(local, at) for at in ends]
        return self._maps[cell]

    def local(self, cell: int, value: int, up: bool) -> int:
        """Return (value - a) / (b - a) over 10^36, rounded outward and held in [0, 1]."""
        a, b = self._integers[cell + DEGREE : cell + DEGREE + 2]
        # ((value / 10^36) - a) / (b - a) times 10^36, with a and b over their denominator.
        top = value * self._over - a * ONE
        share = -(-top // (b - a)) if up else top // (b - a)
        return min(max(share, 0), ONE)

    def differences(self, net: Net, cell: int, order: int) -> Net:
        """Return the net of the derivative of this order from that of the one before."""
        factor = (DEGREE + 1 - order) / (self.breaks[cell + 1] - self.breaks[cell])
        n, d = factor.numerator, factor.denominator
        pairs = (zip(low, high, strict=True) for low, high in pairwise(net))
        return [[(b - a) * n // d for a, b in pair] for pair in pairs]


def _fixed(value: Fraction) -> int:
    return value.numerator * ONE // value.denominator


def _blossom(knots: list[int], at: tuple[int, ...]) -> list[int]:
    """Return, over 10^36, the weights of a cubic segment's coefficients in its blossom.

    Parameters
    ----------
    knots : the local knots t_1 ... t_6;  at : the three arguments; all over one denominator.
    """
    # Row i holds d_i, a sum of the four coefficients: their weights, and the denominator of these.
    d = [([int(i == j) for j in range(DEGREE + 1)], 1) for i in range(DEGREE + 1)]
    for level, u in enumerate(at, start=1):
        for i in range(DEGREE, level - 1, -1):
            low, high = knots[i - 1], knots[i + DEGREE - level]
            (previous, p), (current, q) = d[i - 1], d[i]
            pairs = zip(previous, current, strict=True)
            # d_i = ((high - u) d_{i-1} + (u - low) d_i) / (high - low)
            weights = [(high - u) * q * a + (u - low) * p * b for a, b in pairs]
            d[i] = weights, (high - low) * p * q
    weights, denominator = d[DEGREE]
    return [weight * ONE // denominator for weight in weights]


class Spline:
    """s(x, y) = sum c_ij N_i(x) N_j(y); ``bounds`` encloses any derivative up to order 2."""

    def __init__(self, x_knots: Row, y_knots: Row, rows: list[Row]) -> None:
        self.x, self.y = _Axis(x_knots, "x knots"), _Axis(y_knots, "y knots")
        shape = (len(x_knots) - DEGREE - 1, len(y_knots) - DEGREE - 1)
        if len(rows) != shape[0] or any(len(row) != shape[1] for row in rows):
            raise CertificateError(f"surface: {shape[0]} rows of {shape[1]} numbers are needed")
        self._rows = [[_fixed(c) for c in row] for row in rows]
        if any(abs(c) > LARGEST_ENTRY >> 10 for row in self._rows for c in row):
            raise CertificateError("surface: a coefficient beyond 1000 in size")
        self._nets: dict[tuple[int, ...], Net] = {}
        self._kept: dict[tuple[int, ...], list[int]] = {}
        # Value and slopes are asked for over one rectangle after the other.
        self._rectangle: tuple[Interval, Interval] | None = None
        self._brackets: dict[tuple[int, int], Interval] = {}

    def bounds(self, x: Interval, y: Interval, dx: int = 0, dy: int = 0) -> Interval:
        """Return a bracket of the (dx, dy) derivative over the rectangle x times y."""
        if self._rectangle != (x, y):
            self._rectangle, self._brackets = (x, y), {}
        if (dx, dy) not in self._brackets:
            self._brackets[dx, dy] = self._bracket(x, y, dx, dy)
        return self._brackets[dx, dy]

    def _bracket(self, x: Interval, y: Interval, dx: int, dy: int) -> Interval:
        entries: list[int] = []
        for i in self.x.cells(*x):
            sx, tx = self.x.local(i, x[0], False), self.x.local(i, x[1], True)
            for j in self.y.cells(*y):
                sy, ty = self.y.local(j, y[0], False), self.y.local(j, y[1], True)
                key = (i, j, dx, dy, sx, tx, sy, ty)
                ends = self._kept.get(key)
                if ends is None:
                    net = _restricted(self._net(i, j, dx, dy), sx, tx)
                    net = _restricted(_transposed(net), sy, ty)
                    ends = [min(map(min, net)), max(map(max, net))]
                    # Long ranges of x share their whole cells; other parts hardly come again.
                    if sx == 0 and tx == ONE:
                        self._kept[key] = ends
                entries += ends
        return Interval(min(entries) - PAD, max(entries) + PAD)

    def _net(self, i: int, j: int, dx: int, dy: int) -> Net:
        key = (i, j, dx, dy)
        if key not in self._nets:
            if dx:
                net = self.x.differences(self._net(i, j, dx - 1, dy), i, dx)
            elif dy:
                lower_net = _transposed(self._net(i, j, 0, dy - 1))
                net = _transposed(self.y.differences(lower_net, j, dy))
            else:
                block = [row[j : j + 4] for row in self._rows[i : i + 4]]
                along_x = _product(self.x.map(i), block)
                net = _transposed(_product(self.y.map(j), _transposed(along_x)))
            if any(abs(entry) > LARGEST_ENTRY for row in net for entry in row):
                raise Refused("a surface too steep to bound")
            self._nets[key] = net
        return self._nets[key]


def _product(weights: list[list[int]], net: list[list[int]]) -> Net:
    columns = list(zip(*net, strict=True))
    return [
        [sum(a * b for a, b in zip(row, c, strict=True)) // ONE for c in columns] for row in weights
    ]


def _transposed(net: Net) -> Net:
    return [list(column) for column in zip(*net, strict=True)]


def _restricted(net: Net, start: int, stop: int) -> Net:
    """Return the net of the polynomial in the first direction over [start, stop] of [0, 1]."""
    if len(net) == 1 or (start == 0 and stop == ONE):
        return net
    if stop < ONE:
        net = _first_part(net, stop)
    if start > 0:
        # [start, stop] is the last part of [0, stop], at the share start / stop.
        share = start * ONE // stop if stop else 0
        net = _first_part(net[::-1], ONE - share)[::-1]
    return net


def _first_part(net: Net, share: int) -> Net:
    """Return the net over [0, share] by de Casteljau, all columns at once."""
    leading_rows = [net[0]]
    while len(net) > 1:
        pairs = (zip(low, high, strict=True) for low, high in pairwise(net))
        net = [[a + (b - a) * share // ONE for a, b in pair] for pair in pairs]
        leading_rows.append(net[0])
    return leading_rows
