"""From a plant to a model: premises chosen, rest moved, mass solved, and equal to the plant."""

from __future__ import annotations

from fractions import Fraction
from functools import lru_cache

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import (
    Interval,
    ModelError,
    Output,
    Parameter,
    Plant,
    TSModel,
    Variable,
    interpolate_curve,
    load_model,
    sector_model,
    table_function,
)
from takagi.models.equations.equations import UNKNOWN, unit_of

Q, P, R, S, U, W = sp.symbols("q p r s u w", real=True)
NARROW = Interval.of(-1, 1)


def variable(
    symbol: sp.Symbol, lower: object = -1, upper: object = 1, rest: object = 0
) -> Variable:
    return Variable(symbol, "-", Interval.of(str(lower), str(upper)), Fraction(str(rest)))


def plant(*rows: object, **changes: object) -> Plant:
    states = tuple(variable(s) for s in (Q, P, R, S)[: len(rows)])
    options: dict[str, object] = {"states": states, "inputs": (Variable(U),), "name": "test"}
    return Plant(equations=tuple(map(sp.sympify, rows)), **(options | changes))  # type: ignore[arg-type]


def pendulum() -> Plant:
    """Return the inverted pendulum of Tanaka and Wang (2001), section 2.2, g a parameter."""
    g = sp.Symbol("g", real=True)
    rise = g * sp.sin(Q) - P**2 * sp.sin(2 * Q) / 20 - sp.cos(Q) * U / 10
    return plant(
        P,
        rise / (sp.Rational(2, 3) - sp.cos(Q) ** 2 / 10),
        states=(variable(Q, "-1.4", "1.4"), variable(P, -4, 4)),
        parameters=(Parameter(g, Fraction(98, 10)),),
        outputs=(Output("angle", Q, "rad"),),
    )


TEXTBOOK = {
    sp.Symbol("z1"): 1 / (sp.Rational(2, 3) - sp.cos(Q) ** 2 / 10),
    sp.Symbol("z2"): sp.sin(Q) / Q,
    sp.Symbol("z3"): P * sp.sin(2 * Q),
    sp.Symbol("z4"): sp.cos(Q),
}


def cart() -> Plant:
    """Return two coupled bodies with M(q) = diag(1, 1, [[10, cos p], [cos p, 2/3]])."""
    mass = sp.eye(4)
    mass[2:, 2:] = sp.Matrix([[10, sp.cos(P)], [sp.cos(P), sp.Rational(2, 3)]])
    rows = (R, S, U + S**2 * sp.sin(P), sp.Rational(98, 10) * sp.sin(P))
    states = (Variable(Q), variable(P), Variable(R), variable(S, -3, 3))
    return plant(*rows, mass=mass, states=states)


def singular_everywhere_else() -> Plant:
    """Return functions whose quotients by their variables are removable singularities."""
    rows = (sp.tan(Q) + 1 - sp.cos(P), sp.exp(P) - 1 + sp.sin(Q) * P**2, sp.atan(R) * Q)
    return plant(*rows)


def off_zero() -> Plant:
    """Return a plant that rests at q = 1/2, u = 3/8 and in discrete time."""
    states = (variable(Q, 0, 1, "0.5"), variable(P))
    return plant(
        Q + P / 10,
        P + (U - 3 * Q**3 + sp.sin(Q) - sp.sin(sp.Rational(1, 2))) / 10,
        states=states,
        inputs=(Variable(U, "N", None, Fraction(3, 8)),),
        outputs=(Output("square", Q**2),),
        sample_time=0.1,
    )


CASES = {
    "pendulum": (pendulum, {}, 4),
    "textbook": (pendulum, {"premises": TEXTBOOK, "tolerance": "1e-6"}, 16),
    "least": (pendulum, {"choice": "least-conservative"}, None),
    "cart": (cart, {}, 16),
    "singularities": (singular_everywhere_else, {}, None),
    "off zero": (off_zero, {}, 4),
}


@lru_cache
def model_of(case: str) -> tuple[Plant, TSModel]:
    make, options, _ = CASES[case]
    described = make()
    return described, sector_model(described, **options)  # type: ignore[arg-type]


