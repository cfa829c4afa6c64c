"""Intervals with exact ends: closed intervals of rational numbers with exact arithmetic."""

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
