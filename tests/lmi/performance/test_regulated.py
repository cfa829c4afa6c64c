"""The H2 design of one rule by the Riccati equation: optima, bounds and proofs without a program.

Source of NN3 and ROC10: F. Leibfritz (2004), COMPleib, release 1.1; nothing is weighed on the input
there, so the least norm is approached by ever larger gains.  What clarabel finds for the Gramian's
program, posed in cvxpy in the units of the data, is 0.86611 and 0.26729.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.linalg import solve_continuous_are

from takagi.certificates import Verdict, certify
from takagi.certificates.requests import H2Norm, L2Gain, Peak
from takagi.lmi import Design, h2_pdc, hinf_pdc, pdc, peak_pdc
from takagi.lmi.cone.balance import balanced_states
from takagi.lmi.gains.disturbance import design
from takagi.lmi.gains.disturbance import riccati_bound as regulated
from takagi.lmi.solver import solve
from takagi.models import TSModel
from tests.lmi.compleib import SYSTEMS
from tests.lmi.fixed_order.plants import plant
from tests.lmi.norms import gramian_norm

pytestmark = pytest.mark.numeric

NN3 = TSModel(
    [[[0.5, 1.0, 1.5, 1.0], [-1.0, 3.0, 2.1, 2.0], [1.0, -1.0, -0.6, 1.0], [-2.0, 2.0, -1.0, 1.0]]],
    [[0.0], [0.0], [0.0], [1.0]],
    E=[[0.0], [0.0], [1.0], [0.0]],
)
NN3_OUTPUT = ([[1.0, 0.0, 0.0, 0.0]],)
ROC10 = TSModel(
    [
        [
            [0.0, 1.0, 0.0, 0.0, 0.0, 0.0],
            [48.9844, 0.0, -48.9844, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.18494, 0.0, 0.0],
            [0.0, 0.0, 0.0, -50.0, 0.0, 0.0],
            [0.0, 0.0, -0.5, 0.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        ]
    ],
    [[0.0, 0.0], [0.0, 0.0], [0.0, 50.0], [0.0, 0.0], [0.0, 0.0], [1.0, 0.0]],
    E=[[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 0.5], [0.0, 0.0]],
)
ROC10_OUTPUT = ([[0.0, 0.0, 0.0, 0.0036988, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 1.0, 0.0]],)


@pytest.fixture
def without_programs(monkeypatch: pytest.MonkeyPatch) -> None:
    def never(*args: object, **options: object) -> object:
        raise AssertionError("a program was posed to a solver")

    monkeypatch.setattr(design, "optimise", never)
    monkeypatch.setattr(regulated, "least_variance", never)


def gain_of(found: Design) -> float:
    assert found.gain is not None
    return found.gain


def norm_of(model: TSModel, output: Any, K: Any) -> float:
    C, D = (np.asarray(part, dtype=float) for part in (*output, [[0.0] * K.shape[0]])[:2])
    return gramian_norm(model.A[0] - model.B[0] @ K, np.asarray(model.E[0]), C - D @ K)


@pytest.mark.parametrize("name", sorted(SYSTEMS))
@pytest.mark.usefixtures("without_programs")
def test_one_rule_needs_no_program(name: str) -> None:
    system = SYSTEMS[name]()
    model, output = TSModel([system.A], [system.B], E=[system.B1]), (system.C1, system.D12)
    found = h2_pdc(model, performance=output)

    assert found.gain == pytest.approx(system.h2, rel=1.1e-4)
    assert [one.solver for one in found.answer.tries] == ["regulator"]
    true = norm_of(model, output, found.require()[0][0])
    assert true <= gain_of(found)
    assert true == pytest.approx(system.h2, rel=1e-6)


@pytest.mark.usefixtures("without_programs")
def test_a_chain_of_thirty_states_is_done_at_once() -> None:
    """Fifteen masses in a row, pushed at both ends: the cost by the Riccati equation alone."""
    masses = 15
    stiff = 2 * np.eye(masses) - np.eye(masses, k=1) - np.eye(masses, k=-1)
    zero, one = np.zeros((masses, masses)), np.eye(masses)
    A = np.block([[zero, one], [-stiff, -0.01 * one]])
    B = np.zeros((2 * masses, 2))
    B[masses, 0] = B[-1, 1] = 1.0
    E = np.zeros((2 * masses, 1))
    E[masses + 7] = 1.0
    C, D = np.vstack([np.eye(2 * masses), np.zeros((2, 2 * masses))]), np.zeros((2 * masses + 2, 2))
    D[-2:] = np.eye(2)
    P = solve_continuous_are(A, B, C.T @ C, np.eye(2))

    found = h2_pdc(TSModel([A], [B], E=[E]), performance=(C, D))

    assert found.gain == pytest.approx(float(np.sqrt(E.T @ P @ E)[0, 0]), rel=1.1e-4)


@pytest.mark.parametrize(
    ("model", "output", "least"), [(NN3, NN3_OUTPUT, 0.86603), (ROC10, ROC10_OUTPUT, 0.26728)]
)
def test_a_least_norm_that_is_approached_only_is_found_and_proved(
    model: TSModel, output: Any, least: float
) -> None:
    """Within a thousandth of the infimum, which the other program bounds; the gains are proved."""
    found = h2_pdc(model, performance=output)
    gains, _ = found.require()
    gain = gain_of(found)

    assert least * (1 - 1e-5) <= gain <= least * (1 + 1e-3)
    assert norm_of(model, output, gains[0]) <= gain
    proof = certify(model, gains, claims=[H2Norm(output=output)])
    assert proof.verdict is Verdict.PROVED
    assert proof.document["claims"][-1]["norm"] <= 1.001 * gain


@pytest.mark.usefixtures("without_programs")
def test_a_least_norm_of_zero_is_an_answer() -> None:
    """x1' = x1 + x2 + u with x2 measured: u = -2 x1 - x2 keeps x1 at rest, and z = x1."""
    model = TSModel([[[1.0, 1.0], [0.0, -1.0]]], [[[1.0], [0.0]]], E=[[[0.0], [1.0]]])
    found = h2_pdc(model, performance=([[1.0, 0.0]],))

    assert found.status == "candidate"
    assert 0 < gain_of(found) < 3e-5
    assert norm_of(model, ([[1.0, 0.0]],), found.require()[0][0]) <= gain_of(found)


