"""The program of a gain file commands what the claims are about, or there is no such file."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates import CertificateError
from takagi.certificates.checker import read_text
from takagi.certificates.checker.controller import content
from takagi.certificates.checker.controller.plant_program import plant_program
from takagi.certificates.checker.controller.turbine_content import _rotor
from takagi.certificates.checker.files import gain_file
from takagi.certificates.checker.files.replacements import require_premises
from takagi.certificates.checker.kernel import reader, refusal
from takagi.certificates.checker.kernel.refusal import OtherGains
from tests.certificates.kinds.claims import Data, law_data, model_data, verdict_of
from tests.certificates.recorded.inputs import of_model, read_law


def steps_between(lower: str, upper: str) -> tuple[str, list[dict[str, Any]]]:
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
    name, all_steps = steps_between(lower, upper)
    (weight,) = (one["formula"] for one in all_steps if one["set"] == f"{name}_weight")
    assert weight == "0" if flat else "limit(" in weight


def test_bounds_that_are_one_float_have_no_program() -> None:
    """The claim is about every weight, and a program could give none but 0."""
    with pytest.raises(refusal.CertificateError, match="one number in the floats"):
        steps_between("1", "1.00000000000000000001")


def test_its_inertia_has_the_generators_share() -> None:
    """J = J_r + n^2 J_g, to the digits that a gain file holds."""
    model = read_law("torque")["model"]
    rotor, gear, generator = (
        Fraction(model[name]) for name in ("rotor_inertia", "gear_ratio", "generator_inertia")
    )

    stated = Fraction(_rotor(model)["inertia"])
    assert abs(stated / (rotor + gear**2 * generator) - 1) < Fraction(1, 10**9)
    assert abs(stated / rotor - 1) > Fraction(1, 100)


PREMISE = {"name": "p", "unit": "-", "lower": 0, "upper": 1}
# x' = -x + u in rule 1, x' = -x - u in rule 2.
MODEL = model_data([[[-1]], [[-1]]], B=[[[1]], [[-1]]], input_names=["u [-]"])
LAW = law_data([[[1.5]], [[0.5]]], input_names=["u [-]"], trim={"state": [0], "input": [0]})


def steps(law: Data) -> list[str]:
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
    assert verdict_of(MODEL, LAW, claim) == "PROVED"

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


PREMISES = [{"name": "z", "expression": "g*sin(x)/x", "lower": 0.42, "upper": 0.5, "unit": "-"}]
SQUARE: dict[str, Any] = {
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


@pytest.mark.parametrize(
    ("states", "inputs", "name"),
    [
        (["b_c", "c"], ["a", "a_b"], "K_a_b_c"),
        (["b_rest", "K_a_b"], ["a"], "K_a_b_rest"),
        (["x", "x_rest_"], ["u"], ""),
    ],
)
def test_no_name_of_a_program_has_two_meanings(
    states: list[str], inputs: list[str], name: str
) -> None:
    """K_a_b_c is the gain of a on b_c, and of a_b on c: the program had one value for both."""
    labels = ([f"{name} [-]" for name in names] for names in (states, inputs))
    model = dict(zip(("state_names", "input_names"), labels, strict=True))
    K = [[[f"{i + 1}.{j + 1}" for j in range(len(states))] for i in range(len(inputs))]]
    law = {"name": "pdc", "sample_time": None, "K": K}
    if name:
        with pytest.raises(CertificateError, match=f"one name, {name}, for two quantities"):
            plant_program(model, law, {})
        return
    values = [entry["value"] for entry in plant_program(model, law, {})["names"].values()]
    assert len(values) == len(set(values)) == len(states) * (1 + len(inputs)) + len(inputs)


def require(*kinds: str, K: Any = (1, 2), **entry: Any) -> None:
    """Compare the replacement g (1 - x^2/6) of g sin(x)/x, with other parts of its entry."""
    own = {"of": "x", "within": 1e-4, "formula": "g - g*x^2/6", **entry}
    gains = {"premises": PREMISES, "K": [[[k]] for k in K]}
    whole = {"model": SQUARE, "gains": gains, "own": {"removable": {"z": [own]}}}
    read = read_text(json.dumps(whole), "certificate")
    require_premises(read["model"], read["gains"], read["own"], kinds)


@pytest.mark.parametrize(
    "entry",
    [
        {},
        {"within": 0.01, "formula": "g - g*x^2/6 + g*x^4/120"},
        {"formula": "choose(x, g, g)"},
        {"of": "-2*x", "within": 0.02},
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
    read = read_text(json.dumps({"model": SQUARE, "law": law, "own": removable}), "certificate")
    with pytest.raises(CertificateError):
        require_premises(read["model"], read["law"], {"removable": read["own"]})


def test_a_region_of_a_polynomial_loop_has_no_replaced_premise() -> None:
    """Between its ends a formula may be another: the region is that of the premise alone."""
    require("decay", K=[1, 2])
    require("attraction-region", K=[1, 1])
    require("attraction-region", K=[1])
    with pytest.raises(OtherGains, match="z is replaced near a point, and the claim attraction-"):
        require("decay", "attraction-region", K=[1, 2])


@pytest.mark.parametrize("within", [0.1001, 1.0, 1e6, -1e-9])
def test_a_replacement_far_from_0_is_refused(within: float) -> None:
    """The largest |x| is 1: a tenth of it, and not more."""
    with pytest.raises(OtherGains, match=r"controller.removable.z.within: a tenth of the range"):
        require(within=within)
    if within > 0.2:
        with pytest.raises(OtherGains, match="a tenth of the range"):
            require(of="2*x", within=within)


@pytest.mark.parametrize(
    "formula",
    [
        "0", "g + 9e-8", "g - 9e-8", "g + x/10", "g - x/10", "g - g*x^2/6 + x^2*1000",
        # The premise at both ends of the interval, and at 0.
        "g - g*x^2/6 + 1e6*x^2*(x^2 - 1e-8)*1e6", "g - g*x^2/6 + 1e3*(1e-8 - x^2)",
        # Two terms that are each small enough; one that is three times too large; one wrong side.
        "g - g*x^2/6 + 5e-8 + 3.5e-4*x", "g - g*x^2/6 + 24*x^2", "choose(x, g/2, g)",
        "choose(x, g, g/2)",
    ],
)  # fmt: skip
def test_another_value_is_refused(formula: str) -> None:
    for of in ("x", "-x"):
        with pytest.raises(OtherGains, match=rf"z.formula: it is not the premise near {of} = 0"):
            require(formula=formula.replace("choose(x", f"choose({of}"), of=of)


def test_the_distance_is_that_of_the_variable() -> None:
    """g x^4/120 is 1e-8 at x = 0.04, and 1.7e-7 at 0.08: 8e-8 are allowed."""
    require(of="x", within=0.04)
    with pytest.raises(OtherGains, match="not the premise near"):
        require(of="x/2", within=0.04)


@pytest.mark.parametrize("of", ["x - 1/2", "x^2", "1/2"])
def test_a_place_where_no_variable_and_no_sum_is_0_is_refused(of: str) -> None:
    with pytest.raises(OtherGains, match="a sum of multiples of variables is needed"):
        require(of=of, within=0.01)


@pytest.mark.parametrize("formula", ["g + 7e-8", "g - 7e-8"])
def test_a_millionth_of_the_range_is_allowed(formula: str) -> None:
    """The premise is from 0.42 to 0.5: 8e-8."""
    require(formula=formula)


SEVERAL = [  # premise, its replacement, forgeries of that, and what is 0 where it is 0/0
    (
        "y*sin(x)/x",
        "y - y*x^2/6",
        ["y - y*x^2/5 + x*(y^2 - 1)*y/9", "y - y^3*x^2/6 + y^2 - y^4"],
        "x",
    ),
    ("cos(y)*(1 - cos(x))/x^2", "cos(y)/2 - cos(y)*x^2/24", ["1/2 - y^2/4 - x^2/24"], "x"),
    (
        "sin(x)*sin(y)/(x*y)",
        "(1 - x^2/6)*sin(y)/y",
        ["(1 - x^2/5)*sin(y)/y", "(1 - x^2/6)*sin(y)/y + 5e-6"],
        "x",
    ),
    ("y^2*sin(x + y)/(x + y)", "y^2 - y^2*(x + y)^2/6", ["y^2 - y^2*(x + y)/60"], "x + y"),
    (
        "sqrt(2 - y*abs(x)/x)",
        "choose(x, sqrt(2 + y), sqrt(2 - y))",
        [
            "choose(x, sqrt(2 - y), sqrt(2 + y))",
            "sqrt(2 + y)",
            "choose(y, sqrt(2 + y), sqrt(2 - y))",
        ],
        "x",
    ),
    (
        "abs(x)*exp(y)/x + y",
        "choose(x, y - exp(y), exp(y) + y)",
        ["choose(x, y - exp(y), exp(y) + y*(1 + x)^9)"],
        "x",
    ),
]


@pytest.mark.parametrize(("premise", "formula", "forged", "of"), SEVERAL)
def test_a_replacement_of_several_variables_is_compared_everywhere(
    premise: str, formula: str, forged: list[str], of: str
) -> None:
    """Some forgeries agree at the ends of both ranges, in their middles, or at x = 0."""
    state = {**SQUARE["states"][0], "range": [-0.3, 0.3]}
    states = [{**state, "name": name} for name in ("x", "y")]
    premises = [{**PREMISES[0], "expression": premise, "lower": -2, "upper": 2}]
    embedding = {"premises": premises, "A": [["z", "0"], ["0", "z"]], "B": [["1"], ["1"]]}
    plant = {"states": states, "equations": ["u", "u"], "embedding": embedding}

    def compare(written: str) -> None:
        near = {"z": [{"of": of, "within": 0.01, "formula": written}]}
        read = read_text(
            json.dumps(
                {"m": SQUARE | plant, "g": {"premises": premises}, "c": {"removable": near}}
            ),
            "",
        )
        require_premises(read["m"], read["g"], read["c"])

    compare(formula)
    for other in forged:
        with pytest.raises((OtherGains, CertificateError), match=r"controller.removable.z.formula"):
            compare(other)


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
