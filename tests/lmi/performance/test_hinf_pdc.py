"""Energy gain by compensation: COMPleib, Riccati equations, Hamiltonians, cvxpy, trajectories."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are
from scipy.optimize import minimize_scalar

from takagi.lmi import Design, h2_pdc, hinf_norm, hinf_pdc, peak_pdc, rigorous_no
from takagi.lmi.gains.disturbance.request import DisturbanceCoordinates
from takagi.models import Floats, ModelError, TSModel
from tests.lmi.compleib import SYSTEMS, System, mfp
from tests.lmi.norms import frequency_norm, hamiltonian_norm
from tests.lmi.performance.disturbed import blends, gain_of, loop, three_rules, two_rules

pytestmark = pytest.mark.numeric


def plant(system: System) -> TSModel:
    return TSModel([system.A], [system.B], E=[system.B1])


def riccati_allows(system: System, gamma: float) -> bool:
    """Doyle, Glover, Khargonekar and Francis (1989), full information: is there an X >= 0?"""
    A, B1, B, C, D = system.A, system.B1, system.B, system.C1, system.D12
    n, q = B1.shape
    inputs = np.hstack([B, B1])
    size = B.shape[1] + q
    R = np.zeros((size, size))
    R[: B.shape[1], : B.shape[1]] = D.T @ D
    R[B.shape[1] :, B.shape[1] :] = -(gamma**2) * np.eye(q)
    both = np.hstack([C.T @ D, np.zeros((n, q))])
    try:
        X = solve_continuous_are(A, inputs, C.T @ C, R, s=both)
    except np.linalg.LinAlgError:
        return False
    return bool(np.linalg.eigvalsh((X + X.T) / 2)[0] >= -1e-9 * np.abs(X).max())


@pytest.mark.parametrize("name", SYSTEMS)
def test_one_rule_has_the_optimum_of_compleib(name: str) -> None:
    """COMPleib (Leibfritz, 2004): the infimum over u = -K x, by a Riccati equation; see compleib.

    The equation has its solution a hair above the gain that is found, and none a hair below.
    """
    system = SYSTEMS[name]()
    design = hinf_pdc(plant(system), performance=(system.C1, system.D12), tolerance=1e-6)

    assert gain_of(design) == pytest.approx(system.hinf, rel=1e-5)
    assert riccati_allows(system, gain_of(design) * (1 + 1e-4))
    assert not riccati_allows(system, gain_of(design) * (1 - 1e-4))


@pytest.mark.parametrize("name", SYSTEMS)
def test_a_tolerance_buys_small_gains_that_keep_their_promise(name: str) -> None:
    system = SYSTEMS[name]()
    design = hinf_pdc(plant(system), performance=(system.C1, system.D12), tolerance=0.02)
    tight = hinf_pdc(plant(system), performance=(system.C1, system.D12), tolerance=1e-6)
    assert design.gains is not None and tight.gains is not None
    K = design.gains[0]
    D = np.zeros((len(system.C1), system.B1.shape[1]))
    norm = hamiltonian_norm(system.A - system.B @ K, system.B1, system.C1 - system.D12 @ K, D)

    assert system.hinf * (1 - 1e-6) <= norm <= gain_of(design) * (1 + 1e-6)
    assert gain_of(design) <= system.hinf * (1.02 + 1e-4)
    assert np.abs(K).max() < max(1e2, 1e-2 * np.abs(tight.gains).max())


@pytest.mark.parametrize("sample_time", [None, 0.1])
def test_one_state_against_a_search_over_its_gain(sample_time: float | None) -> None:
    """x' = -0.7 x + u + w or x+ = 0.7 x + u + w, z = (x, u / 2): the best k by a minimiser."""
    a = -0.7 if sample_time is None else 0.7
    model = TSModel([[[a]]], [[1.0]], E=[[1.0]], C=[[1.0], [0.0]], D=[[0.0], [0.5]])
    if sample_time is not None:
        model = TSModel(model.A, model.B, E=model.E, C=model.C, D=model.D, sample_time=sample_time)

    def norm(k: float) -> float:
        A, B, C = loop(model, np.array([[[k]]]), np.ones(1))
        if sample_time is None:
            return hamiltonian_norm(A, B, C, np.zeros((2, 1)))
        return frequency_norm(A, B, C, np.zeros((2, 1)), points=101)

    bounds = (-0.69, 60.0) if sample_time is None else (-0.29, 1.69)
    best: Any = minimize_scalar(norm, bounds=bounds, method="bounded")
    assert gain_of(hinf_pdc(model)) == pytest.approx(float(best.fun), rel=1e-5)


