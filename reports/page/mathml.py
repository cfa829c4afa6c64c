r"""The LaTeX of derivations as MathML, which browsers typeset without scripts.

Supported is the subset of LaTeX that derivations use: fractions, roots, indices,
brackets of any height, accents, functions, Greek letters, ``pmatrix``, ``array``, ``gathered``,
``cases``.  A formula with any other command is refused, so that no formula is shown wrongly.

Source: MathML Core, W3C (2025): elements and what browsers make of them (recalled).
"""

from __future__ import annotations

import re
from html import escape

from takagi.models.errors import ModelError
from takagi.reports.page.mathml_signs import ACCENTS, FUNCTIONS, LETTERS, SIGNS, SPACES, WORDS
from takagi.reports.page.text import powers

TOKEN = re.compile(r"\\[A-Za-z]+\*?|\\.|\d+(?:\.\d+)?|\s+|.", re.DOTALL)
# Elements that enlarge the brackets around them.
TALL = ("<mfrac", "<mtable", "<munder", "<msqrt", "<mroot")
FENCES = {r"\{": "{", r"\}": "}", r"\|": "‖", "|": "|", ".": ""}
# Environment -> the fences around its table.
TABLES = {
    "pmatrix": ("(", ")"),
    "bmatrix": ("[", "]"),
    "matrix": ("", ""),
    "array": ("", ""),
    "gathered": ("", ""),
    "aligned": ("", ""),
    "cases": ("{", ""),
}


def mathml(latex: str, *, block: bool = True) -> str:
    r"""Return ``<math>...</math>`` of a formula without dollars around it.

    Parameters
    ----------
    block : whether it stands on a line of its own.

    The LaTeX itself goes with it as an annotation, to be copied.

    Raises
    ------
    ModelError : a command or an environment that is not read, or brackets that do not pair.
    """
    reader = _Reader(latex)
    body = reader.row(frozenset())
    if reader.peek():
        raise reader.error(f"{reader.peek()} closes nothing")
    display = ' display="block"' if block else ""
    note = f'<annotation encoding="application/x-tex">{escape(latex)}</annotation>'
    return f"<math{display}><semantics>{body}{note}</semantics></math>"


