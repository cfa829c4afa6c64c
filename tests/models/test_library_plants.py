"""The plants that come with the package: exact models and proved bounds."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import (
    Floats,
    ModelError,
    Plant,
    Variable,
    built_in_models,
    load_model,
    sector_model,
)
from tests.models.library_plants import (
    FIELDS,
    blended,
    model_name,
    model_of,
    named,
    plant_of,
)

BLENDED = {"boost_throttle", "split_range"}


# Their equations are in plant/test_uncertain_parameters, certificates/test_discrete_plants, below.
ELSEWHERE = {"cart_chain", "dc_servo", "two_mass_spring"}


FREE = 2.0  # a variable without a range is drawn from [-2, 2]


def side(variable: Variable) -> tuple[float, float] | None:
    found = variable.range
    if found is None:
        return None
    return float(found.lower - variable.rest), float(found.upper - variable.rest)


def test_every_plant_of_the_library_is_tested_here() -> None:
    """Those with two actuators behind a blend are in ``blending/test_library_blends``."""
    plants = {name for name, _ in built_in_models() if isinstance(load_model(name), Plant)}

    assert plants == set(FIELDS) | BLENDED | ELSEWHERE


@pytest.mark.parametrize("name", FIELDS)
@given(shares=st.lists(st.floats(0, 1), min_size=6, max_size=6))
def test_the_model_equals_the_equations_of_the_literature(name: str, shares: list[float]) -> None:
    plant, model = plant_of(name), model_of(name)
    point = []
    for variable, share in zip(plant.variables, shares, strict=False):
        low, high = side(variable) or (-FREE, FREE)
        point.append(min(low + share * (high - low), high))
    n, m = len(plant.states), len(plant.inputs)
    x, u, w = np.split(np.array(point), [n, n + m])
    h = model.memberships(model.premise_values(**named(plant, x, u, w)))

    assert np.all(h >= 0)
    assert h.sum() == pytest.approx(1, abs=1e-12)
    wanted = np.array(FIELDS[name][1](x, u, w), dtype=float)
    size = 1e-9 * max(1.0, float(np.abs(wanted).max()))
    np.testing.assert_allclose(blended(name, x, u, w), wanted, rtol=1e-9, atol=size)


@pytest.mark.parametrize("name", FIELDS)
def test_number_of_rules(name: str) -> None:
    assert len(model_of(name).rules) == FIELDS[name][0]
    assert model_of(name).derivation is not None
    assert model_of(name).derivation.exactness == "checked symbolically"  # type: ignore[union-attr]


# The grid of its four states takes a quarter of a minute.
LARGE = {"flexible_link"}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow if n in LARGE else ()) for n in FIELDS]
)
def test_bounds_hold_all_samples_and_little_more(name: str, reduced: bool) -> None:
    """Extrema on a grid are inside, and at most 1 % of the range is beyond them."""
    if reduced and name in LARGE:
        pytest.skip("takes a minute: without TAKAGI_REDUCED")
    plant, model = plant_of(name), model_of(name)
    count = 41 if len(plant.box) < 3 else 15
    sides = [
        [0.0] if (ends := side(v)) is None else np.linspace(*ends, count) for v in plant.variables
    ]
    names = [model_name(v) for v in plant.variables]
    seen = np.array(
        [
            model.premise_values(**dict(zip(names, map(float, point), strict=True)))
            for point in product(*sides)
        ]
    )

    for premise, values in zip(model.premises, seen.T, strict=True):
        low, high = float(premise.lower), float(premise.upper)
        hair = 1e-12 * (high - low)  # the float nearest to 1/10 is beyond it
        assert low - hair <= values.min() and values.max() <= high + hair
        assert high - low - np.ptp(values) <= 0.01 * (high - low)
        assert premise.evidence.startswith(("ball arithmetic", "Bernstein form"))


@pytest.mark.parametrize("name", FIELDS)
def test_the_bounds_are_proved_again_from_their_evidence(name: str) -> None:
    """Without a search: the range that the kept boxes give lies inside, less than 0.3 % short."""
    for premise in model_of(name).premises:
        again = premise.replay()

        assert premise.bounds.contains(again)
        assert premise.bounds.width - again.width <= premise.bounds.width * 3 / 1000


@pytest.mark.parametrize("name", FIELDS)
def test_a_wrong_bound_is_refused(name: str) -> None:
    for premise in model_of(name).premises:
        symbol = sp.Symbol(premise.name, real=True)
        part = premise.bounds.width / 10
        for wrong in (
            (premise.lower, premise.upper - part),
            (premise.lower + part, premise.upper),
        ):
            with pytest.raises(ModelError, match="leave out values that it attains"):
                sector_model(plant_of(name), bounds={symbol: wrong})


def jacobian(name: str, x: Floats) -> Floats:
    """Return df/dx of the literature's equations by central differences, u = w = 0."""
    plant, field = plant_of(name), FIELDS[name][1]
    u, w, step = np.zeros(len(plant.inputs)), np.zeros(len(plant.disturbances)), 1e-6
    columns = [
        (np.array(field(x + d, u, w)) - np.array(field(x - d, u, w))) / (2 * step)
        for d in step * np.eye(len(x))
    ]
    return np.stack(columns, axis=1)


