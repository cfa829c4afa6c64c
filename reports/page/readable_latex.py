r"""A derivation's LaTeX made readable: names as words, coefficients of many digits shortened.

sympy writes the symbol ``angle`` as ``angle``, which TeX sets as the product of five letters, and
exact coefficients as fractions of any length.  Nothing else is changed.
"""

from __future__ import annotations

import re
from fractions import Fraction

# An integer of more digits than this is written as a decimal with SHOWN significant digits.
LONGEST = 9
SHOWN = 6

# Words and commands that stay, or a name.
WORD = re.compile(
    r"\\(?:begin|end|operatorname|mathrm|mathit|text)\*?\{[^{}]*\}(?:\{[c|lr]+\})?"
    r"|\\[^A-Za-z]|\\[A-Za-z]+|(?P<name>[A-Za-z]{2,})"
)
# What sympy makes of a symbol with such a name: a plant's name is set as it is written.
SIGN_OF_A_NAME = re.compile(
    r"\\(aleph|beth|daleth|gimel|eth|hbar|hslash|mho|varkappa|varpi|varsigma|wp)(?![A-Za-z])"
)
# The space of a product beside a name.
BEFORE = re.compile(r"((?<![\\A-Za-z])[A-Za-z0-9]|[})\]]) (?=\\mathit)")
AFTER = re.compile(
    r"(\\mathit\{\w+\}(?:[_^]\{[^{}]*\})*) "
    r"(?=[A-Za-z0-9(]|\\(?!(?:leq?|geq?|q?quad|right|end|hline|cdot|in)\b)[A-Za-z])"
)
EXPONENT = re.compile(r"(?<=\d)e([+-]\d+)")
LEADING = re.compile(r"(\d+)\s*(?:\\cdot\s*)?(.*)", re.DOTALL)


def readable(latex: str) -> str:
    r"""Return the LaTeX with ``\mathit{...}`` around names, and long fractions as decimals.

    A coefficient with more than nine digits is rounded to six significant ones: the formula is
    then for reading, the certificate has the exact one.  Fractions are set at full size, and rows
    of matrices with fractions further apart.
    """
    latex = SIGN_OF_A_NAME.sub(r"\1", latex)
    return _displayed(_named(EXPONENT.sub(_power, _shortened(latex))))


def shortens(latex: str) -> bool:
    """Return whether ``readable`` rounds a coefficient of this formula."""
    return _shortened(latex) != latex


def _named(latex: str) -> str:
    named = WORD.sub(lambda word: rf"\mathit{{{word['name']}}}" if word["name"] else word[0], latex)
    # Two names side by side would read as one.
    return BEFORE.sub(r"\1\, ", AFTER.sub(r"\1\, ", named))


def _power(exponent: re.Match[str]) -> str:
    return rf" \cdot 10^{{{int(exponent[1])}}}"


def _displayed(latex: str) -> str:
    if r"\frac" not in latex:
        return latex
    return latex.replace(r"\frac", r"\dfrac").replace("\\\\", r"\\[4pt]")


def _shortened(latex: str) -> str:
    segments, position = [], 0
    while (start := latex.find(r"\frac{", position)) >= 0:
        above, numerator_end = _group(latex, start + len(r"\frac"))
        below, end = _group(latex, numerator_end)
        segments += [latex[position:start], _fraction(_shortened(above), _shortened(below))]
        position = end
    return "".join(segments) + latex[position:]


def _group(latex: str, start: int) -> tuple[str, int]:
    """Return what the braces that open at ``start`` hold, and the place behind them."""
    depth = 0
    for position in range(start, len(latex)):
        if latex[position] in "{}" and latex[position - 1] != "\\":
            depth += 1 if latex[position] == "{" else -1
            if depth == 0:
                return latex[start + 1 : position], position + 1
    raise ValueError(f"braces that open at character {start + 1} are not closed: {latex}")


def _fraction(above: str, below: str) -> str:
    """Return N c / M as a decimal times the cofactor c where N or M is long, else the fraction."""
    fraction = rf"\frac{{{above}}}{{{below}}}"
    leading = LEADING.fullmatch(above)
    number, cofactor = (leading[1], leading[2]) if leading else ("1", above)
    if not below.isdecimal() or max(len(number), len(below)) <= LONGEST or _is_sum(cofactor):
        return fraction
    factor = _decimal(Fraction(int(number), int(below)))
    return f"{factor} {cofactor}".rstrip()


def _is_sum(latex: str) -> bool:
    """Return whether terms are added outside of all brackets."""
    depth = 0
    for sign in re.findall(r"\\left|\\right|[{}+\-]", latex):
        depth += {r"\left": 1, "{": 1, r"\right": -1, "}": -1}.get(sign, 0)
        if sign in "+-" and depth == 0:
            return True
    return False


def _decimal(value: Fraction) -> str:
    text = f"{float(value):.{SHOWN}g}"
    if "e" not in text:
        return text
    mantissa, exponent = text.split("e")
    return rf"{mantissa} \cdot 10^{{{int(exponent)}}}"
