"""Parts of an equation that have no value somewhere are never folded away, by either checker."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates import CertificateError, Claim, Verdict, certify
from takagi.certificates.checker import check_document, read_text
from takagi.certificates.checker.files.plant_file import compare_plant
from takagi.certificates.checker.plant.graph import Graph
from takagi.certificates.document.certificate_file import certificate_document
from takagi.models import ModelError, Plant, load_model, sector_model

Data = dict[str, Any]
ABSENT = {
    "-x + 0*log(x)": "an argument of log",
    "-x + log(x)*0": "an argument of log",
    "-x + 0/x": "a denominator",
    "-x + 0*(1/x)": "a denominator",
    "-x + 0*(x/x)": "a denominator",
    "-x + 0/(0.5 - x)": "a denominator",
    "-x + 0*sin(x)/x": "a denominator",
    "-x + log(x) - log(x)": "an argument of log",
    "-x*(log(x)/log(x))": "an argument of log",
    "-x + (0*log(x))^2": "an argument of log",
    "-x + 0*(2 + log(x))*x": "an argument of log",
    "-x + 0*tan(2*x)": "cos under tan",
    "-x + 0*sqrt(x)": "a root's argument",
    "-sqrt(x)^2": "a root's argument",
    "-x^1.5/x^0.5": "a root's argument",
    "-exp(log(x))": "an argument of log",
    "-x + 0*acos(2*x)": "an argument of acos",
    "-x*log(x + 2)^0": "a denominator",
    "-x*(x + 1)^0": "a denominator",
}
PRESENT = [
    "-x + 0*exp(x)",
    "-x + 0*abs(x)",
    "-x + 0*log(x + 2)",
    "-x + 0/(1 + x^2)",
    "-x*log(x + 3)^0",
    "-x + 0*log(1 + x^2)",
]
# A quotient that is removable means its limit where its denominator vanishes.
REMOVABLE = ["-x*x/x", "-(1/x)*x^2", "-x*x^0", "-x + (x - x)/x"]


def document(equation: str, **parameters: float) -> Data:
    """Return a certificate that x' = -x is the plant with this equation on [-1, 1]."""
    state: Data = {"name": "x", "unit": "-", "rest": 0, "range": [-1, 1]}
    model: Data = {"kind": "plant", "name": "d", "sample_time": None, "states": [state]}
    model |= {"inputs": [], "disturbances": [], "outputs": [], "parameters": parameters}
    model |= {"equations": [equation], "embedding": {"premises": [], "A": [["-1"]]}}
    claims: list[Data] = [{"name": "e", "kind": "sector-embedding"}]
    claims += [{"name": "d", "kind": "decay", "P": [[1]], "decay_rate": 0.5}]
    return certificate_document(model=model, gains=None, claims=claims, provenance={})


# Cut to the smallest boxes on both sides of the place, which takes seconds.
DEAR = ("-x + 0*tan(2*x)", "-x*log(x + 2)^0")


@pytest.mark.parametrize(
    "equation",
    [pytest.param(text, marks=[pytest.mark.slow] * (text in DEAR)) for text in ABSENT],
)
def test_what_has_no_value_somewhere_is_not_proved(equation: str) -> None:
    """The place is named, and what to leave out."""
    found = check_document(document(equation)).claims[0]

    assert found.verdict.name == "UNDECIDED"
    assert f"the equation of x: {ABSENT[equation]}" in found.text
    if "0*" in equation or "*0" in equation or "0/" in equation:
        assert "leave out what is multiplied by 0" in found.text


@pytest.mark.parametrize("equation", PRESENT)
def test_what_has_a_value_everywhere_is_proved(equation: str) -> None:
    assert check_document(document(equation)).verdict.name == "PROVED"


@pytest.mark.parametrize("equation", REMOVABLE)
def test_a_removable_quotient_means_its_limit(equation: str) -> None:
    """The verdict says so."""
    found = check_document(document(equation)).claims[0]

    assert found.verdict.name == "PROVED"
    assert "at x = 0 a quotient is taken as its limit" in found.text


@pytest.mark.parametrize("equation", ["-x + k*log(x)", "-x + k/x", "-x + log(x^k)"])
def test_a_parameter_that_is_zero_hides_no_domain(equation: str) -> None:
    wrong = document(equation, k=0)

    assert check_document(wrong).claims[0].verdict.name == "UNDECIDED"