def test_a_direct_path_and_a_loop_of_ones_own_outputs() -> None:
    """With D11 the least gain is at least its norm; of one rule the Hamiltonian confirms it."""
    system = SYSTEMS["NN4"]()
    D11 = np.diag([0.5, -2.0, 0.0, 1.0])
    design = hinf_pdc(plant(system), performance=(system.C1, system.D12, D11), tolerance=0.01)
    assert design.gains is not None
    K = design.gains[0]
    norm = hamiltonian_norm(system.A - system.B @ K, system.B1, system.C1 - system.D12 @ K, D11)

    assert 2.0 <= norm <= gain_of(design) <= 1.02 * norm


def test_inputs_that_differ_only_in_their_cost_are_welcome() -> None:
    """MFP's three inputs push in two directions, each at a cost: not merged, and no misuse."""
    system = mfp()
    assert np.linalg.matrix_rank(system.B) == 2

    free = hinf_pdc(plant(system), performance=(system.C1, system.D12), tolerance=0.01)
    limit = np.array([0.5, 0.3, 0.2])
    limited = hinf_pdc(
        plant(system),
        performance=(system.C1, system.D12),
        tolerance=0.01,
        input_limit=limit,
        disturbance_energy=0.01,
    )
    K, P = limited.require()

    assert free.require()[0].shape == (1, 3, 4)
    assert np.all(np.sqrt(np.diag(K[0] @ np.linalg.inv(P) @ K[0].T)) <= limit * (1 + 1e-6))
    assert gain_of(limited) > gain_of(free)


def test_gains_that_do_not_survive_rounding_are_no_candidate(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Handed out with two digits the gains break the LMIs at the least gamma, and it is said."""
    exact = DisturbanceCoordinates.gains

    def rounded(self: DisturbanceCoordinates, Q: Floats, M: Floats, rules: int) -> Floats:
        K = exact(self, Q, M, rules)
        return np.array([float(f"{entry:.1e}") for entry in K.flat]).reshape(K.shape)

    monkeypatch.setattr(DisturbanceCoordinates, "gains", rounded)
    system = SYSTEMS["AC17"]()
    design = hinf_pdc(plant(system), performance=(system.C1, system.D12))

    assert design.status == "unknown"
    assert design.gains is None and design.gain is None
    assert "rounded as they are" in design.answer.diagnosis


def test_analysis_agrees_where_one_gain_serves_all() -> None:
    """With one gain for all rules the loop is a polytope: its own norm is the design's."""
    model = three_rules(0.1)
    design = hinf_pdc(model, relaxation="common-gain", tolerance=0.01)
    K = design.require()[0][0]
    A, C = model.A - model.B @ K, model.C - model.D @ K
    closed = TSModel(A, E=model.E, C=C, sample_time=0.1)
    answer = hinf_norm(closed)
    assert answer.gain is not None

    assert answer.gain <= gain_of(design)
    assert answer.gain >= gain_of(design) / 1.03


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"relaxation": "tanaka"}, "relaxation 'tanaka' is not known"),
        ({"performance": ([[1.0, 0.0, 0.0]],)}, r"C1 has shape \(1, 3\)"),
        ({"performance": ([[1.0, 0.0]], [[1.0, 0.0]])}, r"D12 has shape \(1, 2\)"),
        ({"performance": ([[1.0, 0.0]], None, [[np.nan]])}, "D11.*is nan"),
        ({"performance": [[1.0, 0.0]] * 4}, r"performance must be \(C1, D12, D11\)"),
        ({"performance": (None,)}, "C1 is needed"),
        ({"performance": (np.zeros((1, 2)),)}, "C1 is zero at every vertex"),
        ({"decay_rate": -1.0}, "decay_rate is -1.0; it must be at least 0"),
        ({"tolerance": 0.0}, "tolerance is 0.0; it must be at least 1e-07"),
        ({"input_limit": [1.0]}, "limits were given, but not the disturbance"),
        ({"disturbance_energy": 1.0}, "but no limit that must hold for it"),
        ({"disturbance_energy": -1.0, "input_limit": [1.0]}, "disturbance_energy is -1"),
        ({"sample_time": 0.1}, "the model is of continuous time"),
    ],
)
def test_misuse_is_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(ModelError, match=message):
        hinf_pdc(two_rules(), **arguments)


