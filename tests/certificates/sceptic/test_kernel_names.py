"""Rows of gains belong to inputs, ranges to variables: names that disagree are refused."""

from __future__ import annotations

import pytest

from takagi.certificates import CertificateError, Verdict
from takagi.certificates.document.certificate_file import certificate_document
from tests.certificates.both_checkers import second, verdicts
from tests.certificates.kinds.claims import Data, law_data, model_data, said_of

DECAY = {"name": "a", "kind": "decay", "decay_rate": 0.5, "P": [[1, 0], [0, 1]]}
# The first input drives x1 and the second x2, each with its own gain.
MODEL = model_data([[[1, 0], [0, 1]]], B=[[[1, 0], [0, 1]]], input_names=["u [-]", "v [-]"])
K = [[[2, 0], [0, 2]]]


def test_inputs_in_another_order_are_refused() -> None:
    """The same numbers with the rows' names exchanged are another law."""
    assert said_of(MODEL, law_data(K, input_names=["u [-]", "v [-]"]), DECAY).verdict is (
        Verdict.PROVED
    )
    with pytest.raises(CertificateError, match="inputs are not the model's"):
        said_of(MODEL, law_data(K, input_names=["v [-]", "u [-]"]), DECAY)


def test_number_of_input_names_is_compared() -> None:
    with pytest.raises(CertificateError, match="2 different names"):
        said_of(MODEL, law_data(K, input_names=["u [-]"]), DECAY)


def test_box_that_may_mean_a_state_or_an_input_shows_nothing() -> None:
    """With |u| <= 0.1 the ellipsoid asks for too much; as a range of x1 it would be kept."""
    model = model_data([[[-1]]], B=[[[1]]], box={"x1 [-]": [-2, 2]})
    claim = {"name": "a", "kind": "invariant-ellipsoid", "P": [[1]], "level": 1, "multiplier": 1}

    named = model | {"input_names": ["x1 [-]"]}
    assert said_of(model, law_data([[[3]]]), claim).verdict is Verdict.PROVED
    assert "have one name" in said_of(named, law_data([[[3]]]), claim).text
    assert said_of(named, law_data([[[3]]]), claim).verdict is Verdict.UNDECIDED
    assert both(named, law_data([[[3]]]), claim) == (["UNDECIDED"], ["UNDECIDED"])


def both(model: Data, gains: Data | None, claim: Data) -> tuple[list[str], list[str]]:
    """Return the verdicts of both checkers."""
    document = certificate_document(model=model, gains=gains, claims=[claim], provenance={})
    return verdicts(document), second(document)


@pytest.mark.parametrize(("gain", "expected"), [(1.0, "PROVED"), (1.01, "UNDECIDED")])
def test_range_of_an_input_that_the_law_alone_names(gain: float, expected: str) -> None:
    """u = -K x with |x| <= 1 keeps |u| <= 1 up to K = 1, whoever says that the input is u."""
    model = model_data([[[-1]]], B=[[[1]]], box={"x1 [-]": [-1, 1], "u [-]": [-1, 1]})
    gains = law_data([[[gain]]], input_names=["u [-]"])
    claim = {"name": "a", "kind": "invariant-ellipsoid", "P": [[1]], "level": 1, "multiplier": 1}

    assert both(model, gains, claim) == ([expected], [expected])
    assert both(model | {"input_names": ["u [-]"]}, gains, claim) == ([expected], [expected])


@pytest.mark.parametrize(("name", "expected"), [("w [-]", "PROVED"), ("x1 [-]", "UNDECIDED")])
def test_box_that_may_mean_a_state_or_a_disturbance(name: str, expected: str) -> None:
    """|x1| <= 1 is kept for |w| <= 10, and |w| <= 1 is not."""
    model = model_data([[[-11]]], E=[[[1]]], box={"x1 [-]": [-1, 1]}, disturbance_names=[name])
    claim = {"name": "a", "kind": "invariant-ellipsoid", "P": [[1]], "level": 1, "multiplier": 10}
    claim |= {"disturbance": "disturbances", "disturbance_bounds": [10]}

    assert both(model, None, claim) == ([expected], [expected])
