"""Bounds over a box: tight where they are attained, with limits, and never too narrow."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Verdict, certify
from takagi.certificates.document.plant_embedding import plant_data
from takagi.models import (
    Domain,
    Interval,
    Plant,
    Variable,
    sector_model,
)
from tests.certificates.embedding.plants import one_state, said_of

# Premise, its exact range over -1 <= x <= 2 as rationals, and the equation x times the premise.
ATTAINED = [
    ("x^2", "0", "4"),
    ("x^2/100 + 1/10", "0.1", "0.14"),
    ("1/(2 + x)", "1/4", "1"),
    ("1/(7/3 + x^2)", "3/19", "3/7"),
    ("abs(x)", "0", "2"),
    ("x^3/7", "-1/7", "8/7"),
    ("cos(3*x)", "-1", "1"),
    ("1/(2 + cos(3*x))", "1/3", "1"),
    ("exp(0*x)", "1", "1"),
    ("tanh(x)^2", "0", "0.92935"),
    ("sqrt(x^2 + 9/4)", "3/2", "5/2"),
]


@pytest.mark.parametrize(("premise", "lower", "upper"), ATTAINED)
def test_bounds_that_are_attained_are_proved(premise: str, lower: str, upper: str) -> None:
    """Also where they are not decimals; and an end moved inward by 1e-7 is not."""
    equation = f"x*({premise})"
    assert said_of(one_state(equation, premise, lower, upper)).verdict is Verdict.PROVED
    narrow = str(Fraction(upper) - Fraction(1, 10**7))
    if Fraction(narrow) >= Fraction(lower) and premise != "tanh(x)^2":
        assert said_of(one_state(equation, premise, lower, narrow)).verdict is Verdict.UNDECIDED
    narrow = str(Fraction(lower) + Fraction(1, 10**7))
    if Fraction(narrow) <= Fraction(upper):
        assert said_of(one_state(equation, premise, narrow, upper)).verdict is Verdict.UNDECIDED


# A quotient whose limit at x = 0 is the stated one; Taylor's series of the numerator.
LIMITS = [
    ("sin(x)", "sin(x)/x", 1),
    ("exp(x) - 1", "(exp(x) - 1)/x", 1),
    ("x*(1 - cos(x))", "(1 - cos(x))", 0),
    ("(1 - cos(x))/x", "(1 - cos(x))/x^2", Fraction(1, 2)),
    ("(x - sin(x))/x^2", "(x - sin(x))/x^3", Fraction(1, 6)),
    ("log(1 + x/2)", "log(1 + x/2)/x", Fraction(1, 2)),
    ("atan(3*x)", "atan(3*x)/x", 3),
    ("tan(x/2)", "tan(x/2)/x", Fraction(1, 2)),
    ("sqrt(4 + x) - 2", "(sqrt(4 + x) - 2)/x", Fraction(1, 4)),
    ("sin(x)^2/x", "(sin(x)/x)^2", 1),
    ("sin(x)*exp(x)", "sin(x)/x*exp(x)", 1),
]


@pytest.mark.parametrize(("equation", "premise", "limit"), LIMITS)
def test_removable_singularities_count_with_their_limit(
    equation: str, premise: str, limit: Fraction
) -> None:
    """On a small box around 0 the bounds close in on the limit; without it they fail."""
    side, slack = ["-0.0001", "0.0001"], Fraction(1, 1000)
    near = one_state(equation, premise, str(limit - slack), str(limit + slack), range=side)
    assert said_of(near).verdict is Verdict.PROVED
    assert "x = 0 a quotient is taken as its limit" in said_of(near).text or "/x" not in premise

    without = one_state(equation, premise, str(limit + slack / 10), str(limit + slack), range=side)
    assert said_of(without).verdict is Verdict.UNDECIDED


@given(
    a=st.fractions(-2, 2, max_denominator=20),
    b=st.fractions(-2, 2, max_denominator=20),
    c=st.fractions(-2, 2, max_denominator=20),
)
def test_cubics_between_their_extremes(a: Fraction, b: Fraction, c: Fraction) -> None:
    """Bounds that hold the extremes of a x^2 + b x^3 + c x^4 are proved, those that cut are not.

    The extremes are found a second way, from the roots of the derivative.
    """
    roots = np.roots([4 * float(c), 3 * float(b), 2 * float(a), 0.0])
    points = [-1.0, 2.0, *(r.real for r in roots if abs(r.imag) < 1e-9 and -1 <= r.real <= 2)]
    values = [float(a) * t**2 + float(b) * t**3 + float(c) * t**4 for t in points]
    low, high = min(values), max(values)
    size = max(high - low, 1e-3)
    premise = f"({a})*x^2 + ({b})*x^3 + ({c})*x^4"

    def said(lower: float, upper: float) -> Verdict:
        ends = (str(Fraction(repr(round(float(end), 9)))) for end in (lower, upper))
        return said_of(one_state(f"x*({premise})", premise, *ends)).verdict

    assert said(low - size / 1000, high + size / 1000) is Verdict.PROVED
    assert said(low - size, high - size / 1000) is Verdict.UNDECIDED
    assert said(low + size / 1000, high + size) is Verdict.UNDECIDED


# ---------------------------------------------------------------------- trim


def test_a_law_states_an_irrational_trim_to_its_last_digit() -> None:
    """A tank, 3 h' = q - sqrt(19.62 h)/10 about h = 1: the inflow at rest is sqrt(19.62)/10."""
    level, inflow = sp.symbols("h q", real=True)
    model = sector_model(
        Plant(
            equations=((inflow - sp.sqrt(sp.Rational(1962, 100) * level) / 10) / 3,),
            states=(Variable(level, "m", Interval(Fraction(1, 3), Fraction(2)), Fraction(1)),),
            inputs=(Variable(inflow, "m^3/s"),),
            name="tank",
        ),
        rest="solve inputs",
    )

    certificate = certify(model, np.array([[0.1]]))

    assert certificate.verdict is Verdict.PROVED
    assert "about the exact trim, which the law has to" in certificate.checked.claims[0].text
    trim = certificate.document["gains"]["trim"]
    assert abs(trim["input"][0] - 19.62**0.5 / 10) < 1e-15


def test_a_model_on_less_than_the_plants_ranges_is_about_its_own_box() -> None:
    """The pendulum's sin(x)/x within [-1, 1] of [-2, 2]: bounds and box are those of the domain."""
    x, v = sp.symbols("x v", real=True)
    plant = Plant(
        equations=(v, -sp.sin(x)),
        states=(Variable(x, "rad", Interval.of(-2, 2)), Variable(v, "rad/s")),
        name="pendulum",
    )
    model = sector_model(plant, domain=Domain.of_box({x: Interval.of(-1, 1)}))

    data = plant_data(model)

    assert data["states"][0]["range"] == [-1, 1]
    assert said_of(data).verdict is Verdict.PROVED
