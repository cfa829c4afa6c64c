"""Intervals bracket the exact result; numbers in words round to the safe side."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates.checker import CertificateError
from takagi.certificates.checker.arithmetic.interval import (
    ONE,
    Interval,
    add,
    div,
    enclose,
    hull,
    magnitude,
    mul,
    neg,
    point,
    square,
    sub,
    within,
)
from takagi.certificates.checker.words.shown import at_least, at_most

RATIONALS = st.fractions(min_value=-1000, max_value=1000, max_denominator=10**30)
SHARES = st.fractions(min_value=0, max_value=1, max_denominator=1000)


@st.composite
def points(draw: st.DrawFn) -> tuple[Interval, Fraction]:
    """Return a bracket and a number inside it."""
    a, b = sorted((draw(RATIONALS), draw(RATIONALS)))
    return enclose(a, b), a + (b - a) * draw(SHARES)


def holds(bracket: Interval, value: Fraction) -> bool:
    return bracket[0] <= value * ONE <= bracket[1]


@given(points(), points())
def test_operations_bracket_the_exact_result(
    p: tuple[Interval, Fraction], q: tuple[Interval, Fraction]
) -> None:
    """Moore (1966): x in A and y in B imply x op y in A op B, here after outward rounding."""
    (a, x), (b, y) = p, q

    assert holds(a, x) and holds(point(x), x)
    assert holds(add(a, b), x + y)
    assert holds(sub(a, b), x - y)
    assert holds(mul(a, b), x * y)
    assert holds(neg(a), -x)
    assert holds(square(a), x * x)
    assert holds(hull(a, b), x) and holds(hull(a, b), y)
    assert magnitude(a) >= abs(x) * ONE
    if b[0] > 0 or b[1] < 0:
        assert holds(div(a, b), x / y)
    else:
        with pytest.raises(CertificateError, match="zero"):
            div(a, b)


@given(points(), SHARES)
def test_within_is_decided_exactly(p: tuple[Interval, Fraction], tiny: Fraction) -> None:
    """A bracket is within its own ends and not within anything smaller."""
    bracket, _ = p
    low, high = Fraction(bracket[0], ONE), Fraction(bracket[1], ONE)
    step = Fraction(1, 10**40)

    assert within(bracket, low - tiny, high + tiny)
    assert not within(bracket, low + step, high)
    assert not within(bracket, low, high - step)


@given(RATIONALS, st.integers(1, 12))
def test_shown_numbers_are_on_the_safe_side(value: Fraction, digits: int) -> None:
    """A lower bound is printed no higher, an upper bound no lower, and both are close."""
    low, high = Fraction(at_least(value, digits)), Fraction(at_most(value, digits))

    assert low <= value <= high
    assert high - low <= abs(value) * Fraction(11, 10**digits)
