"""The program of a gain file commands what the claims are about, or there is no such file."""

from __future__ import annotations

from typing import Any

import pytest

from takagi.certificates import CertificateError
from takagi.certificates.checker.controller import content
from takagi.certificates.document.certificate_file import certificate_document
from tests.certificates.both_checkers import second, verdicts
from tests.certificates.kinds.claims import Data, law_data, model_data

PREMISE = {"name": "p", "unit": "-", "lower": 0, "upper": 1}
# x' = -x + u in rule 1, x' = -x - u in rule 2.
MODEL = model_data([[[-1]], [[-1]]], B=[[[1]], [[-1]]], input_names=["u [-]"])
LAW = law_data([[[1.5]], [[0.5]]], input_names=["u [-]"], trim={"state": [0], "input": [0]})


def steps(law: Data) -> list[str]:
    """Return the formulas of the program of a law."""
    program = content.file_content(MODEL, law, {"name": "two rules"})["programs"][0]
    return [str(one["formula"]) for one in program["steps"]]


def with_premises(*changes: Data) -> Data:
    premises = [PREMISE | change for change in changes]
    rules = [[0] * len(premises), [1, *[0] * (len(premises) - 1)]]
    return LAW | {"premises": premises, "rules": rules}


def test_gains_that_nothing_blends_have_no_program() -> None:
    """Every blend with the weights of the model decays at 0.4 1/s: the claim is true.

    A program without weights would command u = -1.5 x always, and x' = x/2 in rule 2.
    """
    claim = {"name": "d", "kind": "decay", "P": [[1]], "decay_rate": 0.4}
    document = certificate_document(model=MODEL, gains=LAW, claims=[claim], provenance={})
    assert verdicts(document) == second(document) == ["PROVED"]

    with pytest.raises(CertificateError, match="no premises that say how they are blended"):
        steps(LAW)
    assert steps(LAW | {"K": [[[1.5]], [["1.50"]]]})[-1] == "u_rest - (K_u_x1*x1_deviation)"
    blended = "u_rest - (mix(rules, K_u_x1, p_weight)*x1_deviation)"
    assert steps(with_premises({}))[-1] == blended


def test_premises_of_one_name_have_no_program() -> None:
    """The bounds of the second would be those of both."""
    assert "limit((q - q_lower)/(q_upper - q_lower), 0, 1)" in steps(
        with_premises({}, {"name": "q", "upper": 2})
    )
    with pytest.raises(CertificateError, match="different names"):
        steps(with_premises({}, {"upper": 2}))


@pytest.mark.parametrize(("lower", "upper"), [(1, 1), (1, 1.0), ("1", "2/2")])
def test_weight_of_a_constant_premise_is_no_quotient(lower: Any, upper: Any) -> None:
    """(z - 1)/(1 - 1) is no number, however the two bounds are written."""
    constant = {"name": "q", "lower": lower, "upper": upper}

    assert steps(with_premises({}, constant))[-2] == "0"
    assert steps(with_premises({}, constant | {"upper": 1.25}))[-2] != "0"
