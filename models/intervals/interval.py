"""Intervals with exact ends, and floating-point ranges with slopes.

Closed intervals of rational numbers with exact arithmetic.

Ranges with slopes: forward differentiation on intervals, in floating point.

A ``Dual`` holds the range of a quantity over a box and, for each of a few directions, the range of
its derivative along that direction.  Sums, products and chains follow the rules of calculus, so a
formula written once gives its own enclosure and that of its Jacobian.  Functions with corners give
the hull of their one-sided slopes, which is what the mean value theorem asks of Lipschitz maps.

Rounding is not tracked (about 1e-13): what is emitted is widened by far more, and the exact
checker computes every range again in its own arithmetic.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING

from takagi.models.errors import ModelError

if TYPE_CHECKING:
    import sympy as sp


Number = Fraction | int | float | str
"""What a bound may be given as; a float stands for its shortest decimal (see ``exact``)."""


def exact(value: Number) -> Fraction:
    """Return the rational that a number is written as; a float means its shortest decimal.

    ``exact(0.1)`` is 1/10: tables and gains are emitted as decimals, and the decimal is what a
    claim is about, not the nearest binary number.

    Raises
    ------
    ModelError : the value is not a finite number.
    """
    # The type itself first: asking an abstract class for its instances takes longer than the rest.
    if type(value) is Fraction or isinstance(value, Fraction):
        return value
    try:
        if isinstance(value, int):
            return Fraction(value)
        # float() first: a NumPy float prints as "np.float64(...)".
        return Fraction(Decimal(value if isinstance(value, str) else repr(float(value))))
    except (ArithmeticError, TypeError, ValueError) as error:
        raise ModelError(f"{value!r} was given; a finite number is needed") from error


def rational(value: Number) -> sp.Rational:
    """Return the number as sympy's rational, floats by their shortest decimal."""
    import sympy as sp

    return sp.Rational(*exact(value).as_integer_ratio())


