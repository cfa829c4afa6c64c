"""Polynomials in weights: the ring's laws at points of the simplexes, exactly."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.kinds import simplex_polynomial
from takagi.certificates.checker.kinds.simplex_polynomial import Exponent, Polynomial, exponents

Weights = list[list[Fraction]]


def at(X: Polynomial, w: Weights) -> Matrix:
    total = 0 * next(iter(X.terms.values()))
    for a, term in X.terms.items():
        factor = Fraction(1)
        for row, powers in zip(w, a, strict=True):
            for weight, power in zip(row, powers, strict=True):
                factor *= weight**power
        total = total + factor * term
    return total


@st.composite
def polynomials(draw: st.DrawFn, sizes: tuple[int, ...]) -> Polynomial:
    degrees = tuple(draw(st.integers(0, 2)) for _ in sizes)
    entry = st.integers(-5, 5)
    terms: dict[Exponent, Matrix] = {
        a: Matrix([[draw(entry) for _ in range(2)] for _ in range(2)], 3)
        for a in exponents(sizes, degrees)
    }
    return Polynomial(sizes, degrees, terms)


@st.composite
def cases(draw: st.DrawFn) -> tuple[Polynomial, Polynomial, Weights, Weights]:
    sizes = draw(st.sampled_from([(2,), (3,), (2, 2), (1, 2)]))
    w, v = [], []
    for size in sizes:
        raw = [draw(st.integers(1, 5)) for _ in range(size)]
        w.append([Fraction(x, sum(raw)) for x in raw])
        free = [Fraction(draw(st.integers(-5, 5)), 7) for _ in range(size - 1)]
        v.append([*free, -sum(free, Fraction(0))])
    return draw(polynomials(sizes)), draw(polynomials(sizes)), w, v


def same(X: Matrix, Y: Matrix) -> bool:
    return not any(entry for row in (X - Y).rows for entry in row)


@settings(max_examples=60)
@given(cases())
def test_sums_products_and_raised_degrees_keep_their_values(
    case: tuple[Polynomial, Polynomial, Weights, Weights],
) -> None:
    """(X + Y)(w) = X(w) + Y(w), (X Y)(w) = X(w) Y(w), and raising changes no value."""
    X, Y, w, _ = case

    assert same(at(X + Y, w), at(X, w) + at(Y, w))
    assert same(at(X @ Y, w), at(X, w) @ at(Y, w))
    assert same(at(-X.T, w), -at(X, w).T)
    assert same(at(X.raised([2] * len(X.sizes)), w), at(X, w))


@settings(max_examples=60)
@given(cases())
def test_derivatives_are_those_of_difference_quotients(
    case: tuple[Polynomial, Polynomial, Weights, Weights],
) -> None:
    """Four symmetric differences give the slope of a polynomial of degree up to 4 exactly."""
    X, _, w, v = case

    def moved(t: int) -> Matrix:
        return at(
            X, [[a + t * b for a, b in zip(p, q, strict=True)] for p, q in zip(w, v, strict=True)]
        )

    near, far = moved(1) - moved(-1), moved(2) - moved(-2)
    slope = Fraction(2, 3) * near - Fraction(1, 12) * far

    assert same(at(X.derivative(v), w), slope)


def test_every_exponent_has_to_be_positive() -> None:
    """A term that is missing is zero, which is not positive definite."""
    one = Matrix.identity(1)
    full = Polynomial((2,), (1,), {((1, 0),): one, ((0, 1),): one})

    assert not failing(full)
    assert failing(Polynomial((2,), (1,), {((1, 0),): one})) == ["[0, 1]"]
    # w1^2 - w1 w2 + w2^2 > 0 on the simplex, but one monomial is not: raised twice, all are.
    minus = Polynomial((2,), (2,), {((2, 0),): one, ((1, 1),): -one, ((0, 2),): one})
    assert failing(minus) == ["[1, 1]"]
    assert not failing(minus.raised([4]))


def failing(X: Polynomial) -> list[str]:
    return [powers for powers, term in X.coefficients() if not term.is_positive_definite]


@settings(max_examples=40)
@given(cases(), st.data())
def test_half_of_the_weights_has_the_same_values(
    case: tuple[Polynomial, Polynomial, Weights, Weights], data: st.DataObject
) -> None:
    """X on the half at t is X at w_kept = t_kept + t_moved / 2, w_moved = t_moved / 2."""
    X, _, t, _ = case
    k = data.draw(st.sampled_from([k for k, row in enumerate(t) if len(row) > 1]))
    kept, moved = data.draw(st.permutations(range(len(t[k]))))[:2]
    w = [list(row) for row in t]
    w[k][kept], w[k][moved] = t[k][kept] + t[k][moved] / 2, t[k][moved] / 2

    half = X.halved(k, kept, moved)

    assert half.degrees == X.degrees
    assert same(at(half, t), at(X, w))


@pytest.mark.parametrize(("limit", "work"), [("MOST_PRODUCTS", 9), ("MOST_WORK", 9 * 2**3)])
def test_products_are_counted_before_they_are_made(
    limit: str, work: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Three terms by three, each a product of matrices of order 2: eight of numbers."""
    terms = {a: Matrix.identity(2) for a in exponents((3,), (1,))}
    X = Polynomial((3,), (1,), terms)

    monkeypatch.setattr(simplex_polynomial, limit, work)
    assert len((X @ X).terms) == 6
    monkeypatch.setattr(simplex_polynomial, limit, work - 1)
    with pytest.raises(Refused, match="3 by 3 terms"):
        X @ X
