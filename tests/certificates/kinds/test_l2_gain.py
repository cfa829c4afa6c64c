"""The energy gain: exact thresholds, and other ways to the same number."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.certificates import Verdict, certify
from takagi.certificates.requests import L2Gain
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.lmi import hinf_norm
from takagi.models import ModelError, TSModel
from tests.certificates.kinds.claims import model_data, said_of, verdict_of

Data = dict[str, Any]


def line() -> tuple[Data, Data]:
    """Return x' = -2 x + w, y = x, whose gain is 1/2 by its response at rest, and a claim."""
    model = model_data([[[-2]]], E=[[[1]]], C=[[[1]]])
    claim = {"name": "line", "kind": "l2-gain", "disturbance": "disturbances"}
    return model, claim | {"gain": 0.500000001, "P": [[1]]}


def sampled() -> tuple[Data, Data]:
    """Return x+ = x/2 + w, y = x, whose gain is 1 / (1 - 1/2) = 2, and a claim."""
    model = model_data([[[0.5]]], E=[[[1]]], C=[[[1]]], sample_time=0.1)
    claim = {"name": "line", "kind": "l2-gain", "disturbance": "disturbances"}
    return model, claim | {"gain": 2.00000001, "P": [[1]]}


def loop() -> TSModel:
    return TSModel(
        [[[0.0, 1.0], [-1.0, -0.4]], [[0.0, 1.0], [-3.0, -0.2]]],
        [[[0.0], [1.0]], [[0.0], [1.5]]],
        C=[[[1.0, 0.0]], [[0.8, 0.1]]],
        D=[[[0.1]], [[0.2]]],
        E=[[[0.0], [1.0]], [[0.2], [1.0]]],
    )


K = np.array([[[1.0, 2.0]], [[0.5, 1.5]]])


@pytest.mark.parametrize(("case", "limit"), [(line, 0.5), (sampled, 2.0)])
def test_gain_from_both_sides_of_its_exact_value(case: Any, limit: float) -> None:
    model, claim = case()

    assert verdict_of(model, None, claim) == "PROVED"
    for gain in (limit, limit - 1e-9):
        assert verdict_of(model, None, claim | {"gain": gain}) == "UNDECIDED"


def test_two_disturbances_and_one_output() -> None:
    """y = x + [1, 0] w of x' = -2 x + [1, 1] w: [3/2, 1/2] at rest, sqrt(10) / 2 = 1.5811388..."""
    model = model_data([[[-2]]], E=[[[1, 1]]], C=[[[1]]])
    output = {"output": {"C": [[[1]]], "F": [[[1, 0]]]}}
    claim = {"name": "two", "kind": "l2-gain", "disturbance": "disturbances", **output}

    # By hand, P is at its best where gamma P = 1 at the limit.
    proved = [said_of(model, None, claim | {"gain": 1.6, "P": [[p / 100]]}) for p in range(1, 200)]
    assert any(found.verdict is Verdict.PROVED for found in proved)
    for p in range(1, 200):
        below = claim | {"gain": 1.58113, "P": [[p / 100]]}
        assert verdict_of(model, None, below) == "UNDECIDED"


def test_found_gain_is_the_solvers_a_little_raised() -> None:
    """The claim, exact, against the candidate of ``hinf_norm`` for the blends as arrays."""
    made = ClaimedLoop.of(loop(), K)
    least = hinf_norm(made.A, made.E, made.C).gain
    assert least is not None

    attempt = L2Gain().attempt(made)

    assert attempt.proved
    assert least < attempt.claim["gain"] <= least * 1.002


def test_asked_gain_near_the_least_one() -> None:
    made = ClaimedLoop.of(loop(), K)
    least = hinf_norm(made.A, made.E, made.C).gain
    assert least is not None

    assert L2Gain(least * (1 + 1e-5)).attempt(made).proved
    assert not L2Gain(least * (1 - 1e-4)).attempt(made).proved


def test_disturbance_added_to_the_input() -> None:
    """E = B says the same as "inputs", for a model without direct feed-through."""
    model = loop()
    same = TSModel(model.A, model.B, C=model.C, E=model.B)
    without = TSModel(model.A, model.B, C=model.C)

    ways = [L2Gain().attempt(ClaimedLoop.of(m, K)).claim for m in (same, without)]

    assert [claim["disturbance"] for claim in ways] == ["disturbances", "inputs"]
    assert ways[0]["gain"] == pytest.approx(ways[1]["gain"], rel=1e-6)


def test_certificate_with_several_claims(tmp_path: Any) -> None:
    certificate = certify(loop(), K, claims=[L2Gain(), L2Gain(output=(np.eye(2),))])

    assert certificate.verdict is Verdict.PROVED
    assert [claim["kind"] for claim in certificate.document["claims"]] == ["l2-gain"] * 2


def test_unstable_loop_is_not_claimed() -> None:
    model = TSModel([[[0.1]]], C=[[[1.0]]], E=[[[1.0]]])

    attempt = L2Gain().attempt(ClaimedLoop.of(model))

    assert attempt.checked.verdict is Verdict.UNDECIDED
    assert "not stable" in attempt.tried[0]


def test_misuse_raises() -> None:
    with pytest.raises(ModelError, match="positive"):
        L2Gain(-1.0)
    with pytest.raises(ModelError, match="no output"):
        L2Gain().attempt(ClaimedLoop.of(TSModel([[[-1.0]]], E=[[[1.0]]])))
    with pytest.raises(ModelError, match="none such"):
        L2Gain().attempt(ClaimedLoop.of(TSModel([[[-1.0]]], C=[[[1.0]]])))


numbers = st.floats(-1.0, 1.0).map(lambda value: round(value, 3))
matrices = st.lists(numbers, min_size=4, max_size=4).map(lambda v: np.reshape(v, (2, 2)))


@settings(max_examples=25, deadline=None)
@given(matrices, st.booleans(), st.lists(numbers, min_size=4, max_size=4))
def test_proved_gain_is_above_every_frequency_response(
    A: Any, discrete: bool, vectors: list[float]
) -> None:
    """A lower bound of the truth, by the response at sampled frequencies, never exceeds a proof."""
    A = A * 0.6 if discrete else A - 1.6 * np.eye(2)
    B, C = np.reshape(vectors[:2], (2, 1)) + 0.1, np.reshape(vectors[2:], (1, 2)) + 0.15
    model = TSModel([A], C=[C], E=[B], sample_time=0.5 if discrete else None)
    points = (
        np.exp(1j * np.linspace(0, np.pi, 60)) if discrete else 1j * np.geomspace(1e-3, 1e2, 60)
    )
    response = max(abs((C @ np.linalg.solve(s * np.eye(2) - A, B))[0, 0]) for s in points)

    attempt = L2Gain().attempt(ClaimedLoop.of(model))

    poles = np.linalg.eigvals(A)
    if not (np.abs(poles).max() < 0.98 if discrete else poles.real.max() < -0.02):
        return
    assert attempt.proved
    assert attempt.claim["gain"] >= response * (1 - 1e-9)