def test_models_that_lack_something_are_refused() -> None:
    A, B, E, C = [np.diag([1.0, -1.0])], [[1.0], [0.0]], [[1.0], [1.0]], [[1.0, 1.0]]
    for model, message in (
        (TSModel(A, B, C=C), "the model has no disturbance; E is needed"),
        (TSModel(A, B, E=E), "there is no output to keep small; C is needed"),
        (TSModel(A, E=E, C=C), "the model has no input; B is needed"),
        (TSModel(A, [[1.0, 0.0], [0.0, 0.0]], E=E, C=C), "input 2 of 2"),
        (TSModel(A, [[1.0, 2.0], [0.0, 0.0]], E=E, C=C), "B and D12: rank 1"),
        (TSModel(A, [[0.0], [1.0]], E=E, C=C), "the mode at 1"),
    ):
        with pytest.raises(ModelError, match=message):
            hinf_pdc(model)


# ------------------------------------------------------------------ a least norm of zero

E = np.array([[0.0], [1.0]])
ALL_SEEN = (np.array([[0.0, 1.0], [1.0, 0.0]]), [[1.0, 1.0]], [[1.0, 1.0]])
ONE_SEEN = (np.eye(2), [[1.0, 0.0]], [[0.0, 0.0]])
DESIGNS = [hinf_pdc, h2_pdc, peak_pdc]


@pytest.mark.parametrize("design", DESIGNS)
@pytest.mark.parametrize("step", [None, 1.0])
@pytest.mark.parametrize(
    ("A", "rest"),
    [
        ([[[0.0, 1.0], [2.0, -1.0]]], ALL_SEEN),
        ([[[0.0, 1.0], [2.0, -1.0]], [[0.0, 1.0], [4.0, -1.0]]], ALL_SEEN),
        ([[[1.0, 1.0], [0.5, 1.0]]], ONE_SEEN),
        ([[[1.0, 1.0], [0.5, 1.0]], [[1.0, 3.0], [0.5, 1.0]]], ONE_SEEN),
        ([[[-0.5, 0.0], [0.0, -0.2]]], ([[1.0], [0.0]], [[1.0, 0.0], [0.0, 0.0]], [[0.0], [1.0]])),
    ],
)
def test_a_disturbance_that_gains_keep_from_the_output(
    design: Callable[..., Design], step: float | None, A: Any, rest: Any
) -> None:
    """The least norm is zero and is reached, with gains of order one (Wonham, theorem 4.2)."""
    B, C, D = rest
    found = design(TSModel(A, B, E=E, C=C, D=D, sample_time=step))
    K = found.require()[0]

    assert gain_of(found) < 1e-10 and np.abs(K).max() < 20
    x = np.broadcast_to(E[:, 0], (len(K), 2))
    for _ in range(8):
        z = np.einsum("pn,rn->rp", C, x) - np.einsum("pm,rmn,rn->rp", D, K, x)
        assert np.abs(z).max() < 1e-12 * np.abs(x).max()
        x = np.einsum("rmn,rn->rm", np.array(A) - np.array(B) @ K, x)


INTEGRATOR = TSModel([[[0.0, 1.0], [0.0, 0.0]]], E, E=E, C=[[1.0, 0.0]])


@pytest.mark.slow
def test_a_least_norm_of_zero_that_is_approached_alone() -> None:
    """x1 of a double integrator: zero but for the tolerance, with a note."""
    least = hinf_pdc(INTEGRATOR)

    assert gain_of(least) < 1e-4 and "norm_below" in least.answer.note


def test_a_norm_that_is_enough_has_the_gains_that_it_needs() -> None:
    """The norm from w to x1 is 1 / k1 at least, where u = -k1 x1 - k2 x2."""
    enough = hinf_pdc(INTEGRATOR, norm_below=0.01)

    assert gain_of(enough) <= 0.01
    assert 100 <= enough.require()[0][0, 0, 0] < 110


@pytest.mark.parametrize("design", DESIGNS)
def test_a_norm_that_is_asked_for(design: Callable[..., Design]) -> None:
    model = two_rules()
    least = design(model)
    enough, less = (design(model, norm_below=share * gain_of(least)) for share in (2.0, 0.5))

    assert gain_of(enough) <= 2.0 * gain_of(least)
    assert np.abs(enough.require()[0]).max() < np.abs(least.require()[0]).max() / 1.5
    assert less.status == "infeasible" and rigorous_no(less) is not None
    with pytest.raises(ModelError, match="norm_below"):
        design(model, norm_below=0.0)


