"""Observers of what is not measured, and in discrete time: simulation, duality, eigenvalues."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import max_decay_rate, observer, observer_condition
from takagi.lmi.condition.evaluate import smallest_eigenvalues
from takagi.models import ModelError, TSModel

Floats = NDArray[np.float64]

# x1' = x2, x2' = -x1 - x2 + x2^3 / 3, x1 measured, |x2| and its estimate below 1.5.
REACH = 1.5
LINEAR = np.array([[0.0, 1.0], [-1.0, -1.0]])
OUTPUT = np.array([[1.0, 0.0]])


def cubic(x: Floats) -> Floats:
    """Return the part that depends on what is not measured."""
    return np.array([0.0, x[1] ** 3 / 3])


def derivative_hull() -> Floats:
    """0 <= d/dx2 (x2^3 / 3) <= REACH^2."""
    return np.asarray(LINEAR + np.array([np.zeros((2, 2)), [[0.0, 0.0], [0.0, REACH**2]]]))


def errors_along(
    right_side: Callable[[Floats], Floats], start: Floats, step: float, count: int
) -> Floats:
    """Return (count + 1, 4) states of plant and observer, by the classical Runge-Kutta rule."""
    states = [start]
    for _ in range(count):
        z = states[-1]
        k1 = right_side(z)
        k2 = right_side(z + step / 2 * k1)
        k3 = right_side(z + step / 2 * k2)
        k4 = right_side(z + step * k3)
        states.append(z + step / 6 * (k1 + 2 * k2 + 2 * k3 + k4))
    return np.array(states)


def test_the_error_of_a_nonlinear_observer_decays_as_promised() -> None:
    """V = e'Pe falls by e^(-2 alpha t) along simulated plant and observer, wherever both are."""
    alpha = 0.8
    model = TSModel(derivative_hull(), C=OUTPUT)
    L, P = observer(model, decay_rate=alpha, relaxation="common-gain").require()
    assert L.shape == (2, 2, 1)

    def right_side(z: Floats) -> Floats:
        x, xhat = z[:2], z[2:]
        innovation = L[0] @ OUTPUT @ (x - xhat)
        return np.concatenate([LINEAR @ x + cubic(x), LINEAR @ xhat + cubic(xhat) + innovation])

    step, rng, seen = 0.002, np.random.default_rng(0), 0
    for _ in range(6):
        states = errors_along(right_side, rng.uniform(-0.5, 0.5, 4), step, 1500)
        inside = np.abs(states[:, [1, 3]]).max(axis=1) < REACH
        e = states[:, :2] - states[:, 2:]
        V = np.einsum("ti,ij,tj->t", e, P, e)
        for (before, after), here in zip(pairwise(V), inside, strict=False):
            if here:
                assert after <= before * np.exp(-2 * alpha * step) * (1 + 1e-9) + 1e-20
                seen += 1
    assert seen > 5000


def test_discrete_error_of_every_blend() -> None:
    """V+ <= e^(-2 alpha T) V for A(h) - L(h) C at random h, with P as handed out."""
    step, alpha = 0.1, 0.7
    A = np.array([[[1.0, step], [-k * step, 1 - 0.5 * step]] for k in (0.5, 4.0)])
    model = TSModel(A, C=[[1.0, 0.0]], sample_time=step)
    design = observer(model, decay_rate=alpha)
    L, P = design.require()
    h = np.random.default_rng(0).dirichlet(np.ones(2), 100)
    error = np.tensordot(h, A, axes=1) - np.tensordot(h, L, axes=1) @ model.C[0]

    assert design.answer.decay_rate is not None and design.answer.decay_rate >= alpha
    for matrix in error:
        inside = matrix.T @ P @ matrix - np.exp(-2 * alpha * step) * P
        assert np.linalg.eigvalsh(inside)[-1] <= 1e-12 * np.abs(P).max()
    L, _ = observer(model, decay_rate=alpha, relaxation="common-gain").require()
    rate = max_decay_rate(A - L @ model.C, sample_time=step).decay_rate
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
    """With Q = P, M = (P L)' the builder's LMIs hold for secants; with L reversed they do not."""
    model = TSModel(derivative_hull(), C=OUTPUT)
    L, P = observer(model, decay_rate=0.5, relaxation="common-gain").require()
    condition = observer_condition(model, decay_rate=0.5, relaxation="common-gain")
    (rule,) = (lmi for lmi in condition.lmis if lmi.name == "rule")
    values = {"Q": P[None], "M": (P @ L[0]).T[None], "nu": np.ones((1, 1, 1))}

    assert rule.count == 2
    assert smallest_eigenvalues(condition, rule, values).min() > 0
    values["M"] = -values["M"]
    assert smallest_eigenvalues(condition, rule, values).min() < 0


def rotor_and_wind() -> TSModel:
    """Rotor speed driven by an unknown wind: e' = a e + d v, v' = 0, only the speed measured."""
    A = [[[a, d], [0.0, 0.0]] for a in (-0.5, -0.04) for d in (0.016, 0.034)]
    return TSModel(A, C=[[1.0, 0.0]], states=["rotor speed [rad/s]", "wind [m/s]"])


def test_every_blend_of_the_error_decays() -> None:
    """A(h) - L(h) C decays at the rate asked for, with the P that is handed out."""
    model = rotor_and_wind()
    design = observer(model, decay_rate=0.3)
    L, P = design.require()
    h = np.random.default_rng(0).dirichlet(np.ones(4), 100)
    error = np.tensordot(h, model.A, axes=1) - np.tensordot(h, L, axes=1) @ model.C[0]

    assert L.shape == (4, 2, 1)
    for matrix in error:
        inside = P @ matrix + matrix.T @ P + 0.6 * P
        assert np.linalg.eigvalsh(inside)[-1] <= 1e-12 * np.abs(inside).max()


def test_outputs_speak_of_outputs() -> None:
    """Errors of an observer name outputs and C, not inputs and B."""
    with pytest.raises(ModelError, match="needs at least one|no outputs"):
        observer(TSModel([[[-1.0]]], [[[1.0]]]))
    with pytest.raises(ModelError, match="output 1 of 1: its row of C is zero"):
        observer(TSModel([[[-1.0]]], C=[[0.0]]))
    with pytest.raises(ModelError, match="vertex 1 of 1: the mode at 1.* seen in no output"):
        observer(TSModel([[[1.0, 0.0], [0.0, 2.0]]], C=[[0.0, 1.0]]))
    slow = observer(TSModel([[[-1.0, 0.0], [0.0, 2.0]]], C=[[0.0, 1.0]]), decay_rate=3.0)
    assert "no output shows the mode at -1" in slow.answer.diagnosis
