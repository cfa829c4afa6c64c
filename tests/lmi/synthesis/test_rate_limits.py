"""Limits on how fast the inputs move: designs simulated from the boundary of their ellipsoid."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import Unknown, input_rate_bound, pdc, with_input_states
from takagi.lmi.gains.requirements.limits import initial_lmis
from takagi.lmi.gains.requirements.rate_limits import rate_sums
from takagi.models import ModelError, TSModel
from tests.lmi.synthesis.placed import Added, More, pendulum, placed

Floats = NDArray[np.float64]


def limited(model: TSModel, limit: float, speed: float, rates: float | None) -> More:
    """Return the rate limit on an ellipsoid that holds the box 0.1 rad, 0.2 rad/s."""

    def more(Q: Unknown, M: Unknown) -> Added:
        sums, lmis = rate_sums(
            model.A,
            model.B,
            Q,
            M,
            limit=limit,
            speed=speed,
            rate_bounds=rates,
            discrete=model.sample_time is not None,
        )
        return sums, (), lmis + initial_lmis(Q, np.array([[0.1, 0.2], [0.1, -0.2]]))

    return more


@pytest.mark.parametrize(
    ("relaxation", "rates"),
    [("common-gain", None), ("wang-tanaka-griffin", 0.5), ("polya-1", 0.5)],
)
def test_the_design_keeps_its_rate_limit(relaxation: str, rates: float | None) -> None:
    """The exact bound of the gains that were found is below the limit that was asked."""
    model = pendulum()
    K, P, _, _ = placed(
        model, limited(model, 40.0, 6.0, rates), relaxation=relaxation, decay_rate=0.2
    )
    assert K is not None and P is not None

    assert input_rate_bound(model, K, P, rate_bounds=rates)[0] <= 40.0
    assert np.einsum("i,ij,j", [0.1, 0.2], P, [0.1, 0.2]) <= 1


def test_a_simulated_input_never_moves_faster() -> None:
    """x' = (A(h) - B(h) K(h)) x with h = (1 +- cos 2 pi f t) / 2, |h'| <= 0.5, from x' P x = 1."""
    model, rates, dt = pendulum(), 0.5, 2e-3
    K, P, _, _ = placed(model, limited(model, 40.0, 6.0, rates), decay_rate=0.2)
    assert K is not None and P is not None
    angle = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    x = np.linalg.solve(np.linalg.cholesky(P).T, np.array([np.cos(angle), np.sin(angle)])).T
    last, fastest = None, 0.0
    for step in range(2000):
        h = 0.5 + 0.5 * np.cos(2 * rates * step * dt)  # |h'| <= rates
        A, B, k = ((1 - h) * part[0] + h * part[1] for part in (model.A, model.B, K))
        u = -x @ k.T
        if last is not None:
            fastest = max(fastest, float(np.abs(u - last).max() / dt))
        last = u
        x = x + dt * (x @ (A - B @ k).T)

    assert 1.0 < fastest <= 40.0
    assert np.einsum("ki,ij,kj->k", x, P, x).max() < 1e-2


def test_a_tight_limit_is_a_no_at_every_speed() -> None:
    """From that box 2 N m/s cannot hold the pendulum, whatever the speed asked."""
    model = pendulum()
    for speed in (4.0, 6.0, 10.0, 20.0):
        found = placed(
            model, limited(model, 2.0, speed, None), relaxation="common-gain", decay_rate=0.2
        )
        assert found[0] is None and found[2].status == "infeasible"


def test_the_change_in_one_sample_is_limited() -> None:
    """Discrete time, memberships that jump: the bound of the gains found is below the limit."""
    model = pendulum(0.02)
    K, P, _, _ = placed(model, limited(model, 20.0, 0.15, None), decay_rate=0.2)
    assert K is not None and P is not None

    assert input_rate_bound(model, K, P)[0] <= 20.0


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


@pytest.mark.parametrize(
    ("model", "members", "rates", "share"),
    [
        (pendulum(), 2, 0.5, 6.0 + 0.5 + 0.5),
        (pendulum(), 1, None, 6.0),
        (pendulum(0.1), 2, None, 6.0 + 2.0),
        (pendulum(0.1), 1, None, 6.0),
    ],
)
def test_the_commands_are_bounded_by_their_share(
    model: TSModel, members: int, rates: float | None, share: float
) -> None:
    """|K_j x| <= limit / (nu + sum_j phi_j), or limit / (nu + 2) where memberships may jump."""
    Q, M = Unknown("Q", 2, 2, symmetric=True), Unknown("M", 1, 2, count=members)
    _, _, (lmi, *_) = limited(model, 40.0, 6.0, rates)(Q, M)

    assert lmi.count == members
    np.testing.assert_allclose(lmi.constants[0].value, (40.0 / share) ** 2)


def test_what_is_missing_or_wrong_is_refused() -> None:
    model = pendulum()
    with pytest.raises(ModelError, match="give rate_bounds"):
        placed(model, limited(model, 40.0, 6.0, None))
    with pytest.raises(ModelError, match="speed is 0"):
        placed(model, limited(model, 40.0, 0.0, 1.0))
    with pytest.raises(ModelError, match="leave them out"):
        placed(pendulum(0.02), limited(pendulum(0.02), 40.0, 0.2, 1.0))
    with pytest.raises(ModelError, match="no inputs"):
        with_input_states(TSModel([[[1.0]]]))
