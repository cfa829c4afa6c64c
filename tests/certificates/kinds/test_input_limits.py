"""Limits of inputs and rounded gains: exact limits, a simulation, and corners of all roundings."""

from __future__ import annotations

from itertools import combinations_with_replacement, permutations, product
from typing import Any

import numpy as np
import pytest

from takagi.certificates import Verdict, certify
from takagi.certificates.requests import GainRounding, InputLimits
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.lmi import pdc
from takagi.models import TSModel, sector_model
from takagi.models.plant_files.loader import load_plant
from tests.certificates.kinds.claims import Data, law_data, model_data, verdict_of


def mass() -> tuple[TSModel, Any]:
    model = sector_model(load_plant("mass_spring_damper"))
    return model, np.round(pdc(model, decay_rate=0.2).require()[0], 3)


def test_found_limits_are_those_of_the_float_bound() -> None:
    """The proved rate against |K(h) G(h) x| + |K(h)' x| from their rows, in floating point."""
    model, gains = mass()
    phi = 0.7

    attempt = InputLimits(rates=True, membership_rates=phi).attempt(ClaimedLoop.of(model, gains))

    assert attempt.proved
    claim = attempt.claim
    Q = np.linalg.inv(np.array(claim["P"]) / claim["level"])
    closed = model.A[:, None] - model.B[:, None] @ gains[None]
    rows = [
        np.mean([gains[j] @ closed[i, k] for j, i, k in permutations(rules)], axis=0)
        for rules in combinations_with_replacement(range(4), 3)
    ]
    # With one bound for four rates that sum to 0 two are at it, and two at its negative.
    signs = [s for s in product((-1, 1), repeat=4) if sum(s) == 0]
    moved = np.tensordot(signs, gains, axes=1)
    lengths = [max(float((row @ Q @ row.T)[0, 0]) ** 0.5 for row in part) for part in (rows, moved)]
    bound = lengths[0] + phi * lengths[1]
    assert bound <= claim["rate_limits"][0] <= bound * 1.001


def test_asked_limits_shape_the_set() -> None:
    """A set sought for half the inputs is larger than the free one made smaller."""
    model, gains = mass()
    free = InputLimits().attempt(ClaimedLoop.of(model, gains)).claim
    half = [0.5 * free["input_limits"][0]]

    asked = InputLimits(limits=half).attempt(ClaimedLoop.of(model, gains))

    assert asked.proved
    assert asked.claim["input_limits"] == half
    volumes = [np.linalg.det(np.array(c["P"]) / c["level"]) ** -0.5 for c in (asked.claim, free)]
    assert 0.25 * volumes[1] < volumes[0] < volumes[1]


def test_limits_alone_bound_the_set() -> None:
    """Without a box the set is as large as the limits let it be: |3 x| <= 6."""
    model = TSModel([[[1.0]]], [[[1.0]]])

    attempt = InputLimits(limits=[6.0]).attempt(ClaimedLoop.of(model, np.array([[3.0]])))

    assert attempt.proved
    reach = np.sqrt(attempt.claim["level"] / attempt.claim["P"][0][0])
    assert 1.999 < reach <= 2


def test_inputs_keep_their_limits_in_simulation() -> None:
    model, gains = mass()
    claim = InputLimits().attempt(ClaimedLoop.of(model, gains)).claim
    P, level = np.array(claim["P"]), claim["level"]

    draw = np.random.default_rng(3)
    x = np.linalg.solve(np.linalg.cholesky(P).T, draw.normal(size=(2, 2000)))
    x *= np.sqrt(level / np.einsum("ik,ij,jk->k", x, P, x))
    h = draw.dirichlet(np.full(len(gains), 0.2), size=2000)
    u = np.einsum("kr,rmn,nk->km", h, gains, x)
    assert 0.9 * claim["input_limits"][0] < np.abs(u).max() <= claim["input_limits"][0]


def claim(**others: Any) -> Data:
    base = {"name": "x", "kind": "gain-rounding", "decay_rate": 0, "P": [[1]], "tau": [1]}
    return base | {"absolute": [[0]], "relative": 0} | others


@pytest.mark.parametrize("way", ["absolute", "relative"])
@pytest.mark.parametrize(("sample_time", "A", "room"), [(None, 0, 1), (1, 1.5, 0.5)])
def test_room_of_a_scalar_loop(way: str, sample_time: Any, A: float, room: float) -> None:
    """x' = u, or x+ = 1.5 x + u, with u = -x: stable iff the gain is off by less than the room."""
    model = model_data([[[A]]], B=[[[1]]], sample_time=sample_time)
    gains = law_data([[[1]]], sample_time=sample_time)

    for step, verdict in ((room - 1e-6, Verdict.PROVED), (room, Verdict.UNDECIDED)):
        one = {"absolute": [[step]]} if way == "absolute" else {"relative": step}
        assert verdict_of(model, gains, claim(tau=[step], **one)) == verdict.name


@pytest.mark.parametrize("absolute", [None, [[2.0]]])
def test_no_step_at_all_is_never_claimed(absolute: Any) -> None:
    """x' = -x decays at 1 1/s with this gain, and with no smaller one."""
    found = certify(
        TSModel([[[0.0]]], [[[1.0]]]), [[1.0]], claims=[GainRounding(1.0, absolute=absolute)]
    )
    claimed = found.document["claims"][0]

    assert found.verdict is Verdict.UNDECIDED
    assert claimed["relative"] + claimed["absolute"][0][0] > 0


def loop(sample_time: float | None) -> tuple[TSModel, np.ndarray[Any, Any]]:
    A = np.array([[[0.0, 1.0], [1.0, 0.0]], [[0.0, 1.0], [2.0, 0.0]]])
    B = np.array([[[0.1, 0.0], [1.0, 0.5]], [[0.0, 0.0], [1.1, 0.4]]])
    K = np.array([[[3.0, 2.0], [0.5, 0.1]], [[4.0, 2.0], [0.5, 0.2]]])
    if sample_time is not None:
        A, B = np.eye(2) + sample_time * A, sample_time * B
    return TSModel(A, B, sample_time=sample_time), K


@pytest.mark.parametrize("sample_time", [None, 0.05])
@pytest.mark.parametrize("absolute", [None, [[1.0, 0.5], [0.5, 0.5]]])
def test_every_corner_of_the_roundings_decays(sample_time: float | None, absolute: Any) -> None:
    """V falls at every corner of the box of gains that is claimed: 2^8 of them, in floats."""
    model, K = loop(sample_time)
    found = certify(model, K, claims=[GainRounding(absolute=absolute)])
    assert found.verdict is Verdict.PROVED
    claim = found.document["claims"][0]
    P, rate = np.array(claim["P"]), claim["decay_rate"]
    steps = np.array(claim["absolute"]) + claim["relative"] * np.abs(K)
    assert steps.max() > 0.01

    for signs in product((-1, 1), repeat=K.size):
        moved = K + np.array(signs).reshape(K.shape) * steps
        for i, j in ((0, 0), (0, 1), (1, 1)):
            G = model.A[i] + model.A[j] - model.B[i] @ moved[j] - model.B[j] @ moved[i]
            G = G / 2
            left = P @ G + G.T @ P + 2 * rate * P
            if sample_time is not None:
                left = G.T @ P @ G - np.exp(-2 * rate * sample_time) * P
            assert np.linalg.eigvalsh(left).max() < 0
