"""Bounds as text: never on the wrong side of the decimal that they stand for."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.reports.page import text
from takagi.reports.page.rounded_bounds import at_least, at_most, at_most_to

DECIMALS = st.decimals("-1000", "1000", places=7, allow_nan=False).map(float)


@given(DECIMALS, st.integers(1, 6))
def test_the_text_stays_on_the_safe_side(value: float, digits: int) -> None:
    exact = Fraction(repr(value))

    assert Fraction(at_least(value, digits)) <= exact <= Fraction(at_most(value, digits))
    assert 0 <= Fraction(at_most_to(value, digits)) - exact < Fraction(1, 10**digits)


@given(st.floats(1e-3, 1e3), st.integers(1, 4))
def test_the_page_rounds_by_the_same(value: float, digits: int) -> None:
    """Also where a number of floats lies a hair above a decimal."""
    exact = Fraction(repr(value))

    assert Fraction(text.at_least(value, digits)) <= exact
    assert exact <= Fraction(text.at_most(value, digits))


@pytest.mark.parametrize(
    ("shown", "wanted"),
    [
        (at_least(0.145, 3), "0.145"),  # The float is less; what is meant is the decimal.
        (at_least(0.08865, 3), "0.0886"),
        (at_most(0.0399999 * 9.5493, 3), "0.382"),
        (at_most_to(3.15777, 2), "3.16"),
        (at_most_to(3.1600000001, 2), "3.17"),
        (at_most_to(2, 2), "2.00"),
        (at_most_to(-0.2532, 2), "-0.25"),
        (text.at_most(3.1600000001, 2), "3.17"),
        (text.at_least(0.3, 3), "0.300"),
        (text.with_decimals(-0.0001, 2), "0.00"),
        (text.with_decimals(float("inf"), 1), "∞"),
        (text.significant(-2.2154e-6, 3), "−2.22·10⁻⁶"),
        (text.significant(43093.55, 3), "43094"),
        (text.powers("m/s^2 and kg^-1"), "m/s² and kg⁻¹"),
    ],
)
def test_known_numbers(shown: str, wanted: str) -> None:
    assert shown == wanted