@pytest.mark.parametrize("sample_time", [None, 0.1])
def test_a_decay_rate_holds_besides(sample_time: float | None) -> None:
    model = two_rules(sample_time)
    free = hinf_pdc(model, tolerance=0.05)
    fast = hinf_pdc(model, tolerance=0.05, decay_rate=4.0)

    def slowest(design: Design) -> float:
        poles = [np.linalg.eigvals(loop(model, design.require()[0], h)[0]) for h in blends(2, 8)]
        values = np.concatenate(poles)
        if sample_time is None:
            return float(-values.real.max())
        return float(-np.log(np.abs(values).max()) / sample_time)

    assert slowest(fast) > 4.0 > slowest(free)
    assert gain_of(fast) > 0.99 * gain_of(free)
    assert fast.decay_rate == 4.0


@pytest.mark.parametrize("sample_time", [None, 0.1])
def test_limits_hold_for_all_disturbances_of_the_energy(sample_time: float | None) -> None:
    """|u| stays within its limit on the ellipsoid that such disturbances reach, at a price."""
    model = two_rules(sample_time)
    energy = 1.0 if sample_time is None else 1.0 / sample_time
    gains = []
    for limit in (1e3, 3.0, 1.5):
        design = hinf_pdc(model, input_limit=[limit], disturbance_energy=energy)
        K, P = design.require()
        reach = [float(np.sqrt(k @ np.linalg.inv(P) @ k.T)[0, 0]) for k in K]
        assert max(reach) <= limit * (1 + 1e-6)
        gains.append(gain_of(design))

    assert gains[0] == pytest.approx(gain_of(hinf_pdc(model)), rel=2e-2)
    assert gains[0] < gains[1] < gains[2]


@pytest.mark.parametrize("sample_time", [None, 0.1])
@pytest.mark.parametrize("energy", [None, 2.0])
def test_the_function_stores_no_more_than_the_disturbance_gives(
    sample_time: float | None, energy: float | None
) -> None:
    """V' <= gamma |w|^2 - |z|^2 / gamma; with limits over W and W gamma^2, up to an energy of W."""
    model = two_rules(sample_time)
    if energy is None:
        design = hinf_pdc(model, tolerance=0.01)
        given, shown = gain_of(design), 1 / gain_of(design)
    else:
        total = energy if sample_time is None else energy / sample_time
        design = hinf_pdc(model, tolerance=0.01, input_limit=[4.0], disturbance_energy=total)
        given, shown = 1 / total, 1 / (total * gain_of(design) ** 2)
    K, P = design.require()
    tight = -np.inf
    for h in blends(2, 6):
        A, E, C = loop(model, K, h)
        state = A.T @ P + P @ A if sample_time is None else A.T @ P @ A - P
        cross = P @ E if sample_time is None else A.T @ P @ E
        noise = np.zeros((1, 1)) if sample_time is None else E.T @ P @ E
        F = np.block([[state + shown * C.T @ C, cross], [cross.T, noise - given * np.eye(1)]])
        scale = 1 / np.sqrt(np.abs(np.diag(F)))
        tight = max(tight, float(np.linalg.eigvalsh(F * np.outer(scale, scale))[-1]))

    assert -0.2 < tight < 0


def test_limits_that_the_disturbance_breaks_are_a_reasoned_no() -> None:
    no = hinf_pdc(two_rules(), input_limit=[0.8], disturbance_energy=1.0)

    assert no.status == "infeasible"
    assert no.gains is None and no.gain is None
    assert "gains keep the limits without disturbance" in no.answer.diagnosis
    assert "the no rests on rule 2 of 2" in no.answer.diagnosis
    assert hinf_pdc(two_rules(), input_limit=[0.8], disturbance_energy=0.25).found


def test_state_and_initial_boxes_are_kept() -> None:
    design = hinf_pdc(
        two_rules(), disturbance_energy=0.1, initial_box=[0.3, 0.3], state_box=[1.0, 2.0]
    )
    _, P = design.require()
    corner = np.array([0.3, 0.3])

    assert corner @ P @ corner <= 1 + 1e-6
    assert np.all(np.diag(np.linalg.inv(P)) <= np.array([1.0, 4.0]) * (1 + 1e-6))


def test_a_gain_bound_is_kept_at_a_price() -> None:
    model = two_rules()
    free = hinf_pdc(model)
    bounded = hinf_pdc(model, gain_bound=20.0)
    norms = np.linalg.norm(bounded.require()[0], 2, axis=(1, 2))

    assert norms.max() <= 20.0
    assert gain_of(bounded) > gain_of(free)
