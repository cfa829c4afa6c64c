"""How fast inputs move on an ellipsoid: bounds against random states, memberships and rates."""

from __future__ import annotations

from itertools import combinations_with_replacement, permutations

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import input_rate_bound
from takagi.lmi.analysis.actuator_rates import input_rate_rows, velocity_corners
from takagi.models import ModelError, TSModel

Floats = NDArray[np.float64]


def loop(rules: int, seed: int = 0) -> tuple[TSModel, Floats, Floats]:
    """Return a model with two inputs, gains of each rule, and a P."""
    rng = np.random.default_rng(seed)
    model = TSModel(rng.standard_normal((rules, 3, 3)), rng.standard_normal((rules, 3, 2)))
    root = rng.standard_normal((3, 3))
    return model, rng.standard_normal((rules, 2, 3)), root @ root.T + np.eye(3)


def on_the_boundary(P: Floats, count: int, seed: int = 1) -> Floats:
    """Return random x with x' P x = 1."""
    x = np.random.default_rng(seed).standard_normal((count, len(P)))
    return np.asarray(x / np.sqrt(np.einsum("ki,ij,kj->k", x, P, x))[:, None])


def rates_that_sum_to_zero(phi: Floats, count: int, seed: int = 2) -> Floats:
    """Return random blends of the corners of the rates, and the corners themselves."""
    corners = velocity_corners(phi)
    weights = np.random.default_rng(seed).dirichlet(0.1 * np.ones(len(corners)), count)
    return np.concatenate([weights @ corners, corners])


@pytest.mark.parametrize("rules", [1, 2, 3])
def test_no_trajectory_moves_its_input_faster(rules: int) -> None:
    """|u'| of the definition, at random x, h and h', is below the bound, and often near it."""
    model, K, P = loop(rules)
    phi = np.array([0.5, 1.5, 1.0])[:rules]
    bound = input_rate_bound(model, K, P, rate_bounds=phi)
    rng = np.random.default_rng(5)
    x, rates = on_the_boundary(P, 4000), rates_that_sum_to_zero(phi, 4000)[:4000]
    h = np.concatenate([rng.dirichlet(0.3 * np.ones(rules), 4000 - rules), np.eye(rules)])
    count = min(len(x), len(rates))
    A, B, k = (np.tensordot(h[-count:], part, 1) for part in (model.A, model.B, K))
    moved = np.einsum("tnm,tm->tn", A - B @ k, x[:count])
    u_rate = -np.einsum("tmn,tn->tm", k, moved)
    u_rate -= np.einsum("tmn,tn->tm", np.tensordot(rates[:count], K, 1), x[:count])

    assert np.all(np.abs(u_rate).max(axis=0) <= bound)
    assert np.all(bound > 0)


@pytest.mark.parametrize("rules", [2, 3, 4])
def test_the_rows_blend_to_the_rate_of_the_law(rules: int) -> None:
    """K(h) (A(h) - B(h) K(h)) is the sum over multisets of their products' share and mean."""
    model, K, _ = loop(rules)
    h = np.random.default_rng(9).dirichlet(np.ones(rules))
    A, B, gain = (np.tensordot(h, part, 1) for part in (model.A, model.B, K))
    chosen = list(combinations_with_replacement(range(rules), 3))
    weights = [len(set(permutations(one))) * np.prod(h[list(one)]) for one in chosen]
    rows = input_rate_rows(model.A, model.B, K)
    jumps = input_rate_rows(model.A, model.B, K, discrete=True).reshape(rules, -1, 2, 3)
    i, j = np.triu_indices(rules)
    both = np.where(i == j, 1, 2) * h[i] * h[j]
    after = np.random.default_rng(8).dirichlet(np.ones(rules))

    assert sum(weights) == pytest.approx(1)
    np.testing.assert_allclose(np.tensordot(weights, rows, 1), gain @ (A - B @ gain))
    np.testing.assert_allclose(
        np.einsum("l,p,lpmn->mn", after, both, jumps),
        np.tensordot(after, K, 1) @ (A - B @ gain) - gain,
    )


