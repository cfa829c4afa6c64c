"""Rules as combinations of corners of premises."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from takagi.lmi import (
    DoubleSum,
    Unknown,
    double_sum_of,
    pdc,
    relaxation_named,
    relaxation_size,
)
from takagi.models import ModelError, Premise, TSModel
from tests.lmi.sums.known import (
    bound,
    combinations_of,
    largest,
    memberships,
    product_memberships,
    random_theta,
)

Floats = NDArray[np.float64]
# Of the random models one with gains by products of corner weights, and none by pairs of rules.
SEED = 31


@settings(max_examples=12)
@given(st.integers(0, 10_000))
def test_sampled_values_stay_below_every_bound(seed: int) -> None:
    """Rules over two premises: higher degrees bound closer, pairs worst."""
    corners = combinations_of(2, 3)
    theta = random_theta(seed, 6, 1)
    weights = [memberships(seed + place, side, 3000) for place, side in enumerate((2, 3))]
    count = min(map(len, weights))
    reached = largest(theta, product_memberships(corners, [known[:count] for known in weights]))
    found = [bound(theta, name, corners=corners) for name in ("product", "product-1", "product-4")]

    assert all(reached <= value + 1e-9 for value in found)
    pairs = bound(theta, "wang-tanaka-griffin")
    assert found[2] <= found[1] + 2e-3 <= found[0] + 4e-3 <= pairs + 6e-3
    assert relaxation_size("product", 6, corners).lmis == 3 * 6
    assert relaxation_size("product-2", 6, corners).lmis == 5 * 15


def model_of_two_premises(seed: int, spread: float) -> TSModel:
    """Return two states, one input, four rules over two premises."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((2, 2)) + spread * rng.standard_normal((4, 2, 2))
    B = rng.standard_normal((2, 1)) + spread * rng.standard_normal((4, 2, 1))
    return TSModel(A, B, premises=[Premise("z1", 0, 1), Premise("z2", -1, 1)])


def rates(model: TSModel, K: Floats, P: Floats, h: Floats) -> Floats:
    """Return -1/2 lambda_max(P^-1 He(P (A(h) - B(h) K(h))))."""
    A, B, K = (np.tensordot(h, part, axes=1) for part in (model.A, model.B, K))
    L = np.linalg.cholesky(P)
    inside = np.linalg.solve(L, (A - B @ K).transpose(0, 2, 1) @ L)
    return np.asarray(-np.linalg.eigvalsh(inside + inside.transpose(0, 2, 1))[:, -1] / 2)


def test_products_find_gains_where_pairs_do_not() -> None:
    """The gains decay at all product memberships; Liu and Zhang's pairs find none."""
    model = model_of_two_premises(SEED, 0.7)
    K, P = pdc(model, relaxation="product").require()
    z = np.random.default_rng(0).uniform([[0.0], [-1.0]], [[1.0], [1.0]], (2, 4000))
    h = model.memberships(z).T

    assert rates(model, K, P, h).min() > 0
    for pairs in ("liu-zhang", "wang-tanaka-griffin"):
        assert not pdc(model, relaxation=pairs).found


@pytest.mark.parametrize(
    ("corners", "message"),
    [
        ([[0, 0], [0, 1], [1, 0]], "3 rules, 3 of them different.*for 4 combinations"),
        ([[0], [0]], "2 rules, 1 of them different"),
        ([[1], [2]], "2 of them different, least index 1, for 3"),
        ([[0.5], [1.0]], "integers"),
        ([0, 1], r"\(rules, premises\) are needed"),
    ],
)
def test_corners_that_are_no_combinations(corners: list[list[int]], message: str) -> None:
    """Memberships that would not sum to 1 are refused, with what is missing."""
    with pytest.raises(ModelError, match=message):
        DoubleSum(rules=len(corners), blocks=(1,), parts=(), corners=np.array(corners))


def test_double_sums_that_do_not_fit() -> None:
    """Corners for another number of rules, products of what is none, members."""
    with pytest.raises(ModelError, match="corners: 4 rules, but there are 3"):
        DoubleSum(rules=3, blocks=(1,), parts=(), corners=combinations_of(2, 2))
    with pytest.raises(ModelError, match="knows of none; give the model premises"):
        relaxation_named("product")(DoubleSum(rules=6, blocks=(1,), parts=()))
    M = Unknown("M", 1, 1, count=2)
    with pytest.raises(ModelError, match="the part with M is for 1 x 2 rules, but there are 3"):
        double_sum_of(M.over("j") << 0, rules=3)
