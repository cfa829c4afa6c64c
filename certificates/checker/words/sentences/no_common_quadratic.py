"""The sentence of a claim that disproves a common function for its own matrices."""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.words.sentences import no_common_decay
from takagi.certificates.checker.words.sentences.own_matrices import OWN


def said(**given: Any) -> tuple[str, str]:
    """Return name and sentence."""
    name, text = no_common_decay.said(**given)
    return name, text + OWN