@dataclass(frozen=True, slots=True)
class Interval:
    """The set {x : lower <= x <= upper} of reals, with rational ends.

    ``+ - * /`` with an interval, a ``Fraction`` or an ``int`` return the exact range of the
    operation when the operands vary independently (an outer range when they do not).

    Raises
    ------
    ModelError : lower > upper, or an end that is not a ``Fraction`` or ``int``.
    """

    lower: Fraction
    upper: Fraction

    @classmethod
    def of(cls, lower: Number, upper: Number | None = None) -> Interval:
        """Return [lower, upper], or the point [lower, lower]; floats by their shortest decimal."""
        first = exact(lower)
        return cls(first, first if upper is None else exact(upper))

    def __post_init__(self) -> None:
        a, b = self.lower, self.upper
        if type(a) is not Fraction or type(b) is not Fraction:
            self._read_ends()
            a, b = self.lower, self.upper
        # Integers are multiplied crosswise, because comparing two Fractions costs more.
        if a.numerator * b.denominator > b.numerator * a.denominator:
            raise ModelError(
                f"lower end {float(self.lower):.9g} exceeds upper end {float(self.upper):.9g}; "
                "give the smaller one first"
            )

    def _read_ends(self) -> None:
        """Take whole numbers as fractions; refuse all else."""
        for name in ("lower", "upper"):
            value = getattr(self, name)
            if not isinstance(value, (Fraction, int)):
                raise ModelError(
                    f"{name} end {value!r} is a {type(value).__name__}; an Interval has rational "
                    "ends: build it with Interval.of(lower, upper), which reads decimals"
                )
            if not isinstance(value, Fraction):
                object.__setattr__(self, name, Fraction(value))

    @property
    def width(self) -> Fraction:
        """upper - lower."""
        return self.upper - self.lower

    @property
    def centre(self) -> Fraction:
        """(lower + upper) / 2."""
        return (self.lower + self.upper) / 2

    @property
    def magnitude(self) -> Fraction:
        """max |x| over the interval."""
        return max(-self.lower, self.upper)

    def __add__(self, other: Interval | Fraction | int) -> Interval:
        o = _as_interval(other)
        return Interval(self.lower + o.lower, self.upper + o.upper)

    __radd__ = __add__

    def __neg__(self) -> Interval:
        return Interval(-self.upper, -self.lower)

    def __sub__(self, other: Interval | Fraction | int) -> Interval:
        o = _as_interval(other)
        return Interval(self.lower - o.upper, self.upper - o.lower)

    def __rsub__(self, other: Fraction | int) -> Interval:
        return _as_interval(other) - self

    def __mul__(self, other: Interval | Fraction | int) -> Interval:
        o = _as_interval(other)
        (a, b), (c, d) = (self.lower, self.upper), (o.lower, o.upper)
        # Where an operand has one sign, two of the four products are the ends.
        if a.numerator >= 0:
            return Interval((b if c.numerator < 0 else a) * c, (a if d.numerator < 0 else b) * d)
        if b.numerator <= 0:
            return Interval((b if d.numerator < 0 else a) * d, (a if c.numerator < 0 else b) * c)
        if c.numerator >= 0:
            return Interval(a * d, b * d)
        if d.numerator <= 0:
            return Interval(b * c, a * c)
        return Interval(min(a * d, b * c), max(a * c, b * d))

    __rmul__ = __mul__

    def __truediv__(self, other: Interval | Fraction | int) -> Interval:
        o = _as_interval(other)
        if o.lower <= 0 <= o.upper:
            raise ModelError(f"division by {o}, which contains 0; split it or bound it away from 0")
        return self * Interval(1 / o.upper, 1 / o.lower)

    def __rtruediv__(self, other: Fraction | int) -> Interval:
        return _as_interval(other) / self

    def __pow__(self, exponent: int) -> Interval:
        """Return the exact range of x**exponent, exponent >= 0; tighter than repeated products."""
        if exponent < 0:
            raise ModelError(f"exponent {exponent} was given; at least 0 is needed (use 1 / x)")
        ends = sorted((self.lower**exponent, self.upper**exponent))
        # An even power has its minimum at 0 if the interval contains 0, and not at an end.
        if exponent and exponent % 2 == 0 and self.lower < 0 < self.upper:
            return Interval(Fraction(0), ends[1])
        return Interval(ends[0], ends[1])

    def __abs__(self) -> Interval:
        if self.lower >= 0:
            return self
        if self.upper <= 0:
            return -self
        return Interval(Fraction(0), self.magnitude)

    def hull(self, other: Interval | Fraction | int) -> Interval:
        """Return the smallest interval that contains both."""
        o = _as_interval(other)
        return Interval(min(self.lower, o.lower), max(self.upper, o.upper))

    def intersect(self, other: Interval) -> Interval:
        """Return the common part; raises ModelError when none exists."""
        if other.upper < self.lower or self.upper < other.lower:
            raise ModelError(f"{self} and {other} have no point in common")
        return Interval(max(self.lower, other.lower), min(self.upper, other.upper))

    def contains(self, other: Interval | Number) -> bool:
        """Return whether the number (floats by their shortest decimal) or interval lies inside."""
        o = other if isinstance(other, Interval) else Interval.of(other)
        return self.lower <= o.lower and o.upper <= self.upper

    def outward(self, digits: int) -> Interval:
        """Return the smallest interval around this one whose ends have ``digits`` decimals."""
        scale = 10**digits
        return Interval(
            Fraction(math.floor(self.lower * scale), scale),
            Fraction(math.ceil(self.upper * scale), scale),
        )

    def outward_floats(self) -> tuple[float, float]:
        """Return floats (l, u) whose binary values satisfy l <= lower and upper <= u."""
        # float() rounds to nearest, possibly inward; then the next float outside is taken.
        lower, upper = float(self.lower), float(self.upper)
        if Fraction(lower) > self.lower:
            lower = math.nextafter(lower, -math.inf)
        if Fraction(upper) < self.upper:
            upper = math.nextafter(upper, math.inf)
        return lower, upper

    def __str__(self) -> str:
        return f"[{float(self.lower):.9g}, {float(self.upper):.9g}]"


