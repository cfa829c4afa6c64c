"""What a proved claim of kind ``decay`` says."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.loop_words import (
    about,
    deviations,
    undisturbed,
    while_valid,
)
from takagi.certificates.checker.words.rounded import at_least


def said(name: str, loop: PolytopicLoop, alpha: Fraction, blends: int) -> tuple[str, str]:
    """Return name and sentence."""
    return name, (
        f"V = x'Px {falling(alpha)}{undisturbed(loop)} along {about(loop)} "
        f"(inequalities: {blends}){while_valid(loop)}{deviations(loop, 'x')}"
    )


def falling(alpha: Fraction) -> str:
    """Return how V falls."""
    return f"decays as exp(-{at_least(2 * alpha, 6)} t)" if alpha else "falls"
