"""Entries of a plant's matrices: quotients, roots and sums that cancel, and what must not."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Verdict
from takagi.certificates.checker.plant.atoms import Atoms
from takagi.certificates.checker.plant.expression import Scope, read_expression
from takagi.certificates.checker.plant.graph import Graph
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.polynomial import Quotient
from takagi.certificates.document.plant_embedding import plant_data
from takagi.models import sector_model
from tests.certificates.embedding.plants import (
    changed,
    embedding_outcome,
    one_state,
    said_of,
)
from tests.certificates.kinds.claims import as_read
from tests.symbolic_plants import plant_of


def with_quotient(equation: str, entry: str, q: str) -> dict[str, Any]:
    """Return x' = equation with one entry in z = -1 and q, a premise that vanishes for x >= 0."""
    data = one_state(equation, "-1", -1, -1)
    premise = {"name": "q", "expression": q, "lower": 0, "upper": 5}
    data["embedding"]["premises"].append(premise)
    data["embedding"]["A"] = [[entry]]
    return data


@pytest.mark.parametrize("entry", ["z*q/q", "z*q^2/q^2", "(z + q)/q*q - q", "z*(q^(-1)*q)"])
@pytest.mark.parametrize("q", ["abs(x) - x", "sqrt(x^2) - x", "2*(abs(x) - x)"])
def test_a_quotient_in_an_entry_hides_no_part_of_the_equation(entry: str, q: str) -> None:
    """(|x| - x)(|x| + x) = 0: multiplied by q, x' = 9 x and x' = -x agree for x > 0.

    The vertices are those of x' = -x, which is stable; the plant is not.
    """
    unstable = f"-x + 5*(({q}) + 2*x)" if not q.startswith("2") else "-x + 5*(abs(x) + x)"
    found = said_of(with_quotient(unstable, entry, q))
    assert found.verdict is Verdict.UNDECIDED
    assert "do not give the equation" in found.text


def test_a_quotient_that_cancels_in_an_entry_is_only_that() -> None:
    found = said_of(with_quotient("-x", "z*q/q", "abs(x) - x + 1"))
    assert found.verdict is Verdict.PROVED


def test_a_quotient_in_an_entry_of_a_secant_model_hides_nothing() -> None:
    """With s = sqrt((x + 2)^2), which is x + 2 here, (s - x - 2)(s + x + 2) = 0.

    f' = -1 + s + x + 2 = 2 x + 3; multiplied by q = s - x - 2 it agrees with -1.
    """
    s = "sqrt((x + 2)^2)"
    data = with_quotient(f"-x + ({s}*(x + 2) + (x + 2)^2)/2 - 4", "z*q/q", f"{s} - x - 2")
    data["embedding"]["premises"][1]["lower"] = -1
    data["embedding"]["form"] = "secant"
    claim = {"name": "secants", "kind": "secant-embedding"}
    found = embedding_outcome(as_read(data), claim=claim).in_words()
    assert found.verdict is Verdict.UNDECIDED
    assert "is not the slope" in found.text


TRUE = [
    ("sqrt(2)*sqrt(9.81*h)", "sqrt(19.62*h)"),
    ("sqrt(218)", "sqrt(2)*sqrt(109)"),
    ("sqrt(9.81)", "3*sqrt(109)/10"),
    ("sqrt(2*h + 1)", "sqrt(2)*sqrt(h + 1/2)"),
    ("(2*h)^(3/2)", "2*sqrt(2)*h*sqrt(h)"),
    ("(8*h)^(-1/2)", "sqrt(2)/4/sqrt(h)"),
    ("(16*h)^(1/3)", "2*2^(1/3)*h^(1/3)"),
    ("(h/(2*h + 2))^(1/2)", "sqrt(h/(h + 1))/sqrt(2)"),
    ("sqrt(3)*sqrt(5) + sqrt(2)^2", "sqrt(15) + 2"),
    ("sqrt(-h)*sqrt(2)", "sqrt(-2*h)"),
]
FALSE = [
    ("sqrt(2)*sqrt(h)", "sqrt(3*h)"),
    ("sqrt(2)*sqrt(3)", "sqrt(5)"),
    ("sqrt(2) + sqrt(3)", "sqrt(5)"),
    ("sqrt(4*h)", "4*sqrt(h)"),
    ("sqrt(-h)", "-sqrt(h)"),
    ("sqrt(h^2)", "h"),
    ("sqrt(4*h^2)", "2*h"),
    ("sqrt(4*(h - 1)^2)", "2*(1 - h)"),
    ("(8*h)^(1/3)", "sqrt(2)*h^(1/3)"),
    ("sqrt(2*h + 1)", "sqrt(2)*sqrt(h + 1)"),
]


def equal(left: str, right: str) -> bool:
    graph = Graph()
    scope = Scope({"h": graph.variable("h")})
    nodes = [read_expression(text, graph, scope, "here") for text in (left, right)]
    return Algebra(graph).equal(*nodes)


