"""Tables as functions in expressions, and the curve of one argument."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from takagi.models import Curve, Interval, ModelError, Surface, interpolate_curve, table_function
from takagi.models.splines.spline import interpolate
from takagi.models.splines.table_function import TableFunction

X, Y = sp.symbols("x y", real=True)
POINTS = np.array([-2.0, -1.0, 0.5, 1.0, 2.0, 3.5])


def wavy() -> Curve:
    return interpolate_curve(POINTS, np.sin(POINTS), name="wavy")


def cubic_product() -> Surface:
    """x^3 y^2, which a bicubic spline reproduces."""
    axis = np.arange(5.0)
    return interpolate(axis, axis, np.outer(axis**3, axis**2))


def test_the_curve_is_scipys_not_a_knot_spline() -> None:
    other = CubicSpline(POINTS, np.sin(POINTS), bc_type="not-a-knot")
    x = np.linspace(-2, 3.5, 101)

    for order in (0, 1, 2):
        assert np.allclose(wavy()(x, order), other(x, order), atol=1e-12)


@given(st.fractions(-2, Fraction(7, 2), max_denominator=1000), st.integers(0, 2))
def test_exact_values_agree_with_floats(x: Fraction, order: int) -> None:
    assert float(wavy().exact(x, order)) == pytest.approx(float(wavy()(float(x), order)), abs=1e-12)


@pytest.mark.slow
@given(
    st.fractions(-2, Fraction(7, 2), max_denominator=100),
    st.fractions(-2, Fraction(7, 2), max_denominator=100),
    st.fractions(0, 1, max_denominator=100),
    st.integers(0, 2),
)
def test_bounds_contain_every_value(a: Fraction, b: Fraction, s: Fraction, order: int) -> None:
    side = Interval(min(a, b), max(a, b))
    inside = a + s * (b - a)

    hull = wavy().bounds(side, order)

    assert hull.contains(wavy().exact(inside, order))


@pytest.mark.parametrize(
    ("x", "values", "words"),
    [
        ([0, 1, 2], [0, 1, 2], "at least 4"),
        ([0, 1, 1, 2], [0, 1, 2, 3], "increasing"),
        ([0, 1, 2, 3], [0, 1, np.nan, 3], "finite"),
        ([0, 1, 2, 3], [0, 1, 2], "one each"),
    ],
)
def test_a_curve_refuses_tables_it_cannot_interpolate(
    x: list[float], values: list[float], words: str
) -> None:
    with pytest.raises(ModelError, match=words):
        interpolate_curve(x, values)


@pytest.mark.parametrize("outside", [-2.1, 3.6, np.nan])
def test_a_curve_refuses_points_outside(outside: float) -> None:
    with pytest.raises(ModelError, match="outside the table"):
        wavy()(outside)
    with pytest.raises(ModelError, match="leaves the table"):
        wavy().bounds(Interval.of(-3, 0))


def test_derivatives_of_expressions_are_those_of_the_spline() -> None:
    f = table_function("f", wavy())
    expression = X * f(2 * X)

    slope = expression.diff(X).subs(X, sp.Rational(1, 3))

    value, first = wavy().exact(Fraction(2, 3)), wavy().exact(Fraction(2, 3), 1)
    assert slope == sp.Rational(*(value + Fraction(2, 3) * first).as_integer_ratio())


def test_mixed_derivatives_of_two_arguments_keep_their_order() -> None:
    """d^3 (x^3 y^2) / dx^2 dy = 12 x y."""
    g = table_function("g", cubic_product())

    found = g(X, Y).diff(X, 2).diff(Y)

    assert isinstance(found, TableFunction)
    assert found.orders == (2, 1)
    assert float(found.subs({X: 2, Y: 3})) == pytest.approx(72)


def test_each_argument_has_its_own_derivative() -> None:
    """d (x^3 y^2) / dx = 3 x^2 y^2 and / dy = 2 x^3 y, at (2, 3)."""
    g = table_function("g", cubic_product())
    point = {X: 2, Y: 3}

    assert float(g(X, Y).diff(X).subs(point)) == pytest.approx(108)
    assert float(g(X, Y).diff(Y).subs(point)) == pytest.approx(48)
    assert float(g(Y, X).diff(X).subs(point)) == pytest.approx(108)
    assert float(sp.lambdify((X, Y), g(X, Y).diff(Y))(2.0, 3.0)) == pytest.approx(48)


def test_a_third_derivative_is_refused() -> None:
    with pytest.raises(ModelError, match="third derivative"):
        table_function("f", wavy())(X).diff(X, 3)


def test_functions_of_equal_tables_are_equal_and_others_are_not() -> None:
    first, again = table_function("f", wavy()), table_function("f", wavy())
    other = interpolate_curve(POINTS, np.cos(POINTS))

    assert first(X) - again(X) == 0
    assert first(X) != table_function("f", other)(X)
    assert first(X) != table_function("f", wavy(), unit="N")(X)


def test_numbers_inside_the_table_are_exact_and_outside_stay_symbolic() -> None:
    f = table_function("f", wavy())

    assert f(sp.Rational(1, 3)) == sp.Rational(*wavy().exact(Fraction(1, 3)).as_integer_ratio())
    assert isinstance(f(7), TableFunction)
    assert float(f(sp.pi / 3).evalf()) == pytest.approx(float(wavy()(np.pi / 3)))


def test_lambdify_evaluates_with_numpy() -> None:
    f = table_function("f", wavy())
    x = np.array([0.1, 0.4])

    found = sp.lambdify(X, f(X) + f(X).diff(X))(x)

    assert np.allclose(found, wavy()(x) + wavy()(x, 1))


def test_units_must_be_as_many_as_arguments() -> None:
    with pytest.raises(ModelError, match="2 argument units for 1"):
        table_function("f", wavy(), argument_units=("-", "-"))


def test_latex_shows_orders_of_differentiation() -> None:
    f = table_function("f", wavy())

    assert sp.latex(f(X)) == r"f\left(x\right)"
    assert sp.latex(f(X).diff(X)) == r"f^{(1)}\left(x\right)"
    assert sp.latex(f(X) ** 2) == r"f^{2}\left(x\right)"
