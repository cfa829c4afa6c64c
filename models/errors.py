"""The one exception of this floor: misuse, with a message that says how to correct it."""

from __future__ import annotations

from collections.abc import Iterable
from difflib import get_close_matches


class ModelError(ValueError):
    """What was asked makes no sense for the model it was asked of.

    The message says which item is wrong, what was given, what was needed and what to do.
    "No such controller exists" is an answer, not a ``ModelError``.
    """


def did_you_mean(word: str, choices: Iterable[str]) -> str:
    """Return ``" (did you mean ...?)"`` with the known names near the given one, or ``""``."""
    names = list(choices)
    by_lower = {name.lower(): name for name in names}
    similar = get_close_matches(word.lower(), by_lower, n=3, cutoff=0.6)
    if not similar:
        return ""
    return " (did you mean " + " or ".join(repr(by_lower[name]) for name in similar) + "?)"
