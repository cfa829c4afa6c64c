"""What a proved claim says that holds its own matrices: the sentence of ``decay``, and of what."""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.words import decay

__all__ = ["OWN", "said"]

OWN = "; of the matrices in the claim, which need not be those of model or gains"


def said(**given: Any) -> tuple[str, str]:
    """Return name and sentence."""
    name, text = decay.said(**given)
    return name, text + OWN
