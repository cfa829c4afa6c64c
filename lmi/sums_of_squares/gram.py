"""Gram matrices of polynomials: p(x) = m(x)' G m(x), for a vector m of monomials."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np

from takagi.lmi.condition.term import Array, Constant, Equality, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.sums_of_squares.monomials import Exponent


def vanishing(basis: Sequence[Exponent], sizes: Array) -> Array:
    """Return a basis (K, N, N) of the symmetric L with m(x)' L m(x) = 0 for all x.

    If a product of monomials has several factorisations, L is the difference of two of them.

    Parameters
    ----------
    sizes : (N,) w; the monomials are those of w m(x).

    Source: Chesi, Garulli, Tesi, Vicino (2009), Homogeneous Polynomial Forms for Robustness
    Analysis of Uncertain Systems, section 1.2 (square matricial representation).
    """
    ways: dict[Exponent, list[tuple[int, int]]] = {}
    for i, a in enumerate(basis):
        for j in range(i, len(basis)):
            product = tuple(p + q for p, q in zip(a, basis[j], strict=True))
            ways.setdefault(product, []).append((i, j))
    found = []
    for first, *others in ways.values():
        for other in others:
            L = np.zeros((len(basis), len(basis)))
            for (i, j), sign in ((first, 1.0), (other, -1.0)):
                # In both cases the entry stands for twice the product.
                L[i, j] += sign / (sizes[i] * sizes[j])
                L[j, i] += sign / (sizes[i] * sizes[j])
            found.append(L)
    return np.array(found).reshape(len(found), len(basis), len(basis))


Coefficients = Mapping[Exponent, Fraction]


def identity(
    name: str,
    parts: Sequence[tuple[Unknown, Sequence[Exponent], Coefficients]],
    known: Coefficients,
) -> Equality:
    """Return sum_k p_k(x) m_k(x)' X_k m_k(x) = q(x) for all x: one equation for each monomial.

    Parameters
    ----------
    parts : (X_k, monomials m_k, p_k), p_k by its coefficients.
    known : q.
    """
    place: dict[Exponent, int] = {}
    rows: list[tuple[Unknown, list[tuple[int, int, int, Fraction]]]] = []
    for unknown, basis, factor in parts:
        entries = []
        for i, a in enumerate(basis):
            for j, b in enumerate(basis):
                for c, value in factor.items():
                    product = tuple(p + q + r for p, q, r in zip(a, b, c, strict=True))
                    entries.append((place.setdefault(product, len(place)), i, j, value))
        rows.append((unknown, entries))
    for product in known:
        place.setdefault(product, len(place))
    count = len(place)
    terms = []
    for unknown, entries in rows:
        left = np.full((len(entries), 1, unknown.rows), Fraction(0), dtype=object)
        right = np.zeros((len(entries), unknown.cols, 1))
        for t, (_, i, j, value) in enumerate(entries):
            left[t, 0, i], right[t, j, 0] = value, 1.0
        terms.append(
            Term(
                unknown=unknown,
                left=left,
                right=right,
                at=(0, 1),
                items=np.array([item for item, *_ in entries], dtype=np.intp),
                latex=(r"\textstyle\sum_{ij} p_{kij}\, e_i^\top", "e_j"),
            )
        )
    constant = np.full((count, 1, 1), Fraction(0), dtype=object)
    for product, number in known.items():
        constant[place[product], 0, 0] = -number
    return Equality(
        name=name,
        shape=(1, 1),
        terms=tuple(terms),
        constants=(Constant(value=constant, at=(0, 1), latex="-q_k"),) if known else (),
        count=count,
        labels=tuple(f"{name}, monomial {a}" for a in place),
        index=r"x^k \text{ a monomial}",
    )
