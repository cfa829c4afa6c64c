"""The second checker by itself: against published thresholds, and on what it must not believe."""

from __future__ import annotations

import math
from collections.abc import Callable
from copy import deepcopy
from fractions import Fraction
from typing import Any

import pytest
from flint import fmpq, fmpq_mat
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import certify
from takagi.certificates.cross_check.kernel.exact import is_definite
from takagi.certificates.cross_check.kernel.reading import Refusal, loads
from takagi.certificates.cross_check.opinion import judge_document
from takagi.certificates.cross_check.plant.algebra import Algebra
from takagi.certificates.cross_check.plant.expression import minus, parsed, plus, value_of
from takagi.certificates.cross_check.plant.interval import Undefined, range_of
from takagi.certificates.document.certificate_file import certificate_document
from takagi.models import sector_model
from takagi.models.plant_files.loader import load_plant
from tests.certificates.kinds.claims import model_data
from tests.certificates.kinds.test_damage import resealed

entries = st.integers(-9, 9)
FUNCTIONS: dict[str, Callable[[float], float]] = {
    "sin(x)/x": lambda x: math.sin(x) / x if x else 1.0,
    "x^2*sin(2*x)": lambda x: x * x * math.sin(2 * x),
    "1/(2 + cos(x))": lambda x: 1 / (2 + math.cos(x)),
}


@given(st.integers(1, 5), st.data())
def test_definite_as_by_all_principal_minors(n: int, data: Any) -> None:
    """Sylvester: definite exactly if the leading minors are positive, of a random matrix."""
    rows = [[0] * n for _ in range(n)]
    for i in range(n):
        for j in range(i + 1):
            rows[i][j] = rows[j][i] = data.draw(entries)
        rows[i][i] += data.draw(st.integers(0, 25))
    matrix = fmpq_mat([[fmpq(v) for v in row] for row in rows])
    minors = [_determinant([row[:k] for row in rows[:k]]) for k in range(1, n + 1)]

    assert is_definite(matrix) == (min(minors) > 0)
    if is_definite(matrix):
        assert is_definite(matrix, strict=False)


@given(st.lists(st.lists(entries, min_size=3, max_size=3), min_size=1, max_size=4))
def test_a_gram_matrix_is_semidefinite(vectors: list[list[int]]) -> None:
    """G = V V' >= 0, singular when there are more vectors than dimensions; G - I/1000 then not."""
    V = fmpq_mat([[fmpq(v) for v in row] for row in vectors])
    gram = V * V.transpose()

    assert is_definite(gram, strict=False)
    if gram.det() == 0:
        n = gram.nrows()
        less = fmpq_mat(n, n, [fmpq(1, 1000) if i == j else 0 for i in range(n) for j in range(n)])
        assert not is_definite(gram)
        assert not is_definite(gram - less, strict=False)


def _determinant(rows: list[list[int]]) -> fmpq:
    found: fmpq = fmpq_mat([[fmpq(v) for v in row] for row in rows]).det()
    return found


def test_matrix_that_is_not_symmetric_is_not_definite() -> None:
    assert not is_definite(fmpq_mat([[2, 1], [0, 2]]))
    assert not is_definite(fmpq_mat([[1, 0]]))


@pytest.mark.parametrize(("rate", "verdict"), [("0.999999", "PROVED"), ("1", "UNDECIDED")])
def test_decay_on_both_sides_of_its_limit(rate: str, verdict: str) -> None:
    """x' = -x decays faster than exp(-2 a t) for every a < 1, and for no other."""
    claim = {"name": "any", "kind": "decay", "P": [[1]], "decay_rate": float(rate)}
    document = certificate_document(
        model=model_data([[[-1]]]), gains=None, claims=[claim], provenance={}
    )

    assert judge_document(document)[0].verdict == verdict


@pytest.mark.parametrize(
    ("left", "right", "same"),
    [
        ("sin(2*x)", "2*sin(x)*cos(x)", True),
        ("sin(x + y)", "sin(x)*cos(y) + cos(x)*sin(y)", True),
        ("cos(3*x)", "4*cos(x)^3 - 3*cos(x)", True),
        ("tanh(x)", "(exp(2*x) - 1)/(exp(2*x) + 1)", True),
        ("cos(pi/2 - x)", "sin(x)", True),
        ("abs(x)*abs(x)", "x^2", True),
        ("sqrt(x)^3", "x*sqrt(x)", True),
        ("sin(2*atan(x))", "2*x/(1 + x^2)", True),
        ("cos(y - 3*atan(x))*(1 + x^2)^2", "cos(y - 3*atan(x)) * (1 + 2*x^2 + x^4)", True),
        ("sqrt(1 + x^2)*sin(y + atan(x))", "sin(y) + x*cos(y)", True),
        ("tan(atan(x/y) - atan(y))", "(x - y^2)/(y + x*y)", True),
        ("sin(y + atan(tan(x)/2))/cos(atan(tan(x)/2))", "sin(y) + cos(y)*tan(x)/2", True),
        ("sin(13/10*atan(8*x - 8*y))", "-sin(13*atan(8*(y - x))/10)", True),
        ("erf(y - x) + asinh(-x)", "-erf(x - y) - asinh(x)", True),
        ("exp(-453/200)", "exp(147/200)*exp(-3)", True),
        ("sin(exp(y/3 + acos(y)))", "-sin(-exp(acos(y) + y/3))", True),
        ("sin(exp(1 + sinh(2)))", "sin(exp(sinh(2)))", False),
        ("sin(2*x)", "2*sin(x)", False),
        ("sin(atan(x))", "x", False),
        ("cos(atan(x))", "-1/sqrt(1 + x^2)", False),
        ("sin(2*atan(x))", "x/(1 + x^2)", False),
        ("sin(y + atan(x))", "sin(y - atan(x))", False),
        ("atan(tan(x))", "x", False),
        ("acos(-x)", "-acos(x)", False),
        ("cosh(x)", "cos(x)", False),
        ("abs(x)", "x", False),
        ("sin(x)^2", "1 + cos(x)^2", False),
        ("x/(1 + x)", "x", False),
    ],
)
def test_identities(left: str, right: str, same: bool) -> None:
    difference = plus(parsed(left), minus(parsed(right)))

    assert Algebra([difference]).vanishes(difference) is same


