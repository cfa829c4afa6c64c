r"""Decides whether two trees are the same function: each becomes a quotient of FLINT's polynomials.

The variables of the polynomials are called atoms: variables of the plant, pi, and values of
functions.  The relations used between atoms are:

    sin, cos of sum_k n_k a_k     De Moivre for whole multiples of one unit a_k, the addition
                                  theorem for sums; s^2 + c^2 = 1; right angles by their values
    cos, sin of n atan(q)         De Moivre with 1/r and q/r, r >= 0 the root of 1 + q^2: the vector
                                  (1, q) has the length r and the angle atan(q)
    asin, atan, atanh, asinh, erf f(-a) = -f(a)
    exp of sum_k n_k a_k          powers of exp(a_k); sinh, cosh, tanh are quotients of them
    a^(p/q)                       powers of a root r with r^q = a
    |a|                           |a|^2 = a^2

A first pass over all trees finds the units a_k: for each monomial, the greatest common divisor of
the coefficients that it has in any argument.  Polynomials are reduced by dividing by the relations
in turn.  Each new atom comes first in the lexicographic order, so that a remainder has lower powers
of it and is otherwise in older atoms.
"""

from __future__ import annotations

from collections.abc import Iterable
from math import comb, gcd, lcm
from typing import Any, NamedTuple

from flint import Ordering, fmpq, fmpq_mpoly, fmpq_mpoly_ctx

from takagi.certificates.cross_check.kernel.reading import NotReplayed
from takagi.certificates.cross_check.plant.expression import Tree, names_in
from takagi.certificates.cross_check.plant.interval import Box, Interval, Undefined, range_of

# Limits of time and memory: beyond one of them the claim is not replayed, never refuted.
ATOMS, MOST_MULTIPLE, MOST_TERMS, MOST_PRODUCTS, MOST_BITS = 64, 32, 4_000, 200_000, 20_000
MOST_OF_EXP = 200  # a power of one exponential, which is a single term
ODD = ("asin", "atan", "atanh", "asinh", "erf")


def product_of(a: fmpq_mpoly, b: fmpq_mpoly) -> fmpq_mpoly:
    """Return a b.

    Raises
    ------
    NotReplayed : the product has more terms than ``MOST_PRODUCTS``, and would take too long.
    """
    if len(a) * len(b) > MOST_PRODUCTS:
        raise NotReplayed("an identity of too many terms")
    return a * b


def power_of(a: fmpq_mpoly, p: int) -> fmpq_mpoly:
    """Return a^p for p >= 0; see ``product_of``."""
    longest = max(
        (max(c.p.bit_length(), c.q.bit_length()) for c in map(fmpq, a.coeffs())), default=0
    )
    if comb(p + len(a), p) > MOST_PRODUCTS or p * longest > MOST_BITS:
        raise NotReplayed("a power of too many terms or digits")
    return a**p


class Quotient(NamedTuple):
    top: fmpq_mpoly
    bottom: fmpq_mpoly


