"""Lines of a summary: a word, then its text, broken where the line ends."""

from __future__ import annotations

from textwrap import fill

WIDTH, INDENT = 100, " " * 13
_TIE = "\N{NO-BREAK SPACE}"


def told(word: str, text: str) -> list[str]:
    """Return the text behind its word, broken where the lines end."""
    start = f"  {word}".ljust(len(INDENT))
    filled = fill(text, WIDTH, initial_indent=start, subsequent_indent=INDENT)
    return [filled.replace(_TIE, " ")]


def kept(part: str) -> str:
    """Return the part with spaces at which no line ends."""
    return part.replace(" ", _TIE)
