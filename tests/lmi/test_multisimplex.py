"""Polynomials on products of simplexes: every operation against values at random points."""

from __future__ import annotations

from fractions import Fraction
from math import comb

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from takagi.lmi.polynomials import Basis, Known, UnknownPolynomial, contributions
from takagi.models import Floats

simplexes = st.lists(st.tuples(st.integers(1, 4), st.integers(0, 3)), min_size=1, max_size=3)
# An unknown has a weight for every pair of coefficient and member: gigabytes for the largest above.
small = st.lists(st.tuples(st.integers(1, 3), st.integers(0, 2)), min_size=1, max_size=3)


def points(sizes: tuple[int, ...], rng: np.random.Generator, count: int = 5) -> Floats:
    """Return (count, sum of sizes), a random point of each simplex."""
    return np.concatenate([rng.dirichlet(np.ones(size), count) for size in sizes], axis=1)


def value(polynomial: Known, h: Floats) -> Floats:
    """Return the polynomial's matrices at the points."""
    return np.asarray(np.tensordot(polynomial.basis.values(h), polynomial.values, axes=1))


def random_known(basis: Basis, rng: np.random.Generator, p: int, q: int) -> Known:
    return Known(basis, rng.standard_normal((basis.count, p, q)))


def split(pairs: list[tuple[int, int]]) -> tuple[tuple[int, ...], tuple[int, ...]]:
    return tuple(size for size, _ in pairs), tuple(degree for _, degree in pairs)


@given(simplexes)
def test_the_basis_is_nonnegative_sums_to_one_and_is_listed_once(
    pairs: list[tuple[int, int]],
) -> None:
    """(size + degree - 1 choose degree) in each simplex; ``rank`` finds every exponent again."""
    basis = Basis(*split(pairs))
    values = basis.values(points(basis.sizes, np.random.default_rng(0)))

    assert basis.count == np.prod([comb(n + g - 1, g) for n, g in pairs])
    assert (values >= 0).all()
    np.testing.assert_allclose(values.sum(axis=-1), 1.0)
    np.testing.assert_array_equal(basis.rank(basis.exponents), np.arange(basis.count))


@given(simplexes, st.integers(0, 100))
def test_products_and_raised_degrees(pairs: list[tuple[int, int]], seed: int) -> None:
    """(X Y)(h) = X(h) Y(h), and a polynomial in higher degrees is what it was."""
    rng = np.random.default_rng(seed)
    sizes, degrees = split(pairs)
    h = points(sizes, rng)
    X = random_known(Basis(sizes, degrees), rng, 2, 3)
    Y = random_known(Basis(sizes, tuple(1 for _ in sizes)), rng, 3, 2)
    more = tuple(int(k) for k in rng.integers(0, 3, len(sizes)))

    np.testing.assert_allclose(value(X @ Y, h), value(X, h) @ value(Y, h), atol=1e-12)
    np.testing.assert_allclose(value(X.raised(more), h), value(X, h), atol=1e-12)
    np.testing.assert_allclose(value(X - X.raised(more), h), 0, atol=1e-12)


@given(small, st.integers(0, 100))
def test_unknown_coefficients_and_their_rates(pairs: list[tuple[int, int]], seed: int) -> None:
    rng = np.random.default_rng(seed)
    sizes, degrees = split(pairs)
    basis = Basis(sizes, degrees)
    members = rng.standard_normal((basis.count, 2, 2))
    K = random_known(Basis(sizes, tuple(1 for _ in sizes)), rng, 2, 3)
    h = points(sizes, rng)
    target = tuple(g + 1 + int(rng.integers(0, 2)) for g in degrees)

    found = contributions(UnknownPolynomial.of(basis), K, target)
    total = np.zeros((Basis(sizes, target).count, 2, 3))
    np.add.at(total, found.items, members[found.members] @ found.values)
    velocity = [rng.standard_normal(size) for size in sizes]
    velocity = [v - v.mean() for v in velocity]
    slope = np.zeros((len(h), 2, 2))
    for part in UnknownPolynomial.of(basis).derivatives(velocity):
        rate = Known(part.basis, np.tensordot(part.weights, members, axes=1))
        slope = slope + value(rate, h)
    X, e = Known(basis, members), 1e-6 * np.concatenate(velocity)

    np.testing.assert_allclose(
        value(Known(Basis(sizes, target), total), h), value(X, h) @ value(K, h), atol=1e-12
    )
    np.testing.assert_allclose(slope, (value(X, h + e) - value(X, h - e)) / 2e-6, atol=1e-7)
    pairs_found = list(zip(found.items.tolist(), found.members.tolist(), strict=True))
    assert len(set(pairs_found)) == len(pairs_found)


def test_fractions_stay_exact() -> None:
    """A third is no dyadic: raised by one degree, h1 h1 h2 takes 2/3 and 1/3 of its neighbours."""
    X = Known(Basis((2,), (2,)), np.array([[[Fraction(k)]] for k in (1, 10, 100)]))
    raised = X.raised((1,)).values[:, 0, 0]
    found = contributions(UnknownPolynomial.of(Basis((2,), (1,))), X, (4,))

    assert raised.tolist() == [1, Fraction(1, 3) + Fraction(20, 3), Fraction(120, 3), 100]
    assert all(type(entry) is Fraction for entry in found.values.flat)
