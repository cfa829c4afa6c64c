"""Texts from a stranger: refused in bounded time, with a message, and never executed."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Verdict
from takagi.certificates.checker import CertificateError
from takagi.certificates.checker.plant.expression import Scope, read_expression
from takagi.certificates.checker.plant.graph import Graph
from tests.certificates.embedding.plants import one_state, said_of


def read(text: object) -> int:
    graph = Graph()
    names = {name: graph.variable(name) for name in ("x", "y")}
    return read_expression(text, graph, Scope(names, {"table": 2}), "here")


HOSTILE = {
    "deep brackets": "(" * 10_000 + "x" + ")" * 10_000,
    "brackets deep enough for any stack": "(" * 61 + "x" + ")" * 61,
    "deep functions": "sin(" * 2000 + "x" + ")" * 2000,
    "deep powers": "^".join(["2"] * 200),
    "a tower": "9^9^9^9^9",
    "a huge exponent": "1e999999999",
    "an exponent of many digits": "1e" + "9" * 5000,
    "a number of many digits": "1" * 5000,
    "a large power": "x^1000000",
    "a power with a large numerator": "x^(4095/64)",
    "powers of powers": "((((x^60)^60)^60)^60)^60",
    "constants that grow": "((((2^64)^64)^64)^64)",
    "many factors": "*".join(["x"] * 1000),
    "an exponent that varies": "2^x",
    "a division by zero": "1/0",
    "a division by a hidden zero": "1/(2 - 2)",
    "zero to a negative power": "0^(-1)",
    "too long": "x+" * 20_000 + "x",
    "no end": "sin(x",
    "no start": ")x",
    "two names": "x y",
    "an unknown name": "z",
    "an unknown function": "gamma(x)",
    "a function without argument": "sin",
    "a function with two": "sin(x, y)",
    "a table with one argument": "table(x)",
    "python": "__import__('os').system('true')",
    "an attribute": "x.real",
    "an index": "x[0]",
    "a comparison": "x<1",
    "a lambda": "lambda: 0",
    "letters that only look so": "\u0445 + 1",
    "digits that only look so": "x * \u0663",
    "a null": "x\0",
    "nothing": "",
    "blanks": "   ",
    "a comment": "x # y",
    "no text": 3,
    "a row": ["x"],
}


@pytest.mark.parametrize("what", HOSTILE)
def test_hostile_texts_are_refused(what: str) -> None:
    """A CertificateError, whatever it is; nothing else gets out."""
    with pytest.raises(CertificateError):
        read(HOSTILE[what])


@given(st.text(alphabet="xy0123456789.e+-*/^(), sincopi", max_size=60))
def test_any_text_is_read_or_refused(text: str) -> None:
    """No other exception from a text of the right letters in any order."""
    try:
        read(text)
    except CertificateError:
        return


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("-2^2", -4),
        ("2^3^2", 512),
        ("2^-1*4", 2),
        ("1 - 2 - 3", -4),
        ("8/4/2", 1),
        ("--1", 1),
        ("2*-3", -6),
        ("1.5e1 + .5", 15.5),
        ("(1 + 2)*3", 9),
        ("2**3", 8),
        ("-(-1)^3", 1),
    ],
)
def test_the_grammar_is_the_usual_one(text: str, value: float) -> None:
    """Powers bind from the right, and more than signs; - and / from the left."""
    graph = Graph()
    assert graph.value(read_expression(text, graph, Scope({}), "here")) == value


@pytest.mark.slow
def test_work_is_bounded() -> None:
    """Identities and ranges that would take for ever end as not proved."""
    product = "*".join(f"(1 + x + sin({k}*x) + exp({k}*x))" for k in range(1, 26))
    found = said_of(one_state(f"x*({product})", product, -1, 1))
    assert found.verdict is Verdict.UNDECIDED

    # A dependency that no bisection of this size resolves.
    flat = "+".join(f"sin(x + {k})^2*x - sin(x + {k})^2*x" for k in range(20))
    found = said_of(one_state(f"x*(1 + {flat})", f"1 + {flat}", 1, 1))
    assert found.verdict in (Verdict.UNDECIDED, Verdict.PROVED)


def many_states(count: int, entry: str) -> dict[str, Any]:
    names = [f"x{k}" for k in range(count)]
    return {
        "kind": "plant",
        "sample_time": None,
        "states": [{"name": n, "unit": "-", "rest": 0, "range": [-1, 1]} for n in names],
        "equations": ["0"] * count,
        "mass": [[entry] * count for _ in names],
        "embedding": {"premises": [], "A": [["0"] * count for _ in names]},
    }


@pytest.mark.parametrize("count", [0, 65])
def test_too_few_or_too_many_states_are_refused(count: int) -> None:
    with pytest.raises(CertificateError):
        said_of(many_states(count, "1"))
