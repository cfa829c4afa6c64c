"""Requests that make no sense for the model: each is refused, and the error says what to do."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from takagi.certificates import certify
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
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models import ModelError, TSModel
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
