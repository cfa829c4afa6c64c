"""Requests of claims: all at once, and those that make no sense for the model."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import strategies as st

from takagi.certificates import Verdict, certify, check
from takagi.certificates.requests import (
    Decay,
    FuzzyL2Gain,
    GainRounding,
    H2Norm,
    InputLimits,
    InvariantEllipsoid,
    L2Gain,
    ObservedFeedback,
    ObserverError,
    SampledLoop,
    Transient,
)
from takagi.certificates.requests.attempts import attempts_at_all
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.lmi import observer, pdc
from takagi.models import ModelError, TSModel, sector_model
from takagi.models.plant_files.loader import load_plant
from tests.certificates.kinds.test_input_limits import mass

LAG = TSModel([[[-1.0]]])
FED = TSModel([[[-1.0]]], [[[1.0]]])
PUSHED = TSModel([[[-1.0]]], E=[[[1.0]]])
SEEN = TSModel([[[-1.0]]], C=[[[1.0]]])
PLANE = TSModel(
    [[[0.0, 1.0], [-2.0, -1.0]]], [[[0.0], [1.0]]], C=[[[1.0, 0.0]]], E=[np.eye(2)],
    states=["p [m]", "v [m/s]"], box={"p [m]": (-1, 2), "v [m/s]": (-2, 2)},
)  # fmt: skip
K = np.array([[[1.0, 2.0]]])
PLANE_LOOP = ClaimedLoop.of(PLANE, K)


@pytest.mark.parametrize(
    ("words", "asked"),
    [
        ("'all'", lambda: certify(LAG, claims="everything")),  # type: ignore[arg-type]
        ("a number >= 0", lambda: certify(FED, decay_rate=-1)),
        ("claims", lambda: certify(FED, decay_rate=1, claims=[Decay()])),
        ("at least one", lambda: certify(FED, claims=[])),
        ("shape", lambda: certify(FED, gains=[[[1, 2]]])),
        ("positive", lambda: FuzzyL2Gain(gain=-1.0)),
        ("no output", lambda: certify(PUSHED, claims=[FuzzyL2Gain()])),
        ("no gains", lambda: certify(LAG, claims=[GainRounding()])),
        ("steps", lambda: certify(PLANE, K, claims=[GainRounding(absolute=[[1.0]])])),
        ("steps", lambda: certify(PLANE, K, claims=[GainRounding(absolute=[[-1.0, 0.0]])])),
        ("steps", lambda: certify(PLANE, K, claims=[GainRounding(absolute=[[0.0, 0.0]])])),
        ("positive", lambda: H2Norm(0.0)),
        ("give gains", lambda: InputLimits().attempt(ClaimedLoop.of(PLANE))),
        ("1 positive", lambda: InputLimits(limits=[1.0, 2.0]).attempt(PLANE_LOOP)),
        ("membership_rates", lambda: InputLimits(rates=True).attempt(ClaimedLoop.of(*mass()))),
        ("no box", lambda: InvariantEllipsoid().attempt(ClaimedLoop.of(LAG))),
        ("2 numbers", lambda: InvariantEllipsoid(disturbance_bounds=[1.0]).attempt(PLANE_LOOP)),
        ("symmetric", lambda: InvariantEllipsoid(P=np.eye(3)).attempt(PLANE_LOOP)),
        ("positive", lambda: L2Gain(-1.0)),
        ("no output", lambda: L2Gain().attempt(ClaimedLoop.of(PUSHED))),
        ("none such", lambda: L2Gain().attempt(ClaimedLoop.of(SEEN))),
        ("gains K", lambda: ObservedFeedback(np.ones((2, 1))).attempt(ClaimedLoop.of(PLANE))),
        ("L has shape", lambda: ObserverError(np.ones((3, 1))).attempt(PLANE_LOOP)),
        ("no output", lambda: ObserverError(np.ones((1, 1))).attempt(ClaimedLoop.of(LAG))),
        ("give gains", lambda: certify(LAG, claims=[SampledLoop(0.1)])),
        ("sample_time", lambda: SampledLoop(0.0)),
        ("between 0 and 1", lambda: Transient(settled_share=1.0)),
        ("positive", lambda: Transient(decay_rate=0.0)),
        ("1 positive", lambda: Transient(scales=[1.0, 2.0]).attempt(ClaimedLoop.of(LAG))),
    ],
)
def test_misuse_is_refused(words: str, asked: Callable[[], Any]) -> None:
    with pytest.raises(ModelError, match=words):
        asked()


Floats = Any


def duffing() -> tuple[TSModel, Floats]:
    model = sector_model(load_plant("duffing"))
    return model, np.round(pdc(model, decay_rate=0.5).require()[0], 3)


def test_everything_about_a_plant_is_proved_and_replayed(tmp_path: Any) -> None:
    model, gains = duffing()

    certificate = certify(model, gains, claims="all")

    assert certificate.verdict is Verdict.PROVED
    kinds = [claim["kind"] for claim in certificate.document["claims"]]
    assert kinds[:2] == ["sector-embedding", "decay"]
    assert {"transient", "invariant-ellipsoid", "input-limits"} < set(kinds)
    assert {"l2-gain", "h2-norm", "peak"} < set(kinds)
    saved = certificate.save(tmp_path / "certificate.json")
    assert check(saved).verdict is Verdict.PROVED


def test_an_observer_of_the_loop_is_proved_too() -> None:
    model, gains = duffing()
    L = np.round(observer(model, decay_rate=1.0).require()[0], 3)

    found = certify(model, gains, claims=[ObserverError(L), ObservedFeedback(L)])

    kinds = [claim["kind"] for claim in found.document["claims"]]
    assert kinds[-2:] == ["observer", "observed-feedback"]
    assert found.verdict is Verdict.PROVED


def test_sampled_loop() -> None:
    model = TSModel(
        [[[1.0, 0.1], [0.1, 1.0]], [[1.0, 0.1], [0.3, 0.95]]],
        [[0.0], [0.1]],
        C=[[1.0, 0.0]],
        E=[[0.0], [0.02]],
        states=["p [m]", "v [m/s]"],
        box={"p [m]": (-1, 1), "v [m/s]": (-3, 3)},
        sample_time=0.1,
    )
    gains = np.round(pdc(model, decay_rate=0.3).require()[0], 3)
    certificate = certify(model, gains, claims="all")

    assert certificate.verdict is Verdict.PROVED
    assert len(certificate.document["claims"]) == 8


def test_disturbance_that_only_schedules_spoils_no_claim() -> None:
    model = TSModel(
        [[[-1.0]], [[-2.0]]],
        E=[[1.0, 0.0]],
        C=[[1.0]],
        states=["x [-]"],
        disturbances=["a [-]", "s [-]"],
        box={"x [-]": (-1, 1), "a [-]": (-0.5, 0.6), "s [-]": (1, 2)},
    )

    found, notes = attempts_at_all(ClaimedLoop.of(model))

    assert [attempt.claim["kind"] for attempt in found][-3:] == ["l2-gain", "h2-norm", "peak"]
    assert not notes


def test_without_decay_nothing_else_is_claimed() -> None:
    model = TSModel([[[1.0]]], box={"x1 [-]": (-1, 1)}, states=["x1 [-]"])

    certificate = certify(model, claims="all")

    assert certificate.verdict is not Verdict.PROVED
    assert len(certificate.document["claims"]) == 1


numbers = st.integers(-20, 20)
