"""Markdown as GitHub wants it: inline formulas that it leaves alone, and lines not too long."""

from __future__ import annotations

import re
import textwrap

WIDTH = 100
FENCED = re.compile(r"(^```.*?^```$)", re.DOTALL | re.MULTILINE)
INLINE = re.compile(r"(?<!`)\$(?!`)([^$`]+)(?<!`)\$(?!`)")


def github(text: str) -> str:
    """Return the text with $x$ written as $`x`$, and its paragraphs wrapped.

    Between plain dollars Markdown comes first: it takes backslashes away and ends table cells at
    bars.
    """
    parts = FENCED.split(text)
    parts[::2] = [_prose(part) for part in parts[::2]]
    return re.sub(r"\n{3,}", "\n\n", "".join(parts)).rstrip() + "\n"


def _prose(text: str) -> str:
    text = INLINE.sub(lambda found: f"$`{' '.join(found[1].split())}`$", text)
    return "\n\n".join(_paragraph(block) for block in text.split("\n\n"))


def _paragraph(block: str) -> str:
    """Return a paragraph or a list in short lines; tables and headings as they are."""
    inside = block.strip("\n")
    before, _, after = block.partition(inside) if inside else ("", "", block)
    if inside.startswith(("|", "#")):
        return block
    items = re.split(r"\n(?=- )", inside)
    return before + "\n".join(_wrapped(" ".join(item.split())) for item in items) + after


def _wrapped(line: str) -> str:
    # A formula is not broken.
    whole = re.sub(r"\$`.*?`\$", lambda found: found[0].replace(" ", "\0"), line)
    lines = textwrap.wrap(
        whole,
        WIDTH,
        subsequent_indent="  " if line.startswith("- ") else "",
        break_long_words=False,
        break_on_hyphens=False,
    )
    return "\n".join(lines).replace("\0", " ")
