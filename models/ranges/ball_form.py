r"""Enclosures of a differentiable expression over a box, in ball arithmetic.

Three methods make the enclosures tight:

- a variable in which f is monotone over the box is replaced by its two ends;
- for the others the mean-value form, f(X) in f(m) + sum_i df/dx_i(X) (X_i - m_i), next to the
  plain evaluation; for a single one also the Taylor form of second order;
- a removable singularity N(x)/x_j^k at x_j = 0 is taken in Taylor form there:
  N/x_j^k = \int_0^1 k (1 - s)^{k-1} N^{(k)}(s x_j) ds / k!  lies in the range of N^{(k)}/k!.

Source: Johansson (2017), "Arb: efficient arbitrary-precision midpoint-radius interval
arithmetic", IEEE Trans. Computers 66; Moore, Kearfott, Cloud (2009), ch. 6.

Boxes as the ball arithmetic needs them: sides with rational ends, and operations on balls.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

import sympy as sp
from flint import arb, fmpq

from takagi.models.errors import ModelError
from takagi.models.intervals.box_search import Bounded, Ends
from takagi.models.intervals.interval import Interval
from takagi.models.ranges.symbolic_steps import (
    derivative,
    is_zero,
    order_of,
    slope_or_none,
    with_exponentials_as_symbols,
)
from takagi.models.ranges.tape import Tape, tables_class, tape_of

Ball: TypeAlias = Any  # flint.arb and flint.fmpq carry no type annotations


class BoxSide(NamedTuple):
    """Rational ends (``fmpq``), and a ball that contains all between them."""

    lower: Any
    upper: Any
    ball: Ball
    is_point: bool

    def interval(self) -> Interval:
        """Return the side with ends as fractions."""
        return Interval(*(Fraction(int(e.p), int(e.q)) for e in (self.lower, self.upper)))

    def centre(self) -> BoxSide:
        """Return the point in the middle."""
        return self if self.is_point else _side((self.lower + self.upper) / 2)

    def ends(self) -> tuple[BoxSide, BoxSide]:
        """Return both ends as points."""
        return _side(self.lower), _side(self.upper)

    def has_zero(self) -> bool:
        """Return whether 0 is on the side."""
        return bool(self.lower <= 0 <= self.upper)

    def near_zero(self) -> bool:
        """Return whether 0 is within three widths, where N(x)/x^k cancels badly."""
        return not self.is_point and bool(
            max(-self.lower, self.upper) <= 4 * (self.upper - self.lower)
        )


def side_of(interval: Interval) -> BoxSide:
    """Return the interval as a side."""
    ends = (fmpq(e.numerator, e.denominator) for e in (interval.lower, interval.upper))
    return _side(*ends)


def _side(lower: Any, upper: Any = None) -> BoxSide:
    low = arb(lower)
    if upper is None or lower == upper:
        return BoxSide(lower, lower, low, True)
    high = arb(upper)
    ball = low.union(high)
    # Radii have 30 bits: a ball around [0, 1/3] would begin below 0, where sqrt is undefined.
    if lower >= 0 and ball.lower() < 0:
        ball = _from_zero(high.upper())
    elif upper <= 0 and ball.upper() > 0:
        ball = -_from_zero((-low).upper())
    return BoxSide(lower, upper, ball, False)


def _from_zero(high: Ball) -> Ball:
    """Return a ball that contains [0, high] and begins at 0: moved up by what it began too low."""
    ball = arb(0).union(high)
    return ball - ball.lower()


Sides: TypeAlias = tuple[BoxSide, ...]
FINEST = 2**60  # a side is not halved if its magnitude is at least this many widths


def halved(box: Sides, axis: int) -> tuple[Sides, Sides]:
    """Return both halves of a box along one side."""
    side = box[axis]
    middle = (side.lower + side.upper) / 2
    halves = _side(side.lower, middle), _side(middle, side.upper)
    first, second = ((*box[:axis], half, *box[axis + 1 :]) for half in halves)
    return first, second


def worst_axis(box: Sides, slopes: list[Ball | None], sizes: tuple[float, ...]) -> int | None:
    """Return the side along which f changes most; None when every side is a point.

    A side along which f is monotone is put to its ends, so the others come first.  Without slopes
    the side is halved that is the largest part of its size, so that units do not matter.
    """
    best, axis = (False, -1.0), None
    all_known = all(slope is not None for slope in slopes)
    for index, (side, slope) in enumerate(zip(box, slopes, strict=True)):
        width = 2 * float(side.ball.rad())
        if side.is_point or width * FINEST <= float(abs(side.ball).upper()):
            continue
        if not all_known or slope is None:
            rated = (True, width / (sizes[index] or 1.0))
        else:
            is_free = bool(slope.lower() < 0 < slope.upper())
            rated = (is_free, width * float(abs(slope).upper()))
        if rated > best:
            best, axis = rated, index
    return axis


def finite_or_none(ball: Ball | None) -> Ball | None:
    return ball if ball is not None and ball.is_finite() else None


def ends_of(ball: Ball) -> Ends | None:
    return (ball.lower(), ball.upper()) if ball.is_finite() else None


def attained_at(ball: Ball) -> Ends | None:
    """Return the ends of a value's own enclosure, each on the cautious side."""
    return (ball.upper(), ball.lower()) if ball.is_finite() else None


