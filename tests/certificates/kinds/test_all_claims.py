"""All that can be said of a loop in one certificate, and what a proof says of random blends."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.certificates import Verdict, certify, check
from takagi.certificates.requests import ObservedFeedback, ObserverError
from takagi.certificates.requests.attempts import attempts_at_all
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.lmi import observer, pdc
from takagi.models import ModelError, TSModel, sector_model
from takagi.models.plant_files.loader import load_plant
from tests.certificates.kinds.claims import law_data, model_data, verdict_of

Floats = Any


def duffing() -> tuple[TSModel, Floats]:
    """Return a plant with a disturbance, an output and a box, and gains of three digits."""
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
    """A sampled model with disturbance, box and output, and gains of three digits."""
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


def test_unknown_words_are_refused() -> None:
    with pytest.raises(ModelError, match="'all'"):
        certify(TSModel([[[-1.0]]]), claims="everything")  # type: ignore[arg-type]


def _gain(V: Floats, x: Floats, w: Floats, y: Floats, claim: Any) -> float:
    return float(V - claim["gain"] * w @ w + y @ y / claim["gain"])


def _set(V: Floats, x: Floats, w: Floats, y: Floats, claim: Any) -> float:
    """V' - s (c (w/b)^2 - V), whose sign the inequality of a ball decides."""
    P = np.array(claim["P"])
    size = w @ w / claim["disturbance_norm"] ** 2
    return float(V - claim["multiplier"] * (claim["level"] * size - x @ P @ x))


numbers = st.integers(-20, 20)


@pytest.mark.slow
@settings(max_examples=120, deadline=None)
@given(
    st.lists(numbers, min_size=18, max_size=18),
    st.integers(1, 40),
    st.integers(1, 30),
    st.booleans(),
    st.sampled_from(["l2-gain", "peak"]),
)
def test_proof_holds_at_random_blends(
    values: list[int], size: int, other: int, discrete: bool, kind: str
) -> None:
    """Arbitrary claims about arbitrary loops: where one is proved, floats agree at random blends.

    The inequality is evaluated from x, w and the blend of rules i and gains j itself, without the
    means of pairs that the checker takes.
    """
    v = [value / 40 for value in values]
    shift = 0.0 if discrete else 1.0
    A = [[[v[0] - shift, v[1]], [v[2], v[3] - shift]], [[v[4] - shift, v[5]], [v[6], v[7] - shift]]]
    B, K = [[[v[8]], [v[9]]], [[v[10]], [v[11]]]], [[[v[12], v[13]]], [[v[14], v[15]]]]
    C, E = [[[1, v[16]]]], [[[v[17]], [0.5]]]
    model = model_data(A, B=B, C=C, E=E, sample_time=1 if discrete else None)
    claim: dict[str, Any] = {"name": "any", "kind": kind, "disturbance": "disturbances"}
    claim |= {"P": [[size / 5, 0.1], [0.1, other / 5]], "gain": 4}
    if kind == "peak":
        claim |= {"disturbance_norm": 1, "level": 8, "multiplier": 0.4}
    if verdict_of(model, law_data(K, sample_time=1 if discrete else None), claim) != "PROVED":
        return

    excess: Callable[..., float] = _gain if kind == "l2-gain" else _set
    P, draw = np.array(claim["P"]), np.random.default_rng(6)
    for _ in range(200):
        h = draw.dirichlet([0.5, 0.5])
        x, w = draw.normal(size=2), draw.normal(size=1)
        closed = sum(
            h[i] * h[j] * (np.array(A[i]) - np.array(B[i]) @ np.array(K[j]))
            for i in range(2)
            for j in range(2)
        )
        moved = closed @ x + np.array(E[0]) @ w
        V = moved @ P @ moved - x @ P @ x if discrete else 2 * x @ P @ moved
        assert excess(V, x, w, np.array(C[0]) @ x, claim) <= 1e-9
