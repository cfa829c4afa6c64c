"""Docstrings as Markdown: sections as lists, formulas as they are written, nothing set in italics.

The docstrings are plain text.  Their ``*``, ``_`` and ``<`` are signs of formulas, their indented
lines are formulas or code, and an entry of a section is a name, a colon and free text.
"""

from __future__ import annotations

import re
from inspect import cleandoc
from textwrap import dedent
from typing import Any

import griffe

ENTRY = re.compile(r"^(?:``)?(\*{0,2}[\w.]+(?:, \*{0,2}[\w.]+)*)(?:``)? : (.*)$")
CODE = re.compile(r"(``.+?``|`[^`\n]+`)")
LITERAL = re.compile(r"::$", re.MULTILINE)


class Plain(griffe.Extension):
    """Turn every docstring that is read into Markdown."""

    def on_instance(self, *, obj: griffe.Object, **_: Any) -> None:
        """Change the docstring of an object that was read from its source."""
        if obj.docstring is not None:
            obj.docstring.value = as_markdown(obj.docstring.value)


def as_markdown(docstring: str) -> str:
    """Return a docstring in the style of numpy as Markdown."""
    lines = cleandoc(docstring).splitlines()
    blocks, title, start = [], "", 0
    for k in range(1, len(lines) + 1):
        last = k == len(lines)
        if last or re.fullmatch(r"-{3,}", lines[k]):
            end = k if last else k - 1
            blocks.append(_section(title, lines[start:end]))
            title, start = ("", 0) if last else (lines[k - 1].strip(), k + 1)
    return "\n\n".join(block for block in blocks if block)


def _section(title: str, lines: list[str]) -> str:
    return f"**{title}**\n\n{_entries(lines)}" if title else _entries(lines)


def _entries(lines: list[str]) -> str:
    """Return the entries of a section as a list, and the text between them as it is."""
    parts: list[str] = []
    k = 0
    while k < len(lines):
        end = k + 1
        entry = ENTRY.match(lines[k])
        if entry:
            while end < len(lines) and (lines[end].startswith("    ") or not lines[end].strip()):
                end += 1
            body = _text([entry[2], *dedent("\n".join(lines[k + 1 : end])).splitlines()])
            body = body.replace("\n", "\n    ")
            parts.append(f"-   `{entry[1]}`: {body}")
        else:
            while end < len(lines) and not ENTRY.match(lines[end]):
                end += 1
            parts.append(_text(lines[k:end]))
        k = end
    return "\n\n".join(part for part in parts if part)


def _text(lines: list[str]) -> str:
    """Return paragraphs; indented ones as they stand."""
    paragraphs = re.split(r"\n\s*\n", "\n".join(lines).strip("\n"))
    return "\n\n".join(_paragraph(paragraph) for paragraph in paragraphs if paragraph.strip())


def _paragraph(paragraph: str) -> str:
    if paragraph.startswith("    "):
        return f"```text\n{dedent(paragraph)}\n```"
    parts = CODE.split(LITERAL.sub(":", paragraph))
    return "".join(part if k % 2 else _escaped(part) for k, part in enumerate(parts))


def _escaped(text: str) -> str:
    text = re.sub(r"([\\*_\[\]#$])", r"\\\1", text)
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")
