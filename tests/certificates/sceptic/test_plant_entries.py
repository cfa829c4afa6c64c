"""Entries of a plant's matrices: quotients, roots and sums that cancel, and what must not."""

from __future__ import annotations

import math
from fractions import Fraction

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
    said_of,
)
from tests.certificates.kinds.claims import Data
from tests.symbolic_plants import plant_of

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
