"""The checker's intervals are the smallest ones: rounded outward by less than a unit."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from fractions import Fraction
from math import ceil, floor

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates.checker import CertificateError
from takagi.certificates.checker.arithmetic.interval import (
    LARGEST,
    ONE,
    UNIT,
    Interval,
    enclose,
    hull,
    point,
    product,
)

ENDS = st.one_of(
    st.integers(-3, 3).map(lambda k: k * ONE),
    st.integers(-3, 3),
    st.integers(-(ONE << 10), ONE << 10),
)
BRACKETS = st.tuples(ENDS, ENDS).map(lambda ends: Interval(min(ends), max(ends)))


def smallest(values: list[Fraction]) -> Interval:
    """Return the smallest bracket of exact values."""
    return Interval(floor(min(values) * ONE), ceil(max(values) * ONE))


def ends(a: Interval) -> tuple[Fraction, Fraction]:
    return Fraction(a[0], ONE), Fraction(a[1], ONE)


@given(BRACKETS, BRACKETS)
def test_every_operation_gives_the_smallest_bracket(a: Interval, b: Interval) -> None:
    """Of the exact range, which is that of the ends (Moore 1966), here in rationals."""
    pairs = list(itertools.product(ends(a), ends(b)))

    assert a + b == smallest([ends(a)[0] + ends(b)[0], ends(a)[1] + ends(b)[1]])
    assert a - b == smallest([x - y for x, y in pairs])
    assert a * b == smallest([x * y for x, y in pairs])
    exact = [int(x * y * ONE**2) for x, y in pairs]
    assert product(a, b) == (min(exact), max(exact))
    assert -a == smallest([-x for x in ends(a)])
    around_zero = [Fraction(0)] if a[0] <= 0 <= a[1] else []
    assert a.square() == smallest([x * x for x in ends(a)] + around_zero)
    assert hull(a, b) == smallest([*ends(a), *ends(b)])
    assert a.magnitude() == max(abs(x) for x in ends(a)) * ONE
    if b[0] <= 0 <= b[1]:
        with pytest.raises(CertificateError, match="zero"):
            a / b
    else:
        assert a / b == smallest([x / y for x, y in pairs])


@given(st.fractions(max_denominator=10**40), st.fractions(max_denominator=10**40))
def test_numbers_get_the_smallest_bracket(x: Fraction, y: Fraction) -> None:
    low, high = min(x, y), max(x, y)

    assert enclose(low, high) == smallest([low, high])
    assert point(x) == smallest([x])


@pytest.mark.parametrize("b", [(0, 0), (0, ONE), (-ONE, 0), (-1, 1)])
def test_a_divisor_that_touches_zero_is_refused(b: tuple[int, int]) -> None:
    with pytest.raises(CertificateError, match="zero"):
        UNIT / Interval(*b)
    assert UNIT / Interval(1, 1) == (ONE * ONE, ONE * ONE)
    assert UNIT / Interval(-1, -1) == (-ONE * ONE, -ONE * ONE)


def test_within_takes_both_ends_exactly() -> None:
    """A third lies between two units: the bracket of it is not within it, but of a bit more."""
    third, unit = Fraction(1, 3), Fraction(1, ONE)
    bracket = point(third)

    assert not bracket.within(third, third)
    assert not bracket.within(third - unit, third)
    assert not bracket.within(third, third + unit)
    assert bracket.within(third - unit, third + unit)
    assert Interval(ONE, 2 * ONE).within(Fraction(1), Fraction(2))
    assert not Interval(ONE - 1, 2 * ONE).within(Fraction(1), Fraction(2))
    assert not Interval(ONE, 2 * ONE + 1).within(Fraction(1), Fraction(2))


def test_numbers_beyond_the_largest_are_refused() -> None:
    """At 10^320 they are held, a unit beyond it not, at either end and by each operation."""
    assert Interval(-LARGEST, LARGEST).held() == (-LARGEST, LARGEST)
    for wrong in ((-LARGEST - 1, 0), (0, LARGEST + 1)):
        with pytest.raises(CertificateError, match="beyond"):
            Interval(*wrong).held()
    assert Interval(LARGEST, LARGEST) * UNIT == (LARGEST, LARGEST)
    beyond: list[Callable[[], Interval]] = [
        lambda: Interval(0, LARGEST) * Interval(ONE, ONE + 1),
        lambda: Interval(0, 10**200 * ONE).square(),
        lambda: Interval(LARGEST, LARGEST) / Interval(ONE - 1, ONE),
    ]
    for operation in beyond:
        with pytest.raises(CertificateError, match="beyond"):
            operation()
