"""What a proved claim of kind ``observer`` or ``observed-feedback`` says."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.loop_words import deviations, undisturbed, while_valid
from takagi.certificates.checker.words.sentences.decay import falling


def said(
    name: str, loop: PolytopicLoop, alpha: Fraction, *, feedback: bool, secants: bool
) -> tuple[str, str]:
    """Return name and sentence.

    Parameters
    ----------
    feedback : whether it is about the loop with u = -K xhat, not about the error alone.
    secants : whether a part of the plant is described by slopes.
    """
    what = "the loop with u = -K xhat" if feedback else "the error x - xhat of the observer"
    assumed = "premises that the observer measures"
    if secants:
        assumed = "secants of f in the stated hull" + (f" and {assumed}" * (loop.rules > 1))
    return name, (
        f"V of {what}, for exact outputs and {assumed}, {falling(alpha)}{undisturbed(loop)} along "
        f"every blend of {loop.rules} rules{while_valid(loop)}"
        f"{deviations(loop, 'xu') if feedback else ''}"
    )
