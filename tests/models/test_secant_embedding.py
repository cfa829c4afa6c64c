"""Secant embedding of general closed loops: contains every pair, exact where it can be told."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from functools import lru_cache
from typing import cast, get_args

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from takagi.models import (
    Feedback,
    Interval,
    ModelError,
    Plant,
    SecantEmbedding,
    SecantRegion,
    Variable,
    blended_feedback,
    product_memberships,
    secant_embedding,
)
from takagi.models.loops.secant.entries import Form
from takagi.models.loops.secant.matrices import SecantCell

X, V, U, W, P = sp.symbols("x v u w p", real=True)
ROUNDING = 1e-9
Vector = np.ndarray


def plant_of(
    equations: list[sp.Expr],
    states: Mapping[sp.Symbol, tuple[float, float]],
    *,
    inputs: tuple[sp.Symbol, ...] = (),
    disturbances: Mapping[sp.Symbol, tuple[float, float]] | None = None,
    sample_time: float | None = None,
    mass: sp.Matrix | None = None,
) -> Plant:
    """Return a plant at rest in the origin."""
    return Plant(
        equations=tuple(sp.sympify(row) for row in equations),
        states=tuple(Variable(s, range=Interval.of(*side)) for s, side in states.items()),
        inputs=tuple(Variable(s) for s in inputs),
        disturbances=tuple(
            Variable(s, range=Interval.of(*side)) for s, side in (disturbances or {}).items()
        ),
        sample_time=sample_time,
        mass=mass,
        name="test",
    )


def scalar(row: sp.Expr, side: tuple[float, float] = (-1, 1)) -> Plant:
    """Return x' = row(x)."""
    return plant_of([row], {X: side})


def distance(cell: SecantCell, difference: Vector, change: Vector) -> float:
    """Return the least max-norm distance of change to {(C + sum theta D) difference}: an LP."""
    whole = np.array(cell.constant, dtype=float) @ difference
    pushes = np.zeros((len(change), len(cell.factors)))
    for k, factor in enumerate(cell.factors):
        for (row, column), d in factor.entries.items():
            pushes[row, k] += float(d) * difference[column]
    gap = change - whole
    ones = np.ones((len(change), 1))
    found = linprog(
        np.append(np.zeros(len(cell.factors)), 1.0),
        A_ub=np.vstack((np.hstack((pushes, -ones)), np.hstack((-pushes, -ones)))),
        b_ub=np.concatenate((gap, -gap)),
        bounds=[(float(f.bounds.lower), float(f.bounds.upper)) for f in cell.factors] + [(0, None)],
    )
    assert found.status == 0
    assert found.x is not None
    return float(found.x[-1])


def worst(
    cell: SecantCell,
    rate: Callable[[Vector], Vector],
    reference: Vector,
    box: list[tuple[float, float]],
    *,
    count: int = 60,
) -> float:
    """Return the largest distance over random points and the corners of the box."""
    low, high = np.array(box, dtype=float).T
    draws = np.random.default_rng(4).uniform(low, high, size=(count, len(box)))
    corners = np.array(np.meshgrid(*box)).reshape(len(box), -1).T
    at_rest = rate(reference)
    return max(
        distance(cell, point - reference, rate(point) - at_rest) for point in (*draws, *corners)
    )


def shrunk(embedding: SecantEmbedding, number: int = 0) -> SecantCell:
    """Return the first cell with the middle half of one factor's bounds: a wrong bound."""
    (cell, *_) = embedding.cells
    factors = list(cell.factors)
    bounds = factors[number].bounds
    quarter = bounds.width / 4
    factors[number] = replace(
        factors[number], bounds=Interval(bounds.lower + quarter, bounds.upper - quarter)
    )
    return replace(cell, factors=tuple(factors))


@lru_cache
def pendulum_loop(form: Form) -> SecantEmbedding:
    """Return the pendulum on a cart with a two-rule PDC law and a disturbance acceleration.

    Plant of Tanaka and Wang (2001), section 2.2; the gains stabilise it and are ours.
    """
    mass = sp.Rational(2, 3) - sp.cos(X) ** 2 / 10
    rise = (sp.Rational(98, 10) * sp.sin(X) - V**2 * sp.sin(2 * X) / 20 - sp.cos(X) * U / 10) / mass
    plant = plant_of(
        [V, rise + W], {X: (-1, 1), V: (-2, 2)}, inputs=(U,), disturbances={W: (-1, 1)}
    )
    return secant_embedding(plant, pendulum_law(), form=form, tolerance="0.02")


def pendulum_law() -> Feedback:
    shares = product_memberships([(sp.cos(X), "0.5", 1)])
    return blended_feedback([X, V], [U], shares, [[[-300, -80]], [[-200, -60]]])


