"""Polynomials of the state with rational coefficients."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, combinations_with_replacement
from math import comb
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.condition.evaluate import fractions
from takagi.lmi.condition.term import Constant, Equality, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.expressions.parser import Scope, parse_expression

Exponent = tuple[int, ...]
# Most monomials of a Gram matrix: a matrix of this size is solved in about a minute.
MOST_MONOMIALS = 120


def monomials(n: int, degrees: Sequence[int]) -> tuple[Exponent, ...]:
    """Return the exponents of all monomials in n variables of these degrees, in a fixed order.

    Raises
    ------
    ModelError : more monomials than the limit for a Gram matrix.
    """
    count = sum(comb(n + d - 1, d) for d in degrees)
    if count > MOST_MONOMIALS:
        raise ModelError(
            f"{n} states and degree {max(degrees)}: {count} monomials in a Gram matrix, more than "
            f"{MOST_MONOMIALS}; take a lower degree, or fewer states"
        )
    exponents = []
    for degree in degrees:
        for chosen in combinations_with_replacement(range(n), degree):
            exponents.append(tuple(chosen.count(k) for k in range(n)))
    return tuple(exponents)


@dataclass(frozen=True, slots=True)
class StatePolynomial:
    """sum_a c_a x^a in n variables.

    Attributes
    ----------
    n : number of variables.
    terms : exponents -> coefficient, a Fraction other than 0.
    """

    n: int
    terms: Mapping[Exponent, Fraction]

    @classmethod
    def of(cls, expression: object, states: Sequence[str]) -> StatePolynomial:
        """Return the polynomial of a text or of a sympy expression, e.g. ``"-x1 + x1**2*x2"``.

        A text is read by the grammar of plant files: nothing in it is executed, and a decimal is
        that decimal, exactly.

        Raises
        ------
        ModelError : no polynomial with rational coefficients in these states.
        """
        import sympy as sp

        symbols = {name: sp.Symbol(name) for name in states}
        try:
            if isinstance(expression, str):
                read = parse_expression(expression, Scope(symbols))
            else:
                read = sp.nsimplify(sp.sympify(expression, strict=True), rational=True)
            renamed = read.subs(
                {s: symbols[s.name] for s in read.free_symbols if s.name in symbols}
            )
            poly = sp.Poly(renamed, *symbols.values(), domain="QQ")
        except (sp.SympifyError, sp.PolynomialError, sp.CoercionFailed, TypeError) as error:
            raise ModelError(
                f"{expression!r} is no polynomial in {', '.join(states)} with rational coefficients"
            ) from error
        except ModelError as error:
            raise ModelError(
                f"{expression!r} is no polynomial in {', '.join(states)}: {error}"
            ) from error
        terms = {
            tuple(int(power) for power in a): Fraction(int(c.p), int(c.q)) for a, c in poly.terms()
        }
        return cls(len(states), {a: c for a, c in terms.items() if c})

    @classmethod
    def quadratic(cls, P: ArrayLike) -> StatePolynomial:
        """Return x' P x; a float is the dyadic number it stores."""

        exact = fractions(P)
        terms: dict[Exponent, Fraction] = {}
        for (i, j), value in np.ndenumerate(exact):
            a = tuple(int(k == i) + int(k == j) for k in range(len(exact)))
            terms[a] = terms.get(a, Fraction(0)) + value
        return cls(len(exact), {a: c for a, c in terms.items() if c})

    @property
    def degree(self) -> int:
        """Return the largest degree of a term; 0 for the zero polynomial."""
        return max((sum(a) for a in self.terms), default=0)

    @property
    def least_degree(self) -> int:
        """Return the smallest degree of a term."""
        return min((sum(a) for a in self.terms), default=0)

    def __add__(self, other: StatePolynomial) -> StatePolynomial:
        terms = dict(self.terms)
        for a, c in other.terms.items():
            terms[a] = terms.get(a, Fraction(0)) + c
        return StatePolynomial(self.n, {a: c for a, c in terms.items() if c})

    def __mul__(self, other: StatePolynomial) -> StatePolynomial:
        terms: dict[Exponent, Fraction] = {}
        for a, c in self.terms.items():
            for b, d in other.terms.items():
                exponent = tuple(p + q for p, q in zip(a, b, strict=True))
                terms[exponent] = terms.get(exponent, Fraction(0)) + c * d
        return StatePolynomial(self.n, {a: c for a, c in terms.items() if c})

    def times(self, number: Fraction | int) -> StatePolynomial:
        """Return a number times the polynomial."""
        return StatePolynomial(self.n, {a: c * number for a, c in self.terms.items() if number})

    def power(self, times: int) -> StatePolynomial:
        """Return the polynomial to a whole power."""
        product = StatePolynomial(self.n, {(0,) * self.n: Fraction(1)})
        for _ in range(times):
            product = product * self
        return product

    def composed(self, lines: Sequence[StatePolynomial]) -> StatePolynomial:
        """Return p(q_1(z), ..., q_n(z))."""
        total = StatePolynomial(self.n, {})
        for a, c in self.terms.items():
            summand = StatePolynomial(self.n, {(0,) * self.n: c})
            for line, power in zip(lines, a, strict=True):
                summand = summand * line.power(power)
            total = total + summand
        return total

    def along(self, field: Sequence[StatePolynomial]) -> StatePolynomial:
        """Return the derivative along x' = f(x): sum_k dp/dx_k f_k."""
        total = StatePolynomial(self.n, {})
        for k, motion in enumerate(field):
            slope = {
                (*a[:k], a[k] - 1, *a[k + 1 :]): a[k] * c for a, c in self.terms.items() if a[k]
            }
            total = total + StatePolynomial(self.n, slope) * motion
        return total

    def __call__(self, x: ArrayLike) -> Floats:
        """Return its values at x, (..., n), in floating point."""
        at = np.asarray(x, dtype=np.float64)
        total: Any = np.zeros(at.shape[:-1])
        for a, c in self.terms.items():
            total = total + float(c) * np.prod(at ** np.array(a), axis=-1)
        return np.asarray(total)


