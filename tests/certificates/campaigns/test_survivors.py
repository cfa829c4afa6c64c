"""What the campaign of broken lines found untested: words of sentences that are proved."""

from __future__ import annotations

from typing import Any

from takagi.certificates import Verdict
from tests.certificates.kinds.claims import law_data, model_data, said_of


def test_half_width_of_a_strip_is_said() -> None:
    """|Im z| < 3 is [[-6, z - conj(z)], [conj(z) - z, -6]] < 0; poles at -1 +- 2i."""
    model = model_data([[[-1, 2], [-2, -1]]])
    part = {"L": [[-6, 0], [0, -6]], "M": [[0, 1], [-1, 0]]}
    claim = {"name": "strip", "kind": "region", "P": [[1, 0], [0, 1]], "parts": [part]}

    found = said_of(model, None, claim)

    assert found.verdict is Verdict.PROVED
    assert "|Im z| < 3" in found.text


def test_steps_of_one_entry_are_said() -> None:
    """x' = -3 x - (k x_1 + l x_2) in each state: only the first gain may be off."""
    model = model_data([[[-3, 0], [0, -3]]], B=[[[1], [1]]])
    claim: dict[str, Any] = {"name": "steps", "kind": "gain-rounding", "P": [[1, 0], [0, 1]]}
    claim |= {"decay_rate": 0, "relative": 0, "absolute": [[0.1, 0]], "tau": [0.1]}

    found = said_of(model, law_data([[[0, 0]]]), claim)

    assert found.verdict is Verdict.PROVED
    assert "the stated absolute steps" in found.text