@pytest.mark.parametrize(("left", "right"), TRUE)
def test_roots_that_are_equal(left: str, right: str) -> None:
    assert equal(left, right)


@pytest.mark.parametrize(("left", "right"), FALSE)
def test_roots_that_are_not_shown_to_be_equal(left: str, right: str) -> None:
    assert not equal(left, right)


def value(found: Quotient, names: dict[int, tuple[str, int, int]]) -> float:
    """Return the value of a sum of products of roots of whole numbers."""
    assert not found.bottom
    terms = (
        float(c) * math.prod(names[a][2] ** (k / names[a][1]) for a, k in monomial)
        for monomial, c in found.top.items()
    )
    return math.fsum(terms)


@given(
    number=st.fractions(min_value=Fraction(1, 10**6), max_value=10**6, max_denominator=10**6),
    p=st.integers(-5, 5).filter(bool),
    q=st.integers(2, 5),
)
def test_a_power_of_a_number_has_its_value(number: Fraction, p: int, q: int) -> None:
    """In the ring, as products of roots of factors, and in floats."""
    atoms = Atoms()
    found = atoms.power(Quotient({(): number}), Fraction(p, q))
    names = {atom: key for key, atom in atoms.keys.items() if isinstance(key, tuple)}
    assert value(found, names) == pytest.approx(float(number) ** (p / q), rel=1e-11)


@pytest.mark.parametrize("number", ["1" + "0" * 300 + "7", "99999999999999999999999999999977/3"])
def test_a_large_number_is_left_whole(number: str) -> None:
    """It takes no time, and says no more than that equal roots are equal."""
    assert equal(f"sqrt({number})*sqrt(2*h)", f"sqrt(2)*sqrt({number}*h)") in (True, False)
    assert not equal(f"sqrt({number})", f"sqrt({number} + 1)")


@pytest.mark.parametrize(
    ("scale", "verdict"), [("1", Verdict.PROVED), ("1.000001", Verdict.UNDECIDED)]
)
def test_a_tank_that_empties_is_its_model(scale: str, verdict: Verdict) -> None:
    """h' = sqrt(2) (sqrt(g (h* + x)) - sqrt(g h*)) against a premise with 2 g under one root."""
    equation = f"-sqrt(2)*(sqrt(9.81*(1 + x)) - {scale}*sqrt(9.81))"
    premise = "-(sqrt(19.62*(1 + x)) - sqrt(19.62))/x"
    data = one_state(equation, premise, -3, -1, range=["-1/2", 2])
    assert said_of(data).verdict is verdict


def test_a_root_of_what_is_negative_stays_refused() -> None:
    """sqrt(-2) sqrt(-x - 3) = sqrt(2 x + 6) holds for no real root."""
    data = one_state("sqrt(-2)*sqrt(-x - 3)*x", "sqrt(-2)*sqrt(-x - 3)", -10, 10)
    assert said_of(data).verdict is Verdict.UNDECIDED


Data = dict[str, Any]


def two_states(
    equation: str, premise: str, lower: object, upper: object, entries: list[str]
) -> Data:
    """Return x' = equation as a row of entries in z = premise, y' = -y, on |x|, |y| <= 1."""
    return {
        "kind": "plant",
        "sample_time": None,
        "states": [{"name": n, "unit": "-", "rest": 0, "range": [-1, 1]} for n in "xy"],
        "equations": [equation, "-y"],
        "embedding": {
            "premises": [{"name": "z", "expression": premise, "lower": lower, "upper": upper}],
            "A": [entries, ["0", "-1"]],
        },
    }


SINE = two_states("sin(y + 2*x)", "sin(y + 2*x)/(y + 2*x)", "0.0470", 1, ["2*z", "z"])
PROVED = {
    "sine": SINE,
    "written otherwise": two_states(
        "sin(y + 2*x)", "-3*sin(-2*x - y)/(6*x + 3*y)", "0.0470", 1, ["2*z", "z"]
    ),
    "with another variable": two_states(
        "y*sin(y + 2*x)", "y*sin(y + 2*x)/(2*x + y)", -1, 1, ["2*z", "z"]
    ),
    "cosine": two_states("1 - cos(y - x)", "(1 - cos(y - x))/(y - x)", -1, 1, ["-z", "z"]),
    "of order two": two_states(
        "(1 - cos(y - x))/(y - x)", "(1 - cos(y - x))/(x - y)^2", "0.35", "0.5", ["-z", "z"]
    ),
    "exponential": two_states(
        "exp(x + y) - 1", "(exp(y + x) - 1)/(x + y)", "0.432", "3.195", ["z", "z"]
    ),
}
PROVED["about another point"] = two_states(
    "sin(x + y + 1) - sin(1)", "(sin(x + y + 1) - sin(1))/(x + y)", "-0.351", "0.9", ["z", "z"]
)
PROVED["at a corner of the box alone"] = changed(
    SINE, lambda d: [state.update(range=[0, 1]) for state in d["states"]]
)


