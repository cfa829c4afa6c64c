"""What excludes a common function: rules alone and blends that the weights take, never pairs."""

from __future__ import annotations

from typing import Any

from takagi.certificates import Verdict, certify
from takagi.models import TSModel
from tests.certificates.kinds.claims import law_data, model_data, verdict_of

Data = dict[str, Any]
ALONE: Data = {"name": "x", "kind": "no-common-decay", "decay_rate": 0, "P": [[-1]]}


def opposed(s: float) -> tuple[TSModel, list[list[list[float]]]]:
    """Return one state and two rules with G_11 = G_22 = -1 and G_12 + G_21 = s - 2.

    G(h) = -1 + s h_1 h_2: every blend falls exactly where s < 4, the mean of the pair where s < 2.
    """
    K = [[[0.0]], [[s]]]
    return TSModel([[[-1.0]], [[2 * s - 1]]], [[[1.0]], [[2.0]]]), K


def test_a_blend_that_grows_is_named() -> None:
    """Beyond s = 4 the middle of both rules is unstable; the text says which blend it is."""
    model, K = opposed(4.0)
    found = certify(model, K, decay_rate=0)

    assert found.verdict is Verdict.DISPROVED
    assert "none does along 1/2 rule 1 + 1/2 rule 2" in found.checked.claims[0].text


def test_a_blend_is_decided_at_its_threshold() -> None:
    """At h = (1/2, 1/2), and at (1/3, 2/3), where G = -1 + 2 s / 9."""
    for shares, edge in (([1, 1], 4), ([1, 2], 4.5), ([0.5, 1], 4.5)):
        claim = ALONE | {"blend": [shares]}
        for s, verdict in ((edge + 0.001, "DISPROVED"), (edge - 0.001, "UNDECIDED")):
            model, K = opposed(s)
            data = model_data(model.A.tolist(), B=model.B.tolist())
            assert verdict_of(data, law_data(K), claim) == verdict
