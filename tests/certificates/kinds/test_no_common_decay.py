"""What excludes a common function: rules alone and blends that the weights take, never pairs."""

from __future__ import annotations

import pytest

from takagi.certificates import Verdict, certify
from takagi.models import TSModel
from tests.certificates.kinds.claims import Data, law_data, model_data, verdict_of

ALONE: Data = {"name": "x", "kind": "no-common-decay", "decay_rate": 0, "P": [[-1]]}


def opposed(s: float) -> tuple[TSModel, list[list[list[float]]]]:
    """Return one state and two rules with G_11 = G_22 = -1 and G_12 + G_21 = s - 2.

    G(h) = -1 + s h_1 h_2: every blend falls exactly where s < 4, the mean of the pair where s < 2.
    """
    K = [[[0.0]], [[s]]]
    return TSModel([[[-1.0]], [[2 * s - 1]]], [[[1.0]], [[2.0]]]), K


@pytest.mark.parametrize("s", [2.1, 3.0, 3.999])
def test_a_loop_whose_blends_all_fall_is_not_disproved(s: float) -> None:
    """V = x^2 falls along every blend, V' <= -(4 - s)/2 V, though the mean of the pair grows."""
    model, K = opposed(s)

    assert certify(model, K, decay_rate=0).verdict is not Verdict.DISPROVED
    assert certify(model, K).verdict is not Verdict.DISPROVED


def test_a_blend_is_decided_at_its_threshold() -> None:
    """At h = (1/2, 1/2), and at (1/3, 2/3), where G = -1 + 2 s / 9."""
    for shares, edge in (([1, 1], 4), ([1, 2], 4.5), ([0.5, 1], 4.5)):
        claim = ALONE | {"blend": [shares]}
        for s, verdict in ((edge + 0.001, "DISPROVED"), (edge - 0.001, "UNDECIDED")):
            model, K = opposed(s)
            data = model_data(model.A.tolist(), B=model.B.tolist())
            assert verdict_of(data, law_data(K), claim) == verdict
