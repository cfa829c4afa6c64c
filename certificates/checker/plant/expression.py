"""Text -> node, by a strict grammar; no text is ever executed as code.

    sum      product (("+" | "-") product)*
    product  signed (("*" | "/") signed)*
    signed   ("+" | "-")* power
    power    atom (("^" | "**") signed)?          -x^2 is -(x^2), 2^3^2 is 2^(3^2)
    atom     number | name | name "(" sum ("," sum)* ")" | "(" sum ")"

Numbers are exact decimals; exponents contain only constants.  Length, depth, digits and powers are
bounded, so that no text takes long to read.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from fractions import Fraction

from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.plant.graph import FUNCTIONS, Graph

NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,79}", re.ASCII)
TOKEN = re.compile(
    r"[ \t\n]*(?:((?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)"
    r"|([A-Za-z_][A-Za-z0-9_]*)|(\*\*|[-+*/^(),]))",
    re.ASCII,
)
LONGEST, DEEPEST = 20_000, 60
MOST_DIGITS, MOST_EXPONENT = 400, 100
MOST_DEGREE = 256  # of products and powers, if they were multiplied out


@dataclass(frozen=True)
class Scope:
    """The names that a text may use: name -> node, and table -> number of its arguments."""

    names: Mapping[str, int]
    tables: Mapping[str, int] = field(default_factory=dict)


def read_expression(written: object, graph: Graph, scope: Scope, where: str) -> int:
    """Return the node of a text.

    Raises
    ------
    CertificateError : ``written`` is not a text, has an unknown sign, name or function, a missing
        bracket, an exponent that is not constant, or is too long or too deeply nested.
    """
    if not isinstance(written, str) or len(written) > LONGEST:
        raise CertificateError(f"{where}: an expression of up to {LONGEST} characters is needed")
    try:
        return _Reader(_tokens(written), graph, scope).whole()
    except Refused as error:
        raise CertificateError(f"{where}: {error} (in {written[:60]!a})") from error


def _tokens(written: str) -> list[tuple[str, str]]:
    tokens, position, end = [], 0, len(written.rstrip(" \t\n"))
    while position < end:
        match = TOKEN.match(written, position)
        if match is None:
            raise Refused(f"{written[position : position + 10]!a} stands in no expression")
        kind = ("number", "name", "sign")[(match.lastindex or 0) - 1]
        tokens.append((kind, match.group(match.lastindex or 0)))
        position = match.end()
    return [*tokens, ("end", "")]


def _decimal(written: str) -> Fraction:
    mantissa, _, exponent = written.lower().partition("e")
    if len(mantissa) > MOST_DIGITS or len(exponent) > 4 or abs(int(exponent or 0)) > MOST_EXPONENT:
        raise Refused(f"the number {written[:30]!a} has too many digits")
    return Fraction(written)


class _Reader:
    """One pass over one text; every method returns (node, degree) of a part."""

    def __init__(self, tokens: list[tuple[str, str]], graph: Graph, scope: Scope) -> None:
        self.tokens, self.graph, self.scope = tokens, graph, scope
        self.position = self.depth = 0

    @property
    def sign(self) -> str:
        kind, written = self.tokens[self.position]
        return written if kind == "sign" else ""

    def next(self) -> tuple[str, str]:
        token = self.tokens[self.position]
        self.position += token[0] != "end"
        return token

    def expect(self, sign: str) -> None:
        token = self.next()
        if token != ("sign", sign):
            raise Refused(f"{token[1] or 'the end'!a} stands where {sign!a} is needed")

    def whole(self) -> int:
        node, _ = self.sum()
        if self.tokens[self.position][0] != "end":
            raise Refused(f"{self.tokens[self.position][1]!a} is not expected")
        return node

    def sum(self) -> tuple[int, int]:
        self.depth += 1
        if self.depth > DEEPEST:
            raise Refused(f"more than {DEEPEST} brackets or signs inside one another")
        node, degree = self.product()
        while self.sign in ("+", "-"):
            sign = self.next()[1]
            term, term_degree = self.product()
            work = self.graph.add if sign == "+" else self.graph.subtract
            node, degree = work(node, term), max(degree, term_degree)
        self.depth -= 1
        return node, degree

    def product(self) -> tuple[int, int]:
        node, degree = self.signed()
        while self.sign in ("*", "/"):
            sign = self.next()[1]
            factor, factor_degree = self.signed()
            work = self.graph.multiply if sign == "*" else self.graph.divide
            node, degree = work(node, factor), _bounded(degree + factor_degree)
        return node, degree

    def signed(self) -> tuple[int, int]:
        minus = False
        while self.sign in ("+", "-"):
            minus ^= self.next()[1] == "-"
        node, degree = self.power()
        return (self.graph.negative(node) if minus else node), degree

    def power(self) -> tuple[int, int]:
        base, degree = self.atom()
        if self.sign not in ("^", "**"):
            return base, degree
        self.next()
        self.depth += 1
        if self.depth > DEEPEST:
            raise Refused(f"more than {DEEPEST} powers inside one another")
        exponent = self.graph.value(self.signed()[0])
        self.depth -= 1
        if exponent is None:
            raise Refused("an exponent that is not a number")
        node = self.graph.power(base, exponent)
        return node, _bounded(degree * max(1, -int(-abs(exponent) // 1)))

    def atom(self) -> tuple[int, int]:
        kind, written = self.next()
        if kind == "number":
            return self.graph.constant(_decimal(written)), 0
        if kind == "name" and self.sign == "(":
            return self.called(written), 1
        if kind == "name":
            if written in self.scope.names:
                return self.scope.names[written], 1
            if written == "pi":
                return self.graph.pi(), 1
            raise Refused(f"the name {written[:40]!a} is not known")
        if (kind, written) == ("sign", "("):
            node_and_degree = self.sum()
            self.expect(")")
            return node_and_degree
        raise Refused(f"{written or 'the end'!a} stands where a number or name is needed")

    def called(self, name: str) -> int:
        self.expect("(")
        arguments = [self.sum()[0]]
        while self.sign == ",":
            self.next()
            arguments.append(self.sum()[0])
        self.expect(")")
        argument_count = self.scope.tables.get(name, 1 if name in FUNCTIONS else 0)
        if not argument_count:
            raise Refused(f"the function {name[:40]!a} is not known")
        if len(arguments) != argument_count:
            raise Refused(f"{name} takes {argument_count} argument(s), not {len(arguments)}")
        if name in self.scope.tables:
            return self.graph.table(name, tuple(arguments), (0,) * argument_count)
        return self.graph.call(name, arguments[0])


def _bounded(degree: int) -> int:
    if degree > MOST_DEGREE:
        raise Refused(f"products and powers of a degree above {MOST_DEGREE}")
    return degree
