"""A ball of initial states: closed forms from both sides, an independent optimum, units."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import He, Unknown, block, hinf_pdc, optimise, pdc, pose, with_input_states
from takagi.models import ModelError, TSModel
from tests.lmi.synthesis.placed import pendulum


def balance(a: float = 2.0) -> TSModel:
    """x' = a x + u."""
    return TSModel([[[a]]], [[[1.0]]])


def two_rules() -> TSModel:
    """Two rules of a pole on a cart, as the guide has them, in units of order one."""
    A = np.array([[[0, 1], [17.29, 0]], [[0, 1], [9.35, 0]]])
    return TSModel(A, np.array([[[0], [1.0]], [[0], [0.8]]]))


def largest_radius(model: TSModel, limit: float) -> float:
    """The largest ball by LMIs written anew: Q >= t I, u_max^2 and M_i, all pairs; t = radius^2."""
    n, m = model.B.shape[1:]
    Q, M = Unknown("Q", n, n, symmetric=True), Unknown("M", m, n, count=2)
    t = Unknown("t", 1, 1)
    A, B = model.A, model.B
    loop = [[A[i] @ Q - B[i] @ M.member(j) for j in range(2)] for i in range(2)]
    condition = pose(
        *(He(loop[i][i]) << 0 for i in range(2)),
        He(loop[0][1] + loop[1][0]) << 0,
        *(block([[limit**2 * np.eye(m), M.member(i)], [None, Q]]) >= 0 for i in range(2)),
        Q >= t * np.eye(n),
        minimise=-t,
    )
    return float(np.sqrt(-optimise(condition).objective))


@pytest.mark.parametrize(("radius", "status"), [(0.49, "candidate"), (0.51, "infeasible")])
def test_a_scalar_plant_holds_a_ball_up_to_limit_over_pole(radius: float, status: str) -> None:
    """x' = 2 x + u with |u| <= 1: k > 2 and k radius <= 1, so radius < 1/2 exactly."""
    design = pdc(balance(), input_limit=[1.0], initial_ball=radius)

    assert design.status == status
    if design.found:
        gains, P = design.require()
        assert P[0, 0] * radius**2 <= 1 and abs(gains[0, 0, 0]) / np.sqrt(P[0, 0]) <= 1


@pytest.mark.parametrize("factor", [0.98, 1.02])
def test_both_sides_of_the_largest_ball_of_an_independent_optimum(factor: float) -> None:
    """Tanaka and Wang (2001), section 3.4.1: phi^2 I <= X; the largest phi by other LMIs."""
    model = two_rules()
    radius = factor * largest_radius(model, 5.0)

    design = pdc(model, input_limit=[5.0], initial_ball=radius)

    assert design.found is (factor < 1)


def test_the_ball_lies_inside_the_ellipsoid_and_the_input_keeps_its_limit_there() -> None:
    """The largest eigenvalue of P is 1 / radius^2 at most; a much larger ball is not inside."""
    design = pdc(two_rules(), decay_rate=0.5, input_limit=[60.0], initial_ball=0.4)
    K, P = design.require()

    assert np.linalg.eigvalsh(P)[-1] <= 1 / 0.4**2
    assert max(np.sqrt(k @ np.linalg.inv(P) @ k) for k in K[:, 0]) <= 60.0
    # Of all sets with these limits the one of least effort is not much larger than the ball.
    assert np.linalg.eigvalsh(P)[-1] > 1 / 4.0**2


def test_a_ball_asks_less_than_the_box_around_it() -> None:
    """Corners of the box are sqrt(2) radii away: a limit between the two has gains for the ball."""
    model = two_rules()
    radius = 0.9 * largest_radius(model, 5.0)

    ball = pdc(model, input_limit=[5.0], initial_ball=radius)
    box = pdc(model, input_limit=[5.0], initial_box=[radius, radius])

    assert (ball.status, box.status) == ("candidate", "infeasible")


def test_semi_axes_are_a_ball_in_other_units() -> None:
    """The same plant with its rate in mrad/s: the ball becomes an ellipsoid, the answer stays."""
    model, T = two_rules(), np.diag([1.0, 1000.0])
    other = TSModel(T @ model.A @ np.linalg.inv(T), T @ model.B)
    limit = largest_radius(model, 5.0)

    for factor in (0.98, 1.02):
        axes = [factor * limit, 1000.0 * factor * limit]
        assert pdc(other, input_limit=[5.0], initial_ball=axes).found is (factor < 1)


def test_the_largest_decay_rate_is_bounded_by_a_ball_too() -> None:
    """x' = 2 x + u, |u| <= 1 from |x| <= 0.25: k <= 4, so the largest rate is 2 1/s."""
    design = pdc(balance(), decay_rate="max", input_limit=[1.0], initial_ball=0.25)

    assert design.decay_rate == pytest.approx(2.0, rel=1e-3)


def test_disturbances_take_a_ball_too() -> None:
    """The set of ``hinf_pdc`` holds the ball, and its limit on the input."""
    model = TSModel([[[2.0]]], [[[1.0]]], C=[[1.0]], E=[[1.0]])

    design = hinf_pdc(model, input_limit=[1.0], initial_ball=0.3, disturbance_energy=1e-3)

    K, P = design.require()
    assert P[0, 0] * 0.3**2 <= 1 and abs(K[0, 0, 0]) / np.sqrt(P[0, 0]) <= 1


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"initial_ball": -1.0}, "initial_ball"),
        ({"initial_ball": [1.0, 2.0, 3.0]}, r"initial_ball has shape \(3,\)"),
        ({"initial_ball": 2.0, "state_box": [1.0, np.inf]}, "the initial ball reaches to 2"),
        ({"initial_ball": 0.0}, "initial_ball"),
    ],
)
def test_balls_that_are_none_are_refused(arguments: dict[str, Any], message: str) -> None:
    """Radius and semi-axes are positive, and fit into the box of the states."""
    with pytest.raises(ModelError, match=message):
        pdc(two_rules(), **arguments)


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
