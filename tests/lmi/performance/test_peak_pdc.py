"""Peak-to-peak gain by compensation: a minimiser, trajectories under the worst w, cvxpy, limits."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from takagi.lmi import peak_gain, peak_pdc
from takagi.lmi.gains.disturbance import peak_gain as peak_gain_design
from takagi.models import ModelError, TSModel
from tests.lmi.compleib import SYSTEMS
from tests.lmi.norms import sampled
from tests.lmi.performance.disturbed import blends, gain_of, loop, three_rules, two_rules


@pytest.mark.parametrize("sample_time", [None, 0.1])
@pytest.mark.parametrize("through", [0.0, 0.4])
def test_one_state_against_a_search_over_its_gain(
    sample_time: float | None, through: float
) -> None:
    """x' = -0.7 x + u + w or x+ = 0.7 x + u + w, z = (x, u / 2): |x| <= 1 / (0.7 + k)."""
    a = -0.7 if sample_time is None else 0.7
    D11 = np.array([[through], [0.0]])
    model = TSModel([[[a]]], [[1.0]], E=[[1.0]], sample_time=sample_time)

    def peak(k: float) -> float:
        room = -(a - k) if sample_time is None else 1 - abs(a - k)
        return float(np.hypot(1.0, k / 2) / room)

    bounds = (-0.69, 60.0) if sample_time is None else (-0.29, 1.69)
    best: Any = minimize_scalar(peak, bounds=bounds, method="bounded")
    design = peak_pdc(model, performance=([[1.0], [0.0]], [[0.0], [0.5]], D11))
    assert gain_of(design) == pytest.approx(float(best.fun) + through, rel=1e-4)