class Algebra:
    """Quotients of trees; ``trees`` must contain every function that is asked about later."""

    def __init__(self, trees: Iterable[Tree]) -> None:
        # Two passes: the first collects the coefficients of all angles and exponents, since their
        # units must be known before sin or exp of one of them is expanded.
        self.units: dict[Any, fmpq] = {}
        self.context = fmpq_mpoly_ctx.get([f"t{k}" for k in range(ATOMS)], Ordering.lex)
        self.collected: dict[Any, list[fmpq]] | None = {}
        self._empty()
        for tree in trees:
            self.of(tree)
        collected, self.collected = self.collected or {}, None
        for key, values in collected.items():
            below = lcm(*(int(v.q) for v in values))
            self.units[key] = fmpq(gcd(*(int((v * below).p) for v in values)), below)
        self._empty()

    def _empty(self) -> None:
        self.places: dict[Any, int] = {}
        self.relations: list[fmpq_mpoly] = []
        self.done: dict[Tree, Quotient] = {}
        self.tangents: dict[Any, Quotient] = {}  # atom of atan(q) -> q

    def vanishes(self, tree: Tree) -> bool:
        """Return whether the algebra shows that the tree is 0 wherever it is defined."""
        return bool(self.reduced(self.of(tree).top).is_zero())

    def reduced(self, polynomial: fmpq_mpoly) -> fmpq_mpoly:
        """Return the remainder of the division by all relations, the newest first."""
        for relation in reversed(self.relations):
            _, polynomial = divmod(polynomial, relation)
        if len(polynomial) > MOST_TERMS:
            raise NotReplayed("an identity of too many terms")
        return polynomial

    def of(self, tree: Tree) -> Quotient:
        """Return a tree as a quotient of polynomials."""
        if tree not in self.done:
            self.done[tree] = self._lowest(self._of(tree))
        return self.done[tree]

    def _lowest(self, q: Quotient) -> Quotient:
        top, bottom = self.reduced(q.top), self.reduced(q.bottom)
        if bottom.is_zero():
            raise NotReplayed("a denominator that is zero")
        common = top.gcd(bottom)
        return Quotient(top, bottom) if common.is_one() else Quotient(top / common, bottom / common)

    def constant(self, value: fmpq | int) -> fmpq_mpoly:
        return self.context.constant(fmpq(value))

    def atom(self, key: Any) -> fmpq_mpoly:
        """Return the generator of an atom; a new one comes before all older ones."""
        if key not in self.places:
            if len(self.places) == ATOMS:
                raise NotReplayed("an identity of too many functions")
            self.places[key] = ATOMS - 1 - len(self.places)
        return self.context.gen(self.places[key])

    def _of(self, tree: Tree) -> Quotient:
        one = self.constant(1)
        kind = tree[0]
        if kind == "number":
            return Quotient(self.constant(tree[1]), one)
        if kind == "name":
            return Quotient(self.atom(("name", tree[1])), one)
        if kind in ("+", "*", "/"):
            a, b = self.of(tree[1]), self.of(tree[2])
            if kind == "+":
                total = product_of(a.top, b.bottom) + product_of(b.top, a.bottom)
                return Quotient(total, product_of(a.bottom, b.bottom))
            if kind == "*":
                return Quotient(product_of(a.top, b.top), product_of(a.bottom, b.bottom))
            return Quotient(product_of(a.top, b.bottom), product_of(a.bottom, b.top))
        if kind == "^":
            return self._power(self.of(tree[1]), tree[2])
        return self._call(tree[1], [self.of(part) for part in tree[2]])

    def _power(self, base: Quotient, power: fmpq) -> Quotient:
        p, q = int(power.p), int(power.q)
        if q > 1:
            atom = self._opaque(f"root {q}", [base], lambda r: r**q * base.bottom - base.top)
            base = Quotient(atom, self.constant(1))
        if p < 0:
            base, p = Quotient(base.bottom, base.top), -p
        return Quotient(power_of(base.top, p), power_of(base.bottom, p))

    def _opaque(self, name: str, arguments: list[Quotient], relation: Any = None) -> fmpq_mpoly:
        """Return the atom of a function of these arguments; equal arguments have the same atom.

        ``relation`` gives the polynomial of the atom that is 0, such as r^q - a for a root.
        """
        key = self._key(name, arguments)
        new = key not in self.places
        atom = self.atom(key)
        if new and relation is not None and all(a.bottom.is_constant() for a in arguments):
            self.relations.append(relation(atom))
        return atom

    @staticmethod
    def _key(name: str, arguments: list[Quotient]) -> Any:
        return name, tuple((str(a.top), str(a.bottom)) for a in map(_monic, arguments))

    def _call(self, name: str, arguments: list[Quotient]) -> Quotient:
        one = self.constant(1)
        a = arguments[0]
        if name in ("sin", "cos"):
            return self._turned(a)[name == "sin"]
        if name == "tan":
            cosine, sine = self._turned(a)
            above = product_of(sine.top, cosine.bottom)
            return Quotient(above, product_of(sine.bottom, cosine.top))
        if name in ODD and _is_negative(a):
            opposite = self._call(name, [Quotient(-a.top, a.bottom)])
            return Quotient(-opposite.top, opposite.bottom)
        if name in ("exp", "sinh", "cosh", "tanh"):
            up = self._exp(a)
            if name == "exp":
                return up
            square, both = up.top**2, up.bottom**2
            if name == "tanh":
                return Quotient(square - both, square + both)
            half = 2 * up.top * up.bottom
            return Quotient(square - both if name == "sinh" else square + both, half)
        if name == "sqrt":
            return self._power(a, fmpq(1, 2))
        if name == "abs":
            atom = self._opaque("abs", [a], lambda r: r**2 * a.bottom**2 - a.top**2)
            return Quotient(atom, one)
        atom = self._opaque(name, arguments)
        if name == "atan":
            self.tangents[self._key(name, arguments)] = a
        return Quotient(atom, one)

    def _parts(self, kind: str, a: Quotient) -> list[tuple[Any, int, fmpq]]:
        """Return (key, whole multiple of the key's unit, coefficient) of each term."""
        keys = {place: key for key, place in self.places.items()}
        most = MOST_OF_EXP if kind == "exponent" else MOST_MULTIPLE
        found: list[tuple[Any, int, fmpq]] = []
        for powers, factor in a.top.terms():
            used = [(keys[k], p) for k, p in enumerate(powers) if p]
            if not a.bottom.is_constant() or any(k[0] != "name" for k, _ in used):
                # Not a polynomial in variables: the whole argument is one angle.
                sign = -1 if _is_negative(a) else 1
                whole = _monic(Quotient(sign * a.top, a.bottom))
                return [((kind, (str(whole.top), str(whole.bottom))), sign, fmpq(sign))]
            # Of names alone: keys of other atoms have no order.
            key, c = (kind, tuple(sorted(used))), fmpq(factor) / a.bottom.leading_coefficient()
            if self.collected is not None:
                self.collected.setdefault(key, []).append(c)
                found.append(((key, (int(c.p), int(c.q))), 1, c))
                continue
            unit = self.units.get(key)
            n = fmpq(0) if unit is None else c / unit
            if unit is None or n.q != 1 or abs(n) > most:
                raise NotReplayed("an angle with a multiple that was not met before")
            found.append((key, int(n.p), c))
        return found

    def _turned(self, a: Quotient) -> tuple[Quotient, Quotient]:
        """Return (cos a, sin a); a whole multiple of an atan in a turns the vector of the rest."""
        turns: list[tuple[Quotient, int]] = []
        rest = a
        if a.bottom.is_constant():
            keys = {place: key for key, place in self.places.items()}
            lead = a.bottom.leading_coefficient()
            for powers, factor in a.top.terms():
                used = [(k, p) for k, p in enumerate(powers) if p]
                n = fmpq(factor) / lead
                tangent = self.tangents.get(keys[used[0][0]]) if len(used) == 1 else None
                if tangent is None or used[0][1] != 1 or n.q != 1 or abs(n) > MOST_MULTIPLE:
                    continue
                turns.append((tangent, int(n.p)))
                rest = Quotient(rest.top - factor * self.context.gen(used[0][0]), a.bottom)
        one = self.constant(1)
        found = tuple(Quotient(part, one) for part in self._circle(rest))
        for q, times in turns:
            found = self._turn(found, q if times > 0 else Quotient(-q.top, q.bottom), abs(times))
        return found[0], found[1]

    def _turn(
        self, vector: tuple[Quotient, ...], q: Quotient, times: int
    ) -> tuple[Quotient, Quotient]:
        """Return a vector after so many turns by atan(q): (c - q s, s + q c)/r each time."""
        square = product_of(q.bottom, q.bottom)
        length = Quotient(square + product_of(q.top, q.top), square)
        root = self._power(self._lowest(length), fmpq(1, 2)).top
        cosine, sine = vector
        for _ in range(times):
            # Over the common denominator of c, s and q; both entries are divided by r.
            below = product_of(product_of(cosine.bottom, sine.bottom), product_of(q.bottom, root))
            c = product_of(product_of(cosine.top, sine.bottom), q.bottom)
            s = product_of(product_of(sine.top, cosine.bottom), q.bottom)
            qc = product_of(product_of(cosine.top, sine.bottom), q.top)
            qs = product_of(product_of(sine.top, cosine.bottom), q.top)
            cosine = self._lowest(Quotient(c - qs, below))
            sine = self._lowest(Quotient(s + qc, below))
        return cosine, sine

    def _circle(self, a: Quotient) -> tuple[fmpq_mpoly, fmpq_mpoly]:
        """Return (cos a, sin a)."""
        cosine, sine = self.constant(1), self.constant(0)
        for key, n, c in self._parts("angle", a):
            # A whole multiple of pi/2 has known values of cos and sin; it needs no atom.
            if key[1:] == (((("name", "pi"), 1),),) and (2 * c).q == 1:
                turn = int((2 * c).p) % 4
                c1, s1 = self.constant((1, 0, -1, 0)[turn]), self.constant((0, 1, 0, -1)[turn])
                n = 1
            else:
                new = ("cos", key) not in self.places
                c1 = self.atom(("cos", key))
                s1 = self.atom(("sin", key))
                if new:
                    self.relations.append(s1**2 + c1**2 - 1)
                s1 = -s1 if n < 0 else s1
            for _ in range(abs(n)):
                cosine, sine = (
                    self.reduced(cosine * c1 - sine * s1),
                    self.reduced(sine * c1 + cosine * s1),
                )
        return cosine, sine

    def _exp(self, a: Quotient) -> Quotient:
        found = Quotient(self.constant(1), self.constant(1))
        for key, n, _ in self._parts("exponent", a):
            atom = self.atom(("exp", key)) ** abs(n)
            if n > 0:
                found = Quotient(found.top * atom, found.bottom)
            else:
                found = Quotient(found.top, found.bottom * atom)
        return found


