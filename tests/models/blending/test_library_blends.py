"""The plants behind a blend that come with the package: exact models, and a point of rest."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.models import Plant, TSModel, load_model
from takagi.models.blending.blending import RunTimeBlending, blending_of
from takagi.models.blending.substitution import blended_model

Floats = NDArray[np.float64]


def psi(s: float, e: float) -> float:
    """The ramp, by max and min."""
    return max(s - e, 0.0) + min(max(s + e, 0.0), 2 * e) ** 2 / (4 * e)


def split_range(x: Floats, wrong: Floats) -> list[float]:
    """Energy balances of tank and jacket; cooling 0.1 kg/s and heating 0 at rest."""
    T, Tj, _, U = x
    cooling, heating = psi(-U, 1e4) / (4e3 * (Tj - 290)), psi(U, 1e4) / (4e3 * (380 - Tj))
    cooling, heating = 0.1 + (1 + wrong[0]) * (cooling - 0.1), (1 + wrong[1]) * heating
    reaction = 2e4 * np.exp(7000 / 350 - 7000 / T)
    return [
        (2e3 * (Tj - T) + reaction) / 4e6,
        (2e3 * (T - Tj) - 4e3 * cooling * (Tj - 290) + 4e3 * heating * (380 - Tj)) / 8e5,
        T - 350,
        0.0,
    ]


def boost_throttle(x: Floats, wrong: Floats) -> list[float]:
    """Filling through the throttle, charger with a lag; 5 kPa/s each at rest."""
    pm, d, _, U = x
    at = 1 - 5e3 / (20 * 17e3), 5e3 / (20 * 80e3)
    throttle, boost = 1 - psi(-U, 2e4) / (20 * 17e3), psi(U, 2e4) / (20 * 80e3)
    throttle = at[0] + (1 + wrong[0]) * (throttle - at[0])
    boost = at[1] + (1 + wrong[1]) * (boost - at[1])
    filling = 20 * throttle * d - 4 * pm
    return [filling, (100.5e3 + 80e3 * boost - pm - d) / 0.5 - filling, pm - 83.75e3, 0.0]


FIELDS: dict[str, Callable[[Floats, Floats], list[float]]] = {
    "split_range": split_range,
    "boost_throttle": boost_throttle,
}


@cache
def made(name: str) -> tuple[Plant, TSModel]:
    plant = load_model(name)
    assert isinstance(plant, Plant)
    return plant, blended_model(plant)


@pytest.mark.parametrize("name", FIELDS)
@settings(max_examples=15, derandomize=True, deadline=None)
@given(shares=st.lists(st.floats(0, 1), min_size=6, max_size=6))
def test_model_and_running_plant_equal_the_equations(name: str, shares: list[float]) -> None:
    """Anywhere in the box, actuators as wrong as they may be; weights are convex."""
    plant, model = made(name)
    blending = blending_of(plant)
    assert blending is not None
    sides = [v.range for v in plant.states]
    x = np.array([
        float(side.lower) + share * float(side.width)
        for side, share in zip(sides, shares, strict=False)
        if side is not None
    ])  # fmt: skip
    wrong = 0.2 * np.array(shares[4:]) - 0.1
    names = [a.name for a in blending.actuators]
    errors = dict(zip(names, wrong, strict=True))
    running = RunTimeBlending(blending, errors)
    wanted = FIELDS[name](x, wrong)
    size = 1e-9 * np.abs(wanted).max() + 1e-12

    rate = running.disturbed_rate(())(x, np.zeros(1), np.zeros(0))
    np.testing.assert_allclose(rate, wanted, rtol=1e-9, atol=size)
    rest = np.array([float(v.rest) for v in plant.states])
    labels = [label.split(" [")[0] for label in model.states]
    point = dict(zip(labels, x - rest, strict=True)) | running.signals(x)
    point |= {f"{one}_error": error for one, error in errors.items()}
    values = model.premise_values(**point, effort_rate=0.0)
    h = model.memberships(values, clip=True)
    assert h.min() >= 0 and h.sum() == pytest.approx(1, abs=1e-12)
    moved = model.blend(values, clip=True).A @ (x - rest)
    np.testing.assert_allclose(moved, wanted, rtol=1e-9, atol=1e-9 * np.abs(x - rest).max())


@pytest.mark.parametrize("name", FIELDS)
def test_it_rests_where_the_file_says(name: str) -> None:
    plant, _ = made(name)
    rest = np.array([float(v.rest) for v in plant.states])

    np.testing.assert_allclose(FIELDS[name](rest, np.zeros(2)), 0, atol=1e-9)


@pytest.mark.parametrize(("name", "rules"), [("split_range", 16), ("boost_throttle", 16)])
def test_number_of_rules(name: str, rules: int) -> None:
    """As docs/models.md has them: share and two errors, and one premise more."""
    assert len(made(name)[1].rules) == rules
