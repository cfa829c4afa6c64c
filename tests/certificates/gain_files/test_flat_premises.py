"""A premise whose bounds are one float has the weight 0 in a program: its share would be 0/0."""

from __future__ import annotations

import pytest

from takagi.certificates.checker.controller import content
from takagi.certificates.checker.kernel import reader
from tests.certificates.pinned.turbine.recorded_files import certificate


@pytest.mark.parametrize(
    ("lower", "upper", "flat"),
    [
        ("1", "1.0", True),
        ("10e-1", "1", True),
        ("1", "1.00000000000000000001", True),
        ("1", "1.000000000000001", False),
        ("-0", "0", True),
    ],
)
def test_bounds_that_are_one_float(lower: str, upper: str, flat: bool) -> None:
    data = certificate("cart")
    law = data["gains"]
    first = {**law["premises"][0], "lower": reader.Number(lower), "upper": reader.Number(upper)}
    law = {**law, "premises": [first, *law["premises"][1:]]}
    steps = content.file_content(data["model"], law, data["controller"])["programs"][0]["steps"]
    (weight,) = (one["formula"] for one in steps if one["set"] == f"{first['name']}_weight")
    assert weight == "0" if flat else "limit(" in weight
