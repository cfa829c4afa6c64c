"""Whether two nodes are the same function, shown by exact algebra.

A node becomes a quotient of polynomials over opaque atoms: variables, pi, and values of functions
whose arguments are told apart up to equality of quotients.  What is known of the atoms:

    sin(sum c_i m_i)          expanded by the addition theorem into sin and cos of each part c m,
                              multiples of one part by De Moivre;  s^2 = 1 - c^2;  tan = s / c
    exp(sum c_i m_i)          a product of whole powers of atoms exp(b m)
    sinh, cosh, tanh          quotients of exponentials
    a^(p/q)                   the p-th power of a root r, r^q = a >= 0; (c a)^(1/q) for a number
                              c > 0 is the product of the roots of the factors of c and of a
    |a|^2 = a^2               and f(0) of every function where it is a number

Two quotients with equal cross products are equal wherever their denominators are not 0.  Nothing
else is assumed of an atom, so that "not shown" does not mean "different".
"""

from __future__ import annotations

from fractions import Fraction
from math import comb, gcd, lcm

from takagi.certificates.checker.plant.graph import Graph, Node
from takagi.certificates.checker.plant.numbers_under_roots import exact_root, factors
from takagi.certificates.checker.plant.polynomial import Monomial, Polynomial, Quotient, Ring
from takagi.certificates.checker.refusal import Refused

__all__ = ["Algebra"]

MOST_MULTIPLE = 32  # sin(n a) in sin(a), cos(a)
MOST_RESTARTS = 100
MOST_PARTS = 4  # of a sum inside sin and cos
WORK_OF_FACTORS = 20  # of a number under a root, in products of terms
AT_ZERO = {
    "asin": 0,
    "atan": 0,
    "asinh": 0,
    "atanh": 0,
    "erf": 0,
    "abs": 0,
}


class _Finer(Exception):
    """A multiple that is not whole was met: the unit of a part has been made smaller."""


