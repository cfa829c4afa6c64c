"""Dynamic output feedback: closed loops by their matrices, by certificates, and where none is."""

from __future__ import annotations

import numpy as np
import pytest

from takagi.certificates import certify
from takagi.certificates.cross_check.opinion import judge_document
from takagi.certificates.requests import Decay
from takagi.lmi import (
    DynamicController,
    dynamic_output_condition,
    dynamic_output_feedback,
)
from takagi.models import ModelError, TSModel, sector_model
from takagi.models.plant_files.loader import load_plant

pytestmark = pytest.mark.numeric

UNSTABLE = TSModel([[[0.0, 1.0], [1.0, 0.0]]], [[[0.0], [1.0]]], C=[[[1.0, 0.0]]])
SAMPLED = TSModel([[[1.1, 0.1], [0.2, 1.0]]], [[[0.0], [0.1]]], C=[[[1.0, 0.0]]], sample_time=0.1)


def loops(model: TSModel, one: DynamicController) -> np.ndarray:
    """Return the closed loop of every rule, (r, 2n, 2n)."""
    B, C = model.B[0], model.C[0]
    return np.array(
        [
            np.block([[A, B @ H], [G @ C, F]])
            for A, F, G, H in zip(model.A, one.F, one.G, one.H, strict=True)
        ]
    )


def test_the_closed_loop_decays_with_the_function_that_was_found() -> None:
    """P of the closed loop from X and Y, and the poles as a second way."""
    found = dynamic_output_feedback(UNSTABLE, decay_rate=1.0)

    assert found.controller is not None
    (G,), P = loops(UNSTABLE, found.controller), found.controller.P
    assert np.linalg.eigvalsh(P).min() > 0
    assert np.linalg.eigvalsh(G.T @ P + P @ G + 2 * P).max() < 0
    assert np.linalg.eigvals(G).real.max() < -1


def test_discrete_time() -> None:
    found = dynamic_output_feedback(SAMPLED, decay_rate=1.0)

    assert found.controller is not None
    (G,), P = loops(SAMPLED, found.controller), found.controller.P
    rho = np.exp(-0.1)
    assert np.linalg.eigvalsh(P).min() > 0
    assert np.linalg.eigvalsh(G.T @ P @ G - rho**2 * P).max() < 0
    assert np.abs(np.linalg.eigvals(G)).max() < rho


def test_rounded_it_is_proved_for_every_blend_by_both_checkers() -> None:
    """Duffing's x'' = -0.1 x' - x^3 + u with x measured, |x| <= 5; and a wrong sign is not."""
    model = sector_model(load_plant("duffing"))
    found = dynamic_output_feedback(model, decay_rate=1.0)

    assert found.controller is not None
    rounded = found.controller.rounded(6)
    whole, K = rounded.closed_loop(model)
    proof = certify(whole, K, claims=[Decay(0.9)])
    assert proof.verdict.name == "PROVED"
    assert [one.verdict for one in judge_document(proof.document)] == ["PROVED"]
    for matrix, own in zip(loops(model, rounded), whole.A - whole.B @ K, strict=True):
        np.testing.assert_allclose(own, matrix, rtol=1e-12, atol=1e-12)
    wrong = DynamicController(rounded.F, -rounded.G, rounded.H, rounded.P)
    assert certify(*wrong.closed_loop(model), claims=[Decay(0.9)]).verdict.name != "PROVED"


def test_what_no_output_shows_has_no_controller() -> None:
    """x1' = x1 does not show in y = x2; nor can it be moved where u acts on x2 alone."""
    blind = TSModel([[[1.0, 0.0], [0.0, -1.0]]], [[[1.0], [1.0]]], C=[[[0.0, 1.0]]])
    stuck = TSModel([[[1.0, 0.0], [0.0, -1.0]]], [[[0.0], [1.0]]], C=[[[1.0, 1.0]]])

    for model in (blind, stuck):
        found = dynamic_output_feedback(model)
        assert not found.found and found.status != "candidate"


def test_the_rate_from_both_sides_of_a_mode_that_nothing_moves() -> None:
    """x2' = -x2 is neither moved nor seen: 1 1/s is the limit of the loop, whatever is done."""
    fixed = TSModel([[[1.0, 0.0], [0.0, -1.0]]], [[[1.0], [0.0]]], C=[[[1.0, 0.0]]])

    assert dynamic_output_feedback(fixed, decay_rate=0.9).found
    assert not dynamic_output_feedback(fixed, decay_rate=1.1).found


def test_matrices_that_differ_are_refused() -> None:
    A = [[[0.0, 1.0], [0.0, 0.0]], [[0.0, 1.0], [-1.0, 0.0]]]
    by_rule = TSModel(A, [[[0.0], [1.0]], [[0.0], [2.0]]], C=[[1.0, 0.0]])

    with pytest.raises(ModelError, match="B differs between the rules"):
        dynamic_output_feedback(by_rule)
    with pytest.raises(ModelError, match="output"):
        dynamic_output_condition(TSModel(A, [[0.0], [1.0]]))