@pytest.mark.slow
@pytest.mark.parametrize("case", CASES)
@given(shares=st.lists(st.floats(0, 1), min_size=5, max_size=5))
def test_the_model_equals_the_plant_on_its_box(case: str, shares: list[float]) -> None:
    """A(z) dx + B(z) du = M^-1 f(x, u) (minus x* in discrete time) anywhere in the box."""
    described, model = model_of(case)
    point, deviations = {}, {}
    for variable, share in zip(described.variables, shares, strict=False):
        side = variable.range or NARROW
        value = float(side.lower) + share * float(side.width)
        point[variable.symbol] = value
        label = variable.name if variable.rest == 0 else f"delta_{variable.name}"
        deviations[label] = value - float(variable.rest)

    z = model.premise_values(**deviations)
    h = model.memberships(z)
    now = model.blend(z)
    n = len(described.states)
    vector = np.array(list(deviations.values()))
    moved = now.A @ vector[:n] + now.B @ vector[n:]

    assert np.all(h >= 0)
    assert h.sum() == pytest.approx(1, abs=1e-12)
    np.testing.assert_allclose(moved, _derivative(described, point), rtol=1e-9, atol=1e-10)


def _derivative(described: Plant, point: dict[sp.Symbol, float]) -> np.ndarray:
    values = {s: float(v) for s, v in described.values.items()} | point
    f = np.array([float(row.subs(values)) for row in described.equations])
    if described.mass is not None:
        f = np.linalg.solve(np.array(described.mass.subs(values)).astype(float), f)
    if described.sample_time is not None:
        f = f - [float(v.rest) for v in described.states]
    return f


@pytest.mark.parametrize("case", [case for case in CASES if CASES[case][2]])
def test_number_of_rules(case: str) -> None:
    """Two for each premise: the textbook's sixteen when its premises are fixed, else fewer."""
    _, model = model_of(case)

    assert len(model.rules) == CASES[case][2]
    assert model.derivation is not None
    assert model.derivation.exactness == "checked symbolically"


def test_textbook_bounds_of_the_pendulum() -> None:
    """Tanaka and Wang (2001), section 2.2: the extrema of the four premises, in closed form."""
    _, model = model_of("textbook")
    beta = np.cos(1.4)
    expected = {
        "z1": (1 / (2 / 3 - 0.1 * beta**2), 1 / (2 / 3 - 0.1)),
        "z2": (np.sin(1.4) / 1.4, 1.0),
        "z3": (-4.0, 4.0),
        "z4": (beta, 1.0),
    }

    assert [p.name for p in model.premises] == list(expected)
    for premise in model.premises:
        low, high = expected[premise.name]
        assert float(premise.lower) == pytest.approx(low, rel=1e-5)
        assert float(premise.upper) == pytest.approx(high, rel=1e-5)
        assert premise.lower <= Fraction(low) + Fraction(1, 10**12)
        assert premise.upper >= Fraction(high) - Fraction(1, 10**12)


def test_parameters_disturbances_and_outputs() -> None:
    """q' = -c q^3 + w, y = q^3: one premise q^2 is shared by A and C."""
    c = sp.Symbol("c")
    model = sector_model(
        plant(
            -c * Q**3 + W,
            states=(variable(Q, -2, 2),),
            inputs=(),
            disturbances=(Variable(W),),
            outputs=(Output("y", -c * Q**3),),
            parameters=(Parameter(c, Fraction(1, 2)),),
        )
    )

    assert len(model.rules) == 2
    np.testing.assert_allclose(model.E, 1)
    np.testing.assert_allclose(model.A, model.C)
    assert sorted(model.A.ravel().tolist()) == pytest.approx([-2, 0], abs=1e-5)


def test_a_tie_in_rules_goes_to_the_smaller_hull() -> None:
    """x1' = 4 x1 x2 + x1 x3 with |x1| <= 1/10, the others in [-1, 1]: one premise either way.

    Given to x1, the entry 4 x2 + x3 is of size 5 and moves x1' by 5/10; given to x2 and x3 the
    entries 4 x1 and x1 move it by 4/10 and 1/10, together: not independently.
    """
    states = (variable(Q, "-0.1", "0.1"), variable(P), variable(R))
    model = sector_model(plant(4 * Q * P + Q * R, -P, -R, states=states))

    assert len(model.rules) == 2
    assert float(model.premises[0].upper) == pytest.approx(0.1)


