"""The number of rules before a model is built, and the premises that make them."""

from __future__ import annotations

import json
from fractions import Fraction
from itertools import product
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.certificates import Verdict
from takagi.certificates.checker import read_text
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.document.plant_embedding import plant_data
from takagi.models import (
    Interval,
    ModelError,
    Plant,
    Premise,
    TSModel,
    Variable,
    load_model,
    rule_count,
    sector_model,
)
from takagi.models.sector.assembly import check_exact, corner_values, vertex_product
from takagi.models.ts.vertex_arrays import VertexProduct

STATES = sp.symbols("x1:13", real=True)


def chain() -> Plant:
    """Return x_k' = -x_k - x_k^3, |x_k| <= k/10: twelve premises, each in [0, k^2/100]."""
    return Plant(
        states=tuple(
            Variable(s, "-", Interval.of(f"-{(k + 1) / 10}", f"{(k + 1) / 10}"))
            for k, s in enumerate(STATES)
        ),
        equations=tuple(-s - s**3 for s in STATES),
        name="chain",
    )


def turned() -> Plant:
    """Return x' = -(5 + y) x, y' = (sin y/y) x - y, z' = z: premises y and sin y / y."""
    x, y, z = STATES[:3]
    return Plant(
        states=tuple(Variable(s, "-", Interval.of(-1, 1)) for s in (x, y)) + (Variable(z),),
        equations=(-5 * x - y * x, sp.sin(y) - y, z),
        name="turned",
    )


@pytest.mark.parametrize("name", ["cart_pole", "tora", "lorenz", "mass_spring_damper"])
def test_the_count_is_that_of_the_model(name: str) -> None:
    plant = load_model(name)
    assert isinstance(plant, Plant)
    model, count = sector_model(plant), rule_count(plant)

    assert count.rules == len(model.rules) == 2 ** len(count.premises)
    assert {p.name for p in count.premises} == {p.name for p in model.premises}
    for premise in model.premises:
        rough = next(p for p in count.premises if p.name == premise.name)
        assert rough.bounds.width <= premise.bounds.width * 27 / 25


def test_cheap_premises_come_first() -> None:
    """sin y / y in [0.84, 1] is 16 % of its size wide, y in [-1, 1] 200 %."""
    count = rule_count(turned())

    assert [str(p.latex) for p in count.premises] == sorted(
        (str(p.latex) for p in count.premises),
        key=lambda latex: next(
            float(p.bounds.width / p.bounds.magnitude) for p in count.premises if p.latex == latex
        ),
    )
    assert float(count.premises[0].bounds.width) < 0.2
    assert "15.9 % of its size; " in count.words and count.words.endswith("200 % of its size")


def test_many_rules_are_counted_and_refused_before_a_vertex_is_made() -> None:
    """Twelve premises: 4096 rules are told, and 1024 are the most that a model has."""
    count = rule_count(chain())

    assert count.rules == 4096 and len(count.premises) == 12
    with pytest.raises(ModelError, match=r"12 premises make 4096 rules, .* = 1024.*width 100 %"):
        sector_model(chain())


def test_constant_premises_are_told_apart() -> None:
    x, y = STATES[:2]
    point = Plant(
        states=(Variable(x, "-", Interval.of(-1, 1)), Variable(y, "-", Interval.of(0, 0))),
        equations=(-x - x**3, -y - y**3),
        name="point",
    )
    count = rule_count(point)

    assert count.rules == 2
    assert len(count.premises) == len(count.constant) == 1


PLANT = """
format = 1
kind = "plant"
name = "numbers"
units = "unchecked"
[states]
x = { range = [0, 4], rest = 2 }
y = { range = [0.5, 1.5], rest = 1 }
[inputs]
u = { range = [-20, 20], rest = "solve" }
v = { range = [-20, 20], rest = "solve" }
[equations]
"""


@pytest.mark.parametrize(
    ("x", "y", "rules", "numbers"),
    [
        ("u*y - 0.3*x^1.5", "v - y*u", 4, {"u_rest"}),
        ("u - sqrt(x + 2)", "sqrt(x + 2)/pi - y*sqrt(2) + v", 2, {"1/pi", "sqrt(2)"}),
        ("u - x^3/pi", "v - y + x^3", 2, {"1/pi"}),  # x^3 - 8 and (x^3 - 8)/pi + 8/pi
        # v = u/3 at rest, so that (v - u/3)/(1 + y) has no premise for its value there.
        ("u - 0.3*x^1.5", "(v - u/3)/(1 + y) - y + 1", 4, set()),
    ],
)
def test_a_number_that_is_no_fraction_makes_no_rule(
    x: str, y: str, rules: int, numbers: set[str], tmp_path: Path
) -> None:
    """A rest that was solved for, pi or a root is a factor of entries; no premise is narrow."""
    path = tmp_path / "plant.toml"
    path.write_text(f'{PLANT}x = "{x}"\ny = "{y}"\n', encoding="utf-8")
    model = sector_model(load_model(path))  # type: ignore[arg-type]

    assert len(model.A) == rules
    assert all(p.bounds.width > p.bounds.magnitude / 10**9 for p in model.premises)
    found = plant_data(model)["embedding"].get("numbers", [])
    assert {number["expression"] for number in found} == numbers
    claim = {"name": "it is its model", "kind": "sector-embedding"}
    read = read_text(json.dumps(plant_data(model)), "model")
    assert replay(claim, {"model": read}, None, [], "claim").verdict is Verdict.PROVED


