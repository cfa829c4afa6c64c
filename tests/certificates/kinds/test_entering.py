"""Norms from some of the disturbances, the others at rest: exact thresholds.

x' = -2 x + w1/5 + 3 w2, y = x: from one disturbance with the entry e the energy gain and the peak
are e/2, and the variance of y under white noise is e^2/4; from both, e is their Euclidean norm.
"""

from __future__ import annotations

from typing import Any

import pytest

from tests.certificates.kinds.claims import model_data, verdict_of

Data = dict[str, Any]
NAMES = ["w1 [N]", "w2 [m/s]"]
GAIN = {"kind": "l2-gain"}
NOISE = {"kind": "h2-norm"}
PEAK = {"kind": "peak", "disturbance_norm": 1, "multiplier": 2}


def plant(**others: Any) -> Data:
    return model_data([[[-2]]], E=[[[0.2, 3]]], C=[[[1]]], disturbance_names=NAMES, **others)


def claims(entry: float, **members: Any) -> list[Data]:
    """Return the three norms for an entry e, each 1e-9 above its true value at most."""
    base = {"name": "norm", "disturbance": "disturbances", **members}
    norm = entry / 2 * (1 + 1e-9)
    return [
        base | GAIN | {"gain": norm, "P": [[1 / entry]]},
        base | NOISE | {"norm": norm, "P": [[0.2500000001]]},
        base | PEAK | {"gain": norm, "level": entry**2 / 4 * (1 + 1e-9), "P": [[1]]},
    ]


@pytest.mark.parametrize("number", range(3))
def test_each_disturbance_alone_from_both_sides(number: int) -> None:
    """The norm of a named disturbance is proved, and is none of the other, nor of both."""
    for name, entry in zip(NAMES, (0.2, 3.0), strict=True):
        claim = claims(entry, entering=[name])[number]

        assert verdict_of(plant(), None, claim) == "PROVED"
        less = {k: 0.999 * claim[k] for k in ("gain", "norm") if k in claim}
        assert verdict_of(plant(), None, claim | less) == "UNDECIDED"
        assert verdict_of(plant(), None, {k: v for k, v in claim.items() if k != "entering"}) == (
            "UNDECIDED"
        )
    weak = claims(0.2, entering=[NAMES[1]])[number]
    assert verdict_of(plant(), None, weak) == "UNDECIDED"
