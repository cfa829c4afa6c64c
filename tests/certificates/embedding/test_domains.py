"""Parts of an equation that have no value somewhere are never folded away, by either checker."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from takagi.certificates import CertificateError, certify
from takagi.certificates.checker import read_text
from takagi.certificates.checker.files.plant_file import compare_plant
from takagi.certificates.checker.plant.graph import Graph
from takagi.models import ModelError, Plant, load_model, sector_model

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
