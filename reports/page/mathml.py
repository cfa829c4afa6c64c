r"""The LaTeX of derivations as MathML, which browsers typeset without scripts.

latex2mathml converts.  Before it, the LaTeX is written in the subset of commands that it converts
and browsers draw; after it, the result is checked: only elements and attributes of mathematics,
all text escaped, every fraction and script with all its parts.  A formula that does not pass is
refused, so that no formula is shown wrongly.

Names become words and coefficients of many digits are shortened before that: sympy writes the
symbol ``angle`` as ``angle``, which TeX sets as the product of five letters, and exact coefficients
as fractions of any length.  Nothing else is changed.
"""

from __future__ import annotations

import re
from fractions import Fraction
from html import unescape
from xml.etree import ElementTree

from takagi.models.errors import ModelError
from takagi.reports.page.text import powers

ENVIRONMENTS = frozenset({"pmatrix", "bmatrix", "matrix", "array", "cases", "gathered"})
ENVIRONMENT = re.compile(r"\\begin\{([^{}]*)\}")
# Not converted: the distance behind the end of a row; a function's space; escapes in words.
DISTANCE = re.compile(r"\\\\\[[^\[\]]*\]")
FUNCTION = re.compile(
    r"(?<=[\w)}|]) *(?=\\(?:sin|cos|tan|sec|csc|cot|log|exp|arc|ln|operatorname))"
)
ESCAPE = re.compile(r"\\(?=[_&%#$ ])|\\,")
WORDS = re.compile(r"\\(mathit|mathrm|text|operatorname)\{([^{}]*)\}")
# Element -> how many parts it has; None stands for any number.
PARTS = {
    "math": None, "semantics": 2, "mrow": None, "mi": 0, "mn": 0, "mo": 0, "mtext": 0, "mspace": 0,
    "mstyle": None, "mfrac": 2, "msqrt": None, "mroot": 2, "msub": 2, "msup": 2, "msubsup": 3,
    "munder": 2, "mover": 2, "munderover": 3, "mtable": None, "mtr": None, "mtd": None,
}  # fmt: skip
ATTRIBUTES = frozenset(
    "xmlns display displaystyle scriptlevel mathvariant class stretchy fence form accent width "
    "columnalign columnlines rowlines movablelimits lspace rspace".split()
)


def mathml(latex: str, *, block: bool = True) -> str:
    r"""Return ``<math>...</math>`` of a formula without dollars around it.

    Parameters
    ----------
    block : whether it stands on a line of its own.

    The LaTeX itself goes with it as an annotation, to be copied.

    Raises
    ------
    ModelError : a command or an environment that is not converted, or brackets that do not pair.
    """
    # Imported here: it reads a table of all signs of mathematics.
    from latex2mathml.converter import convert_to_element

    unknown = set(ENVIRONMENT.findall(latex)) - ENVIRONMENTS
    if unknown:
        raise _refusal(latex, f"the environment {unknown.pop()} is not converted")
    if not _braces_pair(latex):
        raise _refusal(latex, "its braces do not pair")
    display = "block" if block else "inline"
    try:
        converted = convert_to_element(_plain(latex), display=display)
    except Exception as error:  # The library has a class for each mistake, and no common one.
        raise _refusal(latex, type(error).__name__) from error
    for element in converted.iter():
        _check(element, latex)
    root = ElementTree.Element("math", {"display": display} if block else {})
    semantics = ElementTree.SubElement(root, "semantics")
    semantics.extend(converted)
    note = ElementTree.SubElement(semantics, "annotation", encoding="application/x-tex")
    note.text = latex
    return ElementTree.tostring(root, encoding="unicode", short_empty_elements=False)


def _plain(latex: str) -> str:
    """Return the LaTeX with names as words, a space before functions, and rows without distance."""
    latex = DISTANCE.sub(r"\\\\", latex).replace(r"\dfrac", r"\frac")
    latex = latex.replace(r"\begin{gathered}", r"\begin{array}{c}")
    latex = latex.replace(r"\end{gathered}", r"\end{array}")
    return WORDS.sub(_words, FUNCTION.sub(r"\\, ", latex))


def _words(group: re.Match[str]) -> str:
    text = rf"\text{{{powers(ESCAPE.sub('', group[2]))}}}"
    return rf"\class{{name}}{{{text}}}" if group[1] == "mathit" else text


def _check(element: ElementTree.Element, latex: str) -> None:
    """Make an element's text plain and its accent low; raise ModelError for what is no formula."""
    element.text = unescape(element.text or "")
    if element.tag not in PARTS or not ATTRIBUTES.issuperset(element.attrib):
        raise _refusal(latex, f"{element.tag} with {', '.join(element.attrib)} is no formula")
    if element.text.startswith("\\") or element.text in ("&", "}"):
        raise _refusal(latex, f"{element.text} is not converted")
    if PARTS[element.tag] not in (None, len(element)):
        raise _refusal(
            latex, f"{element.tag} has {len(element)} parts, {PARTS[element.tag]} needed"
        )
    if element.tag == "mover" and element[1].tag == "mo":
        element.set("accent", "true")


def _braces_pair(latex: str) -> bool:
    depth = 0
    for brace in re.findall(r"(?<!\\)(?:\\\\)*([{}])", latex):
        depth += 1 if brace == "{" else -1
        if depth < 0:
            return False
    return depth == 0


def _refusal(latex: str, words: str) -> ModelError:
    return ModelError(f"formula {latex!r}: {words}; it cannot be set as MathML")


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
    latex = EXPONENT.sub(lambda power: rf" \cdot 10^{{{int(power[1])}}}", _shortened(latex))
    latex = WORD.sub(lambda word: rf"\mathit{{{word['name']}}}" if word["name"] else word[0], latex)
    # Two names side by side would read as one.
    latex = BEFORE.sub(r"\1\, ", AFTER.sub(r"\1\, ", latex))
    if r"\frac" in latex:
        latex = latex.replace(r"\frac", r"\dfrac").replace("\\\\", r"\\[4pt]")
    return latex


def shortens(latex: str) -> bool:
    """Return whether ``readable`` rounds a coefficient of this formula."""
    return _shortened(latex) != latex


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
