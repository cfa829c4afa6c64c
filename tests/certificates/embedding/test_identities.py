"""Identities that are shown, and others that must not be."""

from __future__ import annotations

import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import CertificateError, certify
from takagi.certificates.checker import read_text
from takagi.certificates.checker.arithmetic.interval import Interval
from takagi.certificates.checker.files.plant_file import compare_plant
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.plant.derivative import derivative
from takagi.certificates.checker.plant.evaluate import Evaluator
from takagi.certificates.checker.plant.expression import Scope, read_expression
from takagi.certificates.checker.plant.graph import FUNCTIONS, Graph
from takagi.certificates.checker.plant.identity import Algebra
from takagi.models import ModelError, Plant, load_model, sector_model

NAMES = ("x", "y", "u")


def at_point(x: int) -> Interval:
    """Return a number over 10^36 as the interval that it is."""
    return Interval(x, x)


class Texts:
    """One graph and algebra for texts in x, y and u."""

    def __init__(self) -> None:
        self.graph = Graph()
        scope = {name: self.graph.variable(name) for name in NAMES}
        self.scope = Scope(scope, {"table": 1})
        self.algebra = Algebra(self.graph)

    def node(self, text: str) -> int:
        return read_expression(text, self.graph, self.scope, "here")

    def equal(self, left: str, right: str) -> bool:
        return self.algebra.equal(self.node(left), self.node(right))


