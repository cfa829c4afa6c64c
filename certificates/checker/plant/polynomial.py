"""Polynomials with rational coefficients in numbered atoms, and their quotients.

A monomial is a sorted tuple of (atom, power > 0); a polynomial maps monomials to coefficients that
are not 0.  An atom t may have a rule t^k = q with a polynomial q in atoms of smaller numbers, e.g.
s^2 = 1 - c^2, and products are reduced by the rules.  If the atoms have no further relations, a
polynomial is the zero function if and only if its dictionary is empty.  A quotient stores the
factors of its denominator separately, so that sums have their least common multiple as denominator.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from typing import NamedTuple, TypeAlias

from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.plant.graph import largest_bits

Monomial: TypeAlias = tuple[tuple[int, int], ...]
Polynomial: TypeAlias = dict[Monomial, Fraction]

MOST_TERMS = 20_000
MOST_PRODUCTS = 100_000  # of terms, in the life of a ring
MOST_BITS = 40_000  # of a coefficient
MOST_POWER = 1000


class Quotient(NamedTuple):
    """``top`` divided by a product of f^k; ``bottom`` has (number of the factor f, k)."""

    top: Polynomial
    bottom: tuple[tuple[int, int], ...] = ()


class Ring:
    """Rules of atoms, factors of denominators, and the work done so far."""

    def __init__(self, work: int = 0) -> None:
        self.rules: dict[int, tuple[int, Polynomial]] = {}
        self.factors: list[Polynomial] = []
        self._numbers: dict[frozenset[tuple[Monomial, Fraction]], int] = {}
        self.work = work

    # ------------------------------------------------------------------ polynomials

    def plus(self, a: Polynomial, b: Polynomial) -> Polynomial:
        terms = dict(a)
        for monomial, c in b.items():
            total = terms.get(monomial, Fraction(0)) + c
            if total:
                terms[monomial] = total
            else:
                del terms[monomial]
        return terms

    def scaled(self, a: Polynomial, factor: Fraction) -> Polynomial:
        return {monomial: c * factor for monomial, c in a.items()} if factor else {}

    def times(self, a: Polynomial, b: Polynomial) -> Polynomial:
        """Return the product, reduced by the rules."""
        terms = self._product(a, b)
        if len(terms) > MOST_TERMS or any(largest_bits(c) > MOST_BITS for c in terms.values()):
            raise Refused("an identity with too many or too large terms")
        return self.reduced(terms)

    def reduced(self, a: Polynomial) -> Polynomial:
        """Return the polynomial after applying the rules as long as one applies."""
        terms: Polynomial = {}
        unreduced = a
        while unreduced:
            next_round: Polynomial = {}
            for monomial, c in unreduced.items():
                position = next(
                    (
                        k
                        for k, (atom, power) in enumerate(monomial)
                        if atom in self.rules and power >= self.rules[atom][0]
                    ),
                    None,
                )
                if position is None:
                    terms[monomial] = terms.get(monomial, Fraction(0)) + c
                else:
                    next_round = self.plus(next_round, self._once(monomial, position, c))
            unreduced = next_round
        return {monomial: c for monomial, c in terms.items() if c}

    def _once(self, monomial: Monomial, k: int, c: Fraction) -> Polynomial:
        """Return c times the monomial with its k-th factor replaced by the rule."""
        atom, power = monomial[k]
        period, replacement = self.rules[atom]
        times, remainder = divmod(power, period)
        reduced = monomial[:k] + (((atom, remainder),) if remainder else ()) + monomial[k + 1 :]
        terms: Polynomial = {reduced: c}
        for _ in range(times):
            terms = self._product(terms, replacement)
        return terms

    def _product(self, a: Polynomial, b: Polynomial) -> Polynomial:
        """Return the product as it is multiplied out."""
        self.work += len(a) * len(b)
        if self.work > MOST_PRODUCTS:
            raise Refused("an identity that takes too long to multiply out")
        terms: Polynomial = {}
        for p, c in a.items():
            for q, d in b.items():
                monomial = _joined(p, q)
                terms[monomial] = terms.get(monomial, Fraction(0)) + c * d
        return {monomial: c for monomial, c in terms.items() if c}

    # ------------------------------------------------------------------ quotients

    def constant(self, value: Fraction | int) -> Quotient:
        return Quotient({(): Fraction(value)} if value else {})

    def atom(self, number: int) -> Quotient:
        return Quotient({((number, 1),): Fraction(1)})

    def add(self, a: Quotient, b: Quotient) -> Quotient:
        """Return a + b with the least common multiple of both denominators as denominator."""
        first, second = dict(a.bottom), dict(b.bottom)
        common = {f: max(first.get(f, 0), second.get(f, 0)) for f in first | second}
        tops = [
            self._raised(summand.top, {f: k - denominator.get(f, 0) for f, k in common.items()})
            for summand, denominator in ((a, first), (b, second))
        ]
        return self._cancelled(self.plus(*tops), common)

    def _raised(self, top: Polynomial, missing: Mapping[int, int]) -> Polynomial:
        for factor, power in missing.items():
            for _ in range(power):
                top = self.times(top, self.factors[factor])
        return top

    def multiply(self, a: Quotient, b: Quotient) -> Quotient:
        bottom = dict(a.bottom)
        for factor, power in b.bottom:
            bottom[factor] = bottom.get(factor, 0) + power
        return self._cancelled(self.times(a.top, b.top), bottom)

    def inverse(self, a: Quotient) -> Quotient:
        """Return 1 / a.

        Raises
        ------
        Refused : a is zero as a polynomial.
        """
        if not a.top:
            raise Refused("a division by what is zero everywhere")
        content = _content(a.top)
        cofactor = {_without(monomial, content): c for monomial, c in a.top.items()}
        leading = cofactor[max(cofactor)]
        bottom = {self._factor({((atom, 1),): Fraction(1)}): power for atom, power in content}
        if len(cofactor) > 1:
            bottom[self._factor(self.scaled(cofactor, 1 / leading))] = 1
        top = self._raised({(): 1 / leading}, dict(a.bottom))
        return self._cancelled(top, bottom)

    def power(self, a: Quotient, exponent: int) -> Quotient:
        """Return a^exponent for any whole exponent."""
        if abs(exponent) > MOST_POWER:
            raise Refused(f"a power above {MOST_POWER}")
        base = self.inverse(a) if exponent < 0 else a
        result = self.constant(1)
        for _ in range(abs(exponent)):
            result = self.multiply(result, base)
        return result

    def equal(self, a: Quotient, b: Quotient) -> bool:
        """Return whether the numerator of a - b is 0; False only means that it is not shown."""
        return not self.add(a, Quotient(self.scaled(b.top, Fraction(-1)), b.bottom)).top

    def _factor(self, a: Polynomial) -> int:
        key = frozenset(a.items())
        if key not in self._numbers:
            self._numbers[key] = len(self.factors)
            self.factors.append(a)
        return self._numbers[key]

    def _cancelled(self, top: Polynomial, bottom: Mapping[int, int]) -> Quotient:
        """Return the quotient after cancelling atoms common to all terms of the numerator."""
        if not top:
            return Quotient({})
        denominator = dict(bottom)
        content = dict(_content(top)) if denominator else {}
        for factor in list(denominator):
            monomials = list(self.factors[factor])
            if len(monomials) == 1 and len(monomials[0]) == 1:
                atom = monomials[0][0][0]
                common = min(content.get(atom, 0), denominator[factor])
                if common:
                    top = {_without(m, ((atom, common),)): c for m, c in top.items()}
                    denominator[factor] -= common
        return Quotient(top, tuple(sorted((f, k) for f, k in denominator.items() if k)))


def _joined(p: Monomial, q: Monomial) -> Monomial:
    if not p or not q:
        return p or q
    powers = dict(p)
    for atom, power in q:
        powers[atom] = powers.get(atom, 0) + power
        if powers[atom] > MOST_POWER:
            raise Refused(f"a power above {MOST_POWER}")
    return tuple(sorted(powers.items()))


def _content(a: Polynomial) -> Monomial:
    """Return the greatest monomial that divides every term."""
    monomials = iter(a)
    common = dict(next(monomials))
    for monomial in monomials:
        powers = dict(monomial)
        common = {x: min(k, powers[x]) for x, k in common.items() if x in powers}
    return tuple(sorted(common.items()))


def _without(monomial: Monomial, factor: Monomial) -> Monomial:
    powers = dict(monomial)
    for atom, power in factor:
        powers[atom] -= power
    return tuple((atom, power) for atom, power in sorted(powers.items()) if power)
