"""Interval evaluation of nodes over boxes; every part is enclosed once, operands first."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from contextlib import suppress
from fractions import Fraction
from typing import TypeAlias

from takagi.certificates.checker.arithmetic.elementary import function_of
from takagi.certificates.checker.arithmetic.interval import (
    ONE,
    UNIT,
    Interval,
    enclose,
    point,
    product,
)
from takagi.certificates.checker.arithmetic.monotone import pi_interval
from takagi.certificates.checker.arithmetic.powers import power, root, whole_power
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.plant.graph import Graph, Node, largest_bits
from takagi.certificates.checker.plant.linear_sum import Ends
from takagi.certificates.checker.plant.table import Table

Box: TypeAlias = Mapping[str, Interval]


MOST_WORK = 8_000_000  # nodes enclosed in total; a function, power or table adds SLOW
SLOW = 30
MOST_BITS = 20_000  # of an end that is not rounded


class TooLong(Refused):
    """The work limit, which no valid certificate reaches, was exceeded."""


class Evaluator:
    """Encloses nodes of a graph over boxes.

    Raises
    ------
    TooLong : the work limit is exceeded, which no valid certificate needs.
    """

    def __init__(
        self,
        graph: Graph,
        tables: Mapping[str, Table],
        sides: Mapping[str, Ends] | None = None,
    ) -> None:
        self.graph, self.tables = graph, tables
        # (variable, 0 lower or 1 upper, rounded end) -> exact end of the whole box.
        self.sides: dict[str, Ends] = {}
        self._ends: dict[tuple[str, int, int], Fraction] = {}
        for name, side in (sides or {}).items():
            self.add_side(name, side)
        self._orders: dict[int, list[int]] = {}
        self._costs: dict[int, int] = {}
        self._constants: dict[int, Interval] = {}
        self.work = 0

    def add_side(self, name: str, side: Ends) -> Interval:
        """Return the range of a variable, rounded outward; the exact ends are stored."""
        rounded = enclose(*side)
        self.sides[name] = side
        self._ends |= {(name, end, rounded[end]): side[end] for end in (0, 1)}
        return rounded

    def value(self, root: int, box: Box) -> Interval | None:
        """Return a bracket of the node over the box; None where a part has none."""
        order = self._orders.get(root)
        if order is None:
            order = self._orders[root] = self.graph.below([root])
            slow = sum(self.graph[n].op in ("call", "power", "table") for n in order)
            self._costs[root] = len(order) + SLOW * slow
        self.work += self._costs[root]
        if self.work > MOST_WORK:
            raise TooLong("bounds that take too long to prove")
        brackets: dict[int, Interval | None] = {}
        for number in order:
            node = self.graph[number]
            operands = [brackets[operand] for operand in node.operands]
            try:
                brackets[number] = self._one(number, node, operands, box)
            except Refused:
                brackets[number] = None
        return brackets[root]

    def exact_ends(self, root: int, box: Box) -> tuple[Fraction, Fraction] | None:
        """Return a bracket whose ends are exact, except where functions are evaluated.

        It serves a bound that the node attains and that is not a decimal, such as
        1/(2 + cos(x)) >= 1/3: rounding alone would put the range beyond the bound.
        """
        intervals: dict[int, Ends | None] = {}
        for number in self.graph.below([root]):
            node = self.graph[number]
            operands = [intervals[operand] for operand in node.operands]
            defined = [operand for operand in operands if operand is not None]
            intervals[number] = None
            if len(defined) < len(operands):
                continue
            if node.op == "variable":
                intervals[number] = self._side(node.name, box)
            elif node.op == "table" and all(low == high for low, high in defined):
                # At a point a spline of decimals has an exact value.
                value = self.tables[node.name].exact([low for low, _ in defined], node.orders)
                intervals[number] = None if value is None else (value, value)
            elif node.op in ("call", "pi", "sign", "table") or (
                node.op == "power" and node.value.denominator > 1
            ):
                rounded = [enclose(*operand) for operand in defined]
                with suppress(Refused):
                    pair = self._one(number, node, rounded, box)
                    intervals[number] = None if pair is None else _ends(pair)
            else:
                intervals[number] = _unrounded(node, defined)
        self.work += SLOW * len(intervals)
        return intervals[root]

    def _side(self, name: str, box: Box) -> Ends | None:
        """Return the side of a box; an end of the whole box is not rounded."""
        if name not in box:
            return None
        first, last = box[name]
        low = self._ends.get((name, 0, first), Fraction(first, ONE))
        high = self._ends.get((name, 1, last), Fraction(last, ONE))
        if first < last:
            return low, high
        # On a face of the box the variable has a single value.
        end = low if (name, 0, first) in self._ends else high
        return end, end

    def _one(
        self, number: int, node: Node, operands: Iterable[Interval | None], box: Box
    ) -> Interval | None:
        op = node.op
        if op == "const":
            if number not in self._constants:
                self._constants[number] = point(node.value)
            return self._constants[number]
        if op == "variable":
            return box.get(node.name)
        if op == "pi":
            return pi_interval()
        defined = [operand for operand in operands if operand is not None]
        if len(defined) < len(node.operands):
            return None
        if op == "add":
            return defined[0] + defined[1]
        if op == "multiply":
            return self._product(node, defined)
        if op == "divide":
            return defined[0] / defined[1]
        if op == "power":
            return _power(node, defined[0])
        if op == "call":
            return function_of(node.name)(defined[0])
        if op == "table":
            return self.tables[node.name].bounds(defined, node.orders)
        low, high = defined[0]
        # At 0 alone the sign is its limit from the side on which the rest of the box lies.
        return Interval(ONE if low >= 0 < high else -ONE, -ONE if low < 0 >= high else ONE)

    def _product(self, node: Node, operands: list[Interval]) -> Interval:
        """Return a product; a constant is multiplied exactly and rounded once."""
        factor = self.graph.value(node.operands[0])
        if factor is None:
            return operands[0] * operands[1]
        ends = [end * factor.numerator for end in operands[1]]
        low, high = min(ends), max(ends)
        return Interval(low // factor.denominator, -(-high // factor.denominator))


def _ends(pair: Interval) -> Ends:
    return Fraction(pair[0], ONE), Fraction(pair[1], ONE)


def _power(node: Node, a: Interval) -> Interval:
    top, bottom = abs(node.value.numerator), node.value.denominator
    raised = power(a if bottom == 1 else root(a, bottom), top)
    return raised if node.value > 0 else UNIT / raised


def _unrounded(node: Node, operands: list[Ends]) -> Ends | None:
    """Return the interval of a node from those of its parts.

    None for a division by 0, and where a number would have more than 20 000 bits.
    """
    if node.op == "const":
        return node.value, node.value
    growth = abs(int(node.value)) if node.op == "power" else 1
    if any(largest_bits(end) * growth > MOST_BITS for operand in operands for end in operand):
        return None
    if node.op == "add":
        (a, b), (c, d) = operands
        return a + c, b + d
    if node.op == "multiply":
        return product(operands[0], operands[1])
    if node.op == "divide":
        below = _inverse(operands[1])
        return None if below is None else product(operands[0], below)
    raised = whole_power(operands[0], growth)
    return raised if node.value > 0 else _inverse(raised)


def _inverse(a: Ends) -> Ends | None:
    return None if a[0] <= 0 <= a[1] else (1 / a[1], 1 / a[0])
