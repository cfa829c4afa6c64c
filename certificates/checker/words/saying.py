"""From what was found to a claim with its sentence."""

from __future__ import annotations

from importlib import import_module

from takagi.certificates.checker.kernel.result import Claim, Outcome


def in_words(found: Outcome) -> Claim:
    """Return the claim with the verdict that was found, and its sentence."""
    if isinstance(found, Claim):
        return found
    words = import_module(f"takagi.certificates.checker.words.sentences.{found.words}")
    name, text = words.said(**found.given)
    return Claim(name, found.verdict, text)
