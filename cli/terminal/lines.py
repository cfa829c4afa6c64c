"""Lines of a summary: a heading, then its text, broken at the width of the terminal's line."""

from __future__ import annotations

from textwrap import fill

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
