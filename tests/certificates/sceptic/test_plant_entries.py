"""The polynomial that the vertices are made of is what the equations are compared with."""

from __future__ import annotations

from typing import Any

import pytest

from takagi.certificates import Verdict
from tests.certificates.embedding.plants import as_read, embedding_outcome, one_state, said_of


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
