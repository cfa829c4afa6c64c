"""What a proved claim of kind ``gain-rounding`` says."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.loop_words import (
    about,
    deviations,
    undisturbed,
    while_valid,
)
from takagi.certificates.checker.words.rounded import at_least
from takagi.certificates.checker.words.sentences.decay import falling


def said(
    name: str, loop: PolytopicLoop, alpha: Fraction, absolute: Matrix, relative: Fraction
) -> tuple[str, str]:
    """Return name and sentence."""
    room = [f"{at_least(100 * relative, 6)} % of themselves"] if relative else []
    room += ["the stated absolute steps"] if any(map(any, absolute.rows)) else []
    words = " and ".join(room) or "nothing"
    return name, (
        f"V = x'Px {falling(alpha)}{undisturbed(loop)} along {about(loop)}, with all gains off "
        f"by up to {words}{while_valid(loop)}{deviations(loop, 'x')}"
    )
