"""Rows of a summary: a word, and text wrapped behind it; coloured where a terminal shows it."""

from __future__ import annotations

import os
import sys
from textwrap import fill

import typer

WIDTH, INDENT = 100, " " * 15
_TIE = "\N{NO-BREAK SPACE}"


def headline(verdict: str, name: str, remark: str, *, proved: bool) -> str:
    """Return the verdict and the model's name, with a remark at the right."""
    text = f"{verdict}  {name}"
    space = max(3, WIDTH - len(text) - len(remark))
    (shown,) = coloured([verdict], "green" if proved else "red")
    return f"{shown}  {name}{' ' * space}{remark}"


def row_lines(word: str, text: str) -> list[str]:
    """Return the word and its text, broken into indented lines of at most 100 characters."""
    start = f"  {word}".ljust(len(INDENT))
    filled = fill(
        text, WIDTH, initial_indent=start, subsequent_indent=INDENT, break_on_hyphens=False
    )
    return filled.replace(_TIE, " ").splitlines()


def unbroken(part: str) -> str:
    """Return the part with no-break spaces, so that it stays on one line."""
    return part.replace(" ", _TIE)


def coloured(lines: list[str], colour: str | None) -> list[str]:
    """Return the lines in a colour; as they are where no terminal shows them or NO_COLOR is set."""
    if colour is None or not sys.stdout.isatty() or os.environ.get("NO_COLOR"):
        return lines
    return [typer.style(line, fg=colour) for line in lines]
