"""One side of a box as the ball arithmetic needs it: rational ends, and balls around them."""

from __future__ import annotations

from typing import Any, NamedTuple, TypeAlias

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
        from fractions import Fraction

        return Interval(*(Fraction(int(e.p), int(e.q)) for e in (self.lower, self.upper)))

    def centre(self) -> BoxSide:
        """Return the point in the middle."""
        return self if self.is_point else _side((self.lower + self.upper) / 2)

    def ends(self) -> tuple[BoxSide, BoxSide]:
        """Return both ends as points."""
        return _side(self.lower), _side(self.upper)

    def with_zero(self) -> BoxSide:
        """Return the smallest side that contains this one and 0."""
        from flint import fmpq

        return _side(min(self.lower, fmpq(0)), max(self.upper, fmpq(0)))

    def zero(self) -> BoxSide:
        """Return the point 0."""
        from flint import fmpq

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
    from flint import fmpq

    ends = (fmpq(e.numerator, e.denominator) for e in (interval.lower, interval.upper))
    return _side(*ends)


def halves_of(side: BoxSide) -> tuple[BoxSide, BoxSide]:
    """Return the lower and the upper half."""
    middle = (side.lower + side.upper) / 2
    return _side(side.lower, middle), _side(middle, side.upper)


def _side(lower: Any, upper: Any = None) -> BoxSide:
    from flint import arb

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
    from flint import arb

    ball = arb(0).union(high)
    return ball - ball.lower()
