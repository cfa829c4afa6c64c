"""Evidence as JSON: what is written is what is read, and what is broken is refused."""

from __future__ import annotations

import copy
import json
from typing import Any

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.models import Domain, Interval, ModelError, interpolate_curve, table_function
from takagi.models.expressions.writer import expression_text
from takagi.models.ranges import Evidence, evidence_data, evidence_of_data
from takagi.models.sector import expression_range
from takagi.models.ts.premise import round_outward

X, Y = sp.symbols("x y", real=True)
BOX = {X: Interval.of(-1, "1.4"), Y: Interval.of("0.3", 2)}


def proved(expression: sp.Expr, domain: Any = BOX) -> Evidence:
    """Return evidence of bounds that are rounded outward, as a premise has them."""
    found = expression_range(expression, domain, tolerance=sp.Rational(1, 1000))
    assert found.evidence is not None
    return found.evidence.claiming(round_outward(found.outer))


def read_again(evidence: Evidence) -> Evidence:
    return evidence_of_data(json.loads(json.dumps(evidence_data(evidence))))


def expressions() -> st.SearchStrategy[sp.Expr]:
    """Return expressions with a bounded range on BOX."""
    leaves = st.sampled_from([X, Y, sp.Rational(3, 7), sp.Integer(2)])

    def grown(inner: st.SearchStrategy[sp.Expr]) -> st.SearchStrategy[sp.Expr]:
        pairs = st.tuples(inner, inner)
        return st.one_of(
            pairs.map(lambda p: p[0] + p[1]),
            pairs.map(lambda p: p[0] * p[1]),
            pairs.map(lambda p: p[0] / (2 + sp.sin(p[1]))),
            inner.map(lambda e: e**3),
            inner.map(lambda e: sp.sqrt(1 + e**2)),
            inner.map(lambda e: sp.exp(-(e**2))),
            inner.map(sp.Abs),
            inner.map(sp.tanh),
        )

    return st.recursive(leaves, grown, max_leaves=5)


@pytest.mark.slow
@settings(max_examples=50, deadline=None, derandomize=True)
@given(expressions())
def test_what_is_written_replays_when_it_is_read(expression: sp.Expr) -> None:
    """The same claim, proved by the same boxes."""
    evidence = proved(expression)
    again = read_again(evidence)

    assert again.bounds == evidence.bounds and again.trees == evidence.trees
    assert evidence.bounds.contains(again.replay())


def test_a_band_is_written_with_its_coordinates() -> None:
    """x between v^2 - 1/10 and v^2 + 1/10; the share across the band becomes a name."""
    tenth = sp.Rational(1, 10)
    band = Domain.band({Y: Interval.of(-2, 1)}, {X: (Y**2 - tenth, Y**2 + tenth)})
    union = band | Domain.of_box({X: Interval.of(0, 1), Y: Interval.of(2, 3)})
    evidence = proved(X * sp.sin(X - Y**2), union)
    data = evidence_data(evidence)

    assert data["cells"][0]["box"].keys() == {"y", "share_x"}
    assert read_again(evidence).replay() == evidence.replay()


def test_two_symbols_of_one_name_are_not_written() -> None:
    """A variable called as the share across the band is: reading could not tell them apart."""
    named = sp.Symbol("share_x", real=True)
    band = Domain.band({Y: Interval.of(0, 1), named: Interval.of(0, 9)}, {X: (Y, Y + 1)})
    with pytest.raises(ModelError, match="two symbols called share_x"):
        evidence_data(proved(X * Y, band))


def test_tables_are_named_and_given_when_read() -> None:
    """A spline stands by its name; its derivative has none."""
    x = np.linspace(-1, 2, 9)
    wave = table_function("wave", interpolate_curve(x, np.sin(3 * x)))
    evidence = proved(wave(X) * Y)
    data = json.loads(json.dumps(evidence_data(evidence)))

    assert evidence_of_data(data, {"wave": wave}).replay() == evidence.replay()
    with pytest.raises(ModelError, match="'wave' is not a function"):
        evidence_of_data(data)
    with pytest.raises(ModelError, match="cannot be written"):
        expression_text(wave(X).diff(X))
    with pytest.raises(ModelError, match="cannot be written"):
        expression_text(sp.Max(X, Y))
    with pytest.raises(ModelError, match="two symbols of one name"):
        expression_text(X + sp.Symbol("x"))


EXAMPLE = X * sp.sin(3 * X) * sp.cos(Y) + Y


def broken(*path: Any, value: Any) -> dict[str, Any]:
    """Return the data of the example with one field changed."""
    data: Any = copy.deepcopy(evidence_data(proved(EXAMPLE)))
    place = data
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return dict(data)


@pytest.mark.parametrize(
    ("path", "value"),
    [
        (("bounds", 0), "0"),
        (("bounds", 1), "1"),
        (("expression",), "x*sin(3*x)*cos(y) + 2*y"),
        (("expression",), "x*sin(4*x)*cos(y) + y"),
        (("cells", 0, "box", "x"), ["-1", "3"]),
        (("cells", 0, "box", "y"), ["-9", "2"]),
        (("cells", 0, "tree"), "s"),
        (("cells", 0, "sides"), ["y", "x"]),
    ],
)
def test_a_false_claim_is_refused_on_replay(path: tuple[Any, ...], value: Any) -> None:
    """A bound, the expression, the box, the tree or its numbering changed by hand."""
    assert evidence_of_data(evidence_data(proved(EXAMPLE))).replay()
    with pytest.raises(ModelError, match="not proved|halve"):
        evidence_of_data(broken(*path, value=value)).replay()


@pytest.mark.parametrize(
    ("path", "value", "words"),
    [
        (("bounds",), ["0"], "two rational numbers"),
        (("bounds", 0), "1e999999999", "two rational numbers"),
        (("bounds", 0), "nan", "two rational numbers"),
        (("bounds", 0), 0.5, "a text is needed"),
        (("bounds", 0), "1/0", "two rational numbers"),
        (("precision",), 10**9, "53 to 1024 bits"),
        (("precision",), True, "53 to 1024 bits"),
        (("expression",), "__import__('os')", "column"),
        (("expression",), "x^(10^9)", "exponent"),
        (("cells",), [], "1 to 1000 cells"),
        (("cells",), {"a": 1}, "1 to 1000 cells"),
        (("cells", 0, "tree"), "0" * 200_000, "100000 characters"),
        (("cells", 0, "box"), {"x y": ["0", "1"]}, "no name of a variable"),
        (("cells", 0, "box"), 3, "a table is needed"),
        (("cells", 0, "extra"), 3, "fields"),
        (("more",), 3, "fields"),
    ],
)
def test_hostile_data_is_refused_when_read(path: tuple[Any, ...], value: Any, words: str) -> None:
    """Sizes, types, fields and names are checked before anything is computed."""
    with pytest.raises(ModelError, match=words):
        evidence_of_data(broken(*path, value=value))