def pendulum_rate(point: Vector) -> Vector:
    """Return the loop in floats, written independently of the symbols."""
    x, v, w = point
    near, far = (1 - np.cos(x)) / 0.5, (np.cos(x) - 0.5) / 0.5
    u = -(near * (-300 * x - 80 * v) + far * (-200 * x - 60 * v))
    force = 9.8 * np.sin(x) - 0.05 * v**2 * np.sin(2 * x) - 0.1 * np.cos(x) * u
    return np.array([v, force / (2 / 3 - 0.1 * np.cos(x) ** 2) + w])


BOX = [(-1.0, 1.0), (-2.0, 2.0), (-1.0, 1.0)]


@pytest.mark.slow
@pytest.mark.parametrize("form", ["slope", "derivative", "jacobian"])
def test_pendulum_with_a_blended_law_lies_inside(form: Form) -> None:
    (cell,) = pendulum_loop(form).cells

    assert worst(cell, pendulum_rate, np.zeros(3), BOX) < ROUNDING


@pytest.mark.parametrize("number", [0, 1])
def test_a_planted_wrong_bound_is_caught(number: int) -> None:
    cell = shrunk(pendulum_loop("slope"), number)

    assert worst(cell, pendulum_rate, np.zeros(3), BOX) > 1e-3


def test_each_form_is_tighter_than_the_next() -> None:
    widths = [
        sum(
            (entry.width for row in pendulum_loop(form).cells[0].entries for entry in row),
            Fraction(0),
        )
        for form in get_args(Form)
    ]

    assert 2 * widths[0] < widths[1]
    assert 3 * widths[1] < 2 * widths[2]


@pytest.mark.parametrize(
    ("form", "rest", "lower", "upper"),
    [
        ("slope", "0", "0", "1"),  # x^2
        ("derivative", "0", "0", "3"),  # 3 x^2
        ("slope", "1/2", "3/16", "7/4"),  # x^2 + x/2 + 1/4, least at x = -1/4
        ("jacobian", "1/2", "0", "3"),
    ],
)
def test_ranges_of_a_cubic_in_closed_form(form: Form, rest: str, lower: str, upper: str) -> None:
    cell = SecantRegion(reference={X: Fraction(rest)})

    embedding = secant_embedding(scalar(X**3), cells=[cell], form=form, tolerance="1e-6")

    ((found,),) = embedding.cells[0].entries
    wanted = Interval(Fraction(lower), Fraction(upper))
    assert found.contains(wanted)
    assert found.width - wanted.width < Fraction(1, 10**4)


@pytest.mark.parametrize("rest", ["0", "1/3"])
def test_slope_of_the_sine_through_its_removable_singularity(rest: str) -> None:
    """(sin x - sin a)/(x - a) is least at x = -1 or 1 and largest near a: both by a fine grid."""
    a = float(Fraction(rest))
    cell = SecantRegion(reference={X: Fraction(rest)})

    ((found,),) = secant_embedding(scalar(sp.sin(X)), cells=[cell]).cells[0].entries

    grid = np.linspace(-1, 1, 2000)  # an even count has neither 0 nor 1/3 in it
    quotients = (np.sin(grid) - np.sin(a)) / (grid - a)
    assert float(found.lower) <= quotients.min() + ROUNDING
    assert quotients.max() - ROUNDING <= float(found.upper)
    assert float(found.width) <= 1.01 * np.ptp(quotients)


@pytest.mark.parametrize("form", get_args(Form))
def test_kink_has_the_slopes_of_both_sides(form: Form) -> None:
    (cell,) = secant_embedding(scalar(sp.Max(X, 0) - 3 * X), form=form).cells

    ((found,),) = cell.entries
    assert found.contains(Interval.of(-3, -2))
    assert found.width < Fraction(101, 100)


def test_staircase_fixes_the_later_coordinates() -> None:
    """x v changes by 0 (x - 0) + x (v - 0) from the origin: one entry varies, not two."""
    plant = plant_of([X * V, -V], {X: (-1, 1), V: (-2, 2)})

    slope = secant_embedding(plant, form="slope").cells[0]
    jacobian = secant_embedding(plant, form="jacobian").cells[0]

    assert slope.entries[0] == (Interval.of(0), Interval.of(-1, 1))
    assert jacobian.entries[0] == (Interval.of(-2, 2), Interval.of(-1, 1))
    assert (slope.vertex_count, jacobian.vertex_count) == (2, 4)
    assert slope.entries[1] == (Interval.of(0), Interval.of(-1))


