"""What the laws of a turbine are called in sentences."""

from __future__ import annotations

_WORDS = {
    "coherent": "effort-sharing law",
    "paper": "published law",
    "paper-two-integrators": "published law with two integrators",
}


def law_words(name: str) -> str:
    """Return the words for a law, given its name in files; an unknown name is returned as it is."""
    return _WORDS.get(name, f"law {name}")
