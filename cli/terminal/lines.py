"""Lines of a summary: a heading, then its text, broken at the line's width; a check's claims."""

from __future__ import annotations

import json
from textwrap import fill
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from takagi.reports.ci_formats import CheckedFile

WIDTH, INDENT = 100, " " * 13
_TIE = "\N{NO-BREAK SPACE}"


def told(word: str, text: str) -> list[str]:
    """Return the heading and its text, broken into indented lines."""
    start = f"  {word}".ljust(len(INDENT))
    filled = fill(text, WIDTH, initial_indent=start, subsequent_indent=INDENT)
    return [filled.replace(_TIE, " ")]


def kept(part: str) -> str:
    """Return the part with no-break spaces, so that it stays on one line."""
    return part.replace(" ", _TIE)


def claim_lines(checked: CheckedFile) -> list[str]:
    """Return a line for each claim: its verdict, its name in quotes, and the checker's sentence.

    The name is a free text of the file.  Without quotes it could be taken for a sentence of the
    checker.
    """
    width = max((len(claim.verdict.name) for claim in checked.claims), default=0)
    return [
        f"  {claim.verdict.name:<{width}}  {json.dumps(claim.name, ensure_ascii=False)}: "
        f"{claim.text}"
        for claim in checked.claims
    ]
