"""A plant of twelve states is designed and proved by one command."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Plant, load_model, sector_model

Floats = NDArray[np.float64]


def cart_chain(x: Floats, u: Floats, w: Floats) -> list[float]:
    """Newton's law for six carts of 1 kg: springs of 10 N/m, dampers of 0.5 N s/m."""
    place, speed = x[0::2], x[1::2]
    springs = [-10 * place[0] * (1 + 2 * place[0] ** 2) - 0.5 * speed[0]]
    springs += [10 * (place[k] - place[k + 1]) + 0.5 * (speed[k] - speed[k + 1]) for k in range(5)]
    forces = [springs[k] - (springs[k + 1] if k < 5 else -u[0]) for k in range(6)]
    return [value for pair in zip(speed, forces, strict=True) for value in pair]


def test_the_model_is_the_chain_by_newton() -> None:
    """At random points of the box, with equations that are written again."""
    plant = load_model("cart_chain")
    assert isinstance(plant, Plant)
    model, draw = sector_model(plant), np.random.default_rng(2)
    (premise,) = model.premises
    assert float(premise.lower) == pytest.approx(0, abs=2e-3)
    assert float(premise.upper) == pytest.approx(1, abs=2e-3)
    for _ in range(20):
        x, u = draw.uniform(-1, 1, 12) * np.array([1.0, 2.0] * 6), draw.uniform(-10, 10, 1)
        now = model.blend([x[0] ** 2])
        wanted = cart_chain(x, u, np.zeros(0))
        np.testing.assert_allclose(now.A @ x + now.B @ u, wanted, atol=1e-9)


@pytest.mark.slow
def test_the_chain_of_six_carts_is_proved_and_settles() -> None:
    """And by equations that are written again, from the edge of the set."""
    plant = load_model("cart_chain")
    assert isinstance(plant, Plant)
    design = design_plant(plant)
    assert isinstance(design, PlantDesign)

    assert design.proved
    assert len(plant.states) == 12

    claim = next(c for c in design.document["claims"] if c["kind"] == "input-limits")
    P = np.array(claim["P"], dtype=float)
    inverse, law = np.linalg.inv(P), design.law
    assert law is not None
    start = np.sqrt(0.99 * claim["level"]) * inverse[0] / np.sqrt(inverse[0, 0])

    def slope(_: float, x: Floats) -> list[float]:
        u = law.command(x)
        assert abs(u[0]) <= 10
        return cart_chain(x, np.asarray(u), np.zeros(0))

    found = solve_ivp(slope, (0, 60), start, rtol=1e-7, atol=1e-9)
    assert np.abs(found.y[:, -1]).max() < 0.02 * np.abs(start).max()
    half = np.array([1.0, 2.0] * 6)
    assert np.all(np.abs(found.y).max(axis=1) <= half)
