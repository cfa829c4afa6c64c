"""The text of an expression, cut into tokens: numbers, names and signs."""

from __future__ import annotations

import re
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction

from takagi.models.errors import ModelError

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
