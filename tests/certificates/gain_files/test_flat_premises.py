"""A premise with one bound has the weight 0 in a program; bounds that are one float have none."""

from __future__ import annotations

from typing import Any

import pytest

from takagi.certificates.checker.controller import content
from takagi.certificates.checker.kernel import reader, refusal
from tests.certificates.recorded.inputs import of_model


def steps(lower: str, upper: str) -> tuple[str, list[dict[str, Any]]]:
    """Return the first premise's name, and the steps of a law whose premise has these bounds."""
    data = of_model("cart")
    law = data["gains"]
    first = {**law["premises"][0], "lower": reader.Number(lower), "upper": reader.Number(upper)}
    law = {**law, "premises": [first, *law["premises"][1:]]}
    whole = content.file_content(data["model"], law, data["controller"])
    return first["name"], whole["programs"][0]["steps"]


@pytest.mark.parametrize(
    ("lower", "upper", "flat"),
    [
        ("1", "1.0", True),
        ("10e-1", "1", True),
        ("1", "1.000000000000001", False),
        ("-0", "0", True),
    ],
)
def test_a_premise_with_one_bound(lower: str, upper: str, flat: bool) -> None:
    name, all_steps = steps(lower, upper)
    (weight,) = (one["formula"] for one in all_steps if one["set"] == f"{name}_weight")
    assert weight == "0" if flat else "limit(" in weight


def test_bounds_that_are_one_float_have_no_program() -> None:
    """The claim is about every weight, and a program could give none but 0."""
    with pytest.raises(refusal.CertificateError, match="one number in the floats"):
        steps("1", "1.00000000000000000001")