def test_rules_of_wang_tanaka_and_griffin() -> None:
    """The vertices are the two local models: 17.294, 9.360, -0.1765, -0.00524.

    Wang, Tanaka and Griffin (1996), by their formulas with m = 2, M = 8, 2 l = 1, g = 9.8.
    """
    model = model_of("cart_pole_2rules")

    assert model.A[:, 1, 0] == pytest.approx([17.294, 9.360], abs=1e-3)
    assert model.B[:, 1, 0] == pytest.approx([-0.1765, -0.00524], abs=5e-5)


def test_entries_of_tanaka_ikeda_and_wang() -> None:
    """Tanaka, Ikeda and Wang (1996): damper -0.225 or 0, spring -1.5275 or -0.02."""
    A = model_of("mass_spring_damper").A

    assert set(np.round(A[:, 1, 1], 6)) == {-0.225, 0.0}
    assert set(np.round(A[:, 1, 0], 6)) == {-1.5275, -0.02}


def test_poles_of_the_motor_of_the_control_tutorials() -> None:
    """-2.0025 and -9.9975 1/s: P(s) = 0.01/(0.005 s^2 + 0.06 s + 0.1001), by hand.

    Messner and Tilbury, Control Tutorials for MATLAB and Simulink, DC Motor Speed (recalled).
    """
    model = model_of("dc_servo")
    motor = model.A[0][1:3, 1:3]

    assert model.A[0][[0, 3]].tolist() == [[0, 1, 0, 0], [1, 0, 0, 0]]
    assert model.B[0].ravel().tolist() == [0, 0, 2, 0]
    assert model.E[0].tolist() == [[0, 0], [100, 0], [0, 0], [0, -1]]
    assert np.poly(motor) == pytest.approx([1, 12, 20.02])
    assert sorted(np.linalg.eigvals(motor)) == pytest.approx([-9.9975, -2.0025], abs=1e-4)


def test_entries_of_tanaka_and_sano() -> None:
    """Tanaka and Sano (1994), rule 1 in x1, x2, x3: 1.3636, -0.3636, 0.3636, -2 and -0.7143."""
    model = model_of("truck_trailer")
    T = np.array([[1, 0, 0], [2 / 11, 1, 0], [0, 0, 1]])  # x1, x2, x3 from x1, q, x3
    now = model.blend(model.premise_values(x1=0.0, q=0.0, x3=0.0, u=0.0))

    published = np.array([[1.3636, 0, 0], [-0.3636, 1, 0], [0.3636, -2, 1]])
    np.testing.assert_allclose(np.asarray(T @ now.A @ np.linalg.inv(T)), published, atol=5e-5)
    np.testing.assert_allclose(model.C[0] @ np.linalg.inv(T), np.eye(3)[1:], atol=1e-12)
    np.testing.assert_allclose(model.C[0] @ np.linalg.inv(T), [[0, 1, 0], [0, 0, 1]], atol=1e-12)
    assert model.sample_time == 2.0


def test_equilibria_and_eigenvalues_of_lorenz() -> None:
    """At (+-sqrt(72), +-sqrt(72), 27): -13.8546, 0.0940 +- 10.1945i; at 0: 11.8277, -22.8277, -8/3.

    Sparrow (1982), The Lorenz Equations, r = 28; the roots of s^3 + 41/3 s^2 + 304/3 s + 1440.
    """
    root = np.sqrt(72.0)
    for sign in (1, -1):
        point = np.array([sign * root, sign * root, 27.0])
        still = blended("lorenz", point, np.zeros(1), np.zeros(0))
        np.testing.assert_allclose(still, 0, atol=1e-9)
        poles = np.linalg.eigvals(jacobian("lorenz", point))
        np.testing.assert_allclose(np.poly(poles), [1, 41 / 3, 304 / 3, 1440], rtol=1e-6)
        assert sorted(poles.real) == pytest.approx([-13.8546, 0.0940, 0.0940], abs=1e-4)
    model = model_of("lorenz")
    poles = np.linalg.eigvals(model.blend(model.premise_values(x=0.0)).A)
    assert sorted(poles.real) == pytest.approx([-22.8277, -8 / 3, 11.8277], abs=1e-4)


def have_common_quadratic(first: Floats, second: Floats) -> bool:
    """Shorten and Narendra (2002): no negative real eigenvalue of A1 A2 and A1 A2^-1."""
    found = np.linalg.eigvals(np.array([first @ second, first @ np.linalg.inv(second)]))
    return not np.any((np.abs(found.imag) < 1e-12) & (found.real < 0))


@pytest.mark.parametrize(
    ("name", "parameter", "threshold"),
    [("dayawansa_martin", "a", 3 + np.sqrt(8)), ("shorten_narendra", "h", 4 + 4 * np.sqrt(2))],
)
def test_planar_pairs_are_below_their_thresholds(
    name: str, parameter: str, threshold: float
) -> None:
    model, (figure,) = model_of(name), plant_of(name).parameters
    assert figure.symbol.name == parameter
    assert 0.98 * threshold < float(figure.value) < threshold
    assert have_common_quadratic(*model.A)
