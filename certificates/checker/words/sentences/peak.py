"""What a proved claim of kind ``peak`` says."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kinds.invariant_set import InvariantSet
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.invariant_set import rounded_level, where_valid
from takagi.certificates.checker.words.loop_words import (
    about,
    channel_deviations,
    rounded_channel,
)
from takagi.certificates.checker.words.rounded import at_least, at_most


def said(
    name: str,
    claim: Any,
    loop: PolytopicLoop,
    held: InvariantSet,
    gain: Fraction,
    bound: Fraction,
) -> tuple[str, str]:
    """Return name and sentence; ``bound`` is that on |w|_2."""
    return name, (
        f"|y| <= {at_most(gain * bound, 6)} at all times, from rest and from anywhere in "
        f"{{x'Px <= {rounded_level(held)}}}, for |w|_2 <= {at_least(bound, 6)} at all times (gain "
        f"{at_most(gain, 6)}), along {about(loop)} ({rounded_channel(claim, loop)}); the "
        f"set is invariant{where_valid(loop)}{channel_deviations(claim, loop, 'x')}"
    )
