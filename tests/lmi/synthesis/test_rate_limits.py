"""Limits on how fast the inputs move: designs simulated from the boundary of their ellipsoid."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import pdc, with_input_states
from takagi.models import ModelError, TSModel
from tests.lmi.synthesis.placed import pendulum

Floats = NDArray[np.float64]


def test_inputs_as_states_limit_amplitude_and_rate_exactly() -> None:
    """pdc of the extended model: |u| by the state box, |u'| by the input limit, simulated."""
    model = TSModel(pendulum().A, pendulum().B, states=("angle [rad]", "rate [rad/s]"))
    extended = with_input_states(model)
    design = pdc(
        extended,
        decay_rate=0.2,
        input_limit=[200.0],
        initial_box=[0.05, 0.1, 1.0],
        state_box=[1.0, np.inf, 8.0],
    )
    K, P = design.require()
    rng = np.random.default_rng(0)
    x = np.linalg.solve(np.linalg.cholesky(P).T, rng.standard_normal((3, 200)))
    x = (x / np.sqrt(np.einsum("ik,ij,jk->k", x, P, x))).T
    most_u, most_rate, dt = 0.0, 0.0, 1e-3
    for _ in range(1500):
        h = rng.dirichlet([0.5, 0.5])
        A, B, k = (np.tensordot(h, part, 1) for part in (extended.A, extended.B, K))
        most_u = max(most_u, float(np.abs(x[:, 2]).max()))
        most_rate = max(most_rate, float(np.abs(x @ k.T).max()))
        x = x + dt * (x @ (A - B @ k).T)

    assert most_u <= 8.0 and most_rate <= 200.0
    assert np.einsum("ki,ij,kj->k", x, P, x).max() < 0.9


def test_the_extended_model_is_the_old_one_with_an_integrator() -> None:
    """Names, outputs and disturbances go along; u moves by v, in discrete time at once."""
    rng = np.random.default_rng(1)
    parts = {"C": rng.standard_normal((2, 1, 2)), "D": rng.standard_normal((2, 1, 1))}
    model = TSModel(
        rng.standard_normal((2, 2, 2)),
        rng.standard_normal((2, 2, 1)),
        E=rng.standard_normal((2, 2, 1)),
        inputs=["torque [N m]"],
        **parts,  # type: ignore[arg-type]
    )
    extended = with_input_states(model)
    sampled = with_input_states(
        TSModel(model.A, model.B, C=model.C, D=model.D, inputs=model.inputs, sample_time=0.1)
    )
    x, u, v = rng.standard_normal(2), rng.standard_normal(1), rng.standard_normal(1)
    whole = np.concatenate([x, u])

    assert extended.inputs == ("rate of torque [N m/s]",)
    assert extended.states[-1] == "torque [N m]"
    np.testing.assert_allclose(
        extended.A[0] @ whole + extended.B[0] @ v,
        np.concatenate([model.A[0] @ x + model.B[0] @ u, v]),
    )
    np.testing.assert_allclose(extended.C[1] @ whole, model.C[1] @ x + model.D[1] @ u)
    np.testing.assert_allclose(extended.E[0][:2], model.E[0])
    np.testing.assert_allclose(
        sampled.A[0] @ whole + sampled.B[0] @ v,
        np.concatenate([model.A[0] @ x + model.B[0] @ (u + v), u + v]),
    )
    np.testing.assert_allclose(
        sampled.C[0] @ whole + sampled.D[0] @ v, model.C[0] @ x + model.D[0] @ (u + v)
    )
    assert sampled.inputs == ("change of torque [N m]",)
    assert with_input_states(pendulum()).inputs == ("rate of u1 [1/s]",)


def test_a_model_without_inputs_is_refused() -> None:
    with pytest.raises(ModelError, match="no inputs"):
        with_input_states(TSModel([[[1.0]]]))
