"""What a proved claim of kind ``l2-gain`` says."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.loop_words import (
    about,
    channel_deviations,
    granted,
    rounded_channel,
    while_valid,
)
from takagi.certificates.checker.words.rounded import at_least, at_most


def said(
    name: str, claim: Any, loop: PolytopicLoop, gain: Fraction, energy: Fraction | None
) -> tuple[str, str]:
    """Return name and sentence.

    Parameters
    ----------
    energy : of w, the square root of that for which no state leaves the box; None if none is shown.
    """
    validity = while_valid(loop)
    if energy is not None:
        validity = (
            f"; for w of energy at most {at_least(energy, 6)}^2 no state leaves the model's box"
            f"{granted(loop)}"
        )
    return name, (
        f"the energy of y is at most {at_most(gain, 6)}^2 times that of w, from rest, along "
        f"{about(loop)} ({rounded_channel(claim, loop)}){validity}"
        f"{channel_deviations(claim, loop)}"
    )
