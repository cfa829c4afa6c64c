"""LaTeX of the appendix: jinja2 for it, and numbers, units and words as LaTeX."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from takagi.certificates.checker.kernel.result import Checked, Verdict
from takagi.models.arrays import Floats
from takagi.models.intervals.interval import exact

if TYPE_CHECKING:
    from jinja2 import Environment
    from matplotlib.figure import Figure


class Tex(str):
    """Text that is LaTeX already and is not escaped again."""

    __slots__ = ()


NONE = Tex("--")

_SPECIAL = {
    "\\": r"\textbackslash{}",
    "{": r"\{",
    "}": r"\}",
    "&": r"\&",
    "%": r"\%",
    # As text it would come from a font that many distributions have as a bitmap only.
    "$": r"$\mathdollar$",
    "#": r"\#",
    "_": r"\_",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
    "|": r"\textbar{}",
    "\n": " ",
    "²": r"\textsuperscript{2}",
    "°": r"$^\circ$",
    "–": "--",
    "−": "$-$",
    "·": r"\textperiodcentered{}",
    "×": r"$\times$",
    "’": "'",
}
_ACCENTS = {"ä": r"\"a", "ö": r"\"o", "ü": r"\"u", "Ä": r"\"A", "Ö": r"\"O", "Ü": r"\"U"}
_ACCENTS |= {"å": r"\aa{}", "Å": r"\AA{}", "é": r"\'e", "è": r"\`e", "ß": r"\ss{}"}
_POWER = re.compile(r"\^(-?\d+)")


def escape(words: object) -> Tex:
    """Return plain words with every character that LaTeX reads as a command written out.

    A character outside ASCII and the tables above loses its accent, or becomes a question mark, so
    that the document compiles with any engine.
    """
    if isinstance(words, Tex):
        return words
    return Tex("".join(_letter(c) for c in str(words)))


def _letter(c: str) -> str:
    command = _SPECIAL.get(c) or _ACCENTS.get(c)
    if command or " " <= c <= "~":
        return command or c
    return unicodedata.normalize("NFKD", c).encode("ascii", "ignore").decode() or "?"


def unit(name: str) -> Tex:
    """Return a unit in upright letters: ``"N m s^2/rad^2"``; empty for a pure number."""
    if name in ("-", ""):
        return Tex("--")
    escaped = escape(name).replace(r"\textasciicircum{}", "^").replace(" ", r"\,")
    return _in_maths(r"\mathrm{" + _POWER.sub(r"^{\1}", escaped) + "}")


def decimal(value: float | int | str | Fraction) -> Tex:
    """Return a number exactly as it is written to the files: its shortest decimal, no exponent.

    Raises ModelError: not a finite number.
    """
    number = exact(value)
    digits = Decimal(number.numerator) / Decimal(number.denominator)
    text = format(digits, "f")
    return _in_maths(text.rstrip("0").rstrip(".") if "." in text else text)


def with_decimals(value: float, decimals: int) -> Tex:
    """Return a number with this many decimals; infinity and NaN as a dash."""
    number = float(value)
    if not math.isfinite(number):
        return Tex(r"\ensuremath{\infty}") if math.isinf(number) else NONE
    text = f"{number:.{decimals}f}"
    return _in_maths(text[1:] if text.startswith("-") and float(text) == 0 else text)


def scientific(value: float, digits: int = 4) -> Tex:
    """Return a number with this many significant digits, with a power of ten far from 1."""
    number = float(value)
    if number == 0 or not math.isfinite(number):
        return with_decimals(number, 0)
    mantissa, power = f"{number:.{digits - 1}e}".split("e")
    if not -4 <= int(power) < 6:
        return _in_maths(rf"{mantissa} \times 10^{{{int(power)}}}")
    text = f"{number:.{digits}g}"
    return _in_maths(f"{float(text):.0f}" if "e" in text else text)


def interval(ends: Sequence[float | Fraction]) -> Tex:
    """Return [low, high], both ends as ``decimal`` writes them."""
    low, high = (decimal(end) for end in ends)
    return _in_maths(rf"[{low},\ {high}]")


def listed(values: Iterable[float | str | Fraction]) -> Tex:
    """Return numbers as ``decimal`` writes them, with commas between."""
    return Tex(",\\ ".join(decimal(value) for value in values))


def range_text(ends: Iterable[float], decimals: int) -> Tex:
    """Return ``low to high`` of some numbers, or one number where both are equal as written."""
    values = [float(v) for v in ends]
    low, high = with_decimals(min(values), decimals), with_decimals(max(values), decimals)
    return low if low == high else Tex(f"{low} to {high}")


def matrix(values: ArrayLike, *, exactly: bool = False, digits: int = 6) -> Tex:
    """Return a two-dimensional array as a ``bmatrix``, for use inside mathematics.

    exactly : every entry as ``decimal`` writes it; otherwise with ``digits`` significant digits.
    """
    import numpy as np

    array: Floats = np.atleast_2d(np.asarray(values, dtype=np.float64))
    write = decimal if exactly else (lambda v: scientific(v, digits))
    rows = [" & ".join(write(float(v)) for v in row) for row in array]
    return Tex(r"\begin{bmatrix} " + r" \\ ".join(rows) + r" \end{bmatrix}")


def _in_maths(text: str) -> Tex:
    """Return a number that is set as mathematics in text as well as in formulas."""
    return Tex(rf"\ensuremath{{{text}}}")


_TEMPLATES = "takagi.reports.appendix.templates"


def render(template: str, context: Mapping[str, object]) -> str:
    """Return a template filled; a name that the context does not have is an error."""
    return _environment().get_template(template).render(context)


@lru_cache(maxsize=1)
def _environment() -> Environment:
    from jinja2 import Environment, FunctionLoader, StrictUndefined

    environment = Environment(
        block_start_string=r"\BLOCK{",
        block_end_string="}",
        variable_start_string=r"\VAR{",
        variable_end_string="}",
        comment_start_string=r"\#{",
        comment_end_string="}",
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        autoescape=False,
        undefined=StrictUndefined,
        finalize=escape,
        loader=FunctionLoader(_source),
    )
    environment.filters.update(
        decimal=decimal,
        flat=lambda rows: [float(value) for row in rows for value in row],
        interval=interval,
        listed=listed,
        matrix=lambda rows: matrix(rows, exactly=True),
        places=with_decimals,
        rounded=matrix,
        row=lambda cells: Tex(" & ".join(map(escape, cells)) + r" \\"),
        scientific=scientific,
        tex=lambda text: Tex(str(text).strip()),
    )
    return environment


def _source(name: str) -> str:
    return files(_TEMPLATES).joinpath(name).read_text(encoding="utf-8")


def assembled(
    body: str, context: Mapping[str, object], drawn: Mapping[str, Figure]
) -> dict[str, bytes | str]:
    """Return relative file name -> content of the appendix.

    body : the template of the body.
    context : the names that the templates use; the main template needs subject, title, subtitle,
        and whether there is a table of contents.
    drawn : name -> figure.
    """
    from takagi.reports.figures.style import figure_to_pdf

    figures = {f"{name}.pdf": figure_to_pdf(figure) for name, figure in drawn.items()}
    full_context = {**context, "figures": sorted(figures)}
    files: dict[str, bytes | str] = {
        "appendix.tex": render("appendix.tex.jinja", full_context),
        "appendix-body.tex": render(body, full_context),
        "appendix.bib": _source("references.bib"),
    }
    return files | {f"figures/{name}": data for name, data in figures.items()}


def checked_context(document: Mapping[str, Any], checked: Checked) -> dict[str, Any]:
    """Return the checker's verdict, and the certificate's hashes, versions and configuration."""
    from takagi.models.laws.protocol import law_words

    provenance = document.get("provenance", {})
    hashes = {
        **{f"file {name}": value for name, value in provenance.get("files_sha256", {}).items()},
        **{f"certificate: {name}": value for name, value in provenance.get("sha256", {}).items()},
    }
    return {
        "proved": checked.verdict is Verdict.PROVED,
        "verdict": checked.verdict.name,
        "verdict_text": checked.verdict.value,
        "messages": list(checked.messages),
        "hashes": [
            [escape(name), Tex(rf"\texttt{{{escape(value)}}}")] for name, value in hashes.items()
        ],
        "versions": ", ".join(f"{k} {v}" for k, v in provenance.get("versions", {}).items()),
        "model_file": next(iter(provenance.get("files_sha256", {})), ""),
        "configuration": [
            f"{name.replace('_', ' ')} = {law_words(value) if name == 'law' else value}"
            for name, value in provenance.get("configuration", {}).items()
            if value not in (None, {}, [], "") and not isinstance(value, Mapping)
        ],
    }
