"""What a proved claim of kind ``h2-norm`` says."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, Stack
from takagi.certificates.checker.words.loop_words import (
    about,
    channel_deviations,
    in_which_sense,
    rounded_channel,
    unforeseeing,
    while_valid,
)
from takagi.certificates.checker.words.rounded import at_most


def said(
    name: str, claim: Any, loop: PolytopicLoop, norm: Fraction, entering: Stack
) -> tuple[str, str]:
    """Return name and sentence; ``entering`` are the matrices by which the noise comes in."""
    noise = "unit covariance in each sample" if loop.is_discrete else "unit intensity"
    noise += in_which_sense(loop, entering)
    return name, (
        f"the mean over time of E|y|^2 is at most {at_most(norm, 6)}^2 for white noise of {noise}, "
        f"along {about(loop)}{unforeseeing(loop)} ({rounded_channel(claim, loop)})"
        f"{while_valid(loop)}{channel_deviations(claim, loop)}"
    )
