"""From an outcome to a claim with its sentence."""

from __future__ import annotations

from takagi.certificates.checker.kernel.result import Claim, Outcome


def in_words(found: Outcome) -> Claim:
    """Return the claim with the verdict that was found, and its sentence."""
    if isinstance(found, Claim):
        return found
    claim = found.claim
    figures = tuple(claim.figures())
    return Claim(claim.name, found.verdict, claim.sentence(), claim.assumes, figures)
