"""What a proved claim of kind ``decay`` says."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.kernel.family import Family
from takagi.certificates.checker.words.shown import at_least
from takagi.certificates.checker.words.validity import undisturbed, while_valid

__all__ = ["said"]


def said(name: str, family: Family, alpha: Fraction, blends: int) -> tuple[str, str]:
    """Return name and sentence."""
    rate = f"decays as exp(-{at_least(2 * alpha, 6)} t)" if alpha else "falls"
    return name, (
        f"V = x'Px {rate}{undisturbed(family)} along {family.about} (inequalities: {blends})"
        f"{while_valid(family)}"
    )