def wider(first: Ends | None, second: Ends | None) -> Ends | None:
    if first is None or second is None:
        return second if first is None else first
    return min(first[0], second[0]), max(first[1], second[1])


def highest(rate: Ball, bend: Ball, radius: Ball) -> Ball:
    """Return max over 0 <= d <= radius of rate d + bend d^2/2, or more; rate >= 0, exact balls."""
    if bend >= 0 or rate >= -bend * radius:
        return rate * radius + bend * radius**2 / 2
    return -(rate**2) / (2 * bend)


def between(lower: Ball, upper: Ball) -> Ball:
    """Return a ball around both ends that keeps their sign: its radius has 30 bits only."""
    ball = lower.union(upper)
    if lower >= 0 and ball.lower() < 0:
        return ball - ball.lower()
    if upper <= 0 and ball.upper() > 0:
        return ball - ball.upper()
    return ball


def common(first: Ball, second: Ball) -> Ball:
    """Return the intersection of two enclosures of the same set."""
    if not first.is_finite() or not second.is_finite():
        return second if not first.is_finite() else first
    return first.intersection(second)


SHORT = 60  # operations; second derivatives of longer expressions cost more than they gain
PRECISION = 128  # bits; Taylor forms near a removable singularity cancel leading digits


class BallForm:
    """An expression with its derivatives and Taylor forms, each made when first needed.

    Attributes
    ----------
    covered : every argument of every table is proved to stay inside it.
    far : the Taylor form towards a removable pole is tried on every box, not only near the pole.
    sizes : of the sides of the box that is searched; the side that is the largest part of its
        size is halved where slopes are not known.
    positive : arguments of roots that are proved to be >= 0 on the box and towards 0.
    """

    def __init__(
        self,
        expression: sp.Expr,
        symbols: tuple[sp.Symbol, ...],
        covered: bool = False,
        far_from_poles: bool = False,
        sizes: tuple[float, ...] = (),
        positive: frozenset[sp.Expr] = frozenset(),
    ) -> None:
        self.expression = expression
        self.symbols = symbols
        self.covered = covered
        self.far = far_from_poles
        self.positive = positive
        self.sizes = sizes or (1.0,) * len(symbols)
        self._further: BallForm | None = None
        tables = tables_class()
        # A table held at its edge has a kink there.
        self.length = int(expression.count_ops())
        self.is_held = not covered and tables is not None and expression.has(tables)
        self.tape = tape_of([expression], symbols, positive=positive)
        self._joint: Tape | None = None
        self._gradient: tuple[BallForm | None, ...] | None = None
        self._poles: tuple[int, ...] | None = None
        self._taylor: dict[int, BallForm | None] = {}
        self._has_pole: dict[int, bool] = {}

    def look(self, box: Sides) -> Bounded:
        """Return the plain enclosure over the box; see ``search``."""
        value = self.plain(box)
        attained = attained_at(value) if all(side.is_point for side in box) else None
        return Bounded(ends_of(value), attained, worst_axis(box, [None] * len(box), self.sizes))

    def refined(self, box: Sides) -> Bounded:
        """Return the common part of all forms over the box, and values attained there."""
        value, slopes = self.with_slopes(box)
        rough, axis = ends_of(value), worst_axis(box, slopes, self.sizes)
        if rough is None or axis is None:
            return self.look(box)
        enclosure, points = self._tightened(box, rough, slopes)
        attained = None
        for point in points:
            attained = wider(attained, attained_at(point))
        return Bounded(enclosure, attained, axis)

    def further(self) -> BallForm:
        """Return the form that tries the Taylor form towards removable poles on every box.

        Where x is known less well than y, (sin x - sin(x - y))/y is a small difference over a small
        number also far from y = 0: nearness to 0 alone does not tell where N/y cancels badly.
        """
        if self._further is None:
            self._further = BallForm(
                self.expression, self.symbols, self.covered, True, self.sizes, self.positive
            )
        return self._further

    def _tightened(
        self, box: Sides, rough: Ends, slopes: list[Ball | None]
    ) -> tuple[Ends, list[Ball]]:
        """Return the common part of all forms, and balls of values at points."""
        low, high = list(box), list(box)
        free: list[int] = []
        for index, (side, slope) in enumerate(zip(box, slopes, strict=True)):
            if side.is_point:
                continue
            if slope is None or (slope.lower() < 0 < slope.upper()):
                free.append(index)
                continue
            first, last = side.ends()
            rising = slope.lower() >= 0
            low[index], high[index] = (first, last) if rising else (last, first)
        lower, upper = rough
        points: list[Ball] = []
        if len(free) < len(box):
            for face, is_low in ((low, True), (high, False)):
                value = self.plain(tuple(face))
                if not free:
                    points.append(value)
                ends = ends_of(value)
                if ends is not None and is_low:
                    lower = max(lower, ends[0])
                elif ends is not None:
                    upper = min(upper, ends[1])
        if free and all(slopes[i] is not None for i in free):
            value_there = None
            for face, is_low in ((low, True), (high, False)):
                mean, value = self._mean_value(tuple(face), slopes, free, value_there)
                value_there = value if len(free) == len(box) else None
                points.append(value)
                if len(free) == 1:
                    mean = self._curved(tuple(face), box, free[0], value, mean)
                ends = ends_of(mean)
                if ends is not None and is_low:
                    lower = max(lower, ends[0])
                elif ends is not None:
                    upper = min(upper, ends[1])
        elif free:
            points.append(self.plain(tuple(side.centre() for side in box)))
        return (lower, upper), points

    def _mean_value(
        self, box: Sides, slopes: list[Ball | None], free: list[int], value: Ball | None
    ) -> tuple[Ball, Ball]:
        """Return f(m) + sum_i f_i (X_i - m_i) and f(m), the sides that are not free being points.

        ``value`` is f(m) if it is known already.
        """
        middle = tuple(side.centre() for side in box)
        if value is None:
            value = self.plain(middle)
        total = value
        for index in free:
            total = total + slopes[index] * (box[index].ball - middle[index].ball)
        return total, value

    def _curved(self, face: Sides, box: Sides, index: int, value: Ball, mean: Ball) -> Ball:
        """Return the common part of ``mean`` and f(m) + f_i(m) d + f_ii(box) d^2/2, |d| <= r.

        The face has one free side, of radius r and middle m; ``value`` is f(m).  Unlike the
        mean-value form it uses the curvature, which limits the rise of f while f_i falls.
        """
        if self.is_held or any(self.poles()) or self.length > SHORT:
            return mean
        first = self.gradient()[index]
        second = None if first is None else first.gradient()[index]
        if first is None or second is None:
            return mean
        bend = second.plain(box)
        run = first.plain(tuple(side.centre() for side in face))
        if not (bend.is_finite() and run.is_finite() and value.is_finite()):
            return mean
        radius = abs(face[index].ball - face[index].centre().ball).upper()
        largest_slope = abs(run).upper()
        above = value + highest(largest_slope, bend.upper(), radius)
        below = value - highest(largest_slope, -bend.lower(), radius)
        return common(mean, below.lower().union(above.upper()))

    def plain(self, box: Sides) -> Ball:
        """Return one evaluation in balls, in Taylor form towards each removable pole."""
        enclosure = None
        for index, order in enumerate(self.poles()):
            side = box[index]
            if order and self._is_towards_pole(side):
                form = self._removed(index, order, side.has_zero())
                if form is None:
                    continue
                taylor = form.mean_towards_zero(box, index, order)
                if side.has_zero():
                    return taylor
                enclosure = taylor if enclosure is None else common(enclosure, taylor)
        direct = self.tape.run([side.ball for side in box], self.covered)[0]
        return direct if enclosure is None else common(enclosure, direct)

    def _is_towards_pole(self, side: BoxSide) -> bool:
        """Return whether the Taylor form is tried; tables are covered on the box only, not to 0."""
        return side.has_zero() or (not self.covered and (self.far or side.near_zero()))

    def mean_towards_zero(self, box: Sides, index: int, order: int) -> Ball:
        r"""Return k \int_0^1 (1 - s)^{k-1} f(s x) ds over the box, k = ``order``, x side ``index``.

        It lies in the range of f over the hull with x = 0, and in f(0) + x f'(hull) / (k + 1).
        """
        side = box[index]
        hull = _side(min(side.lower, fmpq(0)), max(side.upper, fmpq(0)))
        other_sides = box[:index], box[index + 1 :]
        wide = (*other_sides[0], hull, *other_sides[1])
        if all(part_side.is_point for part_side in wide):
            return self.plain(wide)
        value, slopes = self.with_slopes(wide)
        rough = ends_of(value)
        if rough is None:
            return value
        ends, _ = self._tightened(wide, rough, slopes)
        enclosure, slope = between(*ends), slopes[index]
        if slope is None:
            return enclosure
        start = self.plain((*other_sides[0], _side(fmpq(0)), *other_sides[1]))
        return common(enclosure, start + side.ball * slope / (order + 1))

    def with_slopes(self, box: Sides) -> tuple[Ball, list[Ball | None]]:
        """Return plain value and slopes; None for one that is not bounded."""
        towards_pole = (
            order and self._is_towards_pole(side)
            for order, side in zip(self.poles(), box, strict=True)
        )
        if any(towards_pole):
            slopes = [None if form is None else form.plain(box) for form in self.gradient()]
            return self.plain(box), [finite_or_none(slope) for slope in slopes]
        if self._joint is None:
            slopes_of = [slope_or_none(self.expression, s) for s in self.symbols]
            self._joint = tape_of(
                [self.expression, *slopes_of],
                self.symbols,
                optional=len(self.symbols),
                positive=self.positive,
            )
        value, *slopes = self._joint.run([side.ball for side in box], self.covered)
        return value, [finite_or_none(slope) for slope in slopes]

    def gradient(self) -> tuple[BallForm | None, ...]:
        if self._gradient is None:
            self._gradient = tuple(
                self._form(derivative(self.expression, symbol)) for symbol in self.symbols
            )
        return self._gradient

    def _form(self, expression: sp.Expr | None) -> BallForm | None:
        if expression is None:
            return None
        try:
            return BallForm(
                expression, self.symbols, self.covered, self.far, positive=self.positive
            )
        except ModelError:
            return None  # this derivative has no ball arithmetic, so its slope is unknown

    def poles(self) -> tuple[int, ...]:
        """Return, per symbol, the order of the factor 1/x^k that the expression is written with."""
        if self._poles is None:
            joined = with_exponentials_as_symbols(sp.together, self.expression)
            powers = sp.fraction(joined)[1].as_powers_dict()
            self._poles = tuple(order_of(powers.get(symbol, 0)) for symbol in self.symbols)
        return self._poles

    def _removed(self, index: int, order: int, needed: bool) -> BallForm | None:
        """Return the form of d^k N/dx^k / k! for N = f x^k, after proving N^(i)(0) = 0, i < k.

        The result is None if 0 is a true pole (ModelError if the form is ``needed``).  It is also
        None if a table in N has no k-th derivative, because f then has no known bound at 0.
        """
        if index not in self._taylor:
            x = self.symbols[index]
            numerator = with_exponentials_as_symbols(
                lambda product: sp.expand(sp.together(product).cancel()), self.expression * x**order
            )
            lower = [derivative(numerator, x, k) for k in range(order)]
            vanishes = all(n is None or is_zero(n.subs(x, 0)) for n in lower)
            known_zero = vanishes and None not in lower
            taylor = derivative(numerator, x, order) if known_zero else None
            if taylor is not None:
                taylor = taylor / sp.factorial(order)
            self._taylor[index] = self._form(taylor)
            self._has_pole[index] = not vanishes
        if self._has_pole[index] and needed:
            raise ModelError(
                f"{self.expression} has a pole at {self.symbols[index]} = 0, which the box "
                "contains; take 0 out of the box, or choose another premise"
            )
        return self._taylor[index]
