"""Singularities removable along a sum: sin(s)/s with s = x + 2 y, as range, value and premise."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import Domain, Interval, ModelError, Plant, Variable, sector_model
from takagi.models.ranges.expression_range import expression_range, expression_value
from takagi.models.ranges.symbolic_steps import combined

X, Y, W, U = sp.symbols("x y w u", real=True)
TURN = sp.Symbol("turn", real=True)
BOX = {X: Interval.of(-1, "0.5"), Y: Interval.of("-0.4", "0.8")}  # x + 2 y in [-1.8, 2.1]


def sinc(s: sp.Expr) -> sp.Expr:
    return sp.sin(s) / s


@pytest.mark.parametrize("scale", [sp.S.One, sp.Rational(-3, 7)])
def test_the_range_along_a_sum_is_that_of_one_variable(scale: sp.Rational) -> None:
    """min sin(s)/s at s = 2.1, max 1 at s = 0; also where the sum is written with a factor."""
    s = sp.expand(scale * (X + 2 * Y))
    found = expression_range(sinc(s), BOX)
    end = 2.1 * abs(float(scale))

    assert float(found.outer.lower) == pytest.approx(math.sin(end) / end, rel=1e-6)
    assert 1 <= float(found.outer.upper) <= 1 + 1e-6


def test_a_sum_whose_variables_stand_elsewhere_stays_as_it_is() -> None:
    """x sin(s)/s depends on x by itself: no variable is put in place of the sum."""
    expression = X * sinc(X + 2 * Y)
    written, sides, meanings = combined(expression, BOX)

    assert written == expression and sides == BOX and not meanings
    with pytest.raises(ModelError, match="no finite bound near"):
        expression_range(expression, BOX, most_boxes=200)


@pytest.mark.parametrize("text", ["(exp(x/(1 + x)) - 1)/x", "(exp(1 - 1/(1 + x)) - 1)/x"])
def test_a_variable_that_divides_by_itself_keeps_its_singularity(text: str) -> None:
    """Arrhenius' law about its reference divides by the sum 1 + x and by x, with the limit 1."""
    symbol = sp.Symbol("x", real=True)
    expression = sp.sympify(text, {"x": symbol})
    found = expression_range(expression, {symbol: Interval.of("-0.5", "0.5")})
    at = [expression_value(expression, {symbol: x}) for x in np.linspace(-0.5, 0.5, 101)]

    assert expression_value(expression, {symbol: 0.0}) == pytest.approx(1.0)
    assert float(found.outer.lower) <= min(at) and max(at) <= float(found.outer.upper)
    assert float(found.outer.width) <= 1.001 * (max(at) - min(at))


def test_a_difference_and_its_negative_are_one_premise() -> None:
    rate = sp.exp(Y / (1 + Y)) * (1 + X) - 1
    states = tuple(Variable(s, range=Interval.of("-0.2", "0.2")) for s in (X, Y))
    model = sector_model(
        Plant(equations=(-rate, 3 * rate - Y + U), states=states, inputs=(Variable(U),))
    )

    assert len(model.rules) == 4
    assert len({str(premise.proof.expression) for premise in model.premises if premise.proof}) == 2


def test_a_pole_along_a_sum_is_named_by_the_sum() -> None:
    """cos(s)/s has a pole at s = 0; the words speak of x + 2 y, not of a variable put for it."""
    s = X + 2 * Y
    with pytest.raises(ModelError, match=r"has a pole at \(x \+ 2\*y\) = 0"):
        expression_range(sp.cos(s) / s, BOX)
    with pytest.raises(ModelError, match=r"no finite bound near x \+ 2\*y \+ 1 in"):
        expression_range(sp.log(s + 1) / sp.sqrt(s + 1), BOX, most_boxes=200)


