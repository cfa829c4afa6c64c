r"""The LaTeX of derivations as MathML, which browsers typeset without scripts.

latex2mathml converts.  Before it, the LaTeX is written in the subset of commands that it converts
and browsers draw; after it, the result is checked: only elements and attributes of mathematics,
all text escaped, every fraction and script with all its parts.  A formula that does not pass is
refused, so that no formula is shown wrongly.
"""

from __future__ import annotations

import re
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