def test_products_of_premises_cost_no_premise() -> None:
    """Entries sin(q)/q, r and r sin(q)/q: two premises, for the third is their product."""
    row = sp.sin(Q)
    model = sector_model(plant(row + R * P, R * row, 0 * Q, inputs=()))

    assert len(model.premises) <= 2


def test_affine_combinations_cost_no_premise() -> None:
    """Entries q^2, 3 q^2 - 1 and 5: one premise."""
    model = sector_model(plant(Q**3 + U, 3 * Q**2 * P - P + 5 * Q))

    assert len(model.rules) == 2


def test_a_constant_premise_costs_no_rule() -> None:
    states = (variable(Q), variable(P), variable(R, 2, 2, 2))
    model = sector_model(plant(P * Q, -P + Q, 0, states=states, inputs=()))

    assert len(model.rules) == 2


def test_rest_is_the_origin_and_outputs_are_deviations() -> None:
    _, model = model_of("off zero")

    assert model.states == ("delta_q [-]", "p [-]")
    assert model.inputs == ("delta_u [N]",)
    assert model.outputs == ("delta_square [-]",)
    assert model.sample_time == 0.1
    assert model.box["delta_q [-]"] == (Fraction(-1, 2), Fraction(1, 2))


@given(
    st.lists(st.fractions(-3, 3, max_denominator=9), min_size=3, max_size=3),
    st.fractions(-1, 1, max_denominator=7),
)
def test_polynomials_have_exact_divided_differences(
    coefficients: list[Fraction], rest: Fraction
) -> None:
    """(f(x) - f(x*)) / (x - x*) of a cubic is a polynomial: no denominator is left."""
    f = sum(sp.Rational(*c.as_integer_ratio()) * Q ** (k + 1) for k, c in enumerate(coefficients))
    at = sp.Rational(*rest.as_integer_ratio())
    described = plant(
        sp.sympify(f) - sp.sympify(f).subs(Q, at) + U, states=(variable(Q, -2, 2, rest),)
    )
    model = sector_model(described)

    value = 1.25 - float(rest)
    name = "q" if rest == 0 else "delta_q"
    known = model.premise_values(**{name: value}) if model.premises else None
    blended = model.blend(known).A[0, 0] if model.premises else model.A[0, 0, 0]
    function = sp.lambdify(Q, f)
    wanted = function(1.25) - function(float(rest))
    assert blended * value == pytest.approx(wanted, abs=1e-9)


