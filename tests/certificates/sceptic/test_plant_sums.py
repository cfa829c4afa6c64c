"""Quotients by sums of variables, sin(x + y)/(x + y): their limits, and what has none."""

from __future__ import annotations

import math
from typing import Any

import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Verdict
from takagi.certificates.document.plant_embedding import plant_data
from takagi.models import sector_model
from tests.certificates.embedding.plants import changed, said_of
from tests.symbolic_plants import plant_of

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
    model = sector_model(plant)
    data = plant_data(model)
    found = said_of(data)
    assert found.verdict is Verdict.PROVED, found.text
    assert "model of 2 rules exactly" in found.text
    wrong = changed(data, lambda d: d["embedding"]["premises"][0].update(upper="0.9999999"))
    assert said_of(wrong).verdict is Verdict.UNDECIDED