def _as_interval(value: Interval | Fraction | int) -> Interval:
    if isinstance(value, Interval):
        return value
    if isinstance(value, float):
        raise ModelError(f"float {value!r} in interval arithmetic; write exact({value!r})")
    return Interval(Fraction(value), Fraction(value))


Range = tuple[float, float]
NOTHING: Range = (0.0, 0.0)


def times(a: Range, b: Range) -> Range:
    """Return the range of a product."""
    if a == NOTHING or b == NOTHING:
        return NOTHING
    corners = (a[0] * b[0], a[0] * b[1], a[1] * b[0], a[1] * b[1])
    return min(corners), max(corners)


def span(*values: float) -> Range:
    """Return the smallest range of all the values."""
    return min(values), max(values)


def hull(*ranges: Range) -> Range:
    """Return the smallest range of all the parts."""
    return min(p[0] for p in ranges), max(p[1] for p in ranges)


@dataclass(frozen=True, slots=True)
class Dual:
    """Range of a quantity, and of its derivative along each direction."""

    value: Range
    slopes: tuple[Range, ...]

    def __add__(self, other: Dual) -> Dual:
        value = (self.value[0] + other.value[0], self.value[1] + other.value[1])
        pairs = zip(self.slopes, other.slopes, strict=True)
        return Dual(value, tuple((a[0] + b[0], a[1] + b[1]) for a, b in pairs))

    def __neg__(self) -> Dual:
        flipped = tuple((-b, -a) for a, b in self.slopes)
        return Dual((-self.value[1], -self.value[0]), flipped)

    def __sub__(self, other: Dual) -> Dual:
        return self + -other

    def __mul__(self, other: Dual) -> Dual:
        slopes = []
        for mine, theirs in zip(self.slopes, other.slopes, strict=True):
            a, b = times(mine, other.value), times(self.value, theirs)
            slopes.append((a[0] + b[0], a[1] + b[1]))
        return Dual(times(self.value, other.value), tuple(slopes))

    def scaled(self, factor: float) -> Dual:
        """Return factor times the quantity."""
        at = (factor, factor)
        return Dual(times(at, self.value), tuple(times(at, s) for s in self.slopes))

    def plus(self, offset: float) -> Dual:
        """Return the quantity plus a number."""
        return Dual((self.value[0] + offset, self.value[1] + offset), self.slopes)

    def through(self, value: Range, slope: Range) -> Dual:
        """Return f of the quantity, from the ranges of f and f' over ``value``."""
        return Dual(value, tuple(times(slope, s) for s in self.slopes))

    def inverse(self) -> Dual:
        """Return 1 over a quantity that keeps its sign.

        Raises
        ------
        ZeroDivisionError : the range holds 0.
        """
        low, high = self.value
        if low <= 0.0 <= high:
            raise ZeroDivisionError("a range that holds 0")
        value = (1.0 / high, 1.0 / low)
        size = times(value, value)
        return self.through(value, (-size[1], -size[0]))

    def held(self, low: float, high: float) -> Dual:
        """Return the quantity held to [low, high]; slope hull where it may touch an end."""
        a, b = self.value
        value = (min(max(a, low), high), min(max(b, low), high))
        if b <= low or a >= high:
            return self.through(value, NOTHING)
        return self.through(value, (1.0, 1.0) if low <= a and b <= high else (0.0, 1.0))


def constant(value: float, like: Dual) -> Dual:
    """Return a number as a quantity with the directions of another."""
    return Dual((value, value), (NOTHING,) * len(like.slopes))


def larger(a: Dual, b: Dual) -> Dual:
    """Return max(a, b)."""
    if a.value[0] >= b.value[1]:
        return a
    if b.value[0] >= a.value[1]:
        return b
    value = (max(a.value[0], b.value[0]), max(a.value[1], b.value[1]))
    return Dual(value, tuple(hull(s, t) for s, t in zip(a.slopes, b.slopes, strict=True)))


def smaller(a: Dual, b: Dual) -> Dual:
    """Return min(a, b)."""
    return -larger(-a, -b)
