"""Polynomials of the state with rational coefficients."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.sums_of_squares.monomials import Exponent
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError


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

        A decimal in a text is the decimal, exactly.

        Raises
        ------
        ModelError : no polynomial with rational coefficients in these states.
        """
        import sympy as sp

        symbols = [sp.Symbol(name) for name in states]
        try:
            known = {name: symbol for name, symbol in zip(states, symbols, strict=True)}
            read = (
                sp.sympify(expression, locals=known, rational=True)
                if isinstance(expression, (str, int, float))
                else sp.nsimplify(sp.sympify(expression), rational=True)
            )
            renamed = read.subs({s: known[s.name] for s in read.free_symbols if s.name in known})
            poly = sp.Poly(renamed, *symbols, domain="QQ")
        except (sp.SympifyError, sp.PolynomialError, sp.CoercionFailed, TypeError) as error:
            raise ModelError(
                f"{expression!r} is no polynomial in {', '.join(states)} with rational coefficients"
            ) from error
        terms = {
            tuple(int(power) for power in a): Fraction(int(c.p), int(c.q)) for a, c in poly.terms()
        }
        return cls(len(states), {a: c for a, c in terms.items() if c})

    @classmethod
    def quadratic(cls, P: ArrayLike) -> StatePolynomial:
        """Return x' P x; a float is the dyadic number it stores."""
        from takagi.lmi.condition.exact import fractions

        exact = fractions(P)
        found: dict[Exponent, Fraction] = {}
        for (i, j), value in np.ndenumerate(exact):
            a = tuple(int(k == i) + int(k == j) for k in range(len(exact)))
            found[a] = found.get(a, Fraction(0)) + value
        return cls(len(exact), {a: c for a, c in found.items() if c})

    @property
    def degree(self) -> int:
        """Return the largest degree of a term; 0 for the zero polynomial."""
        return max((sum(a) for a in self.terms), default=0)

    @property
    def least_degree(self) -> int:
        """Return the smallest degree of a term."""
        return min((sum(a) for a in self.terms), default=0)

    def __add__(self, other: StatePolynomial) -> StatePolynomial:
        found = dict(self.terms)
        for a, c in other.terms.items():
            found[a] = found.get(a, Fraction(0)) + c
        return StatePolynomial(self.n, {a: c for a, c in found.items() if c})

    def __mul__(self, other: StatePolynomial) -> StatePolynomial:
        found: dict[Exponent, Fraction] = {}
        for a, c in self.terms.items():
            for b, d in other.terms.items():
                place = tuple(p + q for p, q in zip(a, b, strict=True))
                found[place] = found.get(place, Fraction(0)) + c * d
        return StatePolynomial(self.n, {a: c for a, c in found.items() if c})

    def times(self, number: Fraction | int) -> StatePolynomial:
        """Return a number times the polynomial."""
        return StatePolynomial(self.n, {a: c * number for a, c in self.terms.items() if number})

    def power(self, times: int) -> StatePolynomial:
        """Return the polynomial to a whole power."""
        found = StatePolynomial(self.n, {(0,) * self.n: Fraction(1)})
        for _ in range(times):
            found = found * self
        return found

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
