"""Vertices from multi-affine coefficients: correctly rounded, stored by entry, made on demand."""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import numpy as np
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

from takagi.models import ModelError, Premise, TSModel
from takagi.models.sector.assembly import check_exact, corner_values, vertex_product
from takagi.models.ts.vertex_arrays import VertexProduct

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
