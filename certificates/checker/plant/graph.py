"""Expressions as nodes of one graph: a node is a number, and its parts have smaller numbers.

    const c | pi | variable name | add a b | multiply a b | divide a b | power a (p/q)
    call name a        the elementary functions
    table name a [b]   a spline, or with ``orders`` a partial derivative of it
    sign a             the slope of |a|, which only derivatives contain

Equal nodes are stored once, so that an evaluation in the order of the numbers computes each part
once.  Operations on constants are done exactly when a node is made.  A part that may be undefined
somewhere is never removed: 0 log(x) stays a product and 0/x a quotient, whose parts must be
defined, and a^0 is a/a.
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from typing import NamedTuple

from takagi.certificates.checker.kernel.refusal import Refused

FUNCTIONS = frozenset(
    "sin cos tan asin acos atan sinh cosh tanh asinh acosh atanh exp log sqrt abs erf".split()
)
# Functions that are undefined somewhere, like quotients, roots, negative powers and tables.
PARTIAL = frozenset({"tan", "asin", "acos", "acosh", "atanh", "log"})
MOST_NODES = 50_000
MOST_BITS = 20_000  # of numerator and denominator of a constant
MOST_POWER = 64
MOST_SHOWN = 1_000  # bits of a number in a message


class Node(NamedTuple):
    """One node: ``op`` and the numbers of its parts.

    ``name`` : of a variable, function or table; ``value`` : of a constant, or the exponent of a
    power; ``orders`` : of a table's partial derivative.
    """

    op: str
    operands: tuple[int, ...] = ()
    name: str = ""
    value: Fraction = Fraction(0)
    orders: tuple[int, ...] = ()


def largest_bits(value: Fraction) -> int:
    """Return the bits of the larger of numerator and denominator."""
    return max(value.numerator.bit_length(), value.denominator.bit_length())


class Graph:
    """The nodes, each stored once; all methods take and return numbers of nodes.

    Raises
    ------
    Refused : a division by the constant 0, or a number or graph that is too large.
    """

    def __init__(self) -> None:
        self.nodes: list[Node] = []
        self._numbers: dict[Node, int] = {}
        self._partial: set[int] = set()

    def __getitem__(self, number: int) -> Node:
        return self.nodes[number]

    def _number(self, node: Node) -> int:
        number = self._numbers.get(node)
        if number is None:
            if len(self.nodes) >= MOST_NODES:
                raise Refused(f"expressions of more than {MOST_NODES} parts")
            number = self._numbers[node] = len(self.nodes)
            self.nodes.append(node)
            if _is_partial(node) or not self._partial.isdisjoint(node.operands):
                self._partial.add(number)
        return number

    def constant(self, value: Fraction | int) -> int:
        exact = Fraction(value)
        if largest_bits(exact) > MOST_BITS:
            raise Refused(f"a number of more than {MOST_BITS} bits")
        return self._number(Node("const", value=exact))

    def value(self, number: int) -> Fraction | None:
        """Return the value of a constant; None for any other node."""
        node = self.nodes[number]
        return node.value if node.op == "const" else None

    def pi(self) -> int:
        return self._number(Node("pi"))

    def variable(self, name: str) -> int:
        return self._number(Node("variable", name=name))

    def add(self, a: int, b: int) -> int:
        x, y = self.value(a), self.value(b)
        if x is not None and y is not None:
            return self.constant(x + y)
        if x == 0:
            return b
        if y == 0:
            return a
        return self._number(Node("add", (a, b)))

    def subtract(self, a: int, b: int) -> int:
        return self.add(a, self.negative(b))

    def negative(self, a: int) -> int:
        return self.multiply(self.constant(-1), a)

    def total(self, terms: Iterable[int]) -> int:
        sum_node = self.constant(0)
        for term in terms:
            sum_node = self.add(sum_node, term)
        return sum_node

    def multiply(self, a: int, b: int) -> int:
        x, y = self.value(a), self.value(b)
        if x is not None and y is not None:
            return self.constant(x * y)
        if (x == 0 and b not in self._partial) or (y == 0 and a not in self._partial):
            return self.constant(0)
        if x == 1:
            return b
        if y == 1:
            return a
        return self.power(a, 2) if a == b else self._number(Node("multiply", (a, b)))

    def divide(self, a: int, b: int) -> int:
        y = self.value(b)
        if y == 0:
            raise Refused("a division by zero")
        if y is not None:
            return self.multiply(a, self.constant(1 / y))
        return self._number(Node("divide", (a, b)))

    def power(self, a: int, exponent: Fraction | int) -> int:
        """Return a^(p/q); a whole power of a constant is computed."""
        p, x = Fraction(exponent), self.value(a)
        if largest_bits(p) > MOST_BITS or max(abs(p.numerator), p.denominator) > MOST_POWER:
            # Python refuses to print a number of more than 4,300 digits.
            words = str(p)[:40] if largest_bits(p) <= MOST_SHOWN else "has too many digits to print"
            raise Refused(f"the exponent {words}; at most {MOST_POWER}, above and below")
        if x == 0 and p <= 0:
            raise Refused("zero to a power that is not positive")
        if p == 0:
            return self.divide(a, a)
        if p == 1:
            return a
        if x in (0, 1):
            return a
        if x is not None and p.denominator == 1:
            if largest_bits(x) * abs(p) > MOST_BITS:
                raise Refused(f"a number of more than {MOST_BITS} bits")
            return self.constant(x ** int(p))
        return self._number(Node("power", (a,), value=p))

    def has_zero_factor(self, number: int) -> bool:
        """Return whether a node is 0/b, or a product with 0 whose other part may be undefined."""
        node = self.nodes[number]
        above = node.operands[:1] if node.op == "divide" else node.operands
        return node.op in ("divide", "multiply") and any(self.value(n) == 0 for n in above)

    def call(self, name: str, a: int) -> int:
        """Return an elementary function; sqrt is the power 1/2."""
        if name == "sqrt":
            return self.power(a, Fraction(1, 2))
        return self._number(Node("call", (a,), name=name))

    def sign(self, a: int) -> int:
        return self._number(Node("sign", (a,)))

    def table(self, name: str, arguments: tuple[int, ...], orders: tuple[int, ...]) -> int:
        return self._number(Node("table", arguments, name=name, orders=orders))

    def below(self, roots: Iterable[int]) -> list[int]:
        """Return all nodes below the given roots, operands before results."""
        visited: set[int] = set()
        stack = list(roots)
        while stack:
            number = stack.pop()
            if number not in visited:
                visited.add(number)
                stack.extend(self.nodes[number].operands)
        return sorted(visited)

    def variables(self, root: int) -> set[str]:
        """Return the names of the variables in a node."""
        nodes = (self.nodes[number] for number in self.below([root]))
        return {node.name for node in nodes if node.op == "variable"}


def _is_partial(node: Node) -> bool:
    if node.op == "power":
        return node.value < 0 or node.value.denominator > 1
    return node.op in ("divide", "table") or (node.op == "call" and node.name in PARTIAL)
