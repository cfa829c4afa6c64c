"""Peaks under bounded disturbance: exact thresholds, and a simulation."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.certificates.document.certificate_file import certificate_document
from takagi.certificates.requests import Peak
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models import TSModel
from tests.certificates.kinds.claims import model_data, verdict_of, verdicts

Data = dict[str, Any]


def line() -> tuple[Data, Data]:
    """Return x' = -2 x + w, y = x: |y| <= sup |w| / 2, reached at last by w = 1, and a claim."""
    model = model_data([[[-2]]], E=[[[1]]], C=[[[1]]])
    claim = {"name": "line", "kind": "peak", "disturbance": "disturbances", "disturbance_norm": 1}
    return model, claim | {"gain": 0.5, "P": [[1]], "level": 0.25, "multiplier": 2}


def sampled() -> tuple[Data, Data]:
    """Return x+ = x/2 + w, y = x: |y| <= 2 sup |w|, reached at last by w = 1, and a claim."""
    model = model_data([[[0.5]]], E=[[[1]]], C=[[[1]]], sample_time=0.1)
    claim = {"name": "line", "kind": "peak", "disturbance": "disturbances", "disturbance_norm": 1}
    return model, claim | {"gain": 2, "P": [[1]], "level": 4, "multiplier": 0.5}


@pytest.mark.parametrize("case", [line, sampled])
def test_peak_at_its_exact_value_and_below(case: Any) -> None:
    """1/a and 1/(1 - a): the bound is reached, so it is proved itself, and nothing less is."""
    model, claim = case()
    less = 1 - 1e-12

    assert verdict_of(model, None, claim) == "PROVED"
    for key in ("gain", "level"):
        mutant = claim | {key: claim[key] * less}
        assert verdict_of(model, None, mutant) == "UNDECIDED"
    more = claim | {"disturbance_norm": 1 + 1e-12}
    assert verdict_of(model, None, more) == "UNDECIDED"


numbers = st.floats(-1.0, 1.0).map(lambda value: round(value, 3))
matrices = st.lists(numbers, min_size=4, max_size=4).map(lambda v: np.reshape(v, (2, 2)))


@pytest.mark.slow
@settings(max_examples=8, deadline=None)
@given(matrices, matrices, st.booleans())
def test_proved_peak_holds_in_simulation(first: Any, second: Any, discrete: bool) -> None:
    """Blends that jump and a disturbance of full size that switches never exceed the bound."""
    step = 0.01
    A = np.array([M * 0.4 if discrete else M - 2.5 * np.eye(2) for M in (first, second)])
    model = TSModel(
        A,
        C=[[[1.0, 0.3]], [[0.7, -0.2]]],
        E=[[[1.0], [0.5]], [[0.8], [-0.5]]],
        sample_time=0.1 if discrete else None,
    )
    attempt = Peak().attempt(ClaimedLoop.of(model))
    assert attempt.proved

    draw = np.random.default_rng(1)
    x, most = np.zeros(2), 0.0
    for _ in range(1000):
        h = draw.dirichlet([0.3, 0.3])
        w = draw.choice([-1.0, 1.0]) * attempt.claim["disturbance_norm"]
        moved = np.einsum("i,ijk,k->j", h, model.A, x) + h @ model.E[:, :, 0] * w
        x = moved if discrete else x + step * moved
        most = max(most, abs(float(h @ model.C[:, 0] @ x)))
    assert most <= attempt.claim["gain"] * attempt.claim["disturbance_norm"] * 1.01


@pytest.mark.parametrize(("gain", "verdict"), [(2, "PROVED"), (1.9999, "UNDECIDED")])
def test_a_disturbance_that_reaches_the_output_directly(gain: float, verdict: str) -> None:
    """x' = -x + w with |w| <= 1 keeps |x| <= 1, so that y = x + w reaches 2."""
    model = model_data([[[-1]]], E=[[[1]]])
    claim = {"name": "p", "kind": "peak", "P": [[1]], "level": 1, "multiplier": 1, "share": 0.5}
    claim |= {"disturbance": "disturbances", "disturbance_norm": 1, "gain": gain}
    claim |= {"output": {"C": [[[1]]], "F": [[[1]]]}}
    document = certificate_document(model=model, gains=None, claims=[claim], provenance={})

    assert verdicts(document) == [verdict]