Z = sp.symbols("z1:5")
X, Y = sp.symbols("x y", real=True)
UNIT = [(Fraction(0), Fraction(1))] * 4
numbers = st.fractions(-5, 5, max_denominator=10**6)
members = st.sets(st.integers(0, 3), max_size=4).map(lambda some: tuple(sorted(some)))
corner = st.one_of(st.tuples(numbers), st.tuples(numbers, numbers))


@given(st.dictionaries(members, numbers, max_size=6), st.lists(corner, min_size=4, max_size=4))
def test_every_corner_is_the_rational_rounded_once(
    polynomial: dict[tuple[int, ...], Fraction], corners: list[tuple[Fraction, ...]]
) -> None:
    axes, values = corner_values(polynomial, corners)

    for rule in product(*(range(len(c)) for c in corners)):
        z = [c[k] for c, k in zip(corners, rule, strict=True)]
        exact = Fraction(0)
        for some, coefficient in polynomial.items():
            term = coefficient
            for k in some:
                term *= z[k]
            exact += term
        assert values[tuple(rule[axis] for axis in axes)] == float(exact)


def ten_premises() -> tuple[sp.Matrix, list[Premise]]:
    """Return an 8 x 8 matrix in ten premises, up to two multiplied, and their ranges."""
    z = sp.symbols("z1:11")

    def entry(i: int, j: int) -> sp.Expr:
        return sp.Rational(i - j, 7) + z[(i + j) % 10] / 3 + z[i] * z[(i + j + 2) % 10]

    A = sp.Matrix([[z[j] if j == 0 else entry(i, j) for j in range(8)] for i in range(8)])
    return A, [Premise(f"z{k}", Fraction(-1, k + 2), Fraction(1, k + 1)) for k in range(1, 11)]


def test_a_thousand_rules_are_kept_by_entry_until_they_are_asked_for() -> None:
    """The stack of 1024 vertices equals substitution at some rules; nothing is made before."""
    A, premises = ten_premises()
    product_ = vertex_product(A, sp.symbols("z1:11"), [p.corners for p in premises])
    model = TSModel(product_, premises=premises)

    assert len(model.rules) == 1024
    with pytest.raises(AttributeError):
        object.__getattribute__(model, "A")
    for rule in (0, 1, 500, 1023):
        at = zip(sp.symbols("z1:11"), premises, model.rules[rule], strict=True)
        values = {s: sp.Rational(*p.corners[k].as_integer_ratio()) for s, p, k in at}
        np.testing.assert_array_equal(model.A[rule], np.array(A.subs(values), dtype=float))
    assert model.A is model.A
    assert not model.A.flags.writeable
    assert model.B.shape == (1024, 8, 0)


@pytest.mark.parametrize(
    ("build", "message"),
    [
        (lambda: vertex_product(sp.Matrix([[Z[0] ** 2]]), Z, UNIT), r"A\[0, 0\] = z1\*\*2"),
        (lambda: vertex_product(sp.Matrix([[sp.sin(Z[1])]]), Z, UNIT), "not linear"),
        (lambda: vertex_product(sp.Matrix([[X]]), Z, UNIT), "still contains x"),
        (lambda: VertexProduct((2,), 1, 1, {(0, 0): ((0,), np.ones(3))}), "values of shape"),
        (lambda: VertexProduct((), 1, 1, {(0, 0): ((), np.array(np.nan))}), "not finite"),
        (lambda: TSModel(VertexProduct((2,), 1, 1, {})), "premises have"),
        (
            lambda: TSModel(VertexProduct((), 1, 1, {}), np.ones((1, 1, 1))),
            "give all matrices in one way",
        ),
    ],
)
def test_misuse_names_the_entry(build: object, message: str) -> None:
    with pytest.raises(ModelError, match=message):
        build()  # type: ignore[operator]


def test_exactness_says_how_it_was_checked() -> None:
    """sin(2x) = 2 sin x cos x by sympy; |x| = x on [1, 2] only at points, and the words say so."""
    from takagi.models import Interval

    shown = check_exact([("row 1", sp.sin(2 * X), 2 * sp.sin(X) * sp.cos(X))], {})
    tried = check_exact([("row 1", sp.Abs(X), X)], {X: Interval.of(1, 2)})

    assert shown == "checked symbolically"
    assert "row 1 checked in ball arithmetic at 12 random rational points only" in tried


def test_a_small_planted_error_is_refuted_at_a_point() -> None:
    """sin(2x) against 2 sin x cos x + 1e-15 x: the ball at a point leaves 0 out."""
    wrong = 2 * sp.sin(X) * sp.cos(X) + X * sp.Rational(1, 10**15)
    with pytest.raises(ModelError, match="row 2: the factored form misses the plant by .* at x ="):
        check_exact([("row 1", X, X), ("row 2", sp.sin(2 * X), wrong)], {})
