"""Sums c_1 x_1 + ... + c_n x_n in a denominator that vanish at rest, as in sin(x + y)/(x + y).

Where such a sum s is in a denominator, every part of the expression of the form a s + b is written
as a t + b with a new variable t.  The expression is then exactly G(s(x), x).  A bound of G(t, x)
for every t in the range of s and every x in the box holds on the box, since there t = s(x) is one
of these t.  The sum vanishes on a hyperplane, whose complement is dense in the box.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from operator import add
from typing import NamedTuple, TypeAlias

from takagi.certificates.checker.plant.derivative import rebuilt
from takagi.certificates.checker.plant.graph import Graph, largest_bits

# An interval with exact rational ends.
Ends: TypeAlias = tuple[Fraction, Fraction]

MOST_BITS = 2_000  # of a coefficient
MOST_SHOWN = 64  # bits of a coefficient that stands in a name


class LinearSum(NamedTuple):
    """A sum: its ``constant``, and (variable, factor other than 0) in the order of names."""

    factors: tuple[tuple[str, Fraction], ...]
    constant: Fraction

    def name(self, number: int) -> str:
        """Return a unique name for the sum that is not the name of a variable."""
        if len(self.factors) > 4 or any(largest_bits(c) > MOST_SHOWN for _, c in self.factors):
            return f"sum {number} of variables"
        terms = (v if abs(c) == 1 else f"{abs(c)}*{v}" for v, c in self.factors)
        signs = (" - " if c < 0 else " + " for _, c in self.factors)
        return "".join(map(add, signs, terms)).removeprefix(" + ")


def _scaled(a: LinearSum, c: Fraction) -> LinearSum:
    return LinearSum(tuple((v, c * x) for v, x in a.factors) if c else (), c * a.constant)


def _sum(a: LinearSum, b: LinearSum) -> LinearSum:
    total = dict(a.factors)
    for v, c in b.factors:
        total[v] = total.get(v, Fraction(0)) + c
    return LinearSum(tuple((v, c) for v, c in sorted(total.items()) if c), a.constant + b.constant)


def _linear(graph: Graph, root: int) -> dict[int, LinearSum]:
    """Return part -> sum for the parts of a node that are linear sums with rational factors."""
    sums: dict[int, LinearSum] = {}
    for number in graph.below([root]):
        node = graph[number]
        operands = [sums[operand] for operand in node.operands if operand in sums]
        linear_sum = None
        if node.op == "const":
            linear_sum = LinearSum((), node.value)
        elif node.op == "variable":
            linear_sum = LinearSum(((node.name, Fraction(1)),), Fraction(0))
        elif node.op == "add" and len(operands) == 2:
            linear_sum = _sum(*operands)
        elif node.op == "multiply" and len(operands) == 2 and not all(p.factors for p in operands):
            factor, variable_sum = operands if not operands[0].factors else operands[::-1]
            linear_sum = _scaled(variable_sum, factor.constant)
        if linear_sum is not None and largest_bits(linear_sum.constant) <= MOST_BITS:
            if all(largest_bits(c) <= MOST_BITS for _, c in linear_sum.factors):
                sums[number] = linear_sum
    return sums


def linear_sum(graph: Graph, root: int) -> LinearSum | None:
    """Return a node as a sum; None if it is none."""
    return _linear(graph, root).get(root)


def vanishing_sums(graph: Graph, root: int, sides: Mapping[str, Ends]) -> dict[LinearSum, Ends]:
    """Return sum -> exact range for sums without constant that divide, and may be 0 in the box.

    Each sum has the factor 1 at its first variable.  Single variables, and sums with a variable
    that has no range, are left out.
    """
    linear = _linear(graph, root)
    ranges: dict[LinearSum, Ends] = {}
    for number in graph.below([root]):
        node = graph[number]
        below = node.operands[1:] if node.op == "divide" else ()
        if node.op == "power" and node.value < 0:
            below = node.operands
        for factor in (f for divisor in below for f in _factors(graph, divisor)):
            a = linear.get(factor)
            if a is None or not a.factors or a.constant or graph[factor].op == "variable":
                continue
            unit = _scaled(a, 1 / a.factors[0][1])
            side = _range(unit, sides)
            if side is not None and side[0] <= 0 <= side[1]:
                ranges[unit] = side
    return ranges


def _factors(graph: Graph, root: int) -> Iterator[int]:
    stack = [root]
    while stack:
        number = stack.pop()
        node = graph[number]
        if node.op == "multiply" or (node.op == "power" and node.value.denominator == 1):
            stack += node.operands
        else:
            yield number


def _range(a: LinearSum, sides: Mapping[str, Ends]) -> Ends | None:
    """Return the exact range of a sum over a box; None where a variable has no range."""
    low = high = a.constant
    for name, c in a.factors:
        if name not in sides:
            return None
        ends = sorted(c * end for end in sides[name])
        low, high = low + ends[0], high + ends[1]
    return low, high


def with_variable(graph: Graph, root: int, a: LinearSum, variable: int) -> int:
    """Return the node with c a + b written as c t + b, where t is the variable's node."""
    linear = _linear(graph, root)
    nodes: dict[int, int] = {}
    for number in graph.below([root]):
        linear_sum = linear.get(number)
        if linear_sum is not None and linear_sum.factors:
            c = linear_sum.factors[0][1] / a.factors[0][1]
            if _scaled(a, c).factors == linear_sum.factors:
                multiple = graph.multiply(graph.constant(c), variable)
                nodes[number] = graph.add(multiple, graph.constant(linear_sum.constant))
                continue
        nodes[number] = rebuilt(graph, number, tuple(nodes[n] for n in graph[number].operands))
    return nodes[root]
