"""The disturbance and the output in the sentence of a claim about their channel."""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.deviations import deviations


def rounded_channel(claim: Any, loop: PolytopicLoop) -> str:
    """Return a text about the source of w and of y."""
    alone = ", without the model's disturbance" if loop.E else ""
    given = claim["disturbance"] == "disturbances"
    way = "the model's disturbance" if given else f"added to u{alone}"
    return f"w {way}, y {'of the claim' if 'output' in claim else 'the output of the model'}"


def channel_deviations(claim: Any, loop: PolytopicLoop, others: str = "") -> str:
    """Return the meaning of w, y and other letters with equilibrium values other than 0.

    A w that is added to u is no deviation; an output that the claim writes itself is of x and u.
    """
    seen = {*others, *("xu" if "output" in claim else "y")}
    seen |= {"w"} if claim["disturbance"] == "disturbances" else set()
    return deviations(loop, "".join(a for a in "xuyw" if a in seen))