@pytest.mark.parametrize("sample_time", [None, 0.1])
def test_the_loop_of_one_rule_has_the_peak_gain_of_its_design(sample_time: float | None) -> None:
    """The analysis of the loop agrees: it finds the same bound, or a slightly better rate."""
    plain = three_rules(sample_time)
    A, B, C, D, E = (part[:1] for part in (plain.A, plain.B, plain.C, plain.D, plain.E))
    model = TSModel(A, B, E=E, C=C, D=D, sample_time=sample_time)
    design = peak_pdc(model, tolerance=1e-3)
    answer = peak_gain(*loop(model, design.require()[0], np.ones(1)), sample_time=sample_time)
    assert answer.gain is not None

    assert 0.98 * gain_of(design) <= answer.gain <= gain_of(design) * (1 + 1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(("sample_time", "limit"), [(None, None), (None, 0.7), (0.1, 0.8)])
def test_nothing_leaves_the_ellipsoid(sample_time: float | None, limit: float | None) -> None:
    """From rest, switched at random, under the worst w of its peak: V, |z| and |u| keep bounds."""
    peak, step = 0.5, sample_time or 1e-3
    model, exact = two_rules(sample_time), two_rules(step)
    limits = None if limit is None else [limit]
    design = peak_pdc(model, disturbance_peak=peak, input_limit=limits, tolerance=0.01)
    K, P = design.require()
    rng, x = np.random.default_rng(1), np.zeros((2, 40))
    level, largest, effort = 0.0, 0.0, 0.0
    h = np.full(2, 0.5)
    for k in range(int(15 / step)):
        if k % max(1, int(0.4 / step)) == 0:
            h = rng.dirichlet(np.full(2, 0.3))
        A, B, C = loop(exact, K, h)
        z, u = C @ x, np.tensordot(h, K, 1) @ x
        x = A @ x
        # The worst w of each of the forty, or a random one in every second.
        worst = np.sign(B.T @ P @ x + (x == 0)[:1])
        w = np.where(np.arange(40) % 2 == 0, worst, rng.uniform(-1, 1, size=(1, 40)))
        x = x + peak * B * w
        level = max(level, float(np.einsum("in,ij,jn->n", x, P, x).max()))
        largest = max(largest, float(np.linalg.norm(z, axis=0).max()))
        effort = max(effort, float(np.abs(u).max()))

    assert 0.3 < level <= 1 + 1e-2 * (sample_time is None)
    assert 0.3 * gain_of(design) * peak < largest <= gain_of(design) * peak * 1.01
    if limit is not None:
        reach = [float(np.sqrt(k @ np.linalg.inv(P) @ k.T)[0, 0]) for k in K]
        assert effort <= max(reach) * 1.01
        assert max(reach) <= limit * (1 + 1e-6)


def test_input_limits_cost_and_may_be_too_tight() -> None:
    """A limit that is reached makes the peak grow, until at no rate there are gains: it says so."""
    model = two_rules()
    wide, tight, narrow = (
        gain_of(peak_pdc(model, disturbance_peak=0.5, input_limit=[limit], decay_rate=1.0))
        for limit in (10.0, 0.8, 0.7)
    )
    none = peak_pdc(model, disturbance_peak=0.5, input_limit=[0.6])
    no = peak_pdc(model, disturbance_peak=0.5, input_limit=[0.6], decay_rate=1.0)

    assert wide == pytest.approx(tight, rel=1e-4)
    assert narrow > 1.5 * wide
    assert none.status == "unknown" and none.gains is None and none.gain is None
    assert "at none of" in none.answer.diagnosis
    assert no.status == "infeasible" and no.gains is None
    assert "gains keep the limits without disturbance" in no.answer.diagnosis


def test_a_given_rate_holds_and_does_not_beat_the_one_found() -> None:
    model = two_rules()
    best = gain_of(peak_pdc(model))
    for rate in (0.5, 1.5, 4.0):
        design = peak_pdc(model, decay_rate=rate)
        poles = [np.linalg.eigvals(loop(model, design.require()[0], h)[0]) for h in blends(2, 5)]
        assert float(np.max(np.concatenate(poles).real)) < -rate
        assert gain_of(design) > best * (1 - 2e-3)
        assert design.decay_rate == rate


def test_held_disturbances_are_some_of_all() -> None:
    model = two_rules()
    design = peak_pdc(model, tolerance=0.01)
    K, P = design.require()
    for h in blends(2, 5):
        A, B, _ = loop(model, K, h)
        Ad, Bd = sampled(A, B, 0.05)
        edge = np.linalg.inv(np.linalg.cholesky(P)).T
        angles = np.linspace(0, 2 * np.pi, 181)
        x = Ad @ edge @ np.array([np.cos(angles), np.sin(angles)])
        for w in (-1.0, 1.0):
            after = x + Bd * w
            assert np.einsum("in,ij,jn->n", after, P, after).max() <= 1 + 1e-9


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"decay_rate": 0.0}, "decay_rate is 0 1/s; it must be positive"),
        ({"disturbance_peak": 0.0}, "disturbance_peak is 0; it must be positive"),
        ({"relaxation": "none"}, "relaxation 'none' is not known"),
        ({"input_limit": [1.0, 2.0]}, r"input_limit has shape \(2,\)"),
        ({"performance": ([[1.0]],)}, r"C1 has shape \(1, 1\)"),
    ],
)
def test_misuse_is_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        peak_pdc(two_rules(), **arguments)


def test_no_limits_are_named_where_none_were_given(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(peak_gain_design._Search, "best", lambda search: None)

    assert "limits" not in peak_pdc(two_rules()).answer.diagnosis
    limited = peak_pdc(two_rules(), input_limit=[5.0], initial_box=[0.01, 0.01])
    assert "widen the limits" in limited.answer.diagnosis


@pytest.mark.parametrize(("name", "most"), [("HE1", 0.085), ("MFP", 4.81), ("REA1", 0.628)])
def test_a_search_goes_on_from_where_the_gain_was_least(name: str, most: float) -> None:
    """From what another rate left, HE1 had no gains near the least bound, and others far more."""
    plant = SYSTEMS[name]()
    design = peak_pdc(
        TSModel([plant.A], [plant.B], E=[plant.B1]), performance=(plant.C1, plant.D12)
    )

    assert gain_of(design) < most


def test_a_bound_that_ever_larger_gains_approach() -> None:
    """NN17 of COMPleib: P on the way is indefinite to rounding, which ended in an error.

    Nearer to 0.2427 gains are larger, up to those that are too large to be told.
    """
    A, B = [[0, -1, 2], [1, -2, 3], [0, 1, 0]], [[1, 0], [0, 0], [0, -1]]
    model = TSModel(np.array([A], float), np.array([B], float), E=[[[1.0], [-1.0], [0.0]]])
    output = (np.array([[1.0, 0.0, 1.0]] * 2), np.array([[0.0, 1.0], [0.0, 0.0]]))
    design = peak_pdc(model, performance=output)

    assert 0.24 < gain_of(design) < 0.3
