"""An expression in floats: twelve digits, or no answer."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import sympy as sp

from takagi.models.ranges.expression_range import expression_value
from takagi.models.ranges.float_value import ACCURACY, float_value

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
