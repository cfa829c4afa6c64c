"""All that can be said of a loop in one certificate, and what a proof says of random blends."""

from __future__ import annotations

from typing import Any

import numpy as np
from hypothesis import strategies as st

from takagi.certificates import Verdict, certify, check
from takagi.certificates.requests import ObservedFeedback, ObserverError
from takagi.certificates.requests.attempts import attempts_at_all
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.lmi import observer, pdc
from takagi.models import TSModel, sector_model
from takagi.models.plant_files.loader import load_plant

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
