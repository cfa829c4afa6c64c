"""Monomials of the state, and how they move along x' = A x."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from itertools import combinations_with_replacement
from math import comb, factorial, prod

import numpy as np

from takagi.lmi.condition.exact import fractions
from takagi.lmi.condition.term import Array
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

Exponent = tuple[int, ...]
# Most monomials of a Gram matrix: a matrix of this size is solved in about a minute.
MOST = 120


def monomials(n: int, degrees: Sequence[int]) -> tuple[Exponent, ...]:
    """Return the exponents of all monomials in n variables of these degrees, in a fixed order.

    Raises
    ------
    ModelError : more monomials than the limit for a Gram matrix.
    """
    count = sum(comb(n + d - 1, d) for d in degrees)
    if count > MOST:
        raise ModelError(
            f"{n} states and degree {max(degrees)}: {count} monomials in a Gram matrix, more than "
            f"{MOST}; take a lower degree, or fewer states"
        )
    found = []
    for degree in degrees:
        for chosen in combinations_with_replacement(range(n), degree):
            found.append(tuple(chosen.count(k) for k in range(n)))
    return tuple(found)


def sizes_of(basis: Sequence[Exponent]) -> Floats:
    """Return powers of two near the root of each monomial's multinomial coefficient.

    With sizes w, |w m(x)|^2 is about (x' x)^d, so that the Gram matrix of (x' x)^d is about I.
    """
    roots = [(factorial(sum(a)) / prod(factorial(power) for power in a)) ** 0.5 for a in basis]
    return np.asarray(np.exp2(np.round(np.log2(roots))))


def extended(A: Array, basis: Sequence[Exponent]) -> Array:
    """Return Abar of m' = Abar m along x' = A x, for the monomials m of one degree; Fractions.

    d/dt x^a = sum_kj a_k A_kj x^(a - e_k + e_j), without rounding: a float is the dyadic number it
    stores.

    Parameters
    ----------
    A : (n, n).
    """
    exact = fractions(A)
    n, place = len(exact), {a: i for i, a in enumerate(basis)}
    found = np.full((len(basis), len(basis)), Fraction(0), dtype=object)
    for a in basis:
        for k in range(n):
            if not a[k]:
                continue
            for j in range(n):
                if exact[k, j]:
                    b = list(a)
                    b[k] -= 1
                    b[j] += 1
                    found[place[a], place[tuple(b)]] += a[k] * exact[k, j]
    return found
