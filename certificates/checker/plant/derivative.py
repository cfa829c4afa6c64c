"""Partial derivatives and substitution; each node is computed after its parts."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.plant.graph import Graph, Node

MOST_ORDER = 2  # of differentiation of a table: a cubic spline's third derivative jumps


def derivative(graph: Graph, root: int, name: str) -> int:
    """Return the partial derivative of a node by a variable, by the chain rule.

    Raises
    ------
    Refused : a third derivative of a table, or a derivative of ``sign``.
    """
    zero = graph.constant(0)
    slopes: dict[int, int] = {}
    for number in graph.below([root]):
        node = graph[number]
        if node.op == "variable":
            slopes[number] = graph.constant(int(node.name == name))
        elif all(slopes[operand] == zero for operand in node.operands):
            slopes[number] = zero
        else:
            slopes[number] = _slope(graph, number, node, slopes)
    return slopes[root]


def _slope(graph: Graph, number: int, node: Node, slopes: Mapping[int, int]) -> int:
    g, operands = graph, node.operands
    first = slopes[operands[0]]
    if node.op == "add":
        return g.add(first, slopes[operands[1]])
    if node.op == "multiply":
        a, b = operands
        return g.add(_scaled(g, b, first), _scaled(g, a, slopes[b]))
    if node.op == "divide":
        # (a / b)' = (a' - (a / b) b') / b, so that a / b is computed only once.
        b = operands[1]
        above = g.subtract(first, _scaled(g, number, slopes[b]))
        return above if g.value(above) == 0 else g.divide(above, b)
    if node.op == "power":
        lower = g.power(operands[0], node.value - 1)
        return g.multiply(g.multiply(g.constant(node.value), lower), first)
    if node.op == "call":
        return g.multiply(_outer(g, node.name, operands[0], number), first)
    if node.op == "table":
        return g.total(
            g.multiply(_partial(g, node, argument), slopes[operand])
            for argument, operand in enumerate(operands)
            if g.value(slopes[operand]) != 0
        )
    raise Refused("an absolute value cannot be differentiated twice")


def _scaled(g: Graph, a: int, slope: int) -> int:
    """Return a times a slope; 0 if the slope is 0, also where a may be undefined.

    a is a part of the expression that is differentiated, and is proved to be defined there.
    """
    return slope if g.value(slope) == 0 else g.multiply(a, slope)


def _partial(graph: Graph, node: Node, argument: int) -> int:
    orders = list(node.orders)
    orders[argument] += 1
    if orders[argument] > MOST_ORDER:
        raise Refused(f"a derivative of order {orders[argument]} of the table {node.name}")
    return graph.table(node.name, node.operands, tuple(orders))


def _outer(g: Graph, name: str, a: int, value: int) -> int:
    """Return f'(a); ``value`` is the node of f(a)."""
    unit, square = g.constant(1), g.power(a, 2)
    half = Fraction(1, 2)
    if name in ("exp", "sin", "sinh", "cosh"):
        companion = {"exp": "exp", "sin": "cos", "sinh": "cosh", "cosh": "sinh"}[name]
        return g.call(companion, a)
    if name == "cos":
        return g.negative(g.call("sin", a))
    if name in ("tan", "tanh"):
        squared_value = g.power(value, 2)
        return g.add(unit, squared_value) if name == "tan" else g.subtract(unit, squared_value)
    if name == "log":
        return g.divide(unit, a)
    if name in ("asin", "acos"):
        slope = g.power(g.subtract(unit, square), -half)
        return slope if name == "asin" else g.negative(slope)
    if name == "asinh":
        return g.power(g.add(unit, square), -half)
    if name == "acosh":
        return g.power(g.subtract(square, unit), -half)
    if name == "atan":
        return g.divide(unit, g.add(unit, square))
    if name == "atanh":
        return g.divide(unit, g.subtract(unit, square))
    if name == "erf":
        front = g.multiply(g.constant(2), g.power(g.pi(), -half))
        return g.multiply(front, g.call("exp", g.negative(square)))
    if name == "abs":
        return g.sign(a)
    raise Refused(f"the derivative of {name} is not known")


def substituted(graph: Graph, root: int, replacements: Mapping[str, int]) -> int:
    """Return the node with variables replaced by nodes."""
    replaced: dict[int, int] = {}
    for number in graph.below([root]):
        node = graph[number]
        operands = tuple(replaced[operand] for operand in node.operands)
        if node.op == "variable":
            replaced[number] = replacements.get(node.name, number)
        else:
            replaced[number] = rebuilt(graph, number, operands)
    return replaced[root]


def rebuilt(graph: Graph, number: int, operands: tuple[int, ...]) -> int:
    """Return the same operation with other operands."""
    node = graph[number]
    if operands == node.operands:
        return number
    if node.op == "add":
        return graph.add(*operands)
    if node.op == "multiply":
        return graph.multiply(*operands)
    if node.op == "divide":
        return graph.divide(*operands)
    if node.op == "power":
        return graph.power(operands[0], node.value)
    if node.op == "call":
        return graph.call(node.name, operands[0])
    if node.op == "table":
        return graph.table(node.name, operands, node.orders)
    return graph.sign(operands[0])