def test_entries_with_one_function_share_one_factor() -> None:
    plant = plant_of([2 * sp.sin(X) - X, -3 * sp.sin(X) + 1 - 5 * V], {X: (-1, 1), V: (-1, 1)})

    (cell,) = secant_embedding(plant).cells

    (factor,) = cell.factors
    ratio = Fraction(factor.entries[1, 0], factor.entries[0, 0])
    assert ratio == Fraction(-3, 2)
    assert [list(row) for row in cell.constant] == [[-1, 0], [0, -5]]
    assert cell.vertex_count == 2
    assert cell.residual == (Interval.of(0), Interval.of(1))


def test_limited_command_is_a_sector_with_the_exact_least_share() -> None:
    """|20 x + 8 v| <= 18 on the box and the limit is 2, so s >= 2/18; cubic spring."""
    plant = plant_of([V, -X - X**3 + U], {X: (-0.5, 0.5), V: (-1, 1)}, inputs=(U,))
    law = Feedback({U: -20 * X - 8 * V}, {U: Interval.of(-2, 2)})

    embedding = secant_embedding(plant, law, tolerance="1e-6")

    def rate(point: Vector) -> Vector:
        x, v = point
        return np.array([v, -x - x**3 + np.clip(-20 * x - 8 * v, -2, 2)])

    (cell,) = embedding.cells
    damping = cell.entries[1][1]
    assert float(damping.upper) == pytest.approx(-8 / 9, rel=1e-5)
    assert float(damping.lower) == pytest.approx(-8, rel=1e-5)
    box = [(-0.5, 0.5), (-1.0, 1.0)]
    assert worst(cell, rate, np.zeros(2), box, count=200) < ROUNDING
    assert worst(shrunk(embedding, 1), rate, np.zeros(2), box, count=200) > 1e-2


@pytest.mark.slow
@given(
    gain=st.integers(1, 8),
    limit=st.integers(1, 4),
    rest=st.fractions(-1, 1, max_denominator=8),
    x=st.floats(-2, 2),
)
@settings(max_examples=25, deadline=None)
def test_saturated_scalar_loop_from_any_reference(
    gain: int, limit: int, rest: Fraction, x: float
) -> None:
    plant = plant_of([X - X**3 + U], {X: (-2, 2)}, inputs=(U,))
    law = Feedback({U: -gain * X}, {U: Interval.of(-limit, limit)})

    def rate(value: float) -> float:
        return float(value - value**3 + np.clip(-gain * value, -limit, limit))

    (cell,) = secant_embedding(
        plant, law, [SecantRegion(reference={X: rest})], tolerance="0.1", form="derivative"
    ).cells
    change = np.array([rate(x) - rate(float(rest))])
    assert distance(cell, np.array([x - float(rest)]), change) < ROUNDING
    assert cell.residual[0].lower <= Fraction(rate(float(rest))) + Fraction(1, 10**9)
    assert Fraction(rate(float(rest))) - Fraction(1, 10**9) <= cell.residual[0].upper


def test_reference_along_a_trim_curve_follows_the_exogenous_variable() -> None:
    """x' = p + p^3 - x - x^3 rests at x = p: residual 0, and x*' = 1 p'."""
    plant = plant_of([P + P**3 - X - X**3], {X: (-1, 2)}, disturbances={P: (0, 1)})
    exactly = SecantRegion("trim", box={P: (0, "0.5")}, reference={X: P})
    roughly = SecantRegion("table", box={P: (0, "0.5")}, reference={X: P * sp.Rational(9, 10)})

    embedding = secant_embedding(plant, cells=[exactly, roughly], exogenous=[P])

    trim, table = embedding.cells
    assert trim.residual == (Interval.of(0),)
    assert trim.reference_rate == ((Interval.of(1),),)
    assert table.reference_rate == ((Interval(Fraction(9, 10), Fraction(9, 10)),),)
    ends = np.linspace(0, 0.5, 50)
    left = ends + ends**3 - 0.9 * ends - (0.9 * ends) ** 3
    assert float(table.residual[0].upper) == pytest.approx(left.max(), rel=1e-2)
    assert table.residual[0].lower <= 0
    for p in ends[::7]:
        inside = [
            distance(trim, np.array([x - p]), np.array([p + p**3 - x - x**3]))
            for x in np.linspace(-1, 2, 9)
        ]
        assert max(inside) < ROUNDING


def test_discrete_time_counts_the_residual_from_the_reference() -> None:
    plant = plant_of([X / 2 + X**2 / 4], {X: (-1, 1)}, sample_time=0.1)

    (cell,) = secant_embedding(plant, cells=[SecantRegion(reference={X: "0.5"})]).cells

    assert cell.residual == (Interval.of(Fraction(1, 4) + Fraction(1, 16) - Fraction(1, 2)),)
    assert cell.entries[0][0].contains(Interval(Fraction(3, 8), Fraction(7, 8)))  # 1/2 + (x+1/2)/4


