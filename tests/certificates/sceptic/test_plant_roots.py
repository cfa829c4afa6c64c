"""Numbers under roots: what is shown to be equal, and what must not be."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Verdict
from takagi.certificates.checker.plant.atoms import Atoms
from takagi.certificates.checker.plant.expression import Scope, read_expression
from takagi.certificates.checker.plant.graph import Graph
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.polynomial import Quotient
from tests.certificates.embedding.plants import one_state, said_of

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
