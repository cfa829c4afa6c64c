"""Units of premises: from the plant's parameters, from what is written, or none claimed."""

from __future__ import annotations

import pytest
import sympy as sp

from takagi.models import Plant, interpolate_curve, load_model, sector_model, table_function
from takagi.models.equations.equations import UNKNOWN, unit_of

X, V, Q = sp.symbols("x v q", real=True)
UNITS = {X: "m", V: "m/s", Q: "rad"}


@pytest.mark.parametrize(
    ("expression", "unit"),
    [
        (sp.sin(Q) / Q, "-"),
        (Q, "rad"),
        (V, "m/s"),
        (X**2, "m^2"),
        (V**2 / X, "m/s^2"),
        (sp.sqrt(X), UNKNOWN),
        (V * sp.sin(2 * Q), "m/s"),
        (sp.Abs(V), "m/s"),
        (X + 3 * X * Q, "m"),
        (1 - sp.cos(Q), "-"),
        (sp.tanh(10 * V) / V, "s/m"),
        (2 * X, UNKNOWN),
        (sp.Rational(2, 3) - sp.cos(Q) ** 2 / 10, UNKNOWN),
        (X + V, UNKNOWN),
        (X * (3 + X), "m^2"),
        (sp.Symbol("w") * X, UNKNOWN),
    ],
)
def test_units_as_far_as_the_expression_tells(expression: sp.Expr, unit: str) -> None:
    """A number other than 1 may hide a parameter, so nothing is claimed where one decides."""
    assert unit_of(expression, UNITS) == unit


def test_a_table_tells_its_unit() -> None:
    """The slope of a force over a length is N/m."""
    spring = table_function(
        "spring",
        interpolate_curve([0, 1, 2, 3, 4], [0, 1, 3, 4, 9]),
        unit="N",
        argument_units=("m",),
    )
    assert unit_of(spring(X), UNITS) == "kg m/s^2"
    assert unit_of(spring(X).diff(X), UNITS) == "kg/s^2"
    assert unit_of(X, {X: "furlong"}) == UNKNOWN


def test_premises_of_a_plant_have_the_units_of_their_parameters() -> None:
    """cart_pole: 1/(4l/3 - a m l cos^2) in 1/m, the rate times a sine in 1/s."""
    plant = load_model("cart_pole")
    assert isinstance(plant, Plant)
    units = {premise.name: premise.unit for premise in sector_model(plant).premises}

    assert units == {"inertia": "1/m", "gravity": "-", "swing": "1/s", "arm": "-"}


def test_the_unit_stands_in_the_derivation() -> None:
    plant = load_model("cart_pole")
    assert isinstance(plant, Plant)

    assert r"\mathrm{[1/m]}" in getattr(sector_model(plant).derivation, "latex", "")
