"""Second-order Taylor arithmetic in one variable, with interval coefficients.

A jet (f, f', f'') of enclosures over a range of the variable; used to bound how far a table that
is linear between its nodes leaves the curve it interpolates.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from takagi.models.intervals.interval import Interval

ZERO = Interval(Fraction(0), Fraction(0))


@dataclass(frozen=True, slots=True)
class Jet:
    """Enclosures of a function, its first and its second derivative over one range.

    The rules are those of calculus: (fg)'' = f''g + 2f'g' + fg'', and for h = f/g,
    h' = (f' - h g')/g, h'' = (f'' - 2 h' g' - h g'')/g.
    """

    value: Interval
    slope: Interval
    curvature: Interval

    @classmethod
    def linear(cls, first: Fraction, last: Fraction, width: Fraction) -> Jet:
        """Return the jet of the line from ``first`` to ``last`` over a range of this width."""
        step = (last - first) / width
        values = Interval(min(first, last), max(first, last))
        return cls(values, Interval(step, step), ZERO)

    def __add__(self, other: Jet) -> Jet:
        return Jet(
            self.value + other.value, self.slope + other.slope, self.curvature + other.curvature
        )

    def __mul__(self, other: Jet) -> Jet:
        return Jet(
            self.value * other.value,
            self.slope * other.value + self.value * other.slope,
            self.curvature * other.value
            + self.slope * other.slope * 2
            + self.value * other.curvature,
        )

    def __truediv__(self, other: Jet) -> Jet:
        value = self.value / other.value
        slope = (self.slope - value * other.slope) / other.value
        bent = self.curvature - slope * other.slope * 2 - value * other.curvature
        return Jet(value, slope, bent / other.value)

    def scaled(self, factor: Fraction) -> Jet:
        """Return factor times the jet."""
        return Jet(self.value * factor, self.slope * factor, self.curvature * factor)

    def rounded(self, digits: int) -> Jet:
        """Return the jet with ends rounded outward to ``digits`` decimals."""
        return Jet(
            self.value.outward(digits), self.slope.outward(digits), self.curvature.outward(digits)
        )
