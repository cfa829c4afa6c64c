"""The plants that come with the package: exact models and proved bounds."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.models import ModelError, Plant, Variable, built_in_models, load_model, sector_model
from tests.models.library_plants import FIELDS, blended, model_name, model_of, named, plant_of

BLENDED = {"boost_throttle", "split_range"}


# Their equations are in plant/test_uncertain_parameters, certificates/test_twelve_states, below.
ELSEWHERE = {"cart_chain", "dc_servo", "two_mass_spring"}


FREE = 2.0  # a variable without a range is drawn from [-2, 2]


def side(variable: Variable) -> tuple[float, float] | None:
    """Return the range of the deviation from rest."""
    found = variable.range
    if found is None:
        return None
    return float(found.lower - variable.rest), float(found.upper - variable.rest)


def test_every_plant_of_the_library_is_tested_here() -> None:
    """A new file needs its equations, written again by hand, in this file.

    Those with two actuators behind a blend have them in ``blending/test_library_blends``.
    """
    plants = {name for name, _ in built_in_models() if isinstance(load_model(name), Plant)}

    assert plants == set(FIELDS) | BLENDED | ELSEWHERE


@pytest.mark.parametrize("name", FIELDS)
@settings(max_examples=30, derandomize=True, deadline=None)
@given(shares=st.lists(st.floats(0, 1), min_size=6, max_size=6))
def test_the_model_equals_the_equations_of_the_literature(name: str, shares: list[float]) -> None:
    """Anywhere in the box, with memberships that are weights."""
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
    """As docs/models.md has them."""
    assert len(model_of(name).rules) == FIELDS[name][0]
    assert model_of(name).derivation is not None
    assert model_of(name).derivation.exactness == "checked symbolically"  # type: ignore[union-attr]


# The grid of its four states takes a quarter of a minute.
LARGE = {"flexible_link"}


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=pytest.mark.slow if n in LARGE else ()) for n in FIELDS]
)
def test_bounds_hold_all_samples_and_little_more(name: str, reduced: bool) -> None:
    """Extrema on a grid are inside, and at most 1 % of the range is beyond them.

    Of that, 0.1 % is what the bounds may exceed the range by; the grid misses the rest.
    """
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
    """Each premise with a tenth of its range cut off, at either end."""
    for premise in model_of(name).premises:
        symbol = sp.Symbol(premise.name, real=True)
        part = premise.bounds.width / 10
        for wrong in (
            (premise.lower, premise.upper - part),
            (premise.lower + part, premise.upper),
        ):
            with pytest.raises(ModelError, match="leave out values that it attains"):
                sector_model(plant_of(name), bounds={symbol: wrong})