class _Reader:
    """Reads the tokens of one formula from left to right."""

    def __init__(self, latex: str) -> None:
        self.latex = latex
        self.tokens = TOKEN.findall(latex)
        self.place = 0

    def error(self, words: str) -> ModelError:
        return ModelError(f"formula {self.latex!r}: {words}; it cannot be set as MathML")

    def peek(self) -> str:
        while self.place < len(self.tokens) and self.tokens[self.place].isspace():
            self.place += 1
        return self.tokens[self.place] if self.place < len(self.tokens) else ""

    def take(self) -> str:
        token = self.peek()
        if not token:
            raise self.error("it ends where more is needed")
        self.place += 1
        return token

    def row(self, ends: frozenset[str]) -> str:
        """Return all up to one of ``ends`` (not taken), ``}``, ``\\right`` or the end."""
        parts: list[str] = []
        while (token := self.peek()) and token not in ends and token not in ("}", r"\right"):
            if token in FUNCTIONS and parts and not parts[-1].endswith(("</mo>", "</mspace>")):
                parts.append('<mspace width="0.167em"></mspace>')
            parts.append(self.scripted())
        whole = "".join(parts)
        return whole if len(parts) == 1 else f"<mrow>{whole}</mrow>"

    def scripted(self) -> str:
        """Return one thing with what is raised and lowered beside it."""
        limits = self.peek() in (r"\sum", r"\prod")
        base = self.atom()
        below = above = ""
        while self.peek() in ("_", "^"):
            if self.take() == "_":
                below = self.argument()
            else:
                above = self.argument()
        if not below and not above:
            return base
        if limits:
            return _scripts(base, below, above, ("munder", "mover", "munderover"))
        return _scripts(base, below, above, ("msub", "msup", "msubsup"))

    def argument(self) -> str:
        """Return a group in braces, or the one thing that stands there without."""
        if self.peek() != "{":
            return self.atom()
        self.take()
        inside = self.row(frozenset())
        if self.take() != "}":
            raise self.error("a brace is not closed")
        return inside

    def atom(self) -> str:
        token = self.peek()
        if token == "{":
            return self.argument()
        self.take()
        if token[0].isdigit():
            return f"<mn>{token}</mn>"
        if token[0] != "\\" and token not in "_^&":
            return _letter_or_sign(token)
        if token in (r"\frac", r"\dfrac"):
            return f"<mfrac>{self.argument()}{self.argument()}</mfrac>"
        if token == r"\sqrt":
            return self.root()
        if token == r"\left":
            return self.fenced()
        if token == r"\begin":
            return self.table()
        if token in WORDS:
            return WORDS[token].format(self.words())
        return self.command(token)

    def command(self, token: str) -> str:
        if token in LETTERS:
            return f"<mi>{LETTERS[token]}</mi>"
        if token in FUNCTIONS:
            return f"<mi>{FUNCTIONS[token]}</mi><mo>&#x2061;</mo>"
        if token in SIGNS:
            return f"<mo>{escape(SIGNS[token])}</mo>"
        if token in SPACES:
            return f'<mspace width="{SPACES[token]}em"></mspace>'
        if token in ACCENTS:
            accent = f'<mo stretchy="false">{ACCENTS[token]}</mo>'
            return f'<mover accent="true">{self.argument()}{accent}</mover>'
        raise self.error(f"{token} is not read")

    def root(self) -> str:
        if self.peek() != "[":
            return f"<msqrt>{self.argument()}</msqrt>"
        self.take()
        index = self.row(frozenset("]"))
        self.take()
        return f"<mroot>{self.argument()}{index}</mroot>"

    def fenced(self) -> str:
        opening = self.take()
        inside = self.row(frozenset())
        if self.peek() != r"\right":
            raise self.error(rf"\left{opening} has no \right")
        self.take()
        tall = any(tag in inside for tag in TALL)
        return f"<mrow>{_fence(opening, tall)}{inside}{_fence(self.take(), tall)}</mrow>"

    def words(self) -> str:
        """Return the letters of a group as they stand, for text and upright names."""
        if self.take() != "{":
            raise self.error("words in braces are needed")
        start = self.place
        while self.take() != "}":
            pass
        return escape(powers("".join(self.tokens[start : self.place - 1]).replace("\\", "")))

    def table(self) -> str:
        name = self.words()
        if name not in TABLES:
            raise self.error(f"the environment {name} is not read")
        opening, closing = TABLES[name]
        columns = self.words() if name == "array" else ""
        rows: list[list[str]] = [[]]
        ruled: set[int] = set()
        while True:
            while self.peek() == r"\hline":
                self.take()
                ruled.add(len(rows) - 1)
            if self.peek() == r"\end":
                break
            rows[-1].append(self.row(frozenset({"&", r"\\", r"\end"})))
            if self.peek() not in ("&", r"\\", r"\end"):
                raise self.error(f"{name} is not ended")
            if self.peek() != r"\end" and self.take() == r"\\":
                rows.append([])
                self.skip_distance()
        self.take()
        self.words()
        body = "".join(_row(row, columns, k in ruled) for k, row in enumerate(rows) if row)
        table = f'<mtable class="{name}">{body}</mtable>'
        if not opening and not closing:
            return table
        return f"<mrow>{_fence(opening, True)}{table}{_fence(closing, True)}</mrow>"

    def skip_distance(self) -> None:
        """Pass over the ``[4pt]`` that may follow the end of a row."""
        if self.peek() == "[":
            while self.take() != "]":
                pass


def _row(cells: list[str], columns: str, ruled: bool) -> str:
    """Return a row; ``columns`` is TeX's, with a bar where a line stands before a column."""
    bars = {len(columns[:k].replace("|", "")) for k, c in enumerate(columns) if c == "|"}
    shown = []
    for number, cell in enumerate(cells):
        names = [name for name, on in (("ruled", ruled), ("bar", number in bars)) if on]
        mark = f' class="{" ".join(names)}"' if names else ""
        shown.append(f"<mtd{mark}>{cell}</mtd>")
    return f"<mtr>{''.join(shown)}</mtr>"


def _scripts(base: str, below: str, above: str, names: tuple[str, str, str]) -> str:
    name = names[2] if below and above else names[0] if below else names[1]
    # A function's name ends with the invisible sign of application: scripts belong to the name.
    applied = "<mo>&#x2061;</mo>"
    after = applied if base.endswith(applied) else ""
    return f"<{name}>{base.removesuffix(applied)}{below}{above}</{name}>{after}"


def _fence(token: str, tall: bool) -> str:
    sign = FENCES.get(token, token)
    tight = 'lspace="0" rspace="0"'
    stretchy = "true" if tall else "false"
    return f'<mo stretchy="{stretchy}" {tight}>{escape(sign)}</mo>' if sign else ""


def _letter_or_sign(token: str) -> str:
    if token.isalpha():
        return f"<mi>{token}</mi>"
    if token == "'":
        return "<mo>&#x2032;</mo>"
    sign = "\u2212" if token == "-" else token
    plain = ' stretchy="false"' if token in "()[]|/" else ""
    return f"<mo{plain}>{escape(sign)}</mo>"
