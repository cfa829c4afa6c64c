"""From an outcome to a claim with its sentence."""

from __future__ import annotations

from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.result import Claim


def in_words(outcome: Outcome) -> Claim:
    """Return the claim with its verdict, its sentence and its figures."""
    if isinstance(outcome, Claim):
        return outcome
    claim = outcome.claim
    figures = tuple(claim.figures())
    return Claim(claim.name, outcome.verdict, claim.sentence(), claim.assumes, figures)
