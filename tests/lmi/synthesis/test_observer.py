"""Observers of what is not measured, and in discrete time: simulation, duality, eigenvalues."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.lmi import max_decay_rate, observer, observer_condition
from takagi.lmi.condition.evaluate import smallest_eigenvalues
from takagi.models import TSModel


def error_system(step: float | None) -> TSModel:
    """Rotor speed e' = a e + d v driven by an unknown wind, v' = 0; or a sampled oscillator."""
    if step is None:
        A = [[[a, d], [0.0, 0.0]] for a in (-0.5, -0.04) for d in (0.016, 0.034)]
    else:
        A = [[[1.0, step], [-k * step, 1 - 0.5 * step]] for k in (0.5, 4.0)]
    return TSModel(A, C=[[1.0, 0.0]], sample_time=step)


@pytest.mark.parametrize(("step", "alpha"), [(None, 0.3), (0.1, 0.7)])
def test_every_blend_of_the_error_decays(step: float | None, alpha: float) -> None:
    model = error_system(step)
    design = observer(model, decay_rate=alpha)
    L, P = design.require()
    h = np.random.default_rng(0).dirichlet(np.ones(len(L)), 100)
    error = np.tensordot(h, model.A, axes=1) - np.tensordot(h, L, axes=1) @ model.C[0]

    assert L.shape == (len(model.A), 2, 1)
    assert design.answer.decay_rate is not None and design.answer.decay_rate >= alpha
    for matrix in error:
        if step is None:
            inside = P @ matrix + matrix.T @ P + 2 * alpha * P
        else:
            inside = matrix.T @ P @ matrix - np.exp(-2 * alpha * step) * P
        assert np.linalg.eigvalsh(inside)[-1] <= 1e-12 * np.abs(P).max()
    L, _ = observer(model, decay_rate=alpha, relaxation="common-gain").require()
    rate = max_decay_rate(model.A - L @ model.C, sample_time=step).decay_rate
    assert rate is not None and rate >= alpha


def test_one_state_from_both_sides() -> None:
    """x+ = 2 x, y = x: |2 - L| <= e^(-alpha T); an error that no output shows keeps its |z|."""
    model = TSModel([[[2.0]]], C=[[1.0]], sample_time=0.5)
    L, _ = observer(model, decay_rate=1.0).require()
    assert abs(2.0 - L[0, 0, 0]) <= np.exp(-0.5)

    unseen = TSModel([np.diag([0.9, 2.0])], C=[[0.0, 1.0]], sample_time=0.5)
    slowest = -np.log(0.9) / 0.5
    assert observer(unseen, decay_rate=slowest * 0.9).status == "candidate"
    no = observer(unseen, decay_rate=slowest * 1.1)
    assert no.status == "infeasible"
    assert "no output shows the mode at 0.9" in no.answer.diagnosis


def test_the_condition_is_what_the_gain_satisfies() -> None:
    """x1' = x2, x2' = -x1 - x2 + x2^3 / 3, x1 measured: 0 <= d/dx2 (x2^3 / 3) <= 1.5^2."""
    A = np.array([[[0.0, 1.0], [-1.0, -1.0 + slope]] for slope in (0.0, 1.5**2)])
    model = TSModel(A, C=[[1.0, 0.0]])
    L, P = observer(model, decay_rate=0.5, relaxation="common-gain").require()
    condition = observer_condition(model, decay_rate=0.5, relaxation="common-gain")
    (rule,) = (lmi for lmi in condition.lmis if lmi.name == "rule")
    values = {"Q": P[None], "M": (P @ L[0]).T[None], "nu": np.ones((1, 1, 1))}

    assert rule.count == 2
    assert smallest_eigenvalues(condition, rule, values).min() > 0
    values["M"] = -values["M"]
    assert smallest_eigenvalues(condition, rule, values).min() < 0
