"""Symbolic sector nonlinearity: exact on the box, rigorous bounds, textbook numbers."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.models import Interval, ModelError, Parameter, Plant, TSModel, sector_model
from takagi.models.ranges.expression_range import expression_range, expression_value
from tests.symbolic_plants import plant_of

X1, X2, U = sp.symbols("x1 x2 u", real=True)
Z1, Z2, Z3, Z4 = sp.symbols("z1:5")
FINE = "1e-6"
LIMIT = 1.535889  # 88 deg, the textbook's range of the angle
PREMISES = {
    Z1: 1 / (sp.Rational(2, 3) - sp.cos(X1) ** 2 / 10),
    Z2: sp.sin(X1) / X1,
    Z3: X2 * sp.sin(2 * X1),
    Z4: sp.cos(X1),
}
BOX = {X1: (-LIMIT, LIMIT), X2: (-4, 4)}


def pendulum() -> list[sp.Expr]:
    """Return the inverted pendulum on a cart, m = 2 kg, M = 8 kg, 2l = 1 m, a = 1/(m + M).

    Tanaka and Wang (2001), section 2.2: x2' = (g sin x1 - a m l x2^2 sin(2 x1)/2 - a cos(x1) u)
    / (4l/3 - a m l cos^2 x1), with g = 9.8.
    """
    rise = sp.Rational(98, 10) * sp.sin(X1) - X2**2 * sp.sin(2 * X1) / 20 - sp.cos(X1) * U / 10
    return [X2, rise / (sp.Rational(2, 3) - sp.cos(X1) ** 2 / 10)]


@lru_cache
def textbook() -> TSModel:
    """Return the textbook's model: four premises, sixteen rules."""
    plant = plant_of(pendulum(), [X1, X2], [U], box=BOX, premises=PREMISES)
    return sector_model(plant, tolerance=FINE)


@lru_cache
def found() -> TSModel:
    """Return the model that the factoring finds by itself."""
    return sector_model(plant_of(pendulum(), [X1, X2], [U], box=BOX), tolerance=FINE)


def test_textbook_bounds_of_the_pendulum() -> None:
    """Tanaka and Wang (2001), section 2.2: the four premises' extrema in closed form."""
    beta = np.cos(LIMIT)
    expected = {
        "z1": (1 / (2 / 3 - 0.1 * beta**2), 1 / (2 / 3 - 0.1)),
        "z2": (np.sin(LIMIT) / LIMIT, 1.0),
        "z3": (-4.0, 4.0),
        "z4": (beta, 1.0),
    }

    for premise in textbook().premises:
        low, high = expected[premise.name]
        assert float(premise.lower) == pytest.approx(low, rel=1e-5)
        assert float(premise.upper) == pytest.approx(high, rel=1e-5)
        assert premise.lower <= Fraction(low) + Fraction(1, 10**12)
        assert premise.upper >= Fraction(high) - Fraction(1, 10**12)
    assert len(textbook().rules) == 16


@pytest.mark.parametrize("make", [textbook, pytest.param(found, marks=pytest.mark.slow)])
def test_blend_equals_the_plant(make: object) -> None:
    """A(z) x + B(z) u is the plant's derivative at random points, also at the angle 0."""
    model: TSModel = make()  # type: ignore[operator]
    plant = sp.lambdify((X1, X2, U), pendulum())
    points = np.random.default_rng(7).uniform((-LIMIT, -4, -50), (LIMIT, 4, 50), (40, 3))

    for x1, x2, u in [*points, (0.0, 1.0, 3.0), (1e-12, -4.0, 3.0)]:
        now = model.blend(model.premise_values(x1=x1, x2=x2))
        derivative = now.A @ [x1, x2] + now.B @ [u]
        np.testing.assert_allclose(derivative, plant(x1, x2, u), rtol=1e-9, atol=1e-12)


def test_memberships_at_the_origin_take_the_textbook_corners() -> None:
    """At rest upright z1, z2 and z4 are at their maxima: only rules with those corners count."""
    h = textbook().memberships(textbook().premise_values(x1=0.0, x2=0.0))
    for rule, weight in zip(textbook().rules, h, strict=True):
        assert weight < 1e-6 or (rule[0], rule[1], rule[3]) == (1, 1, 1)


def test_derivation_shows_plant_factored_form_and_bounds() -> None:
    """The derivation carries each step and each premise's proof in words."""
    text = getattr(textbook().derivation, "latex", "")

    assert r"\dot{x_{2}}" in text
    assert r"\sin{\left(x_{1} \right)}" in text
    assert text.count("ball arithmetic") == 4


