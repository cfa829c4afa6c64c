"""The inner convex step and the slack form: what they imply, checked on arbitrary numbers."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.lmi import Unknown, decide, structured_pdc_condition
from takagi.lmi.condition import lmi_value
from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant
from takagi.lmi.gains.structured.slack_matrix import slack_gains
from takagi.lmi.gains.structured.structure import structure_of
from takagi.lmi.gains.structured.sums import Objective, StructuredGains, loop_sum
from takagi.lmi.sums.rule_pairs import pair_lmis
from takagi.models import TSModel

Floats = NDArray[np.float64]


def unstable(step: float | None = None) -> TSModel:
    """x1' = x2, x2' = a x1 - b x2 + u with (a, b) = (2, 1) and (3, 1.5); Euler steps on request."""
    A = np.array([[[0.0, 1.0], [2.0, -1.0]], [[0.0, 1.0], [3.0, -1.5]]])
    B = np.array([[0.0], [1.0]])
    if step is None:
        return TSModel(A, B)
    return TSModel(np.eye(2) + step * A, step * B, sample_time=step)


@pytest.mark.parametrize("objective", ["decay_rate", "cost", "hinf"])
@pytest.mark.parametrize("step", [None, 0.3])
def test_inner_step_is_above_the_bilinear_matrix(objective: Objective, step: float | None) -> None:
    """Schur complement of the added row minus Theta(P, K) is >= 0, and 0 at (I, L).

    Theta(P, K) is that with known gains, so the two ways to write it are compared as well.
    """
    rng = np.random.default_rng(1)
    draw = rng.standard_normal
    n, m, q, p, r = 3, 2, 2, 2, 2
    plant = DisturbedPlant(
        A=draw((r, n, n)),
        B=draw((r, n, m)),
        E=draw((r, n, q)),
        C=draw((r, p, n)),
        D12=draw((r, p, m)),
        D11=draw((r, p, q)),
        sample_time=step,
    )
    structure = structure_of((r, n, m), [[1, 0], [1, 1]], draw((2, n)), None)
    F0 = draw((r, m, 2)) * structure.pattern
    P, gamma = Unknown("P", n, n, symmetric=True), Unknown("gamma", 1, 1)
    rows = structure.unknowns()
    near = StructuredGains(
        known=structure.gains(F0), structure=structure, unknowns=rows, spread=0.7
    )
    for size in (0.0, 0.1, 1.0):
        dP = draw((n, n)) * size
        F = F0 + size * draw(F0.shape) * structure.pattern
        values = {"P": (np.eye(n) + dP + dP.T)[None], "gamma": np.full((1, 1, 1), 1.3)}
        values |= {row.name: part for row, part in zip(rows, structure.parts_of(F), strict=True)}
        known = StructuredGains(known=structure.gains(F))
        inner = pair_lmis(loop_sum(plant, objective, P, gamma, near))
        true = pair_lmis(loop_sum(plant, objective, P, gamma, known))
        rates = {"alpha": 0.3, "contraction": 0.7}
        for above, below in zip(inner, true, strict=True):
            wide, theta = lmi_value(above, values, rates), lmi_value(below, values, rates)
            k = theta.shape[1]
            # A pair of rules has -4 I where one has -2 I: its row is the sum of two.
            row = wide[:, k:, :k]
            schur = wide[:, :k, :k] - row.transpose(0, 2, 1) @ np.linalg.solve(wide[:, k:, k:], row)
            if above is inner[0]:
                gap = np.linalg.eigvalsh(schur - theta)
                assert gap.min() > -1e-12
            if size == 0.0:
                assert np.allclose(schur, theta, atol=1e-12)


def test_known_gains_give_the_matrices_of_the_bounded_real_lemma() -> None:
    """Theta of one rule, written out by hand."""
    rng = np.random.default_rng(2)
    A, B, E = (rng.standard_normal((1, 2, k)) for k in (2, 1, 1))
    C, D12, D11 = (rng.standard_normal((1, 1, k)) for k in (2, 1, 1))
    K = rng.standard_normal((1, 1, 2))
    plant = DisturbedPlant(A=A, B=B, E=E, C=C, D12=D12, D11=D11, sample_time=None)
    P, gamma = Unknown("P", 2, 2, symmetric=True), Unknown("gamma", 1, 1)
    (lmi,) = pair_lmis(loop_sum(plant, "hinf", P, gamma, StructuredGains(known=K)))
    X = np.array([[2.0, 0.3], [0.3, 1.0]])
    G, Z = (A - B @ K)[0], (C - D12 @ K)[0]
    expected = np.block(
        [
            [X @ G + G.T @ X, X @ E[0], Z.T],
            [E[0].T @ X, np.array([[-1.5]]), D11[0].T],
            [Z, D11[0], np.array([[-1.5]])],
        ]
    )
    value = lmi_value(lmi, {"P": X[None], "gamma": np.full((1, 1, 1), 1.5)}, {})
    assert np.allclose(value[0], expected)


@pytest.mark.parametrize("step", [None, 0.1])
@pytest.mark.parametrize("shared", [None, ["a", "a"]])
def test_slack_form_shows_the_rate_for_its_own_function(
    step: float | None, shared: list[str] | None
) -> None:
    """With P = Q^-1 the gains of the slack form satisfy V' <= -2 alpha V, all pairs, by numpy."""
    model, alpha = unstable(step), 0.05
    condition = structured_pdc_condition(model, [[True, False]], decay_rate=alpha, shared=shared)
    found = decide(condition, most=1)
    assert found.status == "candidate"
    structure = structure_of((2, 2, 1), [[True, False]], None, shared)
    F = slack_gains(found.values, structure)
    assert (F[:, :, 1] == 0.0).all()
    K, P = structure.gains(F), np.linalg.inv(found.values["Q"][0])
    G = model.A[:, None] - model.B[:, None] @ K
    G = (G + G.transpose(1, 0, 2, 3)) / 2
    if step is None:
        theta = P @ G + (P @ G).transpose(0, 1, 3, 2) + 2 * alpha * P
    else:
        theta = G.transpose(0, 1, 3, 2) @ P @ G - np.exp(-2 * alpha * step) * P
    assert np.linalg.eigvalsh(theta).max() < 0


def test_slack_form_of_an_output_is_that_of_the_states_it_shows() -> None:
    """y = x1 and a pattern that sees x1 alone are the same law."""
    model = unstable()
    by_pattern = decide(structured_pdc_condition(model, [[1, 0]]), most=1)
    by_output = decide(structured_pdc_condition(model, output=[[1.0, 0.0]]), most=1)
    assert by_pattern.margin == pytest.approx(by_output.margin, rel=1e-4)
    assert by_pattern.margin > 1e-3


def test_slack_pattern_keeps_the_zeros_of_every_inverse() -> None:
    """M G^-1 has the pattern of M for arbitrary M and G of their patterns."""
    rng = np.random.default_rng(3)
    pattern = np.array([[1, 1, 0, 0], [0, 0, 1, 1], [0, 0, 1, 0]], dtype=bool)
    structure = structure_of((1, 4, 3), pattern, None, None)
    G = np.where(structure.slack_pattern(), rng.standard_normal((4, 4)), 0.0) + 3 * np.eye(4)
    M = np.where(pattern, rng.standard_normal((3, 4)), 0.0)
    K = M @ np.linalg.inv(G)
    assert np.abs(K[~pattern]).max() < 1e-14
    # Not only diagonal ones.
    assert structure.slack_pattern().sum() == 7
