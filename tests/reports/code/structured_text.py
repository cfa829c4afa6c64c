"""A small interpreter of IEC 61131-3's Structured Text, from the standard, for tests alone."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from typing import Any

TOKEN = re.compile(
    r"\s*(?:(?P<number>\d+(?:\.\d+)?(?:E[+-]?\d+)?)|(?P<word>[A-Za-z_]\w*)"
    r"|(?P<sign>:=|<=|>=|<>|\*\*|\.\.|[-+*/()\[\],;:=<>]))",
    re.IGNORECASE,
)
FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    "ABS": abs, "SQRT": math.sqrt, "EXP": math.exp, "LN": math.log, "SIN": math.sin,
    "COS": math.cos, "TAN": math.tan, "ASIN": math.asin, "ACOS": math.acos, "ATAN": math.atan,
    "MIN": min, "MAX": max, "EXPT": math.pow, "SEL": lambda g, a, b: b if g else a,
}  # fmt: skip
BINDING = {"OR": 1, "AND": 2, "=": 3, "<>": 3, "<": 4, ">": 4, "<=": 4, ">=": 4,
           "+": 5, "-": 5, "*": 6, "/": 6}  # fmt: skip

Run = Callable[[dict[str, Any]], Any]


class _Exit(Exception):
    pass


class FunctionBlock:
    """Variables by their names in capitals, arrays as dicts by index; ``call`` runs it once."""

    def __init__(self, text: str) -> None:
        plain = re.sub(r"\(\*.*?\*\)", " ", text, flags=re.DOTALL)
        self._tokens = list(_tokens(plain))
        self._at = 0
        self.values: dict[str, Any] = {}
        self.constants: set[str] = set()
        self.inputs: list[str] = []
        self.outputs: list[str] = []
        self._take("FUNCTION_BLOCK")
        self.name = self._next()
        while self._peek().startswith("VAR"):
            self._declarations()
        self._body = self._statements("END_FUNCTION_BLOCK")
        self._take("END_FUNCTION_BLOCK")
        assert self._at == len(self._tokens)

    def call(self, **inputs: Any) -> dict[str, float]:
        for name, value in inputs.items():
            assert name.upper() in self.inputs, name
            self.values[name.upper()] = value
        self._body(self.values)
        return {name: self.values[name] for name in self.outputs}

    # ------------------------------------------------------------ tokens

    def _peek(self) -> str:
        return self._tokens[self._at] if self._at < len(self._tokens) else ""

    def _next(self) -> str:
        self._at += 1
        return self._tokens[self._at - 1]

    def _take(self, *wanted: str) -> None:
        for one in wanted:
            found = self._next()
            assert found == one, f"{found} stands where {one} is needed"

    # ------------------------------------------------------------ declarations

    def _declarations(self) -> None:
        kind = self._next()
        constant = self._peek() == "CONSTANT"
        if constant:
            self._next()
        while self._peek() != "END_VAR":
            name = self._next()
            assert name not in self.values, f"{name} is declared twice"
            self._take(":")
            self.values[name] = self._type()
            if constant:
                self.constants.add(name)
            if kind == "VAR_INPUT":
                self.inputs.append(name)
            elif kind == "VAR_OUTPUT":
                self.outputs.append(name)
        self._take("END_VAR")

    def _type(self) -> Any:
        start: Any
        if self._peek() == "ARRAY":
            self._take("ARRAY", "[")
            ends = [self._range()]
            while self._peek() == ",":
                self._next()
                ends.append(self._range())
            self._take("]", "OF")
            whole = self._next() == "INT"
            places: list[Any] = [()]
            for low, high in ends:
                places = [(*one, k) for one in places for k in range(low, high + 1)]
            start = dict.fromkeys(places, 0 if whole else 0.0)
            if self._peek() == ":=":
                self._take(":=", "[")
                numbers = [self._expression()({})]
                while self._peek() == ",":
                    self._next()
                    numbers.append(self._expression()({}))
                self._take("]")
                start = dict(zip(places, numbers, strict=True))
        else:
            kind = self._next()
            start = {"LREAL": 0.0, "BOOL": False, "INT": 0, "UINT": 0}[kind]
            if self._peek() == ":=":
                self._next()
                start = self._expression()({})
        self._take(";")
        return start

    def _range(self) -> tuple[int, int]:
        low = int(self._next())
        self._take("..")
        return low, int(self._next())

    # ------------------------------------------------------------ statements

    def _statements(self, *ends: str) -> Run:
        found: list[Run] = []
        while self._peek() not in ends:
            found.append(self._statement())

        def run(values: dict[str, Any]) -> None:
            for one in found:
                one(values)

        return run

    def _statement(self) -> Run:
        word = self._peek()
        if word == "IF":
            return self._if()
        if word == "FOR":
            return self._for()
        if word == "WHILE":
            return self._while()
        if word == "EXIT":
            self._take("EXIT", ";")
            return _leave
        return self._assignment()

    def _assignment(self) -> Run:
        name = self._next()
        assert name in self.values, f"{name} is not declared"
        assert name not in self.constants, f"{name} is constant"
        index = self._index() if self._peek() == "[" else None
        self._take(":=")
        value = self._expression()
        self._take(";")

        def run(values: dict[str, Any]) -> None:
            if index is None:
                values[name] = value(values)
            else:
                place = index(values)
                assert place in values[name], f"{name}{place} is outside its array"
                values[name][place] = value(values)

        return run

    def _if(self) -> Run:
        cases: list[tuple[Run, Run]] = []
        while self._peek() in ("IF", "ELSIF"):
            self._next()
            condition = self._expression()
            self._take("THEN")
            cases.append((condition, self._statements("ELSIF", "ELSE", "END_IF")))
        if self._peek() == "ELSE":
            self._next()
            cases.append((lambda _: True, self._statements("END_IF")))
        self._take("END_IF", ";")

        def run(values: dict[str, Any]) -> None:
            for condition, body in cases:
                if condition(values):
                    body(values)
                    return

        return run

    def _for(self) -> Run:
        self._take("FOR")
        name = self._next()
        self._take(":=")
        low = self._expression()
        self._take("TO")
        high = self._expression()
        self._take("DO")
        body = self._statements("END_FOR")
        self._take("END_FOR", ";")

        def run(values: dict[str, Any]) -> None:
            for k in range(low(values), high(values) + 1):
                values[name] = k
                try:
                    body(values)
                except _Exit:
                    return

        return run

    def _while(self) -> Run:
        self._take("WHILE")
        condition = self._expression()
        self._take("DO")
        body = self._statements("END_WHILE")
        self._take("END_WHILE", ";")

        def run(values: dict[str, Any]) -> None:
            while condition(values):
                try:
                    body(values)
                except _Exit:
                    return

        return run

    # ------------------------------------------------------------ expressions

    def _expression(self, least: int = 1) -> Run:
        left = self._operand()
        while BINDING.get(self._peek(), 0) >= least:
            sign = self._next()
            left = _joined(sign, left, self._expression(BINDING[sign] + 1))
        return left

    def _operand(self) -> Run:
        token = self._next()
        if token == "-":
            inner = self._operand()
            return lambda values: -inner(values)
        if token == "NOT":
            inner = self._operand()
            return lambda values: not inner(values)
        if token == "(":
            inner = self._expression()
            self._take(")")
            return inner
        if token[0].isdigit():
            number = float(token) if "." in token else int(token)
            return lambda values: number
        if token in ("TRUE", "FALSE"):
            truth = token == "TRUE"
            return lambda values: truth
        if self._peek() == "(":
            return self._function(token)
        if self._peek() == "[":
            index = self._index()
            return lambda values: values[token][index(values)]
        assert token in self.values, f"{token} is not declared"
        return lambda values: values[token]

    def _function(self, name: str) -> Run:
        function, arguments = FUNCTIONS[name], [self._after("(")]
        while self._peek() == ",":
            arguments.append(self._after(","))
        self._take(")")
        return lambda values: function(*(one(values) for one in arguments))

    def _after(self, sign: str) -> Run:
        self._take(sign)
        return self._expression()

    def _index(self) -> Run:
        parts = [self._after("[")]
        while self._peek() == ",":
            parts.append(self._after(","))
        self._take("]")
        return lambda values: tuple(one(values) for one in parts)


def _leave(values: dict[str, Any]) -> None:
    raise _Exit


def _joined(sign: str, left: Run, right: Run) -> Run:
    """Return an operation; AND and OR compute both sides, as the standard's do."""
    operations: dict[str, Callable[[Any, Any], Any]] = {
        "+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b,
        "/": lambda a, b: a / b, "=": lambda a, b: a == b, "<>": lambda a, b: a != b,
        "<": lambda a, b: a < b, ">": lambda a, b: a > b, "<=": lambda a, b: a <= b,
        ">=": lambda a, b: a >= b, "AND": lambda a, b: bool(a) & bool(b),
        "OR": lambda a, b: bool(a) | bool(b),
    }  # fmt: skip
    operation = operations[sign]
    return lambda values: operation(left(values), right(values))


def _tokens(text: str) -> Iterator[str]:
    at = 0
    while text[at:].strip():
        found = TOKEN.match(text, at)
        assert found is not None, f"not in the standard: {text[at : at + 40]!r}"
        yield found[found.lastgroup or 0].upper()
        at = found.end()
