"""Rows of a summary: a word, and text wrapped behind it; coloured where a terminal shows it."""

from __future__ import annotations

import os
import sys
from dataclasses import asdict
from textwrap import fill
from typing import TYPE_CHECKING, Any

import typer

if TYPE_CHECKING:
    from takagi.reports.ci_formats import CheckedFile
    from takagi.reports.sections.plant.summary import SummaryRow

WIDTH, INDENT = 100, " " * 15
_TIE = "\N{NO-BREAK SPACE}"
_SHORT = 60  # characters of a part that is not broken


def headline(verdict: str, name: str, remark: str, *, proved: bool, part: bool = False) -> str:
    """Return the verdict and the model's name, with a remark at the right.

    part : whether less is proved than the file states; the verdict is yellow then.
    """
    text = f"{verdict}  {name}"
    space = max(3, WIDTH - len(text) - len(remark))
    colour = "yellow" if part else "green"
    (shown,) = coloured([verdict], colour if proved else "red")
    return f"{shown}  {name}{' ' * space}{remark}"


def row_lines(word: str, text: str) -> list[str]:
    """Return the word and its text, broken into indented lines of at most 100 characters."""
    start = f"  {word}".ljust(len(INDENT))
    filled = fill(
        text, WIDTH, initial_indent=start, subsequent_indent=INDENT, break_on_hyphens=False
    )
    return filled.replace(_TIE, " ").splitlines()


def summary_lines(row: SummaryRow) -> list[str]:
    """Return the lines of a row of the summary, in yellow where less is proved than stated."""
    shown = (*row.parts, row.basis) if row.numbers and row.basis else row.parts
    text = ", ".join(map(unbroken, shown)).replace("+, ", "+ ")
    if row.partial:
        # Tied to its figures, unless both together would be too long for a line.
        tie = _TIE if len(row.parts[-1]) + len(row.shortfall) < WIDTH - len(INDENT) - 4 else " "
        text += f"{tie}<-{_TIE}{unbroken(row.shortfall)}"
    if row.regulator:
        text += f"; {unbroken(row.regulator)}"
    return coloured(row_lines(row.name, text), "yellow" if row.partial else None)


def row_as_data(row: SummaryRow) -> dict[str, Any]:
    """Return a row of the summary as plain data."""
    return {
        "name": row.name,
        "text": row.text,
        "regulator": row.regulator or None,
        "proved": row.proved,
        "basis": row.basis or None,
        "less_than_stated": row.partial,
        "claim": row.claim or None,
        "assumes": list(row.assumes),
        "numbers": [asdict(number) for number in row.numbers],
    }


def wrapped_claims(checked: CheckedFile, *, but: str = "") -> list[str]:
    """Return the claims in full with their own assumptions, those of one verdict left out."""
    lines = []
    for claim in checked.claims:
        if claim.verdict.name != but:
            lines.append(f"  {claim.verdict.name:<{len(INDENT) - 3}} {claim.name}")
            assumed = [f"assumes: {'; '.join(claim.assumes)}"] if claim.assumes else []
            for text in (claim.text, *assumed):
                lines += row_lines("", text)
    return lines


def unbroken(part: str) -> str:
    """Return a short part with no-break spaces, so that it stays on one line; else its shares."""
    return part.replace(" ", _TIE) if len(part) < _SHORT else part.replace(" %", f"{_TIE}%")


def coloured(lines: list[str], colour: str | None) -> list[str]:
    """Return the lines in a colour; as they are where no terminal shows them or NO_COLOR is set."""
    if colour is None or not sys.stdout.isatty() or os.environ.get("NO_COLOR"):
        return lines
    return [typer.style(line, fg=colour) for line in lines]
