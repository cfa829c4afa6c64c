"""Rational intervals: exact arithmetic, and outward rounding that never loses a point."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import ModelError
from takagi.models.intervals.interval import Interval, exact
from takagi.models.ranges.expression_range import expression_value
from takagi.models.ranges.float_value import ACCURACY, float_value

RATIONALS = st.fractions(min_value=-50, max_value=50, max_denominator=1000)


@st.composite
def intervals(draw: st.DrawFn) -> Interval:
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


X, Y = sp.symbols("x y", real=True)
EXPRESSIONS = [
    sp.sin(X) / X,
    (1 - sp.cos(X)) / X**2,
    (sp.exp(X) - 1 - X) / X**2,
    Y * sp.sin(2 * X) / 3,
    1 / (sp.Rational(2, 3) - sp.cos(X) ** 2 / 10),
    (X**2 - Y**2) / (X - Y),
    sp.sqrt(1 + X**2) * sp.exp(-Y) - sp.log(3 + X) * sp.tanh(Y),
    sp.Abs(X) / X + sp.atan(Y) ** 3,
    (1 + X**2) ** sp.Rational(-3, 2) + sp.pi * sp.asin(X / 2) / sp.cosh(Y),
]


@pytest.mark.parametrize("expression", EXPRESSIONS, ids=str)
def test_a_value_in_floats_has_twelve_digits(expression: sp.Expr) -> None:
    """Against ball arithmetic, near and far from points where the expression is 0/0."""
    symbols = sorted(expression.free_symbols, key=str)
    evaluate = float_value(expression, symbols)
    assert evaluate is not None
    chance, answered = np.random.default_rng(3), 0
    for _ in range(200):
        point = (chance.uniform(-1, 1, len(symbols)) * 10.0 ** chance.uniform(-9, 0)).tolist()
        value = evaluate(point)
        if value is not None:
            answered += 1
            exact = expression_value(expression, dict(zip(symbols, point, strict=True)))
            assert abs(value - exact) <= ACCURACY * abs(exact)
    assert answered


def test_digits_that_cancel_give_no_value() -> None:
    """(1 - cos x)/x^2 at 1e-8 is 0 in floats, and 1/2 in truth; at 0 there is no value either."""
    evaluate = float_value((1 - sp.cos(X)) / X**2, [X])
    assert evaluate is not None

    assert evaluate([1e-8]) is None and evaluate([0.0]) is None
    assert evaluate([1.0]) == pytest.approx(1 - float(sp.cos(1)), rel=1e-12)


def test_functions_that_are_not_known_have_none() -> None:
    assert float_value(sp.Function("f")(X), [X]) is None
    assert float_value(X**Y, [X, Y]) is None


def test_what_leaves_the_reals_has_no_value() -> None:
    for expression, at in ((sp.log(X), -1.0), (1 / X, 0.0), (sp.exp(X), 1e4), (sp.sqrt(X), -2.0)):
        evaluate = float_value(expression, [X])
        assert evaluate is not None and evaluate([at]) is None


def test_numbers_that_are_no_floats_count_with_their_error() -> None:
    """1/3 is no float: x - 1/3 at the float nearest to it is all rounding."""
    evaluate = float_value(X - sp.Rational(1, 3), [X])
    assert evaluate is not None

    assert evaluate([1 / 3]) is None
    assert evaluate([1.0]) == pytest.approx(float(Fraction(2, 3)))