def test_mass_matrix_is_solved_before_the_secants() -> None:
    mass = sp.Matrix([[1, 0], [0, 2 + sp.cos(X)]])
    plant = plant_of([V, -sp.sin(X) - V], {X: (-1, 1), V: (-1, 1)}, mass=mass)

    (cell,) = secant_embedding(plant, form="derivative").cells

    def rate(point: Vector) -> Vector:
        x, v = point
        return np.array([v, (-np.sin(x) - v) / (2 + np.cos(x))])

    assert worst(cell, rate, np.zeros(2), [(-1, 1), (-1, 1)]) < ROUNDING


def test_export_holds_rationals_and_the_vertices_their_hull() -> None:
    embedding = pendulum_loop("slope")
    (cell,) = embedding.cells

    data = json.loads(json.dumps(embedding.as_data()))

    (read,) = data["cells"]
    assert [[Fraction(e) for e in row] for row in read["constant"]] == [
        list(row) for row in cell.constant
    ]
    ends = [tuple(map(Fraction, factor["bounds"])) for factor in read["factors"]]
    assert ends == [(f.bounds.lower, f.bounds.upper) for f in cell.factors]
    vertices = cell.exact_vertices()
    assert len(vertices) == cell.vertex_count == 4
    for row, sides in enumerate(cell.entries):
        for column, side in enumerate(sides):
            values = [vertex[row][column] for vertex in vertices]
            assert (min(values), max(values)) == (side.lower, side.upper)
    A, E = embedding.vertex_arrays()
    assert A.shape == (4, 2, 2)
    assert np.array_equal(E, np.tile([[0.0], [1.0]], (4, 1, 1)))


def _with_input() -> Plant:
    return plant_of([-X + U], {X: (-1, 1)}, inputs=(U,))


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: secant_embedding(_with_input()), "each needs one command"),
        (lambda: secant_embedding(_with_input(), Feedback({U: V})), "no state"),
        (
            lambda: secant_embedding(scalar(X), cells=[SecantRegion("far", box={X: (0, 2)})]),
            "cell far: .*leaves the plant's range",
        ),
        (
            lambda: secant_embedding(scalar(X), cells=[SecantRegion("far", reference={X: 2})]),
            "outside its range",
        ),
        (
            lambda: secant_embedding(scalar(X), cells=[SecantRegion(reference={X: P})]),
            "not exogenous",
        ),
        (lambda: secant_embedding(scalar(X), exogenous=[P]), "no disturbance"),
        (
            lambda: secant_embedding(scalar(X), form=cast("Form", "exact")),
            "slope, derivative, jacobian",
        ),
        (
            lambda: secant_embedding(
                scalar(sp.atan(1 / X) + X), cells=[SecantRegion(reference={X: "0.5"})]
            ),
            "cell whole, equation of x: .*cannot be bounded",
        ),
        (lambda: secant_embedding(scalar(sp.sin(X) / X**2)), "no finite value at x = 0"),
        (lambda: secant_embedding(scalar(X + sp.sign(X))), "sign.* jumps"),
        (
            lambda: (
                secant_embedding(
                    _with_input(),
                    Feedback({U: -sp.sqrt(4) * X}, {U: Interval.of(-2, 2)}),
                    [SecantRegion(reference={X: "0.5"})],
                )
                .cells[0]
                .exact_vertices(most=0)
            ),
            "more than most = 0",
        ),
        (lambda: Feedback({U: X}, {V: Interval.of(-1, 1)}), "limits of v"),
        (lambda: blended_feedback([X], [U], [1], [[[1, 2]]]), "1 x 1 is needed"),
        (lambda: blended_feedback([X], [U], [1], []), "0 gains for 1"),
        (lambda: product_memberships([(X, 1, 1)]), "leave out a constant"),
    ],
)
def test_misuse_is_told_with_place_and_cure(make: Callable[[], object], words: str) -> None:
    with pytest.raises(ModelError, match=words):
        make()


def test_command_whose_rest_straddles_its_limit_is_refused() -> None:
    """With p in [0, 1] and x* = p the command -p lies on both sides of the limit -1/2."""
    plant = plant_of([-X + U], {X: (-1, 1)}, inputs=(U,), disturbances={P: (0, 1)})
    law = Feedback({U: -X}, {U: Interval.of("-0.5", "0.5")})

    with pytest.raises(ModelError, match="across an end of its limits"):
        secant_embedding(plant, law, [SecantRegion(reference={X: P})], exogenous=[P])
