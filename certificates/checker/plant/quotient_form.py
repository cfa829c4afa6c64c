r"""Ranges of N / (x^k y^l ...) with its limits where x or y vanishes, and of its slopes.

A variable whose range contains 0 may be in a denominator.  If N and its first k - 1 derivatives by
x vanish at x = 0 (which exact algebra shows), Taylor's formula

    N / x^k = k \int_0^1 (1 - s)^{k-1} T(s x) ds,    T = (d/dx)^k N / k!,

extends the quotient to x = 0.  The weights k (1 - s)^(k-1) have the integral 1, so that the
quotient lies in the range of T over the hull of x and 0.  Its slope in x is the weighted mean of
s T'(s x), which lies in the range of T' divided by k + 1.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cached_property
from math import factorial

from takagi.certificates.checker.arithmetic.interval import ZERO, Interval, hull
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.plant.derivative import derivative, rebuilt, substituted
from takagi.certificates.checker.plant.evaluate import Box, Evaluator
from takagi.certificates.checker.plant.graph import Graph
from takagi.certificates.checker.plant.identity import Algebra

Poles = dict[str, int]
MOST_QUOTIENTS = 200  # of one node in which absolute values are divided out


def parted(graph: Graph, root: int, vanishing: frozenset[str]) -> tuple[int, Poles]:
    """Return (N, powers) with node = N / product of powers of variables that may vanish.

    If no such variable is in an outer denominator, N is the node itself and there are no powers.
    """
    forms: dict[int, tuple[int, Poles]] = {}
    for number in graph.below([root]):
        node, tops = graph[number], [forms[operand] for operand in graph[number].operands]
        is_integer_power = node.op == "power" and node.value.denominator == 1
        if graph.has_zero_factor(number):
            # 0/x and 0 (1/x) are not treated as quotients with a limit, since no plant needs them.
            forms[number] = number, {}
        elif node.op == "add":
            first, second = tops[0][1], tops[1][1]
            common = {v: max(first.get(v, 0), second.get(v, 0)) for v in first | second}
            numerators = [
                _times(graph, top, {v: k - poles.get(v, 0) for v, k in common.items()})
                for top, poles in tops
            ]
            forms[number] = graph.add(*numerators), common
        elif node.op == "multiply":
            forms[number] = graph.multiply(tops[0][0], tops[1][0]), _joined(tops[0][1], tops[1][1])
        elif node.op == "divide" or (is_integer_power and node.value < 0):
            below = tops[-1]
            if node.op == "power":
                below = _raised(graph, below, int(-node.value))
                above: tuple[int, Poles] = (graph.constant(1), {})
            else:
                above = tops[0]
            cofactor, powers = _factored(graph, below[0], vanishing)
            divided = (
                above[0] if cofactor == graph.constant(1) else graph.divide(above[0], cofactor)
            )
            top = _times(graph, divided, below[1])
            forms[number] = top, _joined(above[1], powers)
        elif is_integer_power:
            forms[number] = _raised(graph, tops[0], int(node.value))
        else:
            forms[number] = number, {}
    top, poles = forms[root]
    return (top, poles) if poles else (root, {})


def _joined(a: Poles, b: Poles) -> Poles:
    return {v: a.get(v, 0) + b.get(v, 0) for v in a | b}


def _raised(graph: Graph, quotient: tuple[int, Poles], power: int) -> tuple[int, Poles]:
    return graph.power(quotient[0], power), {v: k * power for v, k in quotient[1].items()}


def _times(graph: Graph, top: int, powers: Poles) -> int:
    for name, power in powers.items():
        if power:
            top = graph.multiply(top, graph.power(graph.variable(name), power))
    return top


def _factored(graph: Graph, root: int, vanishing: frozenset[str]) -> tuple[int, Poles]:
    """Return (cofactor, powers) with node = cofactor times powers of variables that may vanish."""
    cofactor, powers = graph.constant(1), Poles()
    stack = [(root, 1)]
    while stack:
        number, times = stack.pop()
        node = graph[number]
        if node.op == "variable" and node.name in vanishing:
            powers[node.name] = powers.get(node.name, 0) + times
        elif node.op == "multiply":
            stack += [(operand, times) for operand in node.operands]
        elif node.op == "power" and node.value.denominator == 1 and node.value > 0:
            stack.append((node.operands[0], times * int(node.value)))
        else:
            cofactor = graph.multiply(cofactor, graph.power(number, times))
    return (cofactor, powers) if powers else (root, {})


class Form:
    """A quotient, and the forms T for its limits; each is made when it is first needed."""

    def __init__(self, evaluator: Evaluator, algebra: Algebra, top: int, poles: Poles) -> None:
        self.evaluator, self.algebra, self.graph = evaluator, algebra, evaluator.graph
        self.top, self.poles = top, poles
        self.direct = top
        if poles:
            below = _times(self.graph, self.graph.constant(1), poles)
            self.direct = self.graph.divide(top, below)
        self.variables = sorted(self.graph.variables(self.direct))
        self._slopes: dict[str, int | None] = {}
        self._continued: dict[str, Form | None] = {}

    def value(self, box: Box) -> Interval | None:
        """Return a bracket over the box; None where none is found."""
        direct = None
        if not any(_has_zero(box[name]) for name in self.poles):
            direct = self.evaluator.value(self.direct, box)
        for name in self.poles:
            form = self.continued(name)
            if form is not None:
                direct = _common(direct, form.value(_towards_zero(box, name)))
        return direct

    @cached_property
    def has_table(self) -> bool:
        """Whether a table is a part of the node."""
        return any(self.graph[number].op == "table" for number in self.graph.below([self.direct]))

    def exact_ends(self, box: Box) -> tuple[Fraction, Fraction] | None:
        """Return a bracket over the box with ends that are not rounded, as ``Evaluator`` does."""
        for name in self.poles:
            if _has_zero(box[name]):
                form = self.continued(name)
                return None if form is None else form.exact_ends(box)
        return self.evaluator.exact_ends(self.direct, box)

    def slope(self, box: Box, name: str) -> Interval | None:
        """Return a bracket of the partial derivative over the box; None where none is found."""
        direct = None
        if not any(_has_zero(box[pole]) for pole in self.poles):
            node = self._slope(name)
            direct = None if node is None else self.evaluator.value(node, box)
        for pole, power in self.poles.items():
            form = self.continued(pole)
            if form is None:
                continue
            slope = form.slope(_towards_zero(box, pole), name)
            if slope is not None and pole == name:
                slope = Interval(slope.low // (power + 1), -(-slope.high // (power + 1)))
            direct = _common(direct, slope)
        return direct

    def _slope(self, name: str) -> int | None:
        if name not in self._slopes:
            try:
                self._slopes[name] = derivative(self.graph, self.direct, name)
            except Refused:
                self._slopes[name] = None
        return self._slopes[name]

    def continued(self, name: str) -> Form | None:
        """Return the form of T for this variable; None if 0 is not proved removable."""
        if name not in self._continued:
            try:
                self._continued[name] = self._continuation(name)
            except Refused:
                self._continued[name] = None
        return self._continued[name]

    def _continuation(self, name: str) -> Form | None:
        graph, power = self.graph, self.poles[name]
        numerator = self.top
        origin = {name: graph.constant(0)}
        for _ in range(power):
            if not self.algebra.vanishes(substituted(graph, numerator, origin)):
                return None
            numerator = derivative(graph, numerator, name)
        # The slope of an absolute value jumps, so there is no limit.
        if any(graph[number].op == "sign" for number in graph.below([numerator])):
            return None
        taylor = graph.multiply(graph.constant(Fraction(1, factorial(power))), numerator)
        other_poles = {pole: k for pole, k in self.poles.items() if pole != name}
        return Form(self.evaluator, self.algebra, taylor, other_poles)


def _has_zero(side: Interval) -> bool:
    return side[0] <= 0 <= side[1]


def _towards_zero(box: Box, name: str) -> Box:
    return {**box, name: hull(box[name], ZERO)}


def _common(a: Interval | None, b: Interval | None) -> Interval | None:
    if a is None or b is None:
        return b if a is None else a
    return Interval(max(a.low, b.low), min(a.high, b.high))


def with_signs(graph: Graph, root: int) -> int:
    """Return the node with sign(v) in the place of |v|/v and v/|v|, for variables v.

    Both are equal where v is not 0.

    Raises
    ------
    Refused : too many quotients.
    """
    listed = graph.below([root])
    if not any(graph[number].name == "abs" for number in listed):
        return root
    if sum(graph[number].op == "divide" for number in listed) > MOST_QUOTIENTS:
        raise Refused("absolute values and too many quotients")
    replaced: dict[int, int] = {}
    for number in listed:
        node = graph[number]
        new_node = rebuilt(graph, number, tuple(replaced[operand] for operand in node.operands))
        if node.op == "divide":
            new_node = _signed(graph, *(replaced[operand] for operand in node.operands)) or new_node
        replaced[number] = new_node
    return replaced[root]


def jumps(graph: Graph, root: int) -> frozenset[str]:
    """Return the variables at whose zero a node with signs may jump; "" for another argument."""
    signs = [graph[graph[n].operands[0]] for n in graph.below([root]) if graph[n].op == "sign"]
    return frozenset(a.name if a.op == "variable" else "" for a in signs)


def _signed(graph: Graph, above: int, below: int) -> int | None:
    """Return above/below after its factors v or |v| were divided out; None if there are none."""
    cofactor, changed = graph.constant(1), False
    for factor in _products(graph, below):
        a = graph[factor]
        size = a.op == "call" and a.name == "abs"
        v = graph[a.operands[0]] if size else a
        divided = None
        if v.op == "variable":
            here = graph.variable(v.name)
            divided = _without(graph, above, here, graph.call("abs", here), size=size)
        # Plain quotients such as x sin(x)/x stay as they are written.
        if divided is None or v.name not in jumps(graph, divided) | ({v.name} if size else set()):
            cofactor = graph.multiply(cofactor, factor)
        else:
            above, changed = divided, True
    return graph.divide(above, cofactor) if changed else None


def _products(graph: Graph, root: int) -> list[int]:
    node = graph[root]
    if node.op == "multiply":
        return [factor for operand in node.operands for factor in _products(graph, operand)]
    return [root]


def _without(graph: Graph, root: int, v: int, absolute: int, *, size: bool) -> int | None:
    """Return the node over v, or |v| for ``size``; None if not every term has such a factor."""
    divided: dict[int, int | None] = {}
    for number in graph.below([root]):
        node, new_node = graph[number], None
        operands = [divided[operand] for operand in node.operands]
        if number in (v, absolute):
            new_node = graph.constant(1) if (number == absolute) == size else graph.sign(v)
        elif node.op == "add" and operands[0] is not None and operands[1] is not None:
            new_node = graph.add(operands[0], operands[1])
        elif node.op == "divide" and operands[0] is not None:
            new_node = graph.divide(operands[0], node.operands[1])
        elif node.op == "multiply" and operands[0] is not None:
            new_node = graph.multiply(operands[0], node.operands[1])
        elif node.op == "multiply" and operands[1] is not None:
            new_node = graph.multiply(node.operands[0], operands[1])
        divided[number] = new_node
    return divided[root]