@given(st.integers(-300, 300), st.integers(1, 200))
def test_ranges_hold_values(low: int, width: int) -> None:
    """sin x / x, x^2 sin 2x and 1/(2 + cos x) at points of an interval lie in its range."""
    a, b = fmpq(low, 100), fmpq(low + width, 100)
    for text, function in FUNCTIONS.items():
        found = range_of(parsed(text), {"x": (a, b)}, lambda *_: True)
        assert found is not None
        ends = [int(end.p) / int(end.q) for end in found]
        for k in range(11):
            x = (low + width * k / 10) / 100
            assert ends[0] - 1e-12 <= function(x) <= ends[1] + 1e-12, (text, x)


def test_division_by_what_may_be_zero_is_not_believed() -> None:
    with pytest.raises(Undefined):
        range_of(parsed("cos(x)/x"), {"x": (fmpq(-1), fmpq(1))}, lambda *_: False)


def test_arithmetic_of_expressions_is_exact() -> None:
    assert value_of(parsed("-2^2 + 3^(1 + 1)/0.3")) == fmpq(26)
    assert value_of(parsed("1/3 - 0.25e-1")) == fmpq(*Fraction(37, 120).as_integer_ratio())


def test_wrong_embeddings_are_not_proved() -> None:
    """Each change makes the model another plant: none is called proved."""
    whole = dict(certify(sector_model(load_plant("flexible_joint"))).document)
    assert judge_document(whole)[0].verdict == "PROVED"
    changes: list[tuple[tuple[Any, ...], Any]] = [
        (("model", "equations", 1), "(-g*l*m*sin(q) - k*(-p + 2*q))/I"),
        (("model", "embedding", "premises", 0, "upper"), 0.9999),
        (("model", "embedding", "premises", 0, "lower"), 0.4546488),
        (("model", "embedding", "premises", 0, "expression"), "sin(q)"),
        (("model", "embedding", "A", 1, 0), "-98*z1/10 - 100"),
        (("model", "states", 0, "range"), [-2, 3]),
        (("model", "parameters", "g"), 9.8),
    ]
    for path, value in changes:
        false = deepcopy(whole)
        place: Any = false
        for key in path[:-1]:
            place = place[key]
        place[path[-1]] = value
        assert judge_document(resealed(false))[0].verdict != "PROVED", path


HOSTILE = [
    "(" * 70 + "z1" + ")" * 70,
    "+".join(["z1"] * 6000),
    "((((z1 + 1)^64)^64)^64)^64",
    "((((2^64)^64)^64)^64)^64",
    "1/0",
    "z1/z1",
    "nothing",
    "__import__(z1)",
]


@pytest.mark.parametrize("written", HOSTILE, ids=lambda text: text[:20])
@pytest.mark.parametrize("place", [("embedding", "A", 0, 0), ("equations", 0)])
def test_hostile_expressions_are_never_proved(written: str, place: tuple[Any, ...]) -> None:
    """Refused, or left open: neither hours of work nor an exception of another kind."""
    document = dict(certify(sector_model(load_plant("flexible_joint"))).document)
    document = deepcopy(document)
    owner: Any = document["model"]
    for key in place[:-1]:
        owner = owner[key]
    owner[place[-1]] = written
    try:
        verdicts = [found.verdict for found in judge_document(resealed(document))]
    except Refusal:
        return
    assert verdicts[0] != "PROVED"


@pytest.mark.parametrize(
    "written",
    [
        "",
        "[]",
        '{"a": 1, "a": 2}',
        '{"a": NaN}',
        '{"a": 1e999}',
        '{"a": ' + "9" * 100 + "}",
        "[" * 1000 + "]" * 1000,
        '{"a": "' + "[" * 100,
    ],
)
def test_hostile_texts_are_refused(written: str) -> None:
    with pytest.raises(Refusal):
        loads(written)
