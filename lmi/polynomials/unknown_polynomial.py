"""Polynomials whose coefficients are sought, and what they add to the items of an LMI."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations_with_replacement
from typing import NamedTuple

import numpy as np

from takagi.lmi.condition.term import Array
from takagi.lmi.polynomials.simplex_polynomials import Basis, Degrees, Known, products
from takagi.models.arrays import Floats, Indices

_fraction = np.frompyfunc(Fraction, 1, 1)


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

        Parameters
        ----------
        direction : v^k, (corners of simplex k,), one a simplex.  Sums to zero in each, or it
            leaves the simplexes.
        """
        found = []
        first = 0
        for k, (degree, v) in enumerate(zip(self.basis.degrees, direction, strict=True)):
            corner = np.arange(len(v))
            if degree and np.any(v):
                low = self.basis.lowered(tuple(int(k == other) for other in range(len(direction))))
                up = np.repeat(low.exponents[:, None, :], len(v), axis=1)
                up[:, corner, first + corner] += 1
                place = self.basis.rank(up.reshape(-1, up.shape[2])).reshape(up.shape[:2])
                slope = degree * (v[None, :, None] * self.weights[place]).sum(axis=1)
                found.append(UnknownPolynomial(low, slope))
            first += len(v)
        return tuple(found)


class Contributions(NamedTuple):
    """What the members of an unknown add to the coefficients: items, members, and the factors."""

    items: Indices
    members: Indices
    values: Array


def contributions(unknown: UnknownPolynomial, known: Known, degrees: Degrees) -> Contributions:
    """Return the coefficients of X(h) K(h), or K(h) X(h), of the given degrees.

    Coefficient ``items[t]`` is the sum over t of X_members[t] values[t] (or the other way round);
    no pair of item and member occurs twice.
    """
    whole = Basis(unknown.basis.sizes, degrees)
    factor = known.to(whole.lowered(unknown.basis.degrees).degrees)
    table = products(unknown.basis, factor.basis)
    t, member = np.nonzero(unknown.weights[table.first])
    scale = unknown.weights[table.first[t], member]
    # A fraction times a float is a float, so each float becomes the fraction it is.
    scale = table.weight(exact=factor.exact)[t] * (_fraction(scale) if factor.exact else scale)
    parts = scale[:, None, None] * factor.values[table.second[t]]
    pair = table.item[t] * unknown.weights.shape[1] + member
    pairs, place = np.unique(pair, return_inverse=True)
    zero = Fraction(0) if parts.dtype == object else 0.0
    values = np.full((len(pairs), *parts.shape[1:]), zero, dtype=parts.dtype)
    np.add.at(values, place, parts)
    items, members = np.divmod(pairs, unknown.weights.shape[1])
    return Contributions(items, members, values)


def substituted(degree: int, points: Floats) -> Floats:
    """Return T, (new count, old count): X(H l) has the coefficients sum_a T[b, a] X_a.

    Of one simplex: h = H l, where l is on a simplex with a corner for each column of H.

    Parameters
    ----------
    degree : g of X.
    points : H, (corners, M), each column a point of the simplex.

    T[b, .] are the coefficients of t^a in the product of the linear forms sum_c H_cj t_c, over the
    g corners j of b: the polar form of X at these corners.
    """
    size, many = points.shape
    chosen = np.array(list(combinations_with_replacement(range(many), degree)), dtype=np.intp)
    T = np.ones((len(chosen), 1))
    one = Basis((size,), (1,))
    for s in range(degree):
        table = products(Basis((size,), (s,)), one)
        wider = np.zeros((len(chosen), Basis((size,), (s + 1,)).count))
        parts = T[:, table.first] * points[table.second][:, chosen[:, s]].T
        np.add.at(wider.T, table.item, parts.T)
        T = wider
    return T
