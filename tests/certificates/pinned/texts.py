"""Expressions of plants as text, and what the checker makes of them; x and y are variables.

Sides of a box are texts of two numbers: ``x="-1 2"``.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.arithmetic.interval import Interval, enclose
from takagi.certificates.checker.plant.derivative import derivative, substituted
from takagi.certificates.checker.plant.evaluate import Evaluator
from takagi.certificates.checker.plant.expression import Scope, read_expression
from takagi.certificates.checker.plant.graph import Graph, largest_bits
from takagi.certificates.checker.plant.identity import Algebra
from takagi.certificates.checker.plant.linear_sum import vanishing_sums, with_variable
from takagi.certificates.checker.plant.quotient_form import Form, parted
from takagi.certificates.checker.plant.ranges import Ranges
from takagi.certificates.checker.plant.table import Table

__all__ = [
    "Written",
    "bracket",
    "continuous",
    "form_of",
    "nonzero",
    "parted_text",
    "polynomial",
    "put",
    "quotient",
    "same",
    "slope",
    "sums",
    "table",
    "unrounded",
    "within",
]


def table(arguments: int = 1) -> Table:
    """Return a table over [0, 30], or over [0, 30] and [-0.2, 0.2], that has no symmetry."""
    x = [Fraction(k) for k in (0, 0, 0, 0, 10, 15, 30, 30, 30, 30)]
    y = [Fraction(k, 50) for k in (-10, -10, -10, -10, 3, 10, 10, 10, 10)]
    if arguments == 1:
        return Table([x], [[Fraction(c)] for c in (7, -2, 300, 41, 0, 5)])
    return Table([x, y], [[Fraction((7 * i + 3 * j * j) % 5 - i, 3) for j in range(5)]
                          for i in range(6)])  # fmt: skip


class Written:
    """A text in a graph of its own, with tables T of one argument and S of two."""

    def __init__(self, text: str, names: str = "x y z") -> None:
        self.graph = Graph()
        self.tables = {"T": table(1), "S": table(2)} if "T(" in text or "S(" in text else {}
        arguments = {name: found.arguments for name, found in self.tables.items()}
        self.scope = Scope({n: self.graph.variable(n) for n in names.split()}, arguments)
        self.root = self.node(text)

    def node(self, text: str) -> int:
        return read_expression(text, self.graph, self.scope, "here")

    def __repr__(self) -> str:
        return self.shown(self.root)

    def shown(self, number: int) -> str:
        """Return a node in writing."""
        node = self.graph[number]
        parts = [self.shown(part) for part in node.parts]
        signs = {"add": " + ", "multiply": " * ", "divide": " / "}
        if node.op in signs:
            return f"({signs[node.op].join(parts)})"
        if node.op == "power":
            return f"{parts[0]}^({node.value})"
        if node.op == "const":
            bits = largest_bits(node.value)
            return str(node.value) if bits < 2000 else f"<{bits} bits>"
        if node.op == "variable":
            return node.name
        orders = "".join(map(str, node.orders))
        return f"{node.name or node.op}{orders}({', '.join(parts)})" if parts else node.op

    def evaluator(self, sides: dict[str, str]) -> Evaluator:
        return Evaluator(self.graph, self.tables, {n: _ends(side) for n, side in sides.items()})

    def ranges(self, sides: dict[str, str]) -> Ranges:
        algebra = Algebra(self.graph, self.tables)
        return Ranges(self.evaluator(sides), algebra, _box(sides))


def _ends(side: str) -> tuple[Fraction, Fraction]:
    low, high = map(Fraction, side.split())
    return low, high


def _box(sides: dict[str, str]) -> dict[str, Interval]:
    return {name: enclose(*_ends(side)) for name, side in sides.items()}


def slope(text: str, name: str) -> str:
    """Return a partial derivative in writing."""
    own = Written(text)
    return own.shown(derivative(own.graph, own.root, name))


def put(text: str, **places: str) -> str:
    """Return the text with others in the place of variables."""
    own = Written(text)
    return own.shown(substituted(own.graph, own.root, {n: own.node(t) for n, t in places.items()}))


def bracket(text: str, **sides: str) -> tuple[Interval | None, int]:
    """Return the enclosure over a box, and the work that it took."""
    own = Written(text)
    evaluator = own.evaluator(sides)
    return evaluator.value(own.root, _box(sides)), evaluator.work


def unrounded(text: str, face: str = "", **sides: str) -> Any:
    """Return the enclosure without rounding; ``face`` names a variable at its lower end."""
    own = Written(text)
    evaluator, box = own.evaluator(sides), _box(sides)
    for word in face.split():
        name, place = word[:-1], int(word[-1])
        box[name] = Interval(box[name][place], box[name][place])
    return evaluator.exact_ends(own.root, box), evaluator.work


def same(first: str, second: str) -> bool:
    """Return whether two texts are shown to be one function."""
    own = Written(f"({first}) - ({second})")
    return Algebra(own.graph, own.tables).equal(own.node(first), own.node(second))


def quotient(text: str) -> Any:
    """Return the text over the atoms of an algebra: numerator, denominator, factors, work."""
    own = Written(text)
    algebra = Algebra(own.graph, own.tables)
    algebra.equal(own.root, own.root)
    found = algebra.quotient(own.root)
    return found, algebra.ring.factors, algebra.ring.rules, algebra.ring.work


def polynomial(text: str) -> Any:
    """Return the text as a polynomial in its variables."""
    own = Written(text)
    return Algebra(own.graph, own.tables).polynomial(own.root)


def parted_text(text: str, vanishing: str = "x y") -> Any:
    """Return (N, powers) of N over powers of the variables that may vanish."""
    own = Written(text)
    top, poles = parted(own.graph, own.root, frozenset(vanishing.split()))
    return own.shown(top), poles


def form_of(text: str, name: str = "x", **sides: str) -> Any:
    """Return of a quotient with its limits: value, slope in a variable, and ends unrounded."""
    own = Written(text)
    box = _box(sides)
    vanishing = frozenset(n for n, side in box.items() if side[0] <= 0 <= side[1])
    algebra = Algebra(own.graph, own.tables)
    top, poles = parted(own.graph, own.root, vanishing)
    form = Form(own.evaluator(sides), algebra, top, poles)
    return form.value(box), form.slope(box, name), form.exact_ends(box), form.poles


def within(text: str, lower: str, upper: str, **sides: str) -> Any:
    """Prove bounds over a box; return how many boxes were looked at, and what is removable."""
    own = Written(text)
    ranges = own.ranges(sides)
    ranges.prove_within(own.root, Fraction(lower), Fraction(upper), "it")
    return ranges.boxes, sorted(ranges.removable)


def continuous(text: str, **sides: str) -> Any:
    """Prove that the text is defined over a box; return as ``within``."""
    own = Written(text)
    ranges = own.ranges(sides)
    ranges.prove_continuous(own.root, "it")
    return ranges.boxes, sorted(ranges.removable)


def nonzero(text: str, **sides: str) -> int:
    """Prove that the text has no zero in a box; return how many boxes were looked at."""
    own = Written(text)
    ranges = own.ranges(sides)
    ranges.prove_nonzero(own.root, "it")
    return ranges.boxes


def sums(text: str, **sides: str) -> Any:
    """Return the sums under a quotient that may vanish, their ranges, and the text with them."""
    own = Written(text)
    found = vanishing_sums(own.graph, own.root, {n: _ends(side) for n, side in sides.items()})
    listed = []
    for k, (a, ends) in enumerate(found.items(), start=1):
        new = with_variable(own.graph, own.root, a, own.graph.variable("t"))
        listed.append((a, a.name(k), ends, own.shown(new)))
    return listed
