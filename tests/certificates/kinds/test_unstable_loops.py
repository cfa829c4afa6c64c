"""Unstable loops with a P that is not positive: every inequality holds but P > 0 itself."""

from __future__ import annotations

from typing import Any

import pytest

from takagi.certificates import Verdict
from tests.certificates.kinds.claims import law_data, model_data, said_of

Data = dict[str, Any]
W = {"disturbance": "disturbances"}
SET = {"level": 1, "multiplier": 0.5}
CLAIMS: dict[str, Data] = {
    "l2-gain": {**W, "gain": 10},
    "h2-norm": {**W, "norm": 1},
    "peak": {**W, **SET, "disturbance_norm": 1, "gain": 10},
    "invariant-ellipsoid": SET,
    "input-limits": {**SET, "input_limits": [9]},
    "transient": {
        "decay_rate": 0.1,
        "scales": [1],
        "lower": 1,
        "overshoot": 2,
        "settled_share": 0.5,
        "settling_time": 90,
    },
    "observer": {"L": [[[1]]], "decay_rate": 0},
}


@pytest.mark.parametrize("kind", CLAIMS)
@pytest.mark.parametrize("step", [None, 1])
@pytest.mark.parametrize("p", [-1, 0, 1])
def test_growth_is_never_proved(kind: str, step: Any, p: int) -> None:
    """x' = 2 x + w and x+ = 2 x + w grow; u = -0 x and L = 1 leave 2 or 1 and more of it."""
    model = model_data([[[2]]], B=[[[1]]], C=[[[0.9]]], E=[[[1]]], sample_time=step)
    claim = {"name": "growing", "kind": kind, "P": [[p]], **CLAIMS[kind]}

    found = said_of(model, law_data([[[0]]], sample_time=step), claim)

    assert found.verdict is Verdict.UNDECIDED


@pytest.mark.parametrize("step", [None, 1])
def test_growth_with_an_observer_is_never_proved(step: Any) -> None:
    model = model_data([[[2]]], B=[[[1]]], C=[[[0.9]]], sample_time=step)
    claim = {"name": "g", "kind": "observed-feedback", "L": [[[0]]], "decay_rate": 0}

    for P in ([[-1, 0], [0, -1]], [[1, 0], [0, 1]], [[1, 0], [0, -1]]):
        found = said_of(model, law_data([[[0]]], sample_time=step), claim | {"P": P})
        assert found.verdict is Verdict.UNDECIDED


def test_symmetry_is_needed() -> None:
    model = model_data([[[-1, 0], [0, -1]]], B=[[[1], [0]]], C=[[[1, 0]]], E=[[[1], [0]]])
    changed = {"scales": [1, 1], "L": [[[1], [0]]]}

    for kind, evidence in CLAIMS.items():
        own = {key: changed.get(key, value) for key, value in evidence.items()}
        claim = {"name": "s", "kind": kind, "P": [[1, 0.1], [0, 1]], **own}
        found = said_of(model, law_data([[[0, 0]]]), claim)
        assert found.verdict is Verdict.UNDECIDED
