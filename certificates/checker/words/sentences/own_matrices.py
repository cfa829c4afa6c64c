"""The sentence of a proved claim with its own matrices: that of ``decay``, and their source."""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.words.sentences import decay

OWN = "; of the matrices in the claim, which need not be those of model or gains"


def said(**given: Any) -> tuple[str, str]:
    """Return name and sentence."""
    name, text = decay.said(**given)
    return name, text + OWN