def test_parameters_in_exponents_are_read_by_both() -> None:
    right = document("-x^k", k=1)

    assert check_document(right).verdict.name == "PROVED"


def test_zero_times_a_number_without_value_is_no_rest() -> None:
    """0 log(-1) is not a number, so that nothing rests there."""
    wrong = document("-x")
    wrong["model"]["states"][0] |= {"rest": "0*log(0 - 1)", "symbol": "dx"}
    wrong = certificate_document(
        model=wrong["model"], gains=None, claims=wrong["claims"], provenance={}
    )
    with pytest.raises(CertificateError):
        check_document(wrong)


def test_folding_in_the_graph() -> None:
    """What is total is folded as before; what is not stays a product or a quotient."""
    g = Graph()
    x, zero = g.variable("x"), g.constant(0)

    assert g.multiply(zero, g.call("sin", g.add(x, g.power(x, 3)))) == zero
    assert g[g.multiply(zero, g.call("log", x))].op == "multiply"
    assert g[g.multiply(g.power(x, -1), zero)].op == "multiply"
    assert g[g.divide(zero, x)].op == "divide"
    assert g.power(x, 0) == g.divide(x, x)
    assert g.power(g.constant(2), 0) == g.constant(1)


# ------------------------------------------------------------------ plant files

FILE = """format = 1
kind = "plant"
units = "unchecked"

[states]
x = { range = [-1, 1] }
z = { range = [1, 3], rest = 2 }

[parameters]
k = { value = 0 }

[tables]
loss = { file = "loss.csv", arguments = [{ name = "v", unit = "-" }] }

[equations]
x = "EQUATION"
z = "2 - z"
"""


def file_of(folder: Path, equation: str) -> Path:
    (folder / "loss.csv").write_text("-1, 0.5\n-0.5, 0.4\n0.5, 0.4\n1, 0.5\n")
    path = folder / "domain.toml"
    path.write_text(FILE.replace("EQUATION", equation))
    return path


LOST = ["-x + 0*loss(2*x)", "-x + loss(2*x) - loss(2*x)", "-x*k/k", "-x*(z - 2.5)^0"]


@pytest.mark.parametrize("equation", [*ABSENT, *LOST, "-x + (x - x)/x"])
def test_a_plant_file_is_not_folded_where_it_has_no_value(tmp_path: Path, equation: str) -> None:
    """sympy folds as it reads: the reader notes what is lost, and says where it stands."""
    with pytest.raises(ModelError) as refused:
        load_model(file_of(tmp_path, equation))

    message = str(refused.value)
    assert "domain.toml:16: field 'equations.x': column" in message
    assert "is not shown to have a value on the whole box" in message
    assert "leave it out, or give ranges on which it has" in message
    assert message.splitlines()[-2].strip() == equation


@pytest.mark.parametrize(
    "equation", [*PRESENT, "-x*x/x", "-(1/x)*x^2", "-x*x^0", "-x*z/z", "-x + 0*loss(x)/(2 + x)"]
)
def test_a_plant_file_may_fold_what_has_a_value(tmp_path: Path, equation: str) -> None:
    plant = load_model(file_of(tmp_path, equation))

    assert isinstance(plant, Plant)
    assert str(plant.equations[0]) == "-x"


@pytest.mark.parametrize(
    ("equation", "words"),
    [
        ("-x + 0*log(x)", "an argument of log"),
        ("-x + 0/x", "a denominator"),
        ("-x + log(x) - log(x)", "an argument of log"),
        ("-x + loss(x) - loss(x)", "has the table loss there, which cancels"),
    ],
)
def test_a_file_is_not_the_plant_where_it_has_no_value(
    tmp_path: Path, equation: str, words: str
) -> None:
    """``check --model`` reads the file by itself: algebra alone would call it the same."""
    plant = load_model(file_of(tmp_path, "-x + 0*log(x + 2)"))
    assert isinstance(plant, Plant)
    honest = sector_model(plant)
    model = json.loads(json.dumps(certify(honest, decay_rate=0.1).document["model"]))
    model["tables"] = {}
    read = read_text(json.dumps(model), "model")

    file = file_of(tmp_path, equation)
    with pytest.raises(CertificateError, match=words):
        compare_plant(read, file)


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
