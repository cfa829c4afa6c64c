"""The atoms of a ring: variables, values of functions, and roots.

Two values of one function are the same atom if algebra shows that their arguments are equal.  A
root r means a^(1/q) >= 0 where a >= 0.  A number c > 0 is separated from it,

    (c a)^(p/q) = c^(p/q) a^(p/q),      c^(1/q) = product of the roots of the factors of c,

so that sqrt(2) sqrt(g h) and sqrt(2 g h) become equal.  The only other property of roots that is
used is r^q = a.
"""

from __future__ import annotations

from collections import Counter
from fractions import Fraction
from math import isqrt

from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.plant.polynomial import Polynomial, Quotient, Ring

MOST_FACTOR = 10_000  # largest divisor that is tried for a number under a root
MOST_BITS = 256  # of such a number
WORK_OF_FACTORS = 20  # the work of one factorisation, counted as so many products of terms
Rule = tuple[int, Polynomial]


class Atoms:
    """A ring and the meaning of its atoms.

    Raises
    ------
    Refused : zero to a negative power; and as ``Ring``.
    """

    def __init__(self, work: int = 0) -> None:
        self.ring = Ring(work)
        self.keys: dict[object, int] = {}
        self._calls: dict[object, list[tuple[tuple[Quotient, ...], int]]] = {}
        self._factors: dict[Fraction, list[tuple[int, int]]] = {}

    def named(self, key: object, rule: Rule | None = None) -> int:
        """Return the atom of this key; a new one is created with its rule."""
        if key not in self.keys:
            number = self.keys[key] = len(self.keys)
            if rule is not None:
                self.ring.rules[number] = rule
        return self.keys[key]

    def opaque(
        self, function: object, arguments: tuple[Quotient, ...], rule: Rule | None = None
    ) -> int:
        """Return the atom of a function of these arguments; equal arguments have the same atom."""
        existing = self.known(function, arguments)
        if existing is not None:
            return existing
        calls = self._calls.setdefault(function, [])
        number = self.named((function, len(calls)), rule)
        calls.append((arguments, number))
        return number

    def known(self, function: object, arguments: tuple[Quotient, ...]) -> int | None:
        """Return the atom of a function of these arguments; None if there is none so far."""
        for call_arguments, number in self._calls.get(function, []):
            if all(self.ring.equal(a, b) for a, b in zip(arguments, call_arguments, strict=True)):
                return number
        return None

    def power(self, base: Quotient, exponent: Fraction) -> Quotient:
        """Return base^(p/q); for q > 1 the base must be >= 0, which the caller proves."""
        ring, q = self.ring, exponent.denominator
        if q == 1:
            return ring.power(base, int(exponent))
        if not base.top:
            if exponent > 0:
                return base
            raise Refused("zero to a negative power")
        if not base.bottom and set(base.top) == {()}:
            root = _exact_root(base.top[()], q)
            if root is not None:
                return ring.power(ring.constant(root), exponent.numerator)
        number = abs(base.top[max(base.top)])
        base = Quotient(ring.scaled(base.top, 1 / number), base.bottom)
        number_power = self._number_power(number, exponent)
        if base == ring.constant(1):
            return number_power
        rule = None if base.bottom else (q, base.top)
        atom = ring.atom(self.opaque(("root", q), (base,), rule))
        # r^q is the base even if the ring has no rule for it.
        quotient, remainder = divmod(exponent.numerator, q)
        return ring.multiply(
            number_power, ring.multiply(ring.power(base, quotient), ring.power(atom, remainder))
        )

    def _number_power(self, value: Fraction, exponent: Fraction) -> Quotient:
        """Return value^(p/q) of a rational > 0 as a product of roots of whole numbers."""
        ring, q, product = self.ring, exponent.denominator, self.ring.constant(1)
        if value not in self._factors:
            self._factors[value] = _factors(value)
            ring.work += WORK_OF_FACTORS
        for factor, power in self._factors[value]:
            atom = ring.atom(self.named(("root of", q, factor), (q, {(): Fraction(factor)})))
            quotient, remainder = divmod(power * exponent.numerator, q)
            number = ring.constant(Fraction(factor) ** quotient)
            product = ring.multiply(product, ring.multiply(number, ring.power(atom, remainder)))
        return product


def _factors(value: Fraction) -> list[tuple[int, int]]:
    """Return whole numbers > 1 with powers, whose product is the value > 0.

    They are primes, except for a cofactor without small prime factors, and for a number that is too
    large to be factored.  The product is exact in every case.
    """
    powers = Counter[int]()
    for number, sign in ((value.numerator, 1), (value.denominator, -1)):
        cofactor, factor = number, 2
        while number.bit_length() <= MOST_BITS and factor <= MOST_FACTOR and factor**2 <= cofactor:
            while cofactor % factor == 0:
                powers[factor] += sign
                cofactor //= factor
            factor += 1
        if cofactor > 1:
            powers[cofactor] += sign
    return sorted((factor, power) for factor, power in powers.items() if power)


def _exact_root(value: Fraction, q: int) -> Fraction | None:
    """Return the square root of a rational where it is rational; None otherwise."""
    if q != 2 or value < 0:
        return None
    top, bottom = isqrt(value.numerator), isqrt(value.denominator)
    exact = top * top == value.numerator and bottom * bottom == value.denominator
    return Fraction(top, bottom) if exact else None