def test_one_gain_of_one_rule_is_exact() -> None:
    """max |K (A - B K) x| on x' P x = 1 is the length of that row in the norm of P^-1."""
    model, K, P = loop(1)
    row = (K @ (model.A - model.B @ K))[0]
    exact = np.sqrt(np.diag(row @ np.linalg.inv(P) @ row.T))

    np.testing.assert_allclose(input_rate_bound(model, K, P), exact)
    worst = np.linalg.inv(P) @ row[0] / exact[0]
    assert worst @ P @ worst == pytest.approx(1)
    assert abs(row[0] @ worst) == pytest.approx(exact[0])


def test_the_bound_grows_with_the_level() -> None:
    model, K, P = loop(2)
    small = input_rate_bound(model, K, 4 * P, rate_bounds=1.0)

    np.testing.assert_allclose(2 * small, input_rate_bound(model, K, P, rate_bounds=1.0))


def test_jumping_memberships_in_discrete_time() -> None:
    """|u(x+) - u(x)| for any next membership, from its definition."""
    model, K, P = loop(3)
    model = TSModel(model.A, model.B, sample_time=0.1)
    bound = input_rate_bound(model, K, P)
    rng = np.random.default_rng(4)
    x = on_the_boundary(P, 4000)
    h, after = rng.dirichlet(0.2 * np.ones(3), (2, 4000))
    A, B, k = (np.tensordot(h, part, 1) for part in (model.A, model.B, K))
    moved = np.einsum("tij,tj->ti", A - B @ k, x)
    change = np.einsum("tmn,tn->tm", np.tensordot(after, K, 1), moved)
    change -= np.einsum("tmn,tn->tm", k, x)

    assert np.all(np.abs(change).max(axis=0) <= bound)
    assert np.all(np.abs(change).max(axis=0) > 0.5 * bound)


def test_many_rules_are_bounded_without_their_corners() -> None:
    """Beyond twelve rules the corners of the rates are not listed: a little looser, still above."""
    phi = np.full(13, 0.3)
    model, K, P = loop(13)
    bound = input_rate_bound(TSModel(model.A * 0, model.B * 1e-6), K, P, rate_bounds=phi)
    rng = np.random.default_rng(0)
    rates = rng.choice([-0.3, 0.3], (3000, 13))
    rates[:, -1] = -rates[:, :-1].sum(axis=1)
    rates = rates[np.abs(rates[:, -1]) <= 0.3 + 1e-12]
    u = np.einsum("trn,tn->tr", np.tensordot(rates, K, 1), on_the_boundary(P, len(rates)))

    assert len(rates) > 100
    assert np.all(np.abs(u).max(axis=0) <= bound)


def test_corners_of_the_rates_are_all_there() -> None:
    """|d_1| <= 1, |d_2| <= 2, |d_3| <= 0.5, sum 0: a hexagon with these corners."""
    corners = {tuple(corner) for corner in velocity_corners(np.array([1.0, 2.0, 0.5])).tolist()}

    assert corners == {
        (1.0, -1.5, 0.5), (1.0, -0.5, -0.5), (-1.0, 1.5, -0.5), (-1.0, 0.5, 0.5),
    }  # fmt: skip


def test_what_is_missing_or_too_much_is_refused() -> None:
    model, K, P = loop(2)
    with pytest.raises(ModelError, match="give rate_bounds"):
        input_rate_bound(model, K, P)
    with pytest.raises(ModelError, match="leave them out"):
        input_rate_bound(TSModel(model.A, model.B, sample_time=1.0), K, P, rate_bounds=1.0)
    with pytest.raises(ModelError, match="not negative"):
        input_rate_bound(model, K, P, rate_bounds=[-1.0, 1.0])
    with pytest.raises(ModelError, match="positive definite"):
        input_rate_bound(model, K, -P, rate_bounds=1.0)
    np.testing.assert_allclose(input_rate_bound(model, K[0], P), input_rate_bound(model, K[:1], P))