class Algebra:
    """Quotients of nodes, with the atoms met so far.

    Raises
    ------
    Refused : a division by zero, or terms too many or too large.
    """

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.units: dict[tuple[str, object], Fraction] = {}
        self._names: dict[object, int] = {}
        self._restarts = 0
        self._factors: dict[Fraction, list[tuple[int, int]]] = {}
        self.ring = Ring()
        self._restart()

    def _restart(self) -> None:
        self._restarts += 1
        if self._restarts > MOST_RESTARTS:
            raise Refused("angles with too many different multiples")
        self.ring = Ring(self.ring.work)
        self._atoms: dict[object, int] = {}
        self._calls: dict[object, list[tuple[tuple[Quotient, ...], int]]] = {}
        self._found: dict[int, Quotient] = {}

    # ------------------------------------------------------------------ questions

    def equal(self, a: int, b: int) -> bool:
        """Return whether the nodes are shown to be equal where their denominators are not 0."""
        while True:
            try:
                return self.ring.equal(self.quotient(a), self.quotient(b))
            except _Finer:
                self._restart()

    def vanishes(self, a: int) -> bool:
        """Return whether the node is shown to be 0."""
        return self.equal(a, self.graph.constant(0))

    def polynomial(self, root: int) -> dict[tuple[tuple[str, int], ...], Fraction]:
        """Return a node as a polynomial: powers of variables -> coefficient.

        Raises
        ------
        Refused : it is no polynomial in its variables with rational coefficients.
        """
        while True:
            try:
                found = self.quotient(root)
                break
            except _Finer:
                self._restart()
        names = {
            number: key[1]
            for key, number in self._atoms.items()
            if isinstance(key, tuple) and key[0] == "variable"
        }
        if found.bottom or any(a not in names for monomial in found.top for a, _ in monomial):
            raise Refused("no polynomial with rational coefficients")
        return {
            tuple((str(names[a]), k) for a, k in monomial): c for monomial, c in found.top.items()
        }

    def quotient(self, root: int) -> Quotient:
        """Return the node over the atoms of this algebra."""
        for number in self.graph.below([root]):
            if number not in self._found:
                self._found[number] = self._of(self.graph[number])
        return self._found[root]

    def _of(self, node: Node) -> Quotient:
        ring = self.ring
        parts = [self._found[part] for part in node.parts]
        if node.op == "const":
            return ring.constant(node.value)
        if node.op in ("pi", "variable"):
            return ring.atom(self._atom((node.op, node.name)))
        if node.op == "add":
            return ring.add(*parts)
        if node.op == "multiply":
            return ring.multiply(*parts)
        if node.op == "divide":
            return ring.multiply(parts[0], ring.inverse(parts[1]))
        if node.op == "power":
            return self._power(parts[0], node.value)
        if node.op == "call":
            return self._call(node.name, parts[0])
        return ring.atom(self._opaque((node.op, node.name, node.orders), tuple(parts)))

    # ------------------------------------------------------------------ atoms

    def _atom(self, key: object, rule: tuple[int, Polynomial] | None = None) -> int:
        if key not in self._atoms:
            number = self._atoms[key] = len(self._atoms)
            if rule is not None:
                self.ring.rules[number] = rule
        return self._atoms[key]

    def _opaque(
        self,
        function: object,
        arguments: tuple[Quotient, ...],
        rule: tuple[int, Polynomial] | None = None,
    ) -> int:
        """Return the atom of a function of these arguments, the same for equal ones."""
        known = self._calls.setdefault(function, [])
        for others, number in known:
            if all(self.ring.equal(a, b) for a, b in zip(arguments, others, strict=True)):
                return number
        number = self._atom((function, len(known)), rule)
        known.append((arguments, number))
        return number

    def _power(self, base: Quotient, exponent: Fraction) -> Quotient:
        if exponent.denominator == 1:
            return self.ring.power(base, int(exponent))
        if not base.top:
            if exponent > 0:
                return base
            raise Refused("zero to a negative power")
        q = exponent.denominator
        if not base.bottom and set(base.top) == {()}:
            root = exact_root(base.top[()], q)
            if root is not None:
                return self.ring.power(self.ring.constant(root), exponent.numerator)
        # A root's argument is >= 0 on the box, and so are both factors, its number and the rest.
        number = abs(base.top[max(base.top)])
        base = Quotient(self.ring.scaled(base.top, 1 / number), base.bottom)
        rule = None if base.bottom else (q, base.top)
        found = self._number_power(number, exponent)
        if base == self.ring.constant(1):
            return found
        atom = self._opaque(("root", q), (base,), rule)
        return self.ring.multiply(found, self._root_power(base, atom, exponent))

    def _root_power(self, base: Quotient, atom: int, exponent: Fraction) -> Quotient:
        """Return base^(p/q), where the atom is the q-th root of the base."""
        whole, rest = divmod(exponent.numerator, exponent.denominator)
        # r^q is the base even where no rule of the ring can say so.
        root = self.ring.power(self.ring.atom(atom), rest)
        return self.ring.multiply(self.ring.power(base, whole), root)

    def _number_power(self, value: Fraction, exponent: Fraction) -> Quotient:
        """Return value^(p/q) of a rational > 0 as a product of roots of whole numbers."""
        q, found = exponent.denominator, self.ring.constant(1)
        if value not in self._factors:
            self._factors[value] = factors(value)
            self.ring.work += WORK_OF_FACTORS
        for factor, power in self._factors[value]:
            atom = self._atom(("root of", q, factor), (q, {(): Fraction(factor)}))
            whole, rest = divmod(power * exponent.numerator, q)
            root = self.ring.power(self.ring.atom(atom), rest)
            number = self.ring.constant(Fraction(factor) ** whole)
            found = self.ring.multiply(found, self.ring.multiply(number, root))
        return found

    def _call(self, name: str, a: Quotient) -> Quotient:
        ring = self.ring
        if name in ("sin", "cos"):
            return self._circular(a)[name == "cos"]
        if name == "tan":
            sine, cosine = self._circular(a)
            return ring.multiply(sine, ring.inverse(cosine))
        if name == "exp":
            return self._exponential(a)
        if name in ("sinh", "cosh", "tanh"):
            rising = self._exponential(a)
            falling = ring.inverse(rising)
            even = ring.add(rising, falling)
            odd = ring.add(rising, ring.multiply(ring.constant(-1), falling))
            if name == "tanh":
                return ring.multiply(odd, ring.inverse(even))
            return ring.multiply(ring.constant(Fraction(1, 2)), odd if name == "sinh" else even)
        if not a.top and name in AT_ZERO:
            return ring.constant(AT_ZERO[name])
        if name in ("log", "acosh") and a == ring.constant(1):
            return ring.constant(0)
        if name == "abs":
            if not a.bottom and set(a.top) == {()}:
                return ring.constant(abs(a.top[()]))
            rule = None if a.bottom else (2, ring.times(a.top, a.top))
            return ring.atom(self._opaque("abs", (a,), rule))
        return ring.atom(self._opaque(name, (a,)))

    # ------------------------------------------------------------------ sums as arguments

    def _whole(self, kind: str, part: object, c: Fraction) -> int:
        """Return c over the unit of this part; the unit is made finer where that is not whole."""
        unit = self.units.setdefault((kind, part), abs(c))
        count = c / unit
        if count.denominator != 1:
            common = lcm(unit.denominator, c.denominator)
            self.units[kind, part] = Fraction(gcd(int(unit * common), int(abs(c) * common)), common)
            raise _Finer
        return int(count)

    def _parts(self, kind: str, a: Quotient) -> list[tuple[object, Fraction, int]]:
        """Return (key, coefficient, multiple of the unit) of each term of an argument.

        An argument that is no sum of few terms, or a large multiple, is one part by itself.
        """
        named = self._terms(a)
        if len(named) <= MOST_PARTS:
            found = [(key, c, self._whole(kind, key, c)) for key, c in named]
            if all(abs(n) <= MOST_MULTIPLE for _, _, n in found):
                return found
        whole = ("argument", self._opaque("argument", (a,)))
        return [(whole, Fraction(1), self._whole(kind, whole, Fraction(1)))]

    def _terms(self, a: Quotient) -> list[tuple[object, Fraction]]:
        """Return (key, coefficient) of the terms that an argument is the sum of.

        Of N/D a constant is taken out, c + (N - c D)/D, so that exp(a - b/T) and
        exp(a) exp(-b/T) have the same parts; any c makes that true, and this c cancels the leading
        term of D in N.
        """
        if not a.bottom:
            return [(self._named(m), c) for m, c in sorted(a.top.items())]
        found: list[tuple[object, Fraction]] = []
        top = a.top
        if len(a.bottom) == 1 and a.bottom[0][1] == 1:
            below = self.ring.factors[a.bottom[0][0]]
            leading = max(below)
            constant = top.get(leading, Fraction(0)) / below[leading]
            if constant:
                found.append((self._named(()), constant))
                top = self.ring.plus(top, self.ring.scaled(below, -constant))
        if top:
            size = top[max(top)]
            rest = Quotient(self.ring.scaled(top, 1 / size), a.bottom)
            found.append((("argument", self._opaque("argument", (rest,))), size))
        return found

    def _named(self, monomial: Monomial) -> object:
        """Return the monomial in names that a restart does not change."""
        keys = list(self._atoms)
        return tuple((self._name(keys[atom]), power) for atom, power in monomial)

    def _name(self, key: object) -> int:
        return self._names.setdefault(key, len(self._names))

    def _circular(self, a: Quotient) -> tuple[Quotient, Quotient]:
        """Return (sin a, cos a)."""
        ring = self.ring
        sine, cosine = ring.constant(0), ring.constant(1)
        for key, c, n in self._parts("sin", a):
            s, k = self._quadrant(key, c) or self._multiple(key, n)
            minus = ring.multiply(ring.constant(-1), ring.multiply(sine, s))
            sine, cosine = (
                ring.add(ring.multiply(sine, k), ring.multiply(cosine, s)),
                ring.add(ring.multiply(cosine, k), minus),
            )
        return sine, cosine

    def _quadrant(self, key: object, c: Fraction) -> tuple[Quotient, Quotient] | None:
        """Return sin and cos of a whole number of right angles; None for another angle."""
        if key != ((self._name(("pi", "")), 1),) or (2 * c).denominator != 1:
            return None
        turn = int(2 * c) % 4
        return self.ring.constant((0, 1, 0, -1)[turn]), self.ring.constant((1, 0, -1, 0)[turn])

    def _multiple(self, key: object, n: int) -> tuple[Quotient, Quotient]:
        """Return sin and cos of n units of a part, by De Moivre from those of one unit."""
        ring, unit = self.ring, self.units["sin", key]
        c1 = self._atom(("cos", key, unit))
        s1 = self._atom(("sin", key, unit), (2, {(): Fraction(1), ((c1, 2),): Fraction(-1)}))
        sine: Polynomial = {}
        cosine: Polynomial = {}
        for k in range(abs(n) + 1):
            term = tuple(sorted((x, p) for x, p in ((c1, abs(n) - k), (s1, k)) if p))
            value = Fraction(comb(abs(n), k) * (-1 if k % 4 >= 2 else 1))
            (sine if k % 2 else cosine)[term] = value
        sine = ring.scaled(ring.reduced(sine), Fraction(-1 if n < 0 else 1))
        return Quotient(sine), Quotient(ring.reduced(cosine))

    def _exponential(self, a: Quotient) -> Quotient:
        ring = self.ring
        found = ring.constant(1)
        for key, _, n in self._parts("exp", a):
            atom = ring.atom(self._atom(("exp", key, self.units["exp", key])))
            found = ring.multiply(found, ring.power(atom, n))
        return found
