"""Expressions of plant files as trees; no text from a file is ever executed as code.

Precedence climbing: ``+ -`` bind weakest, then ``* /``, then signs, then ``^`` (also written
``**``), which groups to the right and takes a constant exponent.  A tree is a tuple:

    ("number", q)  ("name", text)  ("+", a, b)  ("*", a, b)  ("/", a, b)  ("^", a, q)
    ("call", name, (a, ...))

Sums with 0 and products with 0 or 1 are simplified.  A product with 0 stays where the other factor
may be undefined: 0 log(x) is not 0 everywhere.  For the same reason a^0 is read as a/a.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any, TypeAlias

from flint import fmpq

from takagi.certificates.cross_check.kernel.reading import Refusal, Written

Tree: TypeAlias = tuple[Any, ...]
PIECE = re.compile(
    r"\s*(?:(?P<number>(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)|(?P<name>[A-Za-z_]\w*)"
    r"|(?P<sign>\*\*|[-+*/^(),]))",
    re.ASCII,
)
LONGEST, DEEPEST, LARGEST_POWER, MOST_BITS = 20_000, 60, 64, 100_000
# Functions that are defined for every real argument.
EVERYWHERE = frozenset("sin cos exp sinh cosh tanh atan asinh abs erf sign".split())
BINDING = {"+": 1, "-": 1, "*": 2, "/": 2}


def number(value: fmpq | int) -> Tree:
    return ("number", fmpq(value))


def plus(a: Tree, b: Tree) -> Tree:
    return a if b == number(0) else b if a == number(0) else ("+", a, b)


def times(a: Tree, b: Tree) -> Tree:
    if number(0) in (a, b) and not _may_fail(b if a == number(0) else a):
        return number(0)
    return a if b == number(1) else b if a == number(1) else ("*", a, b)


def _may_fail(tree: Tree) -> bool:
    """Return whether a part of a tree may be undefined somewhere; a table may be."""
    kind = tree[0]
    if kind in ("number", "name"):
        return False
    if kind == "/":
        return True
    if kind == "^":
        return bool(tree[2] < 0 or tree[2].q > 1) or _may_fail(tree[1])
    if kind == "call":
        return tree[1] not in EVERYWHERE or any(map(_may_fail, tree[2]))
    return _may_fail(tree[1]) or _may_fail(tree[2])


def minus(a: Tree) -> Tree:
    return times(number(-1), a)


def parsed(written: object, constants: Mapping[str, Tree] | None = None) -> Tree:
    """Return the tree of a text, or of a number; ``constants`` may stand in exponents.

    Raises
    ------
    Refusal : ``written`` is neither, is not an expression, or is too long or too deeply nested.
    """
    if isinstance(written, Written):
        return number(_decimal(written))
    if not isinstance(written, str) or len(written) > LONGEST:
        raise Refusal("an expression is needed")
    pieces, place, text = [], 0, written.rstrip()
    while place < len(text):
        found = PIECE.match(text, place)
        if found is None:
            raise Refusal(f"{text[place : place + 8]!a} stands in no expression")
        pieces.append((found.lastgroup or "", found.group(found.lastgroup or 0)))
        place = found.end()
    pieces.append(("end", ""))
    reader = _Pieces(pieces, constants or {})
    tree = reader.above(0, 0)
    if reader.now[0] != "end":
        raise Refusal(f"{reader.now[1]!a} is not expected")
    return tree


def _decimal(written: str) -> fmpq:
    mantissa, _, power = written.lower().partition("e")
    if len(mantissa) > 400 or abs(int(power or 0)) > 100:
        raise Refusal("a number of too many digits")
    head, _, tail = mantissa.partition(".")
    return fmpq(int((head + tail) or "0"), 1) * fmpq(10) ** (int(power or 0) - len(tail))


class _Pieces:
    """The pieces of one text, read from left to right."""

    def __init__(self, pieces: list[tuple[str, str]], constants: Mapping[str, Tree]) -> None:
        self.pieces, self.place, self.constants = pieces, 0, constants

    @property
    def now(self) -> tuple[str, str]:
        return self.pieces[self.place]

    def take(self, sign: str = "") -> str:
        kind, text = self.now
        if sign and (kind, text) != ("sign", sign):
            raise Refusal(f"{text or 'the end'!a} stands where {sign!a} is needed")
        self.place += kind != "end"
        return text

    def above(self, binding: int, depth: int) -> Tree:
        """Return the longest tree from here whose operators bind more strongly than ``binding``."""
        if depth > DEEPEST:
            raise Refusal("too many brackets or signs inside one another")
        left = self.signed(depth)
        while self.now[0] == "sign" and BINDING.get(self.now[1], 0) > binding:
            sign = self.take()
            right = self.above(BINDING[sign], depth + 1)
            if sign == "-":
                left = plus(left, minus(right))
            else:
                left = {"+": plus, "*": times}.get(sign, _over)(left, right)
        return left

    def signed(self, depth: int) -> Tree:
        negative = False
        while self.now in (("sign", "+"), ("sign", "-")):
            negative ^= self.take() == "-"
        base = self.atom(depth)
        if self.now in (("sign", "^"), ("sign", "**")):
            self.take()
            if depth > DEEPEST:
                raise Refusal("too many powers inside one another")
            power = value_of(put(self.signed(depth + 1), self.constants))
            if power is None or max(abs(power.p), power.q) > LARGEST_POWER:
                raise Refusal("an exponent that is no small rational number")
            if power == 0 and value_of(base) == 0:
                raise Refusal("zero to the power zero")
            base = ("/", base, base) if power == 0 else ("^", base, power)
        return minus(base) if negative else base

    def atom(self, depth: int) -> Tree:
        kind, text = self.now
        self.take()
        if kind == "number":
            return number(_decimal(text))
        if kind == "sign" and text == "(":
            inside = self.above(0, depth + 1)
            self.take(")")
            return inside
        if kind != "name":
            raise Refusal(f"{text or 'the end'!a} stands where a number or name is needed")
        if self.now != ("sign", "("):
            return ("name", text)
        self.take()
        parts = [self.above(0, depth + 1)]
        while self.now == ("sign", ","):
            self.take()
            parts.append(self.above(0, depth + 1))
        self.take(")")
        return ("call", text, tuple(parts))


def _over(a: Tree, b: Tree) -> Tree:
    return ("/", a, b)


def value_of(tree: Tree) -> fmpq | None:
    """Return the rational value of a tree without names; None where no rational value is found.

    Raises
    ------
    Refusal : a division by zero.
    """
    if tree[0] == "number":
        return fmpq(tree[1])
    if tree[0] in ("+", "*", "/"):
        a, b = value_of(tree[1]), value_of(tree[2])
        if a is None or b is None:
            return None
        if tree[0] == "/" and b == 0:
            raise Refusal("a division by zero")
        return a + b if tree[0] == "+" else a * b if tree[0] == "*" else a / b
    if tree[0] == "^" and tree[2].q == 1:
        a = value_of(tree[1])
        if a == 0 and tree[2] < 0:
            raise Refusal("a division by zero")
        if a is None:
            return None
        power = int(tree[2].p)
        if abs(power) * max(int(a.p).bit_length(), int(a.q).bit_length()) > MOST_BITS:
            raise Refusal("a number of too many digits")
        return a**power
    return None


def put(tree: Tree, meaning: Mapping[str, Tree]) -> Tree:
    """Return the tree with names replaced; other names stay."""
    if tree[0] == "name":
        return meaning.get(tree[1], tree)
    if tree[0] == "+":
        return plus(put(tree[1], meaning), put(tree[2], meaning))
    if tree[0] == "*":
        return times(put(tree[1], meaning), put(tree[2], meaning))
    if tree[0] == "/":
        return ("/", put(tree[1], meaning), put(tree[2], meaning))
    if tree[0] == "^":
        return ("^", put(tree[1], meaning), tree[2])
    if tree[0] == "call":
        return ("call", tree[1], tuple(put(part, meaning) for part in tree[2]))
    return tree


def names_in(tree: Tree) -> Iterator[str]:
    """Yield the names in a tree; a name that occurs twice is yielded twice."""
    if tree[0] == "name":
        yield tree[1]
    elif tree[0] == "call":
        for part in tree[2]:
            yield from names_in(part)
    else:
        for part in tree[1:]:
            if isinstance(part, tuple):
                yield from names_in(part)
