"""Rational intervals: exact arithmetic, and outward rounding that never loses a point."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import ModelError
from takagi.models.intervals.interval import Interval, exact

RATIONALS = st.fractions(min_value=-50, max_value=50, max_denominator=1000)


@st.composite
def intervals(draw: st.DrawFn) -> Interval:
    """Return an interval with rational ends."""
    ends = sorted((draw(RATIONALS), draw(RATIONALS)))
    return Interval(ends[0], ends[1])


@given(intervals(), intervals(), st.fractions(0, 1), st.fractions(0, 1))
def test_operations_contain_every_pair(a: Interval, b: Interval, s: Fraction, t: Fraction) -> None:
    """Moore (1966): x in A and y in B imply x op y in A op B."""
    x = a.lower + s * a.width
    y = b.lower + t * b.width

    assert (a + b).contains(x + y)
    assert (a - b).contains(x - y)
    assert (a * b).contains(x * y)
    assert abs(a).contains(abs(x))
    assert (a**2).contains(x**2)
    assert (a**3).contains(x**3)
    if not b.contains(0):
        assert (a / b).contains(x / y)


@given(intervals(), intervals())
def test_operations_are_attained(a: Interval, b: Interval) -> None:
    """The ends of A op B are values at ends: the range is exact, not only outer."""
    ends = [(x, y) for x in (a.lower, a.upper) for y in (b.lower, b.upper)]

    assert (a + b).upper == max(x + y for x, y in ends)
    assert (a - b).lower == min(x - y for x, y in ends)
    assert (a * b).lower == min(x * y for x, y in ends)
    assert a.hull(b).lower == min(a.lower, b.lower)


@given(intervals(), st.integers(0, 9))
def test_outward_rounding_contains_and_is_short(a: Interval, digits: int) -> None:
    rounded = a.outward(digits)

    assert rounded.contains(a)
    assert (rounded.lower * 10**digits).denominator == 1
    assert a.lower - rounded.lower < Fraction(1, 10**digits)
    assert rounded.upper - a.upper < Fraction(1, 10**digits)


@given(intervals())
def test_outward_floats_contain(a: Interval) -> None:
    low, high = a.outward_floats()

    assert Fraction(low) <= a.lower and a.upper <= Fraction(high)


def test_a_float_means_its_decimal() -> None:
    """0.1 stands for 1/10, which its binary value is not."""
    assert exact(0.1) == Fraction(1, 10)
    assert Fraction(0.1) != Fraction(1, 10)
    assert Interval.of(0.1, "0.2").width == Fraction(1, 10)


def test_square_of_a_sign_change_starts_at_zero() -> None:
    """[-1, 2]^2 = [0, 4], although [-1, 2] * [-1, 2] = [-2, 4]."""
    a = Interval.of(-1, 2)

    assert a**2 == Interval.of(0, 4)
    assert a * a == Interval.of(-2, 4)
    assert a**0 == Interval.of(1)


def test_reversed_operands_are_not_swapped() -> None:
    """1 - [2, 3] and 6 / [2, 3] keep their order."""
    a = Interval.of(2, 3)

    assert 1 - a == Interval.of(-2, -1)
    assert 6 / a == Interval.of(2, 3)
    assert a.centre == Fraction(5, 2)


def test_misuse_is_refused() -> None:
    """Reversed ends, floats as ends, division through 0, empty intersections, NaN."""
    with pytest.raises(ModelError, match="exceeds upper end"):
        Interval.of(2, 1)
    with pytest.raises(ModelError, match="Interval.of"):
        Interval(0.5, Fraction(1))  # type: ignore[arg-type]
    with pytest.raises(ModelError, match="contains 0"):
        Interval.of(1) / Interval.of(-1, 1)
    with pytest.raises(ModelError, match="no point in common"):
        Interval.of(0, 1).intersect(Interval.of(2, 3))
    with pytest.raises(ModelError, match="finite number"):
        exact(float("nan"))
    with pytest.raises(ModelError, match="write exact"):
        Interval.of(1) * 0.1  # type: ignore[operator]