TRUE = [
    ("(x + y)^3", "x^3 + 3*x^2*y + 3*x*y^2 + y^3"),
    ("1/(x - y) - 1/(x + y)", "2*y/(x^2 - y^2)"),
    ("x/(x*y)", "1/y"),
    ("sin(x)^2 + cos(x)^2", "1"),
    ("sin(2*x)", "2*sin(x)*cos(x)"),
    ("cos(2*x)", "1 - 2*sin(x)^2"),
    ("sin(3*x)", "3*sin(x) - 4*sin(x)^3"),
    ("sin(x)", "2*sin(x/2)*cos(x/2)"),
    ("sin(x/2)^2", "(1 - cos(x))/2"),
    ("sin(2*x/3)", "2*sin(x/3)*cos(x/3)"),
    ("sin(x + y)", "sin(x)*cos(y) + cos(x)*sin(y)"),
    ("cos(x - 2*y)", "cos(x)*cos(2*y) + sin(x)*sin(2*y)"),
    ("sin(-x)", "-sin(x)"),
    ("sin(x + pi)", "-sin(x)"),
    ("cos(x - pi/2)", "sin(x)"),
    ("sin(1/2 + x)", "sin(1/2)*cos(x) + cos(1/2)*sin(x)"),
    ("tan(x)*cos(x)", "sin(x)"),
    ("1 + tan(x)^2", "1/cos(x)^2"),
    ("sin(x*y)^2", "1 - cos(x*y)^2"),
    ("sin(x/(1 + y))^2", "1 - cos(x/(y + 1))^2"),
    ("exp(x + y)", "exp(x)*exp(y)"),
    ("exp(-x)", "1/exp(x)"),
    ("exp(25 - 8750/(350 + x))", "exp(25)*exp(-8750/(x + 350))"),
    ("exp(25*x/(350 + x))", "exp(25)/exp(8750/(350 + x))"),
    ("exp((2*x + 3)/(x + 1))", "exp(2)*exp(1/(x + 1))"),
    ("exp(x*y/(x + y) + 1)", "exp(1)*exp(x*y/(x + y))"),
    ("sin(1 + 1/x)", "sin(1)*cos(1/x) + cos(1)*sin(1/x)"),
    ("sin(-1/(x + 1))", "-sin(1/(1 + x))"),
    ("exp(x/(7*(350 + x)))^7", "exp(x/(350 + x))"),
    ("exp(3*x)", "exp(x)^3"),
    ("exp(x)", "exp(x/2)^2"),
    ("cosh(x)^2 - sinh(x)^2", "1"),
    ("tanh(x)", "sinh(x)/cosh(x)"),
    ("tanh(2*x)", "2*tanh(x)/(1 + tanh(x)^2)"),
    ("sqrt(x)^2", "x"),
    ("sqrt(x + y)^3", "(x + y)*sqrt(y + x)"),
    ("x^(2/3)*x^(1/3)", "x"),
    ("1/sqrt(2)", "sqrt(2)/2"),
    ("sqrt(9/4)", "3/2"),
    ("abs(x)^2", "x^2"),
    ("abs(x)^3", "x^2*abs(x)"),
    ("log(x + y) + x", "x + log(y + x)"),
    ("atan(x*(y + 1))", "atan(x*y + x)"),
    ("sin(atan(x))", "x/sqrt(1 + x^2)"),
    ("cos(atan(x))", "1/sqrt(1 + x^2)"),
    ("tan(atan(x))", "x"),
    ("sin(2*atan(x))", "2*x/(1 + x^2)"),
    ("cos(-3*atan(x))", "(1 - 3*x^2)/((1 + x^2)*sqrt(1 + x^2))"),
    ("tan(atan(x) - atan(y))", "(x - y)/(1 + x*y)"),
    ("sqrt(1 + x^2)*sin(y + atan(x))", "sin(y) + x*cos(y)"),
    ("sin(y + atan(tan(x)/2))/cos(atan(tan(x)/2))", "sin(y) + cos(y)*tan(x)/2"),
    ("sin(atan(x)/2)^2", "(1 - cos(atan(x)))/2"),
    ("atan(y - x)", "-atan(x - y)"),
    ("erf(y - x) + asinh(-x)", "-erf(x - y) - asinh(x)"),
    ("sin(13/10*atan(8*x - 8*y))", "-sin(13*atan(8*(y - x))/10)"),
    ("exp(-453/200)", "exp(147/200)*exp(-3)"),
    ("table(2*x)*y", "y*table(x + x)"),
    ("sin(sin(2*x))^2 + cos(2*sin(x)*cos(x))^2", "1"),
]
FALSE = [
    ("(x + y)^2", "x^2 + y^2"),
    ("sin(2*x)", "2*sin(x)"),
    ("cos(2*x)", "1 - sin(x)^2"),
    ("sin(x + y)", "sin(x) + sin(y)"),
    ("sin(x + pi)", "sin(x)"),
    ("cos(x + pi/2)", "sin(x)"),
    ("tan(x)", "sin(x)"),
    ("exp(x + y)", "exp(x) + exp(y)"),
    ("exp(-x)", "-exp(x)"),
    ("exp(25 - 8750/(350 + x))", "exp(25)*exp(8750/(x + 350))"),
    ("exp(25 - 8750/(350 + x))", "exp(24)*exp(-8750/(x + 350))"),
    ("exp(1/(x + 1))", "exp(1/(x + 2))"),
    ("exp((2*x + 3)/(x + 1))", "exp(3)*exp(1/(x + 1))"),
    ("sin(1 + 1/x)", "sin(1 - 1/x)"),
    ("cosh(x)^2 + sinh(x)^2", "1"),
    ("sqrt(x^2)", "x"),
    ("abs(x)", "x"),
    ("abs(x)^3", "x^3"),
    ("x^(1/3)", "x^(1/2)"),
    ("log(x*y)", "log(x)*log(y)"),
    ("table(x)", "table(y)"),
    ("asin(x)", "atan(x)"),
    ("sin(atan(x))", "x"),
    ("sin(atan(x))", "1/sqrt(1 + x^2)"),
    ("cos(atan(x))", "sqrt(1 + x^2)"),
    ("cos(atan(x))", "-1/sqrt(1 + x^2)"),
    ("cos(atan(x))", "1/sqrt(1 - x^2)"),
    ("sin(2*atan(x))", "x/(1 + x^2)"),
    ("sin(y + atan(x))", "sin(y - atan(x))"),
    ("atan(tan(x))", "x"),
    ("atan(-x)", "atan(x)"),
    ("acos(-x)", "-acos(x)"),
    ("exp(-453/200)", "exp(147/200)*exp(-2)"),
    ("pi", "22/7"),
    ("pi", "3.14159265358979323846264338327950288"),
    ("sqrt(2)", "1.41421356237309504880168872420969807"),
    ("sin(1)", "sin(2)"),
    ("x", "x + 1/10^60"),
]


