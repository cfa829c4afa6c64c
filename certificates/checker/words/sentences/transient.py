"""What a proved claim of kind ``transient`` says."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.loop_words import (
    about,
    deviations,
    undisturbed,
    while_valid,
)
from takagi.certificates.checker.words.rounded import at_least, at_most


def said(
    name: str,
    loop: PolytopicLoop,
    alpha: Fraction,
    scales: Sequence[Fraction],
    kappa: Fraction,
    share: Fraction,
    time: Fraction,
) -> tuple[str, str]:
    """Return name and sentence."""
    units = "" if set(scales) == {Fraction(1)} else " in the states over their scales"
    return name, (
        f"|x(t)| <= {at_most(kappa, 6)} exp(-{at_least(alpha, 6)} t) |x(0)|{units}, so at most "
        f"{at_most(share, 6)} |x(0)| after {at_most(time, 6)} s,{undisturbed(loop)} "
        f"along {about(loop)}{while_valid(loop)}{deviations(loop, 'x')}"
    )
