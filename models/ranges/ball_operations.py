"""Boxes as the ball arithmetic needs them: sides with rational ends, and operations on balls."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

from flint import arb, fmpq

from takagi.models.intervals.box_search import Ends
from takagi.models.intervals.interval import Interval

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

    def with_zero(self) -> BoxSide:
        """Return the smallest side that contains this one and 0."""
        return _side(min(self.lower, fmpq(0)), max(self.upper, fmpq(0)))

    def zero(self) -> BoxSide:
        """Return the point 0."""
        return _side(fmpq(0))

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
