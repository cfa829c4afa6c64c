"""Elements of a section: numbers as text, tables, figures; the templates print them."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from decimal import Decimal
from fractions import Fraction
from math import ceil
from typing import Any

from takagi.certificates.checker.words import rounded as shown
from takagi.models.files.units import behind as behind
from takagi.reports.output import read_words


def name_of(label: str) -> str:
    """Return the name without its unit."""
    return label.split(" [")[0]


def unit_of(label: str) -> str:
    """Return the unit; "-" for a pure number, empty where the label has none."""
    return label.partition(" [")[2].rstrip("]")


LONG_CELL = 24
RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
MINUS, DASH, INFINITY = "\u2212", "\u2013", "\u221e"


@dataclass(frozen=True, slots=True)
class CaptionedFigure:
    """A figure: name (its file and anchor), caption (HTML), text for those who cannot see it."""

    name: str
    svg: str
    caption: str
    alternative: str

    @property
    def file(self) -> bytes:
        """The figure as an SVG file of its own."""
        return f'<?xml version="1.0" encoding="utf-8"?>\n{self.svg}'.encode()


@dataclass(frozen=True, slots=True)
class Table:
    """A table with a caption; the first column names the row.

    Attributes
    ----------
    columns : (heading, unit) each; an empty unit prints none.
    rows : cells as text, one per column.
    folded : words of the line that unfolds it; empty shows it at once.
    """

    caption: str
    columns: tuple[tuple[str, str], ...]
    rows: tuple[tuple[str, ...], ...]
    folded: str = ""
    note: str = ""

    @property
    def wordy(self) -> tuple[bool, ...]:
        """Per column: whether it holds words that should wrap and stand to the left."""
        return tuple(
            any(len(row[k]) > LONG_CELL for row in self.rows) for k in range(len(self.columns))
        )


def table(
    key: str, rows: Iterable[tuple[str, ...]], *, folded: bool = True, **filled: str
) -> Table:
    """Return a table with its words in ``words.toml``.

    folded : whether it is where it can be;  filled : what the words there leave open.
    """
    words, cells = read_words("page/words.toml")["tables"][key], tuple(rows)
    heads = [head.format(**filled) for head in words["columns"]]
    return Table(
        words["caption"].format(**filled),
        tuple((name_of(head), unit_of(head)) for head in heads),
        cells,
        words.get("folded", "").format(count=len(cells)) if folded else "",
        words.get("note", ""),
    )


@dataclass(frozen=True, slots=True)
class Section:
    """One section: anchor, title, and what its template ``<anchor>.html.jinja`` is filled with."""

    anchor: str
    title: str
    content: Mapping[str, Any] = field(default_factory=dict)

    @property
    def captioned_figures(self) -> tuple[CaptionedFigure, ...]:
        """The figures of the section, in the order of its content."""
        figures: list[CaptionedFigure] = []
        for value in self.content.values():
            items = value if isinstance(value, (list, tuple)) else (value,)
            figures += [item for item in items if isinstance(item, CaptionedFigure)]
        return tuple(figures)


def per_unit(above: str, below: str) -> str:
    """Return the unit of a quotient, "-" for none: ``per_unit("N", "rad/s") == "N s/rad"``."""
    if below == "-":
        return above
    divided, _, divisor = below.partition("/")
    if divisor and "/" not in above and not set("/ ()") & set(divided + divisor):
        return f"{divisor if above == '-' else f'{above} {divisor}'}/{divided}"
    bottom = f"({below})" if set(below) & set("/ ") else below
    top = f"({above})" if "/" in above else above
    return f"{'1' if above == '-' else top}/{bottom}"


def with_decimals(value: float, digits: int) -> str:
    """Return a number with so many decimals; a dash for nan, a true minus sign."""
    if math.isnan(value):
        return DASH
    if math.isinf(value):
        return INFINITY if value > 0 else MINUS + INFINITY
    text = f"{value:.{digits}f}"
    if float(text) == 0:
        text = text.lstrip("-")
    return text.replace("-", MINUS)


def significant(value: float, digits: int = 3) -> str:
    """Return a number to so many significant digits, without an exponent where that reads well."""
    if math.isnan(value) or math.isinf(value):
        return with_decimals(value, 0)
    if value == 0:
        return "0"
    size = math.floor(math.log10(abs(value)))
    if -4 <= size < 7:
        return with_decimals(value, max(digits - 1 - size, 0))
    mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
    return f"{mantissa.replace('-', MINUS)}·10{str(int(exponent)).translate(RAISED)}"


def upper_bound(value: float, digits: int) -> str:
    """Return an upper bound with so many decimals, rounded up to stay one."""
    if not math.isfinite(value):
        return with_decimals(value, digits)
    return with_decimals(float(at_most_to(value, digits)), digits)


def lower_bound(value: float, digits: int = 3) -> str:
    """Return a lower bound above 0 to so many significant digits, rounded down to stay one."""
    if not value > 0 or math.isinf(value):
        return significant(value, digits)
    return significant(float(at_least(value, digits)), digits)


def decimal(value: float) -> str:
    """Return a short decimal as it is emitted, without zeros at its end."""
    return f"{value:.12g}".replace("-", MINUS)


def complex_words(values: Iterable[complex], digits: int = 3) -> list[str]:
    """Return complex numbers to so many digits, those with the largest real part first."""
    texts = []
    for value in sorted(map(complex, values), key=lambda p: (-p.real, p.imag)):
        real, imaginary = (significant(x, digits) for x in (value.real, abs(value.imag)))
        sign = "+" if value.imag > 0 else MINUS
        alone = abs(value.imag) < 1e-9 * max(abs(value), 1e-9)
        texts.append(real if alone else f"{real} {sign} {imaginary} j")
    return texts


def powers(words: str) -> str:
    """Return words with ^2, ^3, ^-1 raised, as in m/s²."""
    return re.sub(r"\^(-?\d+)", lambda match: match[1].translate(RAISED), words)


def typeset(words: str) -> str:
    """Return words as a page sets them: powers raised, the signs for <= and >=, units tied."""
    signs = powers(words).replace("<=", "\u2264").replace(">=", "\u2265")
    return re.sub(r"(?<=\d) (?=[%A-Za-z])|(?<=\d N) (?=m\b)", "\u00a0", signs)


# Bounds are rounded in the direction that keeps the sentence true, by the checker's own words
# (``takagi.certificates.checker.words.rounded``); a float stands for the decimal it is written as.
Bound = float | Fraction


def at_least(value: Bound, digits: int = 3) -> str:
    """Return the greatest decimal with these significant digits that does not exceed the value."""
    return shown.at_least(_exactly(value), digits)


def at_most(value: Bound, digits: int = 3) -> str:
    """Return the least decimal of this many significant digits that is not below the value."""
    return shown.at_most(_exactly(value), digits)


def at_most_to(value: Bound, decimals: int) -> str:
    """Return the least decimal with so many places that is not below the value, zeros kept."""
    return f"{Decimal(ceil(_exactly(value) * 10**decimals)).scaleb(-decimals):f}"


def _exactly(value: Bound) -> Fraction:
    return value if isinstance(value, Fraction) else Fraction(repr(float(value)))
