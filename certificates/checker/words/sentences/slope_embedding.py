"""The sentence of a proved claim of kind ``slope-embedding``."""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.words.sentences.embedding import said as said_of_embedding


def said(**given: Any) -> tuple[str, str]:
    """Return name and sentence; the parameters are those of an embedding."""
    name, text = said_of_embedding(**given)
    rest, any_two = "differences of the plant from rest are", "differences between any two states"
    assert text.startswith(rest)  # the embedding is read with the form "secant"
    return name, f"{any_two}, inputs alike, are{text.removeprefix(rest)}"
