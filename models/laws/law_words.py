"""What the laws of a turbine are called in sentences."""

from __future__ import annotations

from types import MappingProxyType

# By the name that a law has in files.
_WORDS = MappingProxyType(
    {
        "coherent": "effort-sharing law",
        "paper": "published law",
        "paper-two-integrators": "published law with two integrators",
        "baseline": "baseline law",
    }
)


def law_words(name: str) -> str:
    """Return what a law is called in sentences, given its name in files; of others, the name."""
    return _WORDS.get(name, f"law {name}")
