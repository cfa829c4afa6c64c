"""Matrix polynomials on a product of simplexes, by their Bernstein coefficients.

The parameter is h = (h^1, ..., h^K), each h^k a point of a simplex: h^k_c >= 0, sum_c h^k_c = 1.  A
polynomial of degree g_k in each h^k is

    X(h) = sum_a B_a(h) X_a,     B_a(h) = prod_k g_k! / prod_c a^k_c!  prod_c (h^k_c)^(a^k_c),

over all exponents a with sum_c a^k_c = g_k.  The B_a are nonnegative and sum to 1, so X(h) is a
convex combination of its coefficients: X_a > 0 for all a gives X(h) > 0 for all h, and the
coefficients of a constant are that constant.  Written in a higher degree the coefficients come
closer to the values (Polya): nothing but a multiplication by 1, whose coefficients are all 1.

A rule of a Takagi-Sugeno model is a corner of such a product; a model without premises has a single
simplex with a corner a rule.

Source: Farouki (2012), The Bernstein polynomial basis: a centennial retrospective, Computer Aided
Geometric Design 29, for the basis; Oliveira, Bliman and Peres (2008), Robust LMIs with parameters
in multi-simplex, IEEE Conf. Decision and Control, for their use in LMIs.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import combinations_with_replacement
from math import comb, factorial
from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.condition.term import Array
from takagi.models.arrays import Floats, Indices, ShortRepr
from takagi.models.errors import ModelError

Degrees: TypeAlias = tuple[int, ...]

_fraction = np.frompyfunc(Fraction, 2, 1)
_exact = np.frompyfunc(Fraction, 1, 1)


@dataclass(frozen=True, slots=True)
class Basis:
    """The B_a of given degrees, the last simplex changing first.

    Attributes
    ----------
    sizes : corners of each simplex.
    degrees : g_k.
    """

    sizes: tuple[int, ...]
    degrees: Degrees

    @property
    def exponents(self) -> Indices:
        """Return (count, sum of sizes): one row an exponent a, simplex after simplex."""
        return _exponents(self.sizes, self.degrees)

    @property
    def count(self) -> int:
        return len(self.exponents)

    @property
    def orderings(self) -> Indices:
        """Return (count,): the factor prod_k g_k! / prod_c a^k_c! of each B_a."""
        factorials = np.array([factorial(k) for k in range(max(self.degrees, default=0) + 1)])
        factorial_of_degrees = int(np.prod(factorials[list(self.degrees)]))
        return np.asarray(
            factorial_of_degrees // factorials[self.exponents].prod(axis=1), dtype=np.intp
        )

    def raised(self, degrees: Degrees) -> Basis:
        """Return the basis with its degrees raised by the given ones."""
        return Basis(self.sizes, tuple(a + b for a, b in zip(self.degrees, degrees, strict=True)))

    def lowered(self, degrees: Degrees) -> Basis:
        """Return the basis with its degrees lowered by the given ones."""
        return self.raised(tuple(-d for d in degrees))

    def values(self, h: ArrayLike) -> Floats:
        """Return B_a(h), (..., count), for h of shape (..., sum of sizes)."""
        powers = np.asarray(h, dtype=np.float64)[..., None, :] ** self.exponents
        return np.asarray(self.orderings * powers.prod(axis=-1))

    def rank(self, exponents: Indices) -> Indices:
        """Return where rows of exponents appear in ``exponents``: the inverse of taking them."""
        position = np.zeros(len(exponents), dtype=np.intp)
        first = 0
        for size, degree in zip(self.sizes, self.degrees, strict=True):
            powers = exponents[:, first : first + size]
            position = position * comb(size + degree - 1, degree) + _rank(powers, degree)
            first += size
        return position

    def corners(self, corners: Indices) -> Indices:
        """Return which B_a is alone at each corner, (r,), for rows of corner numbers (r, K)."""
        rows = np.zeros((len(corners), sum(self.sizes)), dtype=np.intp)
        starts = np.cumsum([0, *self.sizes[:-1]])
        rows[np.arange(len(corners))[:, None], starts + corners] = self.degrees
        return self.rank(rows)

    def label(self, item: int, axes: Sequence[str]) -> str:
        """Return one product in words, e.g. ``"h1 h2"``; axes are the names of all corners."""
        powers = self.exponents[item].tolist()
        names = [axis for axis, power in zip(axes, powers, strict=True) for _ in range(power)]
        return " ".join(filter(None, names))


class Products(NamedTuple):
    """B_first B_second = weight B_item; weight is numerator / denominator, both integers."""

    item: Indices
    first: Indices
    second: Indices
    numerator: Indices
    denominator: Indices

    def weight(self, *, exact: bool) -> Array:
        """Return the weights, (T,): Fractions where ``exact``."""
        if exact:
            return np.asarray(_fraction(self.numerator, self.denominator))
        return np.asarray(self.numerator / self.denominator)


@lru_cache(maxsize=64)
def products(first: Basis, second: Basis) -> Products:
    """Return every product of the one basis with the other, in the basis of the summed degrees."""
    product_basis = first.raised(second.degrees)
    a, b = np.indices((first.count, second.count)).reshape(2, -1)
    item = product_basis.rank(first.exponents[a] + second.exponents[b])
    return Products(
        item, a, b, first.orderings[a] * second.orderings[b], product_basis.orderings[item]
    )


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """A known matrix polynomial: values (count, p, q), its Bernstein coefficients."""

    basis: Basis
    values: Array

    @classmethod
    def of_vertices(cls, sizes: tuple[int, ...], corners: Indices, vertices: Array) -> Known:
        """Return the polynomial of degree 1 in each simplex with the given values at corners."""
        basis = Basis(sizes, (1,) * len(sizes))
        values = np.empty_like(vertices)
        values[basis.corners(corners)] = vertices
        return cls(basis, values)

    @property
    def exact(self) -> bool:
        """Return whether the coefficients are Fractions."""
        return self.values.dtype == object

    def __matmul__(self, other: Known) -> Known:
        """Return the product, of the summed degrees."""
        table = products(self.basis, other.basis)
        weight = table.weight(exact=self.exact or other.exact)[:, None, None]
        terms = self.values[table.first] @ other.values[table.second]
        return self._summed(self.basis.raised(other.basis.degrees), table.item, weight * terms)

    def raised(self, degrees: Degrees) -> Known:
        """Return the same polynomial with its degrees raised by the given ones."""
        if not any(degrees):
            return self
        table = products(self.basis, Basis(self.basis.sizes, degrees))
        weight = table.weight(exact=self.exact)[:, None, None]
        return self._summed(
            self.basis.raised(degrees), table.item, weight * self.values[table.first]
        )

    def to(self, degrees: Degrees) -> Known:
        """Return the same polynomial written in the given, no smaller, degrees."""
        return self.raised(Basis(self.basis.sizes, degrees).lowered(self.basis.degrees).degrees)

    def __sub__(self, other: Known) -> Known:
        """Return the difference, in the larger of the degrees."""
        pairs = zip(self.basis.degrees, other.basis.degrees, strict=True)
        degrees = tuple(max(a, b) for a, b in pairs)
        first, second = self.to(degrees), other.to(degrees)
        return Known(first.basis, first.values - second.values)

    @staticmethod
    def _summed(basis: Basis, item: Indices, summands: Array) -> Known:
        zero = Fraction(0) if summands.dtype == object else 0.0
        values = np.full((basis.count, *summands.shape[1:]), zero, dtype=summands.dtype)
        np.add.at(values, item, summands)
        return Known(basis, values)


def marginals(h: ArrayLike, sizes: tuple[int, ...], corners: Indices) -> Floats:
    """Return w, (..., sum of sizes), from the weights h, (..., r), of the corners (r, K).

    w^k_c is the sum of h_i over the corners i of the product that take corner c of simplex k.
    """
    weights = np.asarray(h, dtype=np.float64)
    marginal_weights = [
        weights @ (corners[:, k : k + 1] == np.arange(size)) for k, size in enumerate(sizes)
    ]
    return np.concatenate(marginal_weights, axis=-1)


@lru_cache(maxsize=256)
def _exponents(sizes: tuple[int, ...], degrees: Degrees) -> Indices:
    powers = []
    for size, degree in zip(sizes, degrees, strict=True):
        chosen = np.array(list(combinations_with_replacement(range(size), degree)), dtype=np.intp)
        powers.append((chosen[:, :, None] == np.arange(size)).sum(axis=1))
    rows = np.zeros((1, 0), dtype=np.intp)
    for rows_of_simplex in powers:
        repeated = np.repeat(rows, len(rows_of_simplex), axis=0)
        rows = np.concatenate([repeated, np.tile(rows_of_simplex, (len(rows), 1))], axis=1)
    rows.setflags(write=False)
    return rows


def _rank(exponents: Indices, degree: int) -> Indices:
    """Return how many exponents of one simplex come before each, larger first powers first."""
    size = exponents.shape[1]
    tails = degree - np.cumsum(exponents, axis=1)
    position = np.zeros(len(exponents), dtype=np.intp)
    for c in range(size - 1):
        later = size - 1 - c
        smaller = np.array([comb(tail - 1 + later, later) for tail in range(degree + 1)])
        position += smaller[tails[:, c]]
    return position


@dataclass(frozen=True, slots=True, eq=False)
class UnknownPolynomial:
    """X(h) = sum_a B_a(h) sum_m weights[a, m] X_m: linear in the members X_m of an unknown.

    Attributes
    ----------
    basis : of a.
    weights : (count, members).
    """

    basis: Basis
    weights: Array

    @classmethod
    def of(cls, basis: Basis) -> UnknownPolynomial:
        """Return the polynomial whose coefficients are the members themselves."""
        return cls(basis, np.eye(basis.count))

    def derivatives(self, direction: Sequence[Floats]) -> tuple[UnknownPolynomial, ...]:
        """Return sum_c v^k_c dX/dh^k_c for each simplex k: dX/dt is the sum, for dh/dt = v.

        Each is of one degree less in its own simplex; those that are zero are left out.

        ``direction`` : v^k, (corners of simplex k,), one a simplex.  Sums to zero in each, or it
        leaves the simplexes.
        """
        slopes = []
        first = 0
        for k, (degree, v) in enumerate(zip(self.basis.degrees, direction, strict=True)):
            corner = np.arange(len(v))
            if degree and np.any(v):
                low = self.basis.lowered(
                    tuple(int(k == simplex) for simplex in range(len(direction)))
                )
                up = np.repeat(low.exponents[:, None, :], len(v), axis=1)
                up[:, corner, first + corner] += 1
                position = self.basis.rank(up.reshape(-1, up.shape[2])).reshape(up.shape[:2])
                slope = degree * (v[None, :, None] * self.weights[position]).sum(axis=1)
                slopes.append(UnknownPolynomial(low, slope))
            first += len(v)
        return tuple(slopes)


class Contributions(NamedTuple):
    """What the members of an unknown add to the coefficients: items, members, and the factors."""

    items: Indices
    members: Indices
    values: Array


def contributions(
    unknown: UnknownPolynomial, factor_given: Known, degrees: Degrees
) -> Contributions:
    """Return the coefficients of X(h) K(h), or K(h) X(h), of the given degrees.

    Coefficient ``items[t]`` is the sum over t of X_members[t] values[t] (or the other way round);
    no pair of item and member occurs twice.
    """
    full_basis = Basis(unknown.basis.sizes, degrees)
    factor = factor_given.to(full_basis.lowered(unknown.basis.degrees).degrees)
    table = products(unknown.basis, factor.basis)
    t, member = np.nonzero(unknown.weights[table.first])
    scale = unknown.weights[table.first[t], member]
    # A fraction times a float is a float, so each float becomes the fraction it is.
    scale = table.weight(exact=factor.exact)[t] * (_exact(scale) if factor.exact else scale)
    weighted = scale[:, None, None] * factor.values[table.second[t]]
    pair = table.item[t] * unknown.weights.shape[1] + member
    pairs, pair_index = np.unique(pair, return_inverse=True)
    zero = Fraction(0) if weighted.dtype == object else 0.0
    values = np.full((len(pairs), *weighted.shape[1:]), zero, dtype=weighted.dtype)
    np.add.at(values, pair_index, weighted)
    items, members = np.divmod(pairs, unknown.weights.shape[1])
    return Contributions(items, members, values)


def substituted(degree: int, points: Floats) -> Floats:
    """Return T, (new count, old count): X(H l) has the coefficients sum_a T[b, a] X_a.

    Of one simplex: h = H l, where l is on a simplex with a corner for each column of H.

    ``degree`` : g of X.
    ``points`` : H, (corners, M), each column a point of the simplex.

    T[b, .] are the coefficients of t^a in the product of the linear forms sum_c H_cj t_c, over the
    g corners j of b: the polar form of X at these corners.
    """
    size, many = points.shape
    chosen = np.array(list(combinations_with_replacement(range(many), degree)), dtype=np.intp)
    T = np.ones((len(chosen), 1))
    linear_basis = Basis((size,), (1,))
    for s in range(degree):
        table = products(Basis((size,), (s,)), linear_basis)
        wider = np.zeros((len(chosen), Basis((size,), (s + 1,)).count))
        contributions_of = T[:, table.first] * points[table.second][:, chosen[:, s]].T
        np.add.at(wider.T, table.item, contributions_of.T)
        T = wider
    return T


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class PolynomialLyapunov(ShortRepr):
    """P(h) = sum_a B_a(w(h)) P_a for V = x' P(h) x.

    Attributes
    ----------
    basis : the Bernstein polynomials B_a, on one simplex for each premise, or on that of the
        memberships; see ``takagi.lmi.polynomials``.
    members : (count, n, n), the coefficients P_a; where the degree is 1, P at the rules.
    corners : (r, K), the corner of each simplex that rule i takes.
    """

    basis: Basis
    members: Floats
    corners: Indices

    @property
    def vertices(self) -> Floats:
        """Return P at the rules, (r, n, n)."""
        return np.asarray(self.members[self.basis.corners(self.corners)])

    def at(self, h: ArrayLike) -> Floats:
        """Return P(h), (..., n, n), for memberships h of the rules, (..., r).

        Raises
        ------
        ModelError : another number of memberships.
        """
        weights = np.asarray(h, dtype=np.float64)
        if weights.shape[-1:] != (len(self.corners),):
            raise ModelError(
                f"h has shape {weights.shape}; (..., {len(self.corners)}) is needed, one "
                "membership for each rule"
            )
        w = marginals(weights, self.basis.sizes, self.corners)
        return np.asarray(np.tensordot(self.basis.values(w), self.members, axes=1))