def with_mass(entry: sp.Expr) -> Plant:
    return plant(P, U - Q, mass=sp.diag(1, entry))


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: sector_model(with_mass(Q)), r"may be singular: .* in the rows of p, q, .*around"),
        (lambda: sector_model(with_mass(sp.S.Zero)), "singular everywhere in the rows of p"),
        (lambda: sector_model(with_mass(2 + U)), "the mass matrix depends on u"),
        (lambda: sector_model(with_mass(1 + 1 / Q)), "cannot be bounded"),
        (lambda: sector_model(plant(Q - 1, P)), "equation of q: at rest .* x' is -1 per second"),
        (
            lambda: sector_model(plant(sp.Rational(1, 2), sample_time=0.1)),
            r"x\(t \+ T\) - x is 0.5",
        ),
        (lambda: sector_model(plant(Q * U**2)), "row 1: u enters nonlinearly .*q\\*u\\*\\*2"),
        (lambda: sector_model(plant(sp.sin(U) + Q)), "row 1: u enters nonlinearly"),
        (lambda: sector_model(plant(Q / (P - 1), P)), "has a pole at p - 1 = 0"),
        (lambda: sector_model(plant(Q * sp.gamma(P + 8), P)), "no ball arithmetic for gamma"),
        (lambda: sector_model(plant(Q), choice="best"), "choice 'best' was given"),  # type: ignore[arg-type]
        (
            lambda: sector_model(plant(Q**2), premises={sp.Symbol("a"): sp.cos(Q)}),
            "premise a was not found",
        ),
        (
            lambda: sector_model(plant(Q**2), bounds={sp.Symbol("a"): (0, 1)}),
            "bounds of a were given; the premises are z1",
        ),
        (
            lambda: sector_model(plant(Q**2 + sp.sin(P), P**3, Q), most_rules=2),
            r"premises make \d rules, more than most_rules = 2.* in \[",
        ),
        (
            lambda: sector_model(plant(P**2, Q, states=(variable(Q), Variable(P)))),
            "depends on p, for which no range",
        ),
    ],
)
def test_misuse_names_place_and_cure(build: object, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        build()  # type: ignore[operator]


def test_inputs_that_hold_the_states_are_solved_for() -> None:
    """q'' = -sin q + u/3 held at q = 1/2: u* = 3 sin(1/2), irrational and exact."""
    states = (variable(Q, 0, 1, "0.5"), variable(P))
    arm = plant(P, -sp.sin(Q) + U / 3, states=states)
    model = sector_model(arm, rest="solve inputs")

    now = model.blend(model.premise_values(delta_q=0.25))
    wanted = -np.sin(0.75) + np.sin(0.5)
    assert (now.A @ [0.25, 0.0])[1] == pytest.approx(wanted, rel=1e-12)
    assert model.inputs == ("delta_u [-]",)
    with pytest.raises(ModelError, match="let rest='solve inputs'"):
        sector_model(arm)
    with pytest.raises(ModelError, match="no input makes it vanish"):
        sector_model(plant(P + 1, U, states=states), rest="solve inputs")


def test_disturbances_go_to_their_own_column_or_are_premises() -> None:
    """q' = -q^3 + (1 + q) w + w^2: E = 1 + q + w needs q and w, A = -q^2 another premise."""
    wind = (variable(W, -2, 2),)
    model = sector_model(plant(-(Q**3) + (1 + Q) * W + W**2, disturbances=wind))

    for q, w in ((0.5, -1.0), (-0.7, 1.5), (0.0, 0.3)):
        now = model.blend(model.premise_values(q=q, w=w))
        assert now.A[0, 0] * q + now.E[0, 0] * w == pytest.approx(-(q**3) + (1 + q) * w + w**2)


def test_the_derivation_tells_weights_rules_and_vertices() -> None:
    _, model = model_of("pendulum")
    assert model.derivation is not None
    steps = {step.title: step.latex for step in model.derivation.steps}

    assert steps["Rules and their corners."].count(r"\\") == 4
    assert "Weights of the premises." in steps
    for number in range(4):
        assert f"{model.A[number, 1, 0]:.6g}" in steps[f"Vertex {number + 1}."]


X, V, TURN = sp.symbols("x v q", real=True)
UNITS = {X: "m", V: "m/s", TURN: "rad"}


@pytest.mark.parametrize(
    ("expression", "unit"),
    [
        (sp.sin(TURN) / TURN, "-"),
        (TURN, "rad"),
        (V, "m/s"),
        (X**2, "m^2"),
        (V**2 / X, "m/s^2"),
        (sp.sqrt(X), UNKNOWN),
        (V * sp.sin(2 * TURN), "m/s"),
        (sp.Abs(V), "m/s"),
        (X + 3 * X * TURN, "m"),
        (1 - sp.cos(TURN), "-"),
        (sp.tanh(10 * V) / V, "s/m"),
        (2 * X, UNKNOWN),
        (sp.Rational(2, 3) - sp.cos(TURN) ** 2 / 10, UNKNOWN),
        (X + V, UNKNOWN),
        (X * (3 + X), "m^2"),
        (sp.Symbol("w") * X, UNKNOWN),
    ],
)
def test_units_as_far_as_the_expression_tells(expression: sp.Expr, unit: str) -> None:
    """A number other than 1 may hide a parameter, so nothing is claimed where one decides."""
    assert unit_of(expression, UNITS) == unit


def test_a_table_tells_its_unit() -> None:
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
