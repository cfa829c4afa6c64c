"""Changes of a file's text."""

from __future__ import annotations

from collections.abc import Callable

Rewrite = Callable[[str], str]


def replaced(old: str, new: str) -> Rewrite:
    def rewrite(text: str) -> str:
        assert old in text
        return text.replace(old, new, 1)

    return rewrite


def reversed_sections(text: str) -> str:
    head, *sections = text.split("\n[")
    return "\n[".join([head, *(part.rstrip("\n") + "\n" for part in reversed(sections))])


def all_of(*rewrites: Rewrite) -> Rewrite:
    def rewrite(text: str) -> str:
        for one in rewrites:
            text = one(text)
        return text

    return rewrite
