"""Rounded gains: scalar loops whose room is known, and corners of the box of all roundings."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pytest

from takagi.certificates import Verdict, certify
from takagi.certificates.requests import GainRounding
from takagi.models import TSModel
from tests.certificates.kinds.claims import Data, law_data, model_data, verdict_of


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
