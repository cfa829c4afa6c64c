"""A law is of this model only with its times, states, inputs and matrices; and all pairs count."""

from __future__ import annotations

from typing import Any

import pytest

from takagi.certificates import CertificateError, Verdict
from tests.certificates.kinds.claims import law_data, model_data, said_of

Data = dict[str, Any]
DECAY: Data = {"name": "V", "kind": "decay", "decay_rate": 1, "P": [[1, 0], [0, 1]]}
MODEL = model_data([[[-2, 0], [0, -2]]], B=[[[0], [1]]], input_names=["u [N]"])
LAW = law_data([[[0, 0]]], input_names=["u [N]"])


def test_the_law_of_the_model() -> None:
    assert said_of(MODEL, LAW, DECAY).verdict is Verdict.PROVED


@pytest.mark.parametrize(
    ("part", "words"),
    [
        ({"sample_time": 0.1}, "sample_time is not the model's"),
        ({"state_names": ["x2 [-]", "x1 [-]"]}, "in its order"),
        ({"state_names": ["x1 [-]", "x1 [-]"]}, "2 different names"),
        ({"state_names": ["x1 [-]"]}, "2 different names"),
        ({"state_names": ["x1 [-]", "x2 [-]", "x3 [-]"]}, "2 different names"),
        ({"state_names": "x1 [-]"}, "2 different names"),
        ({"input_names": ["F [N]"]}, "in its order"),
        ({"input_names": []}, "1 different names"),
        ({"K": []}, "a list of matrices"),
        ({"K": {"0": [[0, 0]]}}, "a list of matrices"),
        ({"K": [[[0]]]}, "1 by 2"),
    ],
)
def test_another_law_is_refused(part: Data, words: str) -> None:
    with pytest.raises(CertificateError, match=words):
        said_of(MODEL, LAW | part, DECAY)


@pytest.mark.parametrize("A", [[], {"0": [[-2]]}, "[[-2]]", None])
def test_a_model_without_a_list_of_matrices_is_refused(A: Any) -> None:
    model = model_data([[[-2]]]) | {"A": A}

    with pytest.raises(CertificateError, match="a list of matrices"):
        said_of(model, None, DECAY | {"P": [[1]]})


def test_cross_terms_of_outputs_and_gains_count() -> None:
    """y = x - D_i K_j x is 0 in each rule with its own gain, and 2 x in each with the other's.

    Half and half y = x, so that no gain below 2 is shown by these conditions; the inputs are equal,
    and the loop itself is affine in the weights.
    """
    model = model_data([[[-1]]], B=[[[0]]], E=[[[1]]], C=[[[1]]], D=[[[1]], [[-1]]])
    gains = law_data([[[1]], [[-1]]])
    claim = {"name": "y", "kind": "l2-gain", "disturbance": "disturbances", "P": [[2]]}

    below = said_of(model, gains, claim | {"gain": 1.9})
    assert below.verdict is Verdict.UNDECIDED
    assert "rules 1 and 2" in below.text
    assert said_of(model, gains, claim | {"gain": 2.1}).verdict is Verdict.PROVED


@pytest.mark.parametrize(("bound", "expected"), [(1.41, Verdict.PROVED), (1.42, Verdict.UNDECIDED)])
def test_energy_that_keeps_the_state_in_its_box(bound: float, expected: Verdict) -> None:
    """x^2 <= gain bound^2 = 1 with gain 1/2: the bound is the root of two, 1.4142."""
    model = model_data([[[-2.1]]], E=[[[1]]], C=[[[1]]], box={"x1 [-]": [-1, 1]})
    claim = {"name": "y", "kind": "l2-gain", "disturbance": "disturbances", "P": [[1]]}

    found = said_of(model, None, claim | {"gain": 0.5, "energy_bound": bound})

    assert found.verdict is expected, found.text