@pytest.mark.parametrize(
    ("expression", "low", "high"),
    [
        (sp.sin(X1) / X1, np.sin(1.5) / 1.5, 1.0),
        ((1 - sp.cos(X1)) / X1**2, (1 - np.cos(1.5)) / 1.5**2, 0.5),
        (sp.cos(X1) / X1 - 1 / X1, (np.cos(1.5) - 1) / 1.5, (1 - np.cos(1.5)) / 1.5),
        (X1**2 - X1 * X2 + X2**3, -1.25, 4.75),
        (sp.exp(-(X1**2)), np.exp(-2.25), 1.0),
    ],
)
def test_ranges_by_calculus(expression: sp.Expr, low: float, high: float) -> None:
    """Ranges over |x1| <= 3/2, |x2| <= 1 worked out by hand, within one part in 10^5."""
    sides = {X1: Interval.of("-1.5", "1.5"), X2: Interval.of(-1, 1)}
    outer = expression_range(expression, sides).outer

    assert outer.lower <= Fraction(low) + Fraction(1, 10**14)
    assert outer.upper >= Fraction(high) - Fraction(1, 10**14)
    assert float(outer.lower) == pytest.approx(low, abs=1e-5 * (high - low))
    assert float(outer.upper) == pytest.approx(high, abs=1e-5 * (high - low))


@pytest.mark.slow
@settings(max_examples=60, derandomize=True, deadline=None)
@given(st.floats(-1.5, 1.5), st.floats(-1, 1))
def test_a_range_contains_every_value(x1: float, x2: float) -> None:
    """No sampled value leaves the enclosure of a function with two removable singularities."""
    expression = sp.sin(X1) * sp.tanh(X2) / (X1 * X2) + X1 * X2
    outer = _mixed_range(expression)

    assert float(outer.lower) <= expression_value(expression, {X1: x1, X2: x2})
    assert expression_value(expression, {X1: x1, X2: x2}) <= float(outer.upper)


@lru_cache
def _mixed_range(expression: sp.Expr) -> Interval:
    sides = {X1: Interval.of("-1.5", "1.5"), X2: Interval.of(-1, 1)}
    return expression_range(expression, sides, tolerance=Fraction(1, 1000)).outer


def test_given_bounds_are_marked_and_contradicted_ones_refused() -> None:
    """A bound from the user is used as it is, unless an attained value lies outside."""
    plant = plant_of([sp.sin(X1)], [X1], box={X1: (-1, 1)}, premises={Z1: sp.sin(X1) / X1})
    exact = sector_model(plant, bounds={Z1: (0, 1)})

    assert exact.premises[0].lower == 0
    assert exact.premises[0].upper == 1
    assert exact.premises[0].evidence.startswith("given by the user")
    with pytest.raises(ModelError, match="leave out values"):
        sector_model(plant, bounds={Z1: (0, "0.99")})


def test_parameters_disturbances_and_outputs() -> None:
    """x1' = -c x1^3 + w, y = x1^3: one premise x1^2 is shared by A and C."""
    c, w = sp.symbols("c w")
    plant = plant_of(
        [-c * X1**3 + w],
        [X1],
        box={X1: (-2, 2)},
        disturbances=[w],
        outputs=[-c * X1**3],
        parameters=(Parameter(c, Fraction(1, 2)),),
    )
    model = sector_model(plant)

    assert len(model.rules) == 2
    np.testing.assert_allclose(model.E, 1)
    np.testing.assert_allclose(model.A, model.C)
    assert sorted(model.A.ravel().tolist()) == pytest.approx([-2, 0], abs=1e-5)


def _of(*f: sp.Expr, box: Any = BOX) -> Plant:
    """Return the plant with one state or two."""
    return plant_of(f, [X1, X2][: len(f)], [U], box=box)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: sector_model(_of(*pendulum(), box={X1: (-1, 1)})), "x2, for which no range"),
        (lambda: sector_model(_of(sp.cos(X1))), "x' is 1 per second, not 0"),
        (lambda: sector_model(_of(U**2)), "u enters nonlinearly"),
        (lambda: sector_model(_of(X1 / (X2 - 1), X2)), "has a pole at x2 - 1 = 0"),
        (lambda: sector_model(_of(X1 * sp.gamma(X2 + 8), X2)), "no ball arithmetic for gamma"),
        (lambda: sector_model(_of(X1 / (1 + X2), X2, box={**BOX, X1: (-1, 1)})), "a pole at"),
    ],
)
def test_misuse_is_explained(build: object, message: str) -> None:
    """Each mistake raises ModelError and names the row, the symbol or the premise."""
    with pytest.raises(ModelError, match=message):
        build()  # type: ignore[operator]
