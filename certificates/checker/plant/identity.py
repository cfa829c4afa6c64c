"""Prove by exact algebra that two nodes are the same function.

A node becomes a quotient of polynomials in atoms: variables, pi, and values of functions, whose
arguments are compared as quotients.  The known properties of the atoms are:

    sin(sum c_i m_i)          expanded by the addition theorem into sin and cos of each part c m,
                              multiples of one part by De Moivre;  s^2 = 1 - c^2;  tan = s / c
    sin(atan q), cos(atan q)  q/r and 1/r with the root r of 1 + q^2, r^2 = 1 + q^2: atan q lies in
                              (-pi/2, pi/2), where cos > 0, and 1/cos^2 = 1 + tan^2 = 1 + q^2
    exp(sum c_i m_i)          a product of whole powers of atoms exp(b m)
    sinh, cosh, tanh          quotients of exponentials
    a^(p/q)                   the p-th power of a root r, r^q = a; positive numbers are separated
                              from a first (``atoms``)
    table(numbers)            the spline's exact value
    |a|^2 = a^2
    atan(-a) = -atan(a)       and so for asin, atanh, asinh, erf
    f(0)                      of every function for which it is a rational number

Two quotients with equal cross products are equal wherever their denominators are not 0.  No other
property is used, so that two nodes may be equal although this is not shown.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from math import comb, gcd, lcm

from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.plant.atoms import Atoms
from takagi.certificates.checker.plant.graph import Graph, Node
from takagi.certificates.checker.plant.polynomial import Monomial, Polynomial, Quotient
from takagi.certificates.checker.plant.table import Table

# Of sin(n a) in sin(a), cos(a), which has n terms; exp(a)^n has one.
MOST_MULTIPLE = {"sin": 32, "exp": 200}
MOST_RESTARTS = 100
MOST_PARTS = 4  # of a sum inside sin and cos
AT_ZERO = {
    "asin": 0,
    "atan": 0,
    "asinh": 0,
    "atanh": 0,
    "erf": 0,
    "abs": 0,
}
ODD = {"asin", "atan", "asinh", "atanh", "erf"}


class _Finer(Exception):
    """The unit of a part was made smaller, so that all atoms must be made again with it."""


class Algebra:
    """Quotients of nodes, with the atoms that occurred so far.

    Raises
    ------
    Refused : a division by zero, or terms that are too many or too large.
    """

    def __init__(self, graph: Graph, tables: Mapping[str, Table] | None = None) -> None:
        self.graph, self.tables = graph, tables or {}
        self.units: dict[tuple[str, object], Fraction] = {}
        self._names: dict[object, int] = {}
        self._restarts = 0
        self.atoms = Atoms()
        self._restart()

    def _restart(self) -> None:
        self._restarts += 1
        if self._restarts > MOST_RESTARTS:
            raise Refused("angles with too many different multiples")
        self.atoms = Atoms(self.atoms.ring.work)
        self.ring = self.atoms.ring
        self._tangents: dict[object, Quotient] = {}
        self._found: dict[int, Quotient] = {}

    # ------------------------------------------------------------------ questions

    def equal(self, a: int, b: int) -> bool:
        """Return whether algebra shows that the nodes are equal where no denominator is 0."""
        while True:
            try:
                return self.ring.equal(self.quotient(a), self.quotient(b))
            except _Finer:
                self._restart()

    def vanishes(self, a: int) -> bool:
        """Return whether algebra shows that the node is 0 where no denominator is 0."""
        return self.equal(a, self.graph.constant(0))

    def polynomial(self, root: int) -> dict[tuple[tuple[str, int], ...], Fraction]:
        """Return a node as a polynomial: powers of variables -> coefficient.

        Raises
        ------
        Refused : it is not a polynomial in its variables with rational coefficients.
        """
        while True:
            try:
                q = self.quotient(root)
                break
            except _Finer:
                self._restart()
        names = {
            number: key[1]
            for key, number in self.atoms.keys.items()
            if isinstance(key, tuple) and key[0] == "variable"
        }
        if q.bottom or any(a not in names for monomial in q.top for a, _ in monomial):
            raise Refused("no polynomial with rational coefficients")
        return {tuple((str(names[a]), k) for a, k in monomial): c for monomial, c in q.top.items()}

    def collected(self, root: int) -> int:
        """Return a node equal to this one where it is defined: of a polynomial, its sum of terms.

        What is no polynomial is returned as it is.
        """
        g = self.graph
        try:
            terms = self.polynomial(root)
        except Refused:
            return root
        total = g.constant(0)
        for monomial, factor in terms.items():
            term = g.constant(factor)
            for name, power in monomial:
                term = g.multiply(term, g.power(g.variable(name), Fraction(power)))
            total = g.add(total, term)
        return total

    def quotient(self, root: int) -> Quotient:
        """Return the node as a quotient of polynomials in this algebra's atoms."""
        for number in self.graph.below([root]):
            if number not in self._found:
                self._found[number] = self._of(self.graph[number])
        return self._found[root]

    def _of(self, node: Node) -> Quotient:
        ring = self.ring
        operands = [self._found[operand] for operand in node.operands]
        if node.op == "const":
            return ring.constant(node.value)
        if node.op in ("pi", "variable"):
            return ring.atom(self.atoms.named((node.op, node.name)))
        if node.op == "add":
            return ring.add(*operands)
        if node.op == "multiply":
            return ring.multiply(*operands)
        if node.op == "divide":
            return ring.multiply(operands[0], ring.inverse(operands[1]))
        if node.op == "power":
            return self.atoms.power(operands[0], node.value)
        if node.op == "call":
            return self._call(node.name, operands[0])
        value = self._at_numbers(node, operands) if node.op == "table" else None
        if value is not None:
            return ring.constant(value)
        return ring.atom(self.atoms.opaque((node.op, node.name, node.orders), tuple(operands)))

    def _at_numbers(self, node: Node, arguments: list[Quotient]) -> Fraction | None:
        """Return a table's exact value where its arguments are numbers; None elsewhere."""
        if node.name not in self.tables or any(a.bottom or set(a.top) - {()} for a in arguments):
            return None
        point = [a.top.get((), Fraction(0)) for a in arguments]
        return self.tables[node.name].exact(point, node.orders)

    # ------------------------------------------------------------------ functions

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
            return ring.atom(self.atoms.opaque("abs", (a,), rule))
        if name in ODD:
            return self._odd(name, a)
        return ring.atom(self.atoms.opaque(name, (a,)))

    def _odd(self, name: str, a: Quotient) -> Quotient:
        """Return f(a) of an odd function, as -f(-a) where f(-a) occurred before."""
        ring, minus = self.ring, self.ring.constant(-1)
        opposite = ring.multiply(minus, a)
        opposite_atom = self.atoms.known(name, (opposite,))
        if opposite_atom is not None:
            return ring.multiply(minus, ring.atom(opposite_atom))
        atom = self.atoms.opaque(name, (a,))
        if name == "atan":
            self._tangents[self._named(((atom, 1),))] = a
        return ring.atom(atom)

    # ------------------------------------------------------------------ sums as arguments

    def _whole(self, kind: str, term: object, c: Fraction) -> int:
        """Return c divided by the unit of this part.

        If it is no integer, the unit becomes the common divisor of both, and ``_Finer`` is raised.
        """
        unit = self.units.setdefault((kind, term), abs(c))
        count = c / unit
        if count.denominator != 1:
            common = lcm(unit.denominator, c.denominator)
            self.units[kind, term] = Fraction(gcd(int(unit * common), int(abs(c) * common)), common)
            raise _Finer
        return int(count)

    def _parts(self, kind: str, a: Quotient) -> list[tuple[object, Fraction, int]]:
        """Return (key, coefficient, multiple of the unit) of each term of an argument.

        An argument of many terms, or with a large multiple, counts as a single part.
        """
        named = self._terms(a)
        if len(named) <= MOST_PARTS:
            multiples = [(key, c, self._whole(kind, key, c)) for key, c in named]
            if all(abs(n) <= MOST_MULTIPLE[kind] for _, _, n in multiples):
                return multiples
        argument_key = ("argument", self.atoms.opaque("argument", (a,)))
        return [(argument_key, Fraction(1), self._whole(kind, argument_key, Fraction(1)))]

    def _terms(self, a: Quotient) -> list[tuple[object, Fraction]]:
        """Return (key, coefficient) of the terms that an argument is the sum of.

        From N/D a constant is separated, c + (N - c D)/D, so that exp(a - b/T) and
        exp(a) exp(-b/T) have the same parts.  This is true for any c; the c that is used cancels
        the leading term of D in N.
        """
        if not a.bottom:
            return [(self._named(m), c) for m, c in sorted(a.top.items())]
        terms: list[tuple[object, Fraction]] = []
        top = a.top
        if len(a.bottom) == 1 and a.bottom[0][1] == 1:
            below = self.ring.factors[a.bottom[0][0]]
            leading = max(below)
            constant = top.get(leading, Fraction(0)) / below[leading]
            if constant:
                terms.append((self._named(()), constant))
                top = self.ring.plus(top, self.ring.scaled(below, -constant))
        if top:
            size = top[max(top)]
            remainder = Quotient(self.ring.scaled(top, 1 / size), a.bottom)
            terms.append((("argument", self.atoms.opaque("argument", (remainder,))), size))
        return terms

    def _named(self, monomial: Monomial) -> object:
        """Return the monomial with names instead of atoms, whose numbers a restart changes."""
        keys = list(self.atoms.keys)
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
        if key in self._tangents and unit.denominator == 1:
            return self._of_tangent(self._tangents[key], n * int(unit))
        c1 = self.atoms.named(("cos", key, unit))
        s1 = self.atoms.named(("sin", key, unit), (2, {(): Fraction(1), ((c1, 2),): Fraction(-1)}))
        sine: Polynomial = {}
        cosine: Polynomial = {}
        for k in range(abs(n) + 1):
            term = tuple(sorted((x, p) for x, p in ((c1, abs(n) - k), (s1, k)) if p))
            value = Fraction(comb(abs(n), k) * (-1 if k % 4 >= 2 else 1))
            (sine if k % 2 else cosine)[term] = value
        sine = ring.scaled(ring.reduced(sine), Fraction(-1 if n < 0 else 1))
        return Quotient(sine), Quotient(ring.reduced(cosine))

    def _of_tangent(self, q: Quotient, n: int) -> tuple[Quotient, Quotient]:
        """Return sin and cos of n atan(q), from those of atan(q) by the addition theorem."""
        ring = self.ring
        if abs(n) > MOST_MULTIPLE["sin"]:
            raise Refused("a multiple of atan that is too large")
        square = ring.add(ring.constant(1), ring.multiply(q, q))
        # Not the power -1/2, which is r/r^2: r/r cancels also where r^2 is no polynomial.
        cosine = ring.inverse(self.atoms.power(square, Fraction(1, 2)))
        sine = ring.multiply(ring.constant(-1 if n < 0 else 1), ring.multiply(q, cosine))
        sine_cosine = ring.constant(0), ring.constant(1)
        for _ in range(abs(n)):
            minus = ring.multiply(ring.constant(-1), ring.multiply(sine_cosine[0], sine))
            sine_cosine = (
                ring.add(
                    ring.multiply(sine_cosine[0], cosine), ring.multiply(sine_cosine[1], sine)
                ),
                ring.add(ring.multiply(sine_cosine[1], cosine), minus),
            )
        return sine_cosine

    def _exponential(self, a: Quotient) -> Quotient:
        ring = self.ring
        product = ring.constant(1)
        for key, _, n in self._parts("exp", a):
            atom = self.atoms.named(("exp", key, self.units["exp", key]))
            power = Quotient({((atom, abs(n)),): Fraction(1)}) if n else ring.constant(1)
            product = ring.multiply(product, ring.inverse(power) if n < 0 else power)
        return product
