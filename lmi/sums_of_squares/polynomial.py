"""Polynomials of the state with exact coefficients."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations_with_replacement
from math import comb
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import solve_continuous_lyapunov

from takagi.lmi.condition.evaluate import fractions
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
    def of(cls, expression: str, states: Sequence[str]) -> StatePolynomial:
        """Return the polynomial of a text, e.g. ``"-x1 + x1**2*x2"``.

        It is read by the grammar of plant files: nothing in it is executed, and a decimal is that
        decimal, exactly.

        Raises ModelError: no polynomial with rational coefficients in these states.
        """
        import sympy as sp

        symbols = {name: sp.Symbol(name) for name in states}
        try:
            read = parse_expression(expression, Scope(symbols))
            poly = sp.Poly(read, *symbols.values(), domain="QQ")
        except (sp.PolynomialError, sp.CoercionFailed, ModelError) as error:
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


def function_of_linearisation(f: Sequence[StatePolynomial]) -> StatePolynomial:
    """Return x'Px with A'P + P A = -I for the linear part x' = A x of x' = f(x), to six digits.

    Raises
    ------
    ModelError : A has an eigenvalue that is not stable.
    """
    n = len(f)
    A = np.array(
        [[float(p.terms.get(tuple(row), 0)) for row in np.eye(n, dtype=int).tolist()] for p in f]
    )
    if np.linalg.eigvals(A).real.max() >= 0:
        raise ModelError(
            "the linearisation at 0 is not stable, so it has no quadratic function; give V"
        )
    P = solve_continuous_lyapunov(A.T, -np.eye(n))
    short = [[f"{value:.6g}" for value in row] for row in (P + P.T) / 2]
    return StatePolynomial.quadratic(np.array(short))
