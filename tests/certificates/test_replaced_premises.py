"""What a gain file's program takes for a premise near 0/0 is compared with the premise."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import CertificateError, read_text
from takagi.certificates.checker.files import gain_file
from takagi.certificates.checker.files.replacements import require_premises
from takagi.certificates.checker.kernel import reader
from takagi.certificates.checker.kernel.refusal import OtherGains
from tests.certificates.recorded.inputs import of_model

PREMISES = [{"name": "z", "expression": "g*sin(x)/x", "lower": 0.42, "upper": 0.5, "unit": "-"}]
MODEL = {
    "kind": "plant",
    "name": "pendulum",
    "sample_time": None,
    "states": [{"name": "x", "unit": "rad", "range": [-1, 1], "rest": 0}],
    "inputs": [{"name": "u", "unit": "-", "range": None, "rest": 0}],
    "disturbances": [],
    "parameters": {"g": "1/2"},
    "equations": ["g*sin(x) + u"],
    "outputs": [],
    "embedding": {
        "premises": PREMISES,
        "A": [["z"]],
        "B": [["1"]],
    },
}


def require(**entry: Any) -> None:
    """Compare the replacement g (1 - x^2/6) of g sin(x)/x, with other parts of its entry."""
    own = {"of": "x", "within": 1e-4, "formula": "g - g*x^2/6", **entry}
    whole = {"model": MODEL, "gains": {"premises": PREMISES}, "own": {"removable": {"z": [own]}}}
    read = read_text(json.dumps(whole), "certificate")
    require_premises(read["model"], read["gains"], read["own"])


@pytest.mark.parametrize(
    "entry",
    [
        {},
        {"within": 0.1, "formula": "g - g*x^2/6 + g*x^4/120"},
        {"formula": "choose(x, g, g)"},
        {"of": "2*x", "within": 0.2},
    ],
)
def test_a_replacement_of_the_premise_passes(entry: dict[str, Any]) -> None:
    require(**entry)


@pytest.mark.parametrize(
    ("removable", "law"),
    [
        ([1], {"premises": PREMISES}),
        ({"z": True}, {"premises": PREMISES}),
        ({"z": [True]}, {"premises": PREMISES}),
        ({"z": [{}]}, {"premises": PREMISES}),
        ({"z": [{"of": "x", "within": True, "formula": "g"}]}, {"premises": PREMISES}),
        ({"z": []}, None),
        ({"z": []}, {"premises": [{"name": []}]}),
        ({"z": []}, {"premises": True}),
    ],
)
def test_parts_of_another_type_are_refused_and_do_not_crash(removable: Any, law: Any) -> None:
    read = read_text(json.dumps({"model": MODEL, "law": law, "own": removable}), "certificate")
    with pytest.raises(CertificateError):
        require_premises(read["model"], read["law"], {"removable": read["own"]})


@pytest.mark.parametrize("within", [0.1001, 1.0, 1e6, -1e-9])
def test_a_replacement_far_from_0_is_refused(within: float) -> None:
    """The largest |x| is 1: a tenth of it, and not more."""
    with pytest.raises(OtherGains, match=r"controller.removable.z.within: a tenth of the range"):
        require(within=within)
    if within > 0.2:
        with pytest.raises(OtherGains, match="a tenth of the range"):
            require(of="2*x", within=within)


@pytest.mark.parametrize(
    "formula", ["0", "g + 9e-8", "g - 9e-8", "g + x/10", "g - x/10", "g - g*x^2/6 + x^2*1000"]
)
def test_another_value_is_refused(formula: str) -> None:
    with pytest.raises(OtherGains, match="z.formula: it is not the premise near x = 0"):
        require(formula=formula)


@pytest.mark.parametrize("formula", ["g + 7e-8", "g - 7e-8"])
def test_a_millionth_of_the_range_is_allowed(formula: str) -> None:
    """The premise is from 0.42 to 0.5: 8e-8."""
    require(formula=formula)


@pytest.mark.parametrize(("formula", "right"), [("1 - x^2/6", True), ("1.01 - x^2/6", False)])
def test_a_gain_file_is_refused_with_its_certificate_s_own_wrong_replacement(
    formula: str, right: bool, tmp_path: Path
) -> None:
    """Both say the same, so that no difference is found: what is compared is the premise."""
    data = of_model("step")
    entry = {"of": "x", "within": reader.Number("0.001"), "formula": formula}
    data["controller"]["removable"] = {"z1": [entry]}
    file = tmp_path / "gains.json"
    file.write_text(reader.canonical(gain_file.expected_file(data)), encoding="utf-8")
    if right:
        assert gain_file.compare_gains(data, file) == ""
        return
    with pytest.raises(OtherGains, match="removable.z1"):
        gain_file.compare_gains(data, file)
