"""What a proved claim of kind ``h2-norm`` says."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, Stack
from takagi.certificates.checker.words.about import about
from takagi.certificates.checker.words.disturbance_channel import (
    channel_deviations,
    rounded_channel,
)
from takagi.certificates.checker.words.rounded import at_most
from takagi.certificates.checker.words.validity import while_valid


def said(
    name: str, claim: Any, family: PolytopicLoop, norm: Fraction, entering: Stack
) -> tuple[str, str]:
    """Return name and sentence; ``entering`` are the matrices by which the noise comes in."""
    noise = "unit covariance in each sample" if family.is_discrete else "unit intensity"
    noise += _in_which_sense(family, entering)
    return name, (
        f"the mean over time of E|y|^2 is at most {at_most(norm, 6)}^2 for white noise of {noise}, "
        f"along {about(family)}{_unforeseeing(family)} ({rounded_channel(claim, family)})"
        f"{while_valid(family)}{channel_deviations(claim, family)}"
    )


def _in_which_sense(family: PolytopicLoop, entering: Stack) -> str:
    """Return the stochastic integral (Ito), if the result depends on its definition."""
    if family.is_discrete or all(one == entering[0] for one in entering):
        return ""
    return " in Ito's sense (it enters by a matrix that moves, so that other noise may do more)"


def _unforeseeing(family: PolytopicLoop) -> str:
    """Return the assumption on weights that are not described or depend on a signal."""
    granted = family.rules > 1 and family.scheduled_by is None
    granted = granted or (len(family.K) > 1 and not family.shared_weights)
    known = {*family.states, *(family.inputs if family.K else ())}
    signals = ", ".join(name for name in family.scheduled_by or () if name not in known)
    free = "weights" if granted else f"values of {signals}"
    unaware = f" for {free} that do not depend on the noise at the same instant"
    return unaware if granted or signals else ""
