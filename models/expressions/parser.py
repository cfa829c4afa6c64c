"""Expressions as text -> sympy, by a grammar of our own: nothing in the text is ever executed.

    sum     = product {("+" | "-") product}
    product = signed {("*" | "/") signed}
    signed  = ("+" | "-") signed | power
    power   = atom [("^" | "**") signed]                 right to left: 2^3^2 = 2^(3^2)
    atom    = number | name | name "(" sum {"," sum} ")" | "(" sum ")"

A parser of precedences (Pratt 1973, "Top down operator precedence") with bounds on length, depth
and the size of what powers make, so that no text takes long.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from decimal import Decimal
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

import sympy as sp

from takagi.models.errors import ModelError, did_you_mean
from takagi.models.expressions.lost_parts import PARTIAL, LostPart, lost_parts

if TYPE_CHECKING:
    from takagi.models.splines.table_function import TableFunction


MAX_LENGTH = 4000  # characters
MAX_DIGITS = 40
MAX_EXPONENT = 100  # of ten, in a number
NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
PATTERN = re.compile(
    rf"(?P<number>{NUMBER})|(?P<name>[A-Za-z_][A-Za-z0-9_]*)|(?P<sign>\*\*|[-+*/^(),])"
    r"|(?P<space>\s+)",
    re.ASCII,
)


@dataclass(frozen=True, slots=True)
class Token:
    """A piece of text: ``kind`` is number, name, sign or end; ``start`` counts from 0."""

    kind: str
    text: str
    start: int


def expression_error(text: str, position: int, problem: str) -> ModelError:
    """Return (not raise) an error that names line and column and puts a caret under the place."""
    text_before = text[:position]
    number = text_before.count("\n") + 1
    column = position - (text_before.rfind("\n") + 1)
    line = text.splitlines()[number - 1] if text.strip() else ""
    start = max(0, column - 40)
    excerpt = line[start : column + 40].replace("\t", " ")
    position_text = f"column {column + 1}" if number == 1 else f"line {number}, column {column + 1}"
    return ModelError(f"{position_text}: {problem}\n    {excerpt}\n    {' ' * (column - start)}^")


def tokens_of(text: str) -> list[Token]:
    """Return the tokens, the last of kind ``end``.

    Raises
    ------
    ModelError : an empty or too long text, or a character that no expression has.
    """
    if len(text) > MAX_LENGTH:
        raise ModelError(
            f"the expression has {len(text)} characters, {MAX_LENGTH} are allowed; split it by "
            "writing parts of it as parameters or equations"
        )
    tokens = []
    position = 0
    while position < len(text):
        match = PATTERN.match(text, position)
        if match is None:
            raise expression_error(text, position, _strange(text[position]))
        if match.lastgroup != "space":
            tokens.append(Token(str(match.lastgroup), match.group(), position))
        position = match.end()
    if not tokens:
        raise expression_error(text, 0, "the expression is empty; write 0 for nothing")
    return [*tokens, Token("end", "", len(text.rstrip()))]


def number_of(token: Token, text: str) -> Fraction:
    """Return the decimal of a number token, exactly.

    Raises
    ------
    ModelError : more than 40 digits, or a power of ten beyond 10^100 either way.
    """
    mantissa, _, exponent = token.text.lower().partition("e")
    digits = len(mantissa.replace(".", ""))
    if digits > MAX_DIGITS or len(exponent) > 5 or abs(int(exponent or 0)) > MAX_EXPONENT:
        raise expression_error(
            text,
            token.start,
            f"the number {token.text[:50]} has {digits} digits and exponent {exponent[:20] or 0}; "
            f"at most {MAX_DIGITS} digits and powers of ten to 10^{MAX_EXPONENT} are read",
        )
    return Fraction(Decimal(token.text))


def _strange(letter: str) -> str:
    advice_for = {
        "=": "an expression has no '='; write what stands on its right",
        "[": "use round brackets",
        "]": "use round brackets",
        "'": "derivatives stand on the left: give the state an equation of its own",
        "·": "write '*'",
        "×": "write '*'",
        "−": "write the minus sign '-'",
        "²": "write '^2'",
        "π": "write 'pi'",
        "%": "write a number such as 0.05",
    }
    advice = advice_for.get(
        letter, "names are of the letters a-z, A-Z, digits and _, signs are + - * / ^"
    )
    return f"{letter!r} cannot stand in an expression; {advice}"


FUNCTIONS = {
    "sin": "sin",
    "cos": "cos",
    "tan": "tan",
    "asin": "asin",
    "acos": "acos",
    "atan": "atan",
    "sinh": "sinh",
    "cosh": "cosh",
    "tanh": "tanh",
    "asinh": "asinh",
    "acosh": "acosh",
    "atanh": "atanh",
    "exp": "exp",
    "log": "log",
    "sqrt": "sqrt",
    "abs": "Abs",
    "erf": "erf",
}
"""Name in the text -> name in sympy; each has ball arithmetic (ranges/expression_range.py)."""
RESERVED = frozenset(FUNCTIONS) | {"pi"}
GROWING = frozenset({"exp", "sinh", "cosh"})

MAX_DEPTH = 50  # brackets, signs and powers inside one another
MAX_POWER = 64
MAX_DEGREE = 256  # of products and powers, multiplied out
MAX_BITS = 20_000  # of the numbers, if all were multiplied
MAX_ARGUMENT = 700  # of exp, sinh and cosh of a number: e^709 is the largest float
BINDING = {"+": 1, "-": 1, "*": 2, "/": 2, "^": 4, "**": 4}
SIGN_BINDING = 3  # -x^2 is -(x^2), -x*y is (-x)*y


@dataclass(frozen=True, slots=True)
class Scope:
    """What names may mean: symbols, values of those that are constant, tables as functions."""

    symbols: Mapping[str, sp.Symbol]
    constants: Mapping[sp.Symbol, Fraction] = field(default_factory=dict)
    tables: Mapping[str, type[TableFunction]] = field(default_factory=dict)


def parse_expression(text: str, scope: Scope) -> sp.Expr:
    """Return the sympy expression that the text stands for; numbers are exact decimals.

    ``scope`` : the names that may be used.  Exponents are made of numbers and constants only.

    Raises
    ------
    ModelError : with line, column and a caret: a character, name or function that is not known,
        a bracket or operand that is missing, a table with a wrong number of arguments, a value
        that is not a finite real number, or an expression too long, too deep or too large.

    Not promised: that the expression has a value on a box (1/x is accepted).
    """
    return _Parser(text, scope).whole()


def parsed_with_losses(text: str, scope: Scope) -> tuple[sp.Expr, tuple[LostPart, ...]]:
    """Return the expression, and the parts whose domain it does not show any more.

    Raises
    ------
    ModelError : as ``parse_expression``.
    """
    parser = _Parser(text, scope)
    expression = parser.whole()
    return expression, lost_parts(parser.parts, expression)


class _Sized(NamedTuple):
    """An expression, and bounds on the bits of its numbers and on its degree."""

    expression: sp.Expr
    bits: int
    degree: int
    losses: tuple[int, ...] = ()  # of the parser's, that appear in it


class _Parser:
    """One pass over one text."""

    def __init__(self, text: str, scope: Scope) -> None:
        self.text = text
        self.scope = scope
        self.tokens = tokens_of(text)
        self.position = 0
        self.depth = 0
        self.parts: list[LostPart] = []

    def whole(self) -> sp.Expr:
        parsed = self.operand(0)
        if self.token.kind != "end":
            raise self.error(self.token, self._unexpected(self.token))
        return parsed.expression

    @property
    def token(self) -> Token:
        return self.tokens[self.position]

    def advance(self) -> Token:
        token = self.token
        self.position += 1
        return token

    def error(self, token: Token, problem: str) -> ModelError:
        return expression_error(self.text, token.start, problem)

    def operand(self, binding: int) -> _Sized:
        """Return the longest expression from here whose operators bind more than ``binding``."""
        self.depth += 1
        if self.depth > MAX_DEPTH:
            raise self.error(
                self.token, f"more than {MAX_DEPTH} levels of brackets, signs and powers; split it"
            )
        first = self.prefix()
        while self.token.kind == "sign" and BINDING.get(self.token.text, 0) > binding:
            sign = self.advance()
            # A power takes its exponent from the right, with a sign of its own: 2^-3^2.
            second = self.operand(SIGN_BINDING if sign.text in ("^", "**") else BINDING[sign.text])
            first = self.checked(self.combined(sign, first, second), sign)
        self.depth -= 1
        return first

    def prefix(self) -> _Sized:
        token = self.advance()
        if token.kind == "number":
            value = number_of(token, self.text)
            ratio = value.as_integer_ratio()
            return _Sized(
                sp.Rational(*ratio), sum(number_part.bit_length() for number_part in ratio), 0
            )
        if token.kind == "name":
            return self.call(token) if self.token.text == "(" else self.name(token)
        if token.text in ("+", "-"):
            inner = self.operand(SIGN_BINDING)
            return inner if token.text == "+" else inner._replace(expression=-inner.expression)
        if token.text == "(":
            operand = self.operand(0)
            self.close(token)
            return operand
        raise self.error(token, self._unexpected(token))

    def close(self, opening: Token) -> None:
        if self.token.text != ")":
            token_text = repr(self.token.text) if self.token.kind != "end" else "the end"
            raise self.error(
                self.token,
                f"{token_text} where the bracket opened in column {opening.start + 1} should "
                "close; add ')' or an operator",
            )
        self.advance()

    def name(self, token: Token) -> _Sized:
        if token.text in self.scope.symbols:
            return _Sized(self.scope.symbols[token.text], 0, 1)
        if token.text == "pi":
            return _Sized(sp.pi, 0, 1)
        if token.text in FUNCTIONS or token.text in self.scope.tables:
            raise self.error(token, f"{token.text} is a function; write {token.text}(...)")
        names = [*self.scope.symbols, "pi"]
        raise self.error(
            token,
            f"{token.text!r} is not known{did_you_mean(token.text, names)}; names here are "
            + ", ".join(sorted(names)),
        )

    def call(self, token: Token) -> _Sized:
        opening = self.advance()
        arguments = [self.operand(0)]
        while self.token.text == ",":
            self.advance()
            arguments.append(self.operand(0))
        self.close(opening)
        bits = sum(argument.bits for argument in arguments)
        expressions = [argument.expression for argument in arguments]
        function = self.function(token, expressions)
        inner = tuple(loss for argument in arguments for loss in argument.losses)
        call_losses = self.noted_call(token, expressions, function)
        return self.checked(_Sized(function, bits, 1, (*inner, *call_losses)), token)

    def noted(self, part: LostPart) -> tuple[int, ...]:
        """Keep a part that has no value somewhere; nothing for one of a number."""
        if part.argument.is_number:
            return ()
        self.parts.append(part)
        return (len(self.parts) - 1,)

    def noted_call(
        self, token: Token, arguments: list[sp.Expr], result: sp.Expr
    ) -> tuple[int, ...]:
        name, table = token.text, self.scope.tables.get(token.text)
        if table is not None:
            from takagi.models.splines.table_function import table_ranges

            sides = zip(arguments, table_ranges(table.table), strict=True)
            noted = [self.noted(LostPart(name, a, result, token.start, side)) for a, side in sides]
            return tuple(loss for numbers in noted for loss in numbers)
        if name == "sqrt":
            return self.noted(LostPart("root", arguments[0], result, token.start))
        if name in PARTIAL:
            return self.noted(LostPart(name, arguments[0], result, token.start))
        return ()

    def idle(self, *operands: _Sized) -> None:
        """Note that what appears in these operands is multiplied by 0."""
        for loss in (loss for operand in operands for loss in operand.losses):
            self.parts[loss] = replace(self.parts[loss], idle=True)

    def function(self, token: Token, arguments: list[sp.Expr]) -> sp.Expr:
        table = self.scope.tables.get(token.text)
        if table is None and token.text not in FUNCTIONS:
            names = [*FUNCTIONS, *self.scope.tables]
            variable = token.text in self.scope.symbols
            advice = (
                f"; {token.text} is a variable or parameter: write {token.text}*(...)"
                if variable
                else f"{did_you_mean(token.text, names)}; functions are {', '.join(sorted(names))}"
            )
            raise self.error(token, f"{token.text!r} is not a function{advice}")
        argument_count = 1 if table is None else len(table.orders)
        if len(arguments) != argument_count:
            raise self.error(
                token,
                f"{token.text} takes {argument_count} argument(s), {len(arguments)} are given",
            )
        if table is not None:
            return table(*arguments)
        if token.text in GROWING and arguments[0].is_number:
            if abs(float(arguments[0])) > MAX_ARGUMENT:
                raise self.error(
                    token, f"{token.text} of a number beyond {MAX_ARGUMENT} is too large"
                )
        return getattr(sp, FUNCTIONS[token.text])(*arguments)

    def combined(self, sign: Token, first: _Sized, second: _Sized) -> _Sized:
        a, b = first.expression, second.expression
        bits, degree = first.bits + second.bits, first.degree + second.degree
        losses = first.losses + second.losses
        if sign.text in ("+", "-"):
            total = a + b if sign.text == "+" else a - b
            return _Sized(total, bits, max(first.degree, second.degree), losses)
        if sign.text == "*":
            if a == 0 or b == 0:
                self.idle(first, second)
            return _Sized(a * b, bits, degree, losses)
        if sign.text == "/":
            if b == 0:
                raise self.error(sign, "division by zero")
            below = self.noted(LostPart("quotient", b, a / b, sign.start))
            quotient = _Sized(a / b, bits, degree, losses + below)
            if a == 0:
                self.idle(quotient)
            return quotient
        return self.power(sign, first, second)

    def power(self, sign: Token, base: _Sized, exponent: _Sized) -> _Sized:
        value = exponent.expression.subs(self.scope.constants)
        if value.free_symbols:
            names = ", ".join(sorted(str(symbol) for symbol in value.free_symbols))
            raise self.error(
                sign,
                f"the exponent depends on {names}; exponents are numbers or parameters, write "
                "exp(b*log(a)) for a^b",
            )
        if not value.is_Rational or abs(value) > MAX_POWER:
            raise self.error(
                sign, f"the exponent is {str(value)[:40]}; a rational up to {MAX_POWER} is needed"
            )
        times = max(1, -(-abs(int(value.p)) // int(value.q)))
        bits, degree = (base.bits + exponent.bits) * times, base.degree * times
        self.check_size(bits, degree, sign)  # before the power is worked out
        if base.expression == 0 and value <= 0:
            raise self.error(sign, f"0^{value} is not a number")
        result, losses = base.expression**exponent.expression, base.losses + exponent.losses
        if value.q > 1:
            losses += self.noted(LostPart("root", base.expression, result, sign.start))
        elif value <= 0:
            losses += self.noted(LostPart("quotient", base.expression, result, sign.start))
        return _Sized(result, bits, degree, losses)

    def checked(self, sized: _Sized, token: Token) -> _Sized:
        """Refuse what is too large, or a number that is not finite and real."""
        self.check_size(sized.bits, sized.degree, token)
        if sized.expression.has(sp.zoo, sp.nan, sp.oo, -sp.oo, sp.I):
            bent = sized.expression.has(sp.I)
            why = "takes a root or logarithm of what is negative" if bent else "divides by 0"
            raise self.error(token, f"this is not a finite real number: it {why}; correct it")
        if sized.expression.is_number and sized.expression.is_real is False:
            raise self.error(token, f"{sized.expression} is not a real number")
        return sized

    def check_size(self, bits: int, degree: int, token: Token) -> None:
        if bits > MAX_BITS or degree > MAX_DEGREE:
            raise self.error(
                token,
                f"up to here the expression has degree {degree} and numbers of {bits} bits; at "
                f"most {MAX_DEGREE} and {MAX_BITS} are worked with, lower the powers",
            )

    @staticmethod
    def _unexpected(token: Token) -> str:
        if token.kind == "end":
            return "the expression ends where a number, name or bracket is needed"
        if token.kind in ("number", "name") or token.text == "(":
            return f"an operator is missing before {token.text!r}; write '*' for a product"
        if token.text == ")":
            return "')' without its opening bracket, or nothing before it"
        return f"{token.text!r} where a number, name or bracket is needed"
