"""The sentence of a proved claim of kind ``fuzzy-l2-gain``."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.loop_words import (
    about,
    channel_deviations,
    rounded_channel,
    while_valid,
)
from takagi.certificates.checker.words.rounded import at_most
from takagi.certificates.checker.words.sentences.fuzzy_decay import Rates, rounded_rates


def said(
    name: str, claim: Any, loop: PolytopicLoop, gain: Fraction, rates: Rates | None
) -> tuple[str, str]:
    """Return name and sentence; ``rates``, or None, are assumed bounds of the weights' rates."""
    moving = "however the weights move"
    if rates is not None:
        moving = "while the weights keep to their rates: " + rounded_rates(rates)
    return name, (
        f"the energy of y is at most {at_most(gain, 6)}^2 times that of w, from rest, along "
        f"{about(loop)}, {moving}, shown by V = x'P(h)x "
        f"({rounded_channel(claim, loop)}){while_valid(loop)}"
        f"{channel_deviations(claim, loop)}"
    )
