"""What a claim says that disproves a common function of its own matrices: and of what."""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.words import no_common_decay
from takagi.certificates.checker.words.own_matrices import OWN

__all__ = ["said"]


def said(**given: Any) -> tuple[str, str]:
    """Return name and sentence."""
    name, text = no_common_decay.said(**given)
    return name, text + OWN