def _is_negative(a: Quotient) -> bool:
    """Return whether the leading coefficient is below 0, which -a then has above 0."""
    return bool(
        not a.top.is_zero() and a.top.leading_coefficient() / a.bottom.leading_coefficient() < 0
    )


def _monic(a: Quotient) -> Quotient:
    """Return the quotient with 1 as the denominator's leading coefficient, to compare texts."""
    lead = a.bottom.leading_coefficient()
    return Quotient(a.top * (1 / lead), a.bottom * (1 / lead))


# Places of the points at which a supposed identity is tried out, as shares of each side of the box:
# three inside, where it is unlikely that terms cancel by chance, and two corners.
SHARES = (fmpq(2, 7), fmpq(5, 11), fmpq(11, 13), fmpq(1), fmpq(0))


def identical(algebra: Algebra, tree: Tree, box: Box, label: str) -> bool:
    """Return True if algebra shows that a tree is 0, False if it is not 0 at a point of the box.

    Raises
    ------
    NotReplayed : neither is found.
    """
    if algebra.vanishes(tree):
        return True
    if any(_is_not_zero(tree, box, share) for share in SHARES):
        return False
    raise NotReplayed(f"{label}: not shown to be an identity")


def _is_not_zero(tree: Tree, box: Box, share: fmpq) -> bool:
    """Return whether a tree differs from 0 at one point of the box.

    The point lies at another share of each side (the fractional part of a multiple of ``share``):
    with equal shares a difference of two variables could vanish.
    """
    place: dict[str, Interval] = {}
    for k, name in enumerate(sorted(set(names_in(tree)) & set(box))):
        low, high = box[name] or (fmpq(-1), fmpq(1))
        turned = share * (k + 1)
        part = share if share.q == 1 else turned - turned.p // turned.q
        value = low + part * (high - low)
        place[name] = (value, value)
    try:
        found = range_of(tree, place, lambda *_: False)
    except (Undefined, NotReplayed):
        return False
    return not_zero(found)


def not_zero(a: Interval) -> bool:
    return a is not None and not a[0] <= 0 <= a[1]
