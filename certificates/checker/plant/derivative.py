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
        elif all(slopes[part] == zero for part in node.parts):
            slopes[number] = zero
        else:
            slopes[number] = _slope(graph, number, node, slopes)
    return slopes[root]


def _slope(graph: Graph, number: int, node: Node, slopes: Mapping[int, int]) -> int:
    g, parts = graph, node.parts
    first = slopes[parts[0]]
    if node.op == "add":
        return g.add(first, slopes[parts[1]])
    if node.op == "multiply":
        a, b = parts
        return g.add(_scaled(g, b, first), _scaled(g, a, slopes[b]))
    if node.op == "divide":
        # (a / b)' = (a' - (a / b) b') / b, so that a / b is computed only once.
        b = parts[1]
        above = g.subtract(first, _scaled(g, number, slopes[b]))
        return above if g.value(above) == 0 else g.divide(above, b)
    if node.op == "power":
        lower = g.power(parts[0], node.value - 1)
        return g.multiply(g.multiply(g.constant(node.value), lower), first)
    if node.op == "call":
        return g.multiply(_outer(g, node.name, parts[0], number), first)
    if node.op == "table":
        return g.total(
            g.multiply(_partial(g, node, place), slopes[part])
            for place, part in enumerate(parts)
            if g.value(slopes[part]) != 0
        )
    raise Refused("an absolute value cannot be differentiated twice")


def _scaled(g: Graph, a: int, slope: int) -> int:
    """Return a times a slope; 0 if the slope is 0, also where a may be undefined.

    a is a part of the expression that is differentiated, and is proved to be defined there.
    """
    return slope if g.value(slope) == 0 else g.multiply(a, slope)


def _partial(graph: Graph, node: Node, place: int) -> int:
    orders = list(node.orders)
    orders[place] += 1
    if orders[place] > MOST_ORDER:
        raise Refused(f"a derivative of order {orders[place]} of the table {node.name}")
    return graph.table(node.name, node.parts, tuple(orders))


def _outer(g: Graph, name: str, a: int, value: int) -> int:
    """Return f'(a); ``value`` is the node of f(a)."""
    one, square = g.constant(1), g.power(a, 2)
    half = Fraction(1, 2)
    if name in ("exp", "sin", "sinh", "cosh"):
        other = {"exp": "exp", "sin": "cos", "sinh": "cosh", "cosh": "sinh"}[name]
        return g.call(other, a)
    if name == "cos":
        return g.negative(g.call("sin", a))
    if name in ("tan", "tanh"):
        own = g.power(value, 2)
        return g.add(one, own) if name == "tan" else g.subtract(one, own)
    if name == "log":
        return g.divide(one, a)
    if name in ("asin", "acos"):
        found = g.power(g.subtract(one, square), -half)
        return found if name == "asin" else g.negative(found)
    if name == "asinh":
        return g.power(g.add(one, square), -half)
    if name == "acosh":
        return g.power(g.subtract(square, one), -half)
    if name == "atan":
        return g.divide(one, g.add(one, square))
    if name == "atanh":
        return g.divide(one, g.subtract(one, square))
    if name == "erf":
        front = g.multiply(g.constant(2), g.power(g.pi(), -half))
        return g.multiply(front, g.call("exp", g.negative(square)))
    if name == "abs":
        return g.sign(a)
    raise Refused(f"the derivative of {name} is not known")


def substituted(graph: Graph, root: int, places: Mapping[str, int]) -> int:
    """Return the node with variables replaced by nodes."""
    found: dict[int, int] = {}
    for number in graph.below([root]):
        node = graph[number]
        parts = tuple(found[part] for part in node.parts)
        if node.op == "variable":
            found[number] = places.get(node.name, number)
        else:
            found[number] = rebuilt(graph, number, parts)
    return found[root]


def rebuilt(graph: Graph, number: int, parts: tuple[int, ...]) -> int:
    """Return the node with other parts."""
    node = graph[number]
    if parts == node.parts:
        return number
    if node.op == "add":
        return graph.add(*parts)
    if node.op == "multiply":
        return graph.multiply(*parts)
    if node.op == "divide":
        return graph.divide(*parts)
    if node.op == "power":
        return graph.power(parts[0], node.value)
    if node.op == "call":
        return graph.call(node.name, parts[0])
    if node.op == "table":
        return graph.table(node.name, parts, node.orders)
    return graph.sign(parts[0])