@pytest.mark.parametrize(("left", "right"), TRUE)
def test_true_identities_are_shown(left: str, right: str) -> None:
    """In either order, and inside a larger expression."""
    texts = Texts()
    assert texts.equal(left, right)
    assert texts.equal(right, left)
    assert texts.equal(f"u*({left}) + 1/(u - ({right}))", f"({right})*u - 1/({left} - u)")


@pytest.mark.parametrize(("left", "right"), FALSE)
def test_false_identities_are_not_shown(left: str, right: str) -> None:
    """Nor are they when a true identity of the same functions was met before."""
    texts = Texts()
    for true, also in TRUE:
        texts.equal(true, also)
    assert not texts.equal(left, right)


@pytest.mark.parametrize("text", ["1/(x - x)", "1/(sin(x)^2 + cos(x)^2 - 1)", "1/(tan(x)*0)"])
def test_a_division_by_what_is_zero_everywhere_is_refused(text: str) -> None:
    """A hidden zero would make every identity true."""
    with pytest.raises((Refused, ValueError)):
        Texts().equal(text, "x")


leaves = st.sampled_from(["x", "y", "2", "1/3", "sin(x)", "cos(y)", "exp(x)", "abs(y)", "tanh(x)"])
expressions = st.recursive(
    leaves,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*"), inner).map(lambda t: f"({t[0]}{t[1]}{t[2]})"),
        inner.map(lambda t: f"sin({t})"),
        inner.map(lambda t: f"({t})^2"),
        inner.map(lambda t: f"({t})/(2 + cos({t}))"),
    ),
    max_leaves=5,
)


@given(left=expressions, right=expressions)
def test_what_is_shown_is_so_at_a_point(left: str, right: str) -> None:
    texts = Texts()
    a, b = texts.node(left), texts.node(right)
    try:
        shown = texts.algebra.equal(a, b)
    except Refused:
        return
    box = {"x": at_point(7 * 10**35), "y": at_point(-3 * 10**35)}
    evaluator = Evaluator(texts.graph, {})
    first, second = evaluator.value(a, box), evaluator.value(b, box)
    if first is None or second is None:
        return
    overlap = first[0] <= second[1] and second[0] <= first[1]
    assert overlap or not shown


@given(text=expressions)
def test_the_derivative_is_that_of_differences(text: str) -> None:
    """f'(x) by the chain rule against a central difference, at a point without a kink."""
    texts = Texts()
    root = texts.node(text)
    try:
        slope = derivative(texts.graph, root, "x")
    except Refused:
        return
    evaluator, step = Evaluator(texts.graph, {}), 10**24

    def at(node: int, x: int) -> float:
        pair = evaluator.value(node, {"x": at_point(x), "y": at_point(-3 * 10**35)})
        assert pair is not None
        return (pair[0] + pair[1]) / 2 / 10**36

    x = 7 * 10**35
    pairs = [
        evaluator.value(root, {"x": at_point(x + s), "y": at_point(-3 * 10**35)})
        for s in (-step, step)
    ]
    if any(pair is None for pair in pairs):
        return
    low, high = (sum(pair) for pair in pairs if pair is not None)
    difference = (high - low) / 4 / step

    assert math.isclose(difference, at(slope, x), rel_tol=1e-6, abs_tol=1e-6)


@pytest.mark.parametrize("scale", ["1", "2", "-1"])
@pytest.mark.parametrize("name", sorted(FUNCTIONS - {"acosh"}) + ["acosh"])
def test_every_function_has_its_slope(name: str, scale: str) -> None:
    """f(c x)' against a central difference at x = 3/10 (acosh: 7/5), for each function."""
    texts = Texts()
    shift = "+ 7/5 - 3/10*(" + scale + ")" if name == "acosh" else ""
    positive = "+ 2" if name in ("log", "sqrt") else ""
    root = texts.node(f"{name}(({scale})*x {shift} {positive})")
    slope = derivative(texts.graph, root, "x")
    evaluator, x, step = Evaluator(texts.graph, {}), 3 * 10**35, 10**24

    low, middle, high = (evaluator.value(n, {"x": at_point(at)})
                         for n, at in ((root, x - step), (slope, x), (root, x + step)))  # fmt: skip

    assert low is not None and middle is not None and high is not None
    difference = (sum(high) - sum(low)) / 4 / step
    assert math.isclose(difference, sum(middle) / 2 / 10**36, rel_tol=1e-9)


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