@pytest.mark.slow
@given(
    st.fractions(-3, 3, max_denominator=7),
    st.fractions(-3, 3, max_denominator=7),
    st.fractions(-1, 1, max_denominator=9),
)
def test_ranges_along_random_sums_contain_samples(a: Fraction, b: Fraction, c: Fraction) -> None:
    """(1 - cos s)/s^2, s = a x + b y + c, with coefficients of any sign, 0 included."""
    s = sp.Rational(a) * X + sp.Rational(b) * Y + sp.Rational(c)
    if not s.free_symbols:
        return
    expression = (1 - sp.cos(s)) / s**2
    found = expression_range(expression, BOX, tolerance=Fraction(1, 1000), most_boxes=300)
    chance = np.random.default_rng(3)
    x, y = chance.uniform(-1, 0.5, 200), chance.uniform(-0.4, 0.8, 200)
    at = float(a) * x + float(b) * y + float(c)
    values = 2 * np.sin(at / 2) ** 2 / np.where(at == 0, 1, at**2)
    values = values[np.abs(at) > 1e-6]
    assert values.size == 0 or float(found.outer.lower) <= values.min() + 1e-9
    assert values.size == 0 or values.max() <= float(found.outer.upper) + 1e-9


def test_the_value_on_the_line_where_the_sum_vanishes() -> None:
    """sin(s)/s is 1 at x = 1, y = -1/2."""
    assert expression_value(sinc(X + 2 * Y), {X: 1.0, Y: -0.5}) == 1.0
    assert expression_value(sinc(X + 2 * Y), {X: 1.0, Y: 0.5}) == pytest.approx(math.sin(2) / 2)


def trailer() -> Plant:
    """Return the truck and trailer in the paper's own states x1, x2, x3.

    Tanaka and Sano (1994), recalled: x2+ = x2 + (v T/L) x1, x3+ = x3 + v T sin(x2 + v T/(2 L) x1),
    here with v T / L = -4/11 and v T = -2.
    """
    x1, x2, x3 = sp.symbols("x1 x2 x3", real=True)
    share = sp.Rational(-4, 11)
    middle = x2 + share / 2 * x1
    return Plant(
        states=(
            Variable(x1, "rad", Interval.of(-1, 1)),
            Variable(x2, "rad", Interval.of(-2, 2)),
            Variable(x3, "m"),
        ),
        inputs=(Variable(U, "rad"),),
        equations=((1 - share) * x1 - U / 2, x2 + share * x1, x3 - 2 * sp.sin(middle)),
        premises={TURN: sinc(middle)},
        sample_time=2.0,
        name="trailer",
    )


def test_the_truck_and_trailer_has_two_rules_in_the_papers_states() -> None:
    model = sector_model(trailer())
    assert len(model.rules) == 2
    assert model.premises[0].name == "turn"
    assert model.derivation is not None
    assert model.derivation.exactness == "checked symbolically"

    points = [*np.random.default_rng(5).uniform((-1, -2), (1, 2), (30, 2)), (0.5, 1 / 11), (0, 0)]
    for x1, x2 in points:
        middle = x2 - 2 / 11 * x1
        now = model.blend(model.premise_values(x1=x1, x2=x2))
        wanted = [15 / 11 * x1, x2 - 4 / 11 * x1, 3.0 - 2 * math.sin(middle)]
        np.testing.assert_allclose(now.A @ [x1, x2, 3.0], wanted, rtol=1e-9, atol=1e-12)


def test_a_band_in_the_variables_of_a_sum() -> None:
    """|x2 - 2 x1/11| <= 1/10: the premise is within (1/10)^2/6 of 1."""
    plant = trailer()
    x1, x2, _ = (variable.symbol for variable in plant.states)
    line, tenth = sp.Rational(2, 11) * x1, sp.Rational(1, 10)
    near = Domain.band({x1: Interval.of(-1, 1)}, {x2: (line - tenth, line + tenth)})
    (premise,) = sector_model(plant, domain=near).premises

    assert Fraction("0.99833") < premise.lower < 1
    assert premise.bounds.contains(premise.replay())
