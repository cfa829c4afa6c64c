"""What `certify` is given that it cannot take: what was given, what is needed, which entry."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from takagi.certificates import certify
from takagi.certificates.requests import Decay
from takagi.models import ModelError, TSModel

K = [[[1.0, 2.0]], [[1.0, 3.0]]]


def model() -> TSModel:
    A = [[[0.0, 1.0], [-1.0, -1.0]], [[0.0, 1.0], [-2.0, -1.0]]]
    return TSModel(np.array(A), np.array([[[0.0], [1.0]]] * 2))


@pytest.mark.parametrize(
    ("claims", "words"),
    [
        (["foo"], r"claims\[0\]: 'foo' was given; a request is needed, such as Decay\(\)"),
        ([Decay(), 3], r"claims\[1\]: 3 was given; a request is needed"),
        ([Decay(), None], r"claims\[1\]: None was given"),
        ([Decay], r"claims\[0\]: the class Decay was given; .* such as Decay\(\)"),
        (["x" * 99], r"claims\[0\]: 'x{59}\.\.\. was given"),
        (Decay(), r"claims: Decay\(decay_rate=None\) was given; a list of requests is needed"),
        (7, r"claims: 7 was given; a list of requests"),
    ],
)
def test_what_is_no_request_is_named(claims: Any, words: str) -> None:
    with pytest.raises(TypeError, match=words):
        certify(model(), K, claims=claims)


@pytest.mark.parametrize(
    ("entry", "words"),
    [
        (np.nan, r"K\[1, 0, 1\] is nan; every entry must be finite"),
        (-np.inf, r"K\[1, 0, 1\] is -inf; every entry must be finite"),
        ("fast", "K cannot be read as an array of numbers .*'fast'"),
    ],
)
def test_a_gain_that_is_no_number_is_named(entry: Any, words: str) -> None:
    gains: Any = [[[1.0, 2.0]], [[1.0, entry]]]

    with pytest.raises(ModelError, match=words):
        certify(model(), gains)
    with pytest.raises(ModelError, match=words.replace("1, 0, 1", "0, 1")):
        certify(model(), gains[1])


def test_gains_of_another_shape_say_which_are_needed() -> None:
    with pytest.raises(ModelError, match=r"shape \(1, 3\); .* \(2, 1, 2\), or \(1, 2\) for one"):
        certify(model(), [[1.0, 2.0, 3.0]])
