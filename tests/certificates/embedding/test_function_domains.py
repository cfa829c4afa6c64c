"""Each function on the very box where it has a value, and on one that is a hundredth wider."""

from __future__ import annotations

from typing import Any

import pytest

from takagi.certificates import CertificateError, Claim, Verdict
from takagi.certificates.checker import check_document
from takagi.certificates.document.certificate_file import certificate_document

Data = dict[str, Any]
CLAIM = {"name": "tied", "kind": "sector-embedding"}


def model_of(equation: str, **state: Any) -> Data:
    """Return x' = -x as the model of a plant on -1 <= x <= 1 with this equation."""
    one: Data = {"name": "x", "unit": "-", "rest": 0, "range": [-1, 1]} | state
    model: Data = {"kind": "plant", "name": "d", "sample_time": None, "states": [one]}
    model |= {"inputs": [], "disturbances": [], "outputs": [], "parameters": {}}
    return model | {"equations": [equation], "embedding": {"premises": [], "A": [["-1"]]}}


def said(model: Data, claim: Data = CLAIM) -> Claim:
    document = certificate_document(model=model, gains=None, claims=[claim], provenance={})
    return check_document(document).claims[0]


@pytest.mark.parametrize(
    ("inside", "beyond"),
    [
        ("asin(x)", "asin(1.01*x)"),
        ("acos(x)", "acos(1.01*x)"),
        ("acosh(x + 2)", "acosh(x + 1.99)"),
        ("atanh(0.99*x)", "atanh(x)"),
        ("log(x + 1.01)", "log(x + 1)"),
        ("tan(1.57*x)", "tan(1.58*x)"),
        ("sqrt(x + 1)", "sqrt(x + 0.99)"),
        ("1/(x + 1.01)", "1/(x + 1)"),
        ("1/(x - 1.01)", "1/(x - 1)"),
    ],
)
def test_a_function_on_its_domain(inside: str, beyond: str) -> None:
    """What is multiplied by zero must have a value all the same: 0 f(x) is not folded away."""
    assert said(model_of(f"-x + 0*{inside}")).verdict is Verdict.PROVED

    found = ""
    try:
        claim = said(model_of(f"-x + 0*{beyond}"))
        assert claim.verdict is Verdict.UNDECIDED
        found = claim.text
    except CertificateError as error:
        found = str(error)
    assert found


def test_a_deviation_has_a_name_of_its_own() -> None:
    """Where the rest is not zero, the equations say x and the model x - 3: two symbols."""
    shifted = {"rest": 3, "range": [2, 4]}

    assert said(model_of("3 - x", **shifted, symbol="delta_x")).verdict is Verdict.PROVED
    with pytest.raises(CertificateError, match="a name of its own"):
        said(model_of("3 - x", **shifted, symbol="x"))


@pytest.mark.parametrize("kind", ["sector-embedding", "secant-embedding"])
def test_a_claim_about_a_plant_needs_one(kind: str) -> None:
    model = {"kind": "takagi-sugeno", "sample_time": None, "state_names": ["x [-]"], "A": [[[-1]]]}

    with pytest.raises(CertificateError, match="a claim about a plant; model.kind is"):
        said(model, CLAIM | {"kind": kind})
