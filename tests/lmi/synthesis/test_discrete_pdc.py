"""Gains for x+ = A x + B u: published problems, closed forms, Riccati, blends step by step."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm, solve_discrete_are

from takagi.lmi import Design, pdc, pdc_condition
from takagi.lmi.condition.evaluate import margin
from takagi.models import ModelError, TSModel
from tests.lmi.known_models import truck_trailer


def sampled_pendulum(step: float) -> TSModel:
    vertices = []
    for gravity, authority in ((17.3, -0.177), (9.4, -0.1)):
        inside = np.array([[0.0, 1.0, 0.0], [gravity, 0.0, authority], [0.0, 0.0, 0.0]])
        vertices.append(expm(inside * step)[:2])
    return TSModel([v[:, :2] for v in vertices], [v[:, 2:] for v in vertices], sample_time=step)


def random_model(seed: int, rules: int = 3) -> TSModel:
    rng = np.random.default_rng(seed)
    A = 0.8 * rng.standard_normal((2, 2)) + 0.4 * rng.standard_normal((rules, 2, 2))
    B = rng.standard_normal((2, 1)) + 0.4 * rng.standard_normal((rules, 2, 1))
    return TSModel(A, B, sample_time=0.5)


def worst_contraction(model: TSModel, design: Design) -> float:
    K, P = design.require()
    h = np.random.default_rng(0).dirichlet(np.ones(len(model.A)), 200)
    h = np.concatenate([h, np.eye(len(model.A))])
    A, B, K = (np.tensordot(h, part, axes=1) for part in (model.A, model.B, K))
    L = np.linalg.cholesky(P)
    moved = np.linalg.solve(L, (A - B @ K).transpose(0, 2, 1) @ L)
    return float(np.linalg.norm(moved, 2, axis=(1, 2)).max() ** 2)


def rate(contraction: float, step: float) -> float:
    return float(-np.log(contraction) / step)


def test_truck_trailer_from_both_sides() -> None:
    """Tanaka and Sano (1994): with free gains the least contraction lies in [0.99367, 0.99369]."""
    reached = pdc(truck_trailer(), decay_rate=rate(0.9937, 2.0))
    beyond = pdc(truck_trailer(), decay_rate=rate(0.9936, 2.0))

    assert worst_contraction(truck_trailer(), reached) <= 0.9937**2
    assert beyond.status == "infeasible" and beyond.gains is None


def test_truck_trailer_gains_of_four_digits_are_refused() -> None:
    """Tanaka and Sano (1994) as recalled to four digits: V rises at the second rule."""
    F = np.array([[[1.2837, -0.4139, 0.0201]], [[0.9773, -0.0709, 0.0005]]])
    P = np.array([[113.9, -92.61, 2.54], [-92.61, 110.7, -3.038], [2.54, -3.038, 0.5503]])
    G = truck_trailer().A[1] + truck_trailer().B[1] @ F[1]
    condition = pdc_condition(truck_trailer())
    Q = np.linalg.inv(P) / np.linalg.eigvalsh(np.linalg.inv(P))[-1]

    assert np.linalg.eigvalsh(G.T @ P @ G - P)[-1] == pytest.approx(0.0104, abs=1e-4)
    assert margin(condition, {"Q": Q[None], "M": -F @ Q, "nu": np.array([[[1e4]]])}) < 0


@pytest.mark.parametrize("contraction", [0.9, 0.3])
def test_a_scalar_needs_exactly_the_gain_that_its_rate_asks(contraction: float) -> None:
    """x+ = 1.5 x + 2 u contracts by c with |K| = (1.5 - c) / 2 and not with less."""
    model = TSModel([[[1.5]]], [[[2.0]]], sample_time=0.1)
    needed, alpha = (1.5 - contraction) / 2, rate(contraction, 0.1)

    assert pdc(model, decay_rate=alpha, gain_bound=1.001 * needed).found
    assert pdc(model, decay_rate=alpha, gain_bound=0.999 * needed).status == "infeasible"


def test_the_largest_rate_of_a_scalar_is_that_of_its_largest_gain() -> None:
    """x+ = 1.5 x + 2 u with |K| <= 0.5 contracts by 0.5 at best."""
    design = pdc(TSModel([[[1.5]]], [[[2.0]]], sample_time=0.1), decay_rate="max", gain_bound=0.5)

    assert design.decay_rate == pytest.approx(rate(0.5, 0.1), rel=2e-4)
    assert design.decay_rate < rate(0.5, 0.1) <= design.answer.bound * (1 + 1e-6)
    assert np.abs(design.require()[0]).max() <= 0.5


def test_a_scalar_that_one_step_can_stop_has_no_largest_rate() -> None:
    """x+ = 1.5 x + 2 u is at rest after one step with K = 0.75; the search ends, and says so."""
    design = pdc(TSModel([[[1.5]]], [[[2.0]]], sample_time=0.1), decay_rate="max", gain_bound=1.0)

    assert design.decay_rate > rate(1e-3, 0.1)
    assert design.answer.bound == np.inf
    np.testing.assert_allclose(design.require()[0], 0.75, atol=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_one_rule_accepts_the_discrete_riccati_solution(seed: int) -> None:
    """For (A / rho, B) the Riccati solution P, K satisfies the condition; -K does not."""
    rng = np.random.default_rng(seed)
    A, B = 1.2 * rng.standard_normal((3, 3)), rng.standard_normal((3, 2))
    rho, step = 0.8, 0.2
    P = solve_discrete_are(A / rho, B, np.eye(3), np.eye(2))
    K = rho * np.linalg.solve(np.eye(2) + B.T @ P @ B, B.T @ P @ A / rho)
    Q = np.linalg.inv(P)
    Q /= np.linalg.eigvalsh(Q)[-1]
    model = TSModel([A], [B], sample_time=step)
    condition = pdc_condition(model, decay_rate=rate(rho, step))
    values = {"Q": Q[None], "M": (K @ Q)[None], "nu": np.array([[[1e6]]])}

    assert margin(condition, values) > 0
    assert margin(condition, {**values, "M": -values["M"]}) < 0
    design = pdc(model, decay_rate=rate(rho, step))
    assert np.abs(np.linalg.eigvals(A - B @ design.require()[0][0])).max() <= rho


@pytest.mark.filterwarnings("ignore::takagi.lmi.ZeroGainsWarning")
@settings(max_examples=15)
@given(st.integers(0, 10_000), st.sampled_from(["wang-tanaka-griffin", "tuan", "liu-zhang"]))
def test_every_blend_contracts_as_asked(seed: int, relaxation: str) -> None:
    """V(x+) <= e^(-2 alpha T) V(x) for memberships that were never given to the solver."""
    model = random_model(seed)
    design = pdc(model, decay_rate=0.1, relaxation=relaxation)

    if design.found:
        assert worst_contraction(model, design) <= np.exp(-2 * 0.1 * 0.5)
        shown = design.answer.decay_rate
        assert shown is not None and worst_contraction(model, design) <= np.exp(-shown) * (1 + 1e-9)
        assert shown >= design.decay_rate == 0.1


@pytest.mark.parametrize("step", [1e-2, 1e-3, 1e-4])
def test_fine_sampling_tends_to_continuous_time(step: float) -> None:
    """The largest rate with |K| <= 300 differs from that of continuous time by the order of T."""
    continuous = TSModel(
        [[[0.0, 1.0], [17.3, 0.0]], [[0.0, 1.0], [9.4, 0.0]]], [[[0.0], [-0.177]], [[0.0], [-0.1]]]
    )
    limit = pdc(continuous, decay_rate="max", gain_bound=300.0).decay_rate
    found = pdc(sampled_pendulum(step), decay_rate="max", gain_bound=300.0).decay_rate

    assert found == pytest.approx(limit, rel=max(5 * step, 1e-3))


def test_a_mode_out_of_reach_limits_the_rate() -> None:
    """A mode at 0.9 that no input moves decays at -ln 0.9 / T; one at 1.1 is refused by name."""
    model = TSModel([np.diag([0.9, 1.2])], [[[0.0], [1.0]]], sample_time=0.1)
    limit = rate(0.9, 0.1)

    assert pdc(model, decay_rate=0.99 * limit).found
    no = pdc(model, decay_rate=1.01 * limit)
    assert no.status == "infeasible" and f"below {limit:.6g} 1/s" in no.answer.diagnosis
    with pytest.raises(ModelError, match=r"mode at 1.1.* not inside the unit circle"):
        pdc(TSModel([np.diag([1.1, 1.2])], [[[0.0], [1.0]]], sample_time=0.1))