@pytest.mark.parametrize("what", PROVED)
def test_a_quotient_by_a_sum_has_its_limit(what: str) -> None:
    found = said_of(PROVED[what])
    assert found.verdict is Verdict.PROVED, found.text
    assert "= 0 a quotient is taken as its limit" in found.text


NOT_PROVED = {
    "a lower end that is not kept": changed(
        PROVED["exponential"], lambda d: d["embedding"]["premises"][0].update(lower="0.44")
    ),
    "an upper end that is not kept": changed(
        PROVED["exponential"], lambda d: d["embedding"]["premises"][0].update(upper="3.19")
    ),
    "a bound that is not kept": changed(
        SINE, lambda d: d["embedding"]["premises"][0].update(lower="0.0471")
    ),
    "a limit beyond the bound": changed(
        SINE, lambda d: d["embedding"]["premises"][0].update(upper="0.99999")
    ),
    "a pole on the line": two_states(
        "cos(y + 2*x)", "cos(y + 2*x)/(y + 2*x)", -(10**9), 10**9, ["2*z", "z"]
    ),
    "a pole of higher order": two_states(
        "sin(x + y)/(x + y)", "sin(x + y)/(x + y)^2", -(10**9), 10**9, ["z", "z"]
    ),
    "a kink": two_states("abs(y - x)", "abs(y - x)/(y - x)", -1, 1, ["-z", "z"]),
    "another sum above": two_states(
        "sin(x + y)", "sin(x + 1.000000001*y)/(x + y)", -5, 5, ["z", "z"]
    ),
    "a limit along one line alone": two_states(
        "x^2/(x + y)", "x^2/(x + y)^2", -(10**9), 10**9, ["z", "z"]
    ),
    "a sum that vanishes away from rest": two_states(
        "x*sin(x + y - 1)/(x + y - 1)", "sin(x + y - 1)/(x + y - 1)", -1, 1, ["z", "0"]
    ),
    "a sum of what has no range": changed(SINE, lambda d: d["states"][1].update(range=None)),
    "inside a function": two_states(
        "x*cos(sin(x + y)/(x + y))", "cos(sin(x + y)/(x + y))", 0, 1, ["z", "0"]
    ),
    "the wrong entries": changed(SINE, lambda d: d["embedding"]["A"].__setitem__(0, ["z", "2*z"])),
}


@pytest.mark.parametrize("what", NOT_PROVED)
def test_what_has_no_limit_or_other_bounds_is_not_proved(what: str) -> None:
    assert said_of(NOT_PROVED[what]).verdict is Verdict.UNDECIDED


@given(
    a=st.integers(-3, 3).filter(bool),
    b=st.integers(-3, 3).filter(bool),
    share=st.floats(0.9, 1.1).filter(lambda s: abs(s - 1) > 1e-6),
)
def test_the_bound_is_the_threshold(a: int, b: int, share: float) -> None:
    """sin(s)/s falls from 1 to sin(r)/r, r = |a| + |b|, for r below its first minimum at 4.49."""
    r = abs(a) + abs(b)
    if r > 4:
        return
    true = math.sin(r) / r
    lower = true + (1 - share) * 0.1
    s = f"{a}*x + {b}*y"
    data = two_states(f"sin({s})", f"sin({s})/({s})", repr(lower), 1, [f"{a}*z", f"{b}*z"])
    assert (said_of(data).verdict is Verdict.PROVED) == (lower <= true)


def test_the_truck_and_trailer_in_states_of_its_own() -> None:
    """x3+ = x3 + v T sin(x2 + v T/(2 L) x1) with the premise sin(s)/s: two rules.

    Tanaka and Sano (1994), as recalled in the built-in plant's file.
    """
    x1, x2, x3, u, z = sp.symbols("x1 x2 x3 u z", real=True)
    s = x2 - x1 * sp.Rational(2, 11)
    plant = plant_of(
        [
            x1 * sp.Rational(15, 11) - sp.Rational(5, 7) * u,
            x2 - 2 * x1 / sp.Integer(11) * 2,
            x3 - 2 * sp.sin(s),
        ],
        [x1, x2, x3],
        [u],
        box={x1: (-1, 1), x2: (-2, 2)},
        premises={z: sp.sin(s) / s},
    )
    data = plant_data(sector_model(plant))
    found = said_of(data)
    assert found.verdict is Verdict.PROVED, found.text
    assert "model of 2 rules exactly" in found.text
    wrong = changed(data, lambda d: d["embedding"]["premises"][0].update(upper="0.9999999"))
    assert said_of(wrong).verdict is Verdict.UNDECIDED
