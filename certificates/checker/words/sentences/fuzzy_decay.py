"""What a proved claim of kind ``fuzzy-decay`` says."""

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
from takagi.certificates.checker.words.rounded import at_least
from takagi.certificates.checker.words.sentences.decay import falling

Rates = Sequence[Sequence[Fraction] | None]


def said(name: str, loop: PolytopicLoop, alpha: Fraction, rates: Rates | None) -> tuple[str, str]:
    """Return name and sentence; ``rates`` of weights that are taken for granted, None for none."""
    moving = "however the weights move"
    if rates is not None:
        moving = "while the weights keep to their rates: " + rounded_rates(rates)
    return name, (
        f"V = x'P(h)x {falling(alpha)}{undisturbed(loop)} along {about(loop)}, {moving}"
        f"{while_valid(loop)}{deviations(loop, 'x')}"
    )


def rounded_rates(rates: Rates) -> str:
    """Return the bounds, simplex by simplex."""
    rows = ("any" if row is None else ", ".join(at_least(v, 6) for v in row) for row in rates)
    return "; ".join(rows) + " 1/s"
