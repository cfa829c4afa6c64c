"""Relaxations that know products of memberships, where the cost is what matters."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import lqr_pdc, structured_pdc
from takagi.models import Premise, TSModel

Floats = NDArray[np.float64]


@pytest.fixture
def model() -> TSModel:
    """Return four rules over two premises, the input of which depends on one of them."""
    corners = [(a, b) for a in (0.0, 1.0) for b in (0.0, 1.0)]
    return TSModel(
        [[[0.2 + 0.5 * a, 1.0], [0.3 * b, -0.1]] for a, b in corners],
        [[[0.2 * a], [1.0 + 0.4 * b]] for a, b in corners],
        premises=[Premise("a", 0, 1), Premise("b", 0, 1)],
    )


def spent(model: TSModel, K: Floats, P: Floats, z: Floats) -> float:
    """Return lambda_max of V' + x' x + u^2 at premises z."""
    h = model.memberships(z)
    gain = np.tensordot(h, K, axes=1)
    A, B = (np.tensordot(h, stack, axes=1) for stack in (model.A, model.B))
    moved = P @ (A - B @ gain)
    return float(np.linalg.eigvalsh(moved + moved.T + np.eye(2) + gain.T @ gain)[-1])


def test_a_cost_by_products_of_premises(model: TSModel) -> None:
    """The rules' products are known to the cost's LMIs, and the bound holds on the whole box."""
    product = lqr_pdc(model, np.eye(2), np.eye(1), relaxation="product")
    pairs = lqr_pdc(model, np.eye(2), np.eye(1), relaxation="wang-tanaka-griffin")
    assert product.cost is not None and pairs.cost is not None
    assert product.cost <= pairs.cost * (1 + 1e-5)
    K, P = product.require()
    grid = np.linspace(0.0, 1.0, 9)
    worst = max(spent(model, K, P, np.array([a, b])) for a in grid for b in grid)
    assert worst <= 1e-6 * np.linalg.norm(P)


@pytest.mark.slow
def test_structured_gains_by_products_of_premises(model: TSModel) -> None:
    found = structured_pdc(
        model,
        objective="cost",
        shared=["low", "low", "high", "high"],
        Q=np.eye(2),
        R=np.eye(1),
        relaxation="product",
        tolerance=1e-3,
    )
    K, P = found.require()
    assert np.array_equal(K[0], K[1]) and np.array_equal(K[2], K[3])
    assert found.value == pytest.approx(np.trace(P), rel=1e-9)
    assert spent(model, K, P, np.array([0.3, 0.8])) <= 1e-6 * np.linalg.norm(P)