def without_idle(basis: Sequence[Exponent], support: Iterable[Exponent]) -> tuple[Exponent, ...]:
    """Return the monomials m_i that m' S m with S >= 0 can hold, if its terms are in the support.

    The square of a monomial has a positive coefficient.  If it is not in the support and is no
    product of two other monomials, the monomial's row of S is 0.  This is repeated; what stays lies
    in half the Newton polytope of the support.

    Source: Reznick (1978), Duke Mathematical Journal 45; Loefberg (2009), IEEE Transactions on
    Automatic Control 54, section IV (diagonal inconsistency).
    """
    there, monomials_left = set(support), list(basis)
    while True:
        products = {_product(a, b) for a, b in combinations(monomials_left, 2)} | there
        fewer = [a for a in monomials_left if _product(a, a) in products]
        if len(fewer) == len(monomials_left):
            return tuple(monomials_left)
        monomials_left = fewer


def _product(a: Exponent, b: Exponent) -> Exponent:
    return tuple(p + q for p, q in zip(a, b, strict=True))


def identity(
    name: str,
    summands: Sequence[tuple[Unknown, Sequence[StatePolynomial], StatePolynomial]],
    right_side: StatePolynomial,
) -> Equality:
    """Return sum_k p_k(x) m_k(x)' X_k m_k(x) = q(x) for all x: one equation for each monomial.

    Parameters
    ----------
    summands : (X_k, polynomials m_k, p_k).
    right_side : q.
    """
    row_of: dict[Exponent, int] = {}
    rows: list[tuple[Unknown, list[tuple[int, int, int, Fraction]]]] = []
    for unknown, basis, factor in summands:
        entries = []
        for i, a in enumerate(basis):
            for j, b in enumerate(basis):
                for product, value in (a * b * factor).terms.items():
                    entries.append((row_of.setdefault(product, len(row_of)), i, j, value))
        rows.append((unknown, entries))
    for product in right_side.terms:
        row_of.setdefault(product, len(row_of))
    count = len(row_of)
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
    for product, number in right_side.terms.items():
        constant[row_of[product], 0, 0] = -number
    return Equality(
        name=name,
        shape=(1, 1),
        terms=tuple(terms),
        constants=(Constant(value=constant, at=(0, 1), latex="-q_k"),) if right_side.terms else (),
        count=count,
        labels=tuple(f"{name}, monomial {a}" for a in row_of),
        index=r"x^k \text{ a monomial}",
    )