DIS5 = TSModel(
    [
        [
            [0.8189, 0.0863, 0.09, 0.0813],
            [0.2524, 1.0033, 0.0313, 0.2004],
            [-0.0545, 0.0102, 0.7901, -0.258],
            [-0.1918, -0.1034, 0.1602, 0.8604],
        ]
    ],
    [[0.0045, 0.0044], [0.1001, 0.01], [0.0003, -0.0136], [-0.0051, 0.0936]],
    E=[[0.0953, 0.0, 0.0], [0.0145, 0.0, 0.0], [0.0862, 0.0, 0.0], [-0.0011, 0.0, 0.0]],
)
DIS5_OUTPUT = (
    [[1.0, 0.0, -1.0, 0.0], [0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0]],
    [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]],
)
DIS5_HINF, DIS5_H2 = 27.4937, 36.0206


@pytest.fixture(autouse=True)
def without_sdpa(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(solve, "sdpa_is_installed", lambda: False)


def test_a_missile_in_its_own_units_has_its_least_norm() -> None:
    """AC4: entries from 0.05 to 150, a direct path, an input without which nothing is stable."""
    missile = plant("AC4")
    design = hinf_pdc(
        TSModel([missile.A], [missile.B2], E=[missile.B1]),
        performance=(missile.C1, missile.D12, missile.D11),
    )

    assert design.status == "candidate"
    assert design.gain == pytest.approx(0.557288, rel=1e-4)


@pytest.mark.parametrize(("design", "least"), [(h2_pdc, DIS5_H2), (hinf_pdc, DIS5_HINF)])
def test_a_decentralised_plant_has_its_least_norms(design: object, least: float) -> None:
    """DIS5: an input of 1 moves the states by 1e-3, and what it costs crosses with the states."""
    found = design(DIS5, performance=DIS5_OUTPUT)  # type: ignore[operator]

    assert found.status == "candidate"
    assert found.gain == pytest.approx(least, rel=2e-4)


@pytest.mark.parametrize(
    ("name", "asked", "request_of"),
    [
        *((name, hinf_pdc, L2Gain) for name in ("NN2", "DIS2", "HE1", "NN4")),
        *((name, h2_pdc, H2Norm) for name in ("NN2", "DIS2", "HE1", "NN4", "TG1")),
        ("NN2", peak_pdc, Peak),
    ],
)
def test_a_default_design_is_proved_within_a_thousandth(
    name: str, asked: Any, request_of: Any
) -> None:
    system = SYSTEMS[name]()
    model, output = TSModel([system.A], [system.B], E=[system.B1]), (system.C1, system.D12)
    design = asked(model, performance=output)
    assert design.gain is not None

    found = certify(model, design.gains, claims=[request_of(output=output)])

    assert found.verdict is Verdict.PROVED
    claim = found.document["claims"][-1]
    assert claim.get("gain", claim.get("norm")) <= 1.001 * design.gain


def test_states_that_only_act_on_others_do_not_run_away() -> None:
    """A disturbance's model of two states drives the plant; nothing drives it back.

    Made smaller and smaller in turn, the plant's unstable mode seemed out of the input's reach.
    """
    A = np.array(
        [
            [0.01, 1.0, 0.0, 0.02, 0.0],
            [0.3, -0.7, 1.0, 0.05, 0.0],
            [0.0, 0.0, -20.0, 0.0, 0.0],
            [0.0, 0.0, 0.0, -0.44, 0.0044],
            [0.0, 0.0, 0.0, -0.0044, -0.44],
        ]
    )
    s = balanced_states(A[None])

    assert s.max() / s.min() < 1e6
    assert pdc(TSModel([A], [[[0.0], [0.0], [20.0], [0.0], [0.0]]])).status == "candidate"
