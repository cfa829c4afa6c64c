"""What a proved claim of kind ``effort-blend`` says."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.plant.blend import Acting, Blend
from takagi.certificates.checker.words.rounded import at_least, at_most


def said(name: str, blend: Blend, low: Fraction, high: Fraction, law: bool) -> tuple[str, str]:
    """Return name and sentence.

    Parameters
    ----------
    low, high : between which the share lies.
    law : whether there is a law, which knows what its gains depend on.
    """
    unit = "" if blend.effort.unit == "-" else f" {blend.effort.unit}"
    ends = f"[{at_most(blend.ends[0], 9)}, {at_least(blend.ends[1], 9)}]"
    told = [
        f"where the effort is in {ends}{unit} and the state in the box, {blend.high.name} has a "
        f"share between {at_least(low, 6)} and {at_most(high, 6)} of its motion from rest and "
        f"{blend.low.name} the rest",
        *filter(None, map(_acts, blend.actuators)),
    ]
    if law:
        told.append("the law knows all that its gains depend on")
    return name, "; ".join([*told, "standard library alone"])


def _acts(acting: Acting) -> str:
    """Return the range that an actuator keeps and the error that it may have; empty for neither."""
    kept = wrong = ""
    if acting.side is not None:
        kept = f" keeps [{at_least(acting.side[0], 9)}, {at_most(acting.side[1], 9)}]"
        kept += "" if acting.unit == "-" else f" {acting.unit}"
    if acting.error is not None and acting.error.side is not None:
        down, up = acting.error.side
        # An assumption, as the box is: rounded inward, so that the sentence claims no more.
        wrong = f" moves the plant {at_most(1 + down, 6)} to {at_least(1 + up, 6)} times as "
        wrong += "much as told from its position at rest"
    if not kept and not wrong:
        return ""
    return f"{acting.name}{kept}{' and' * bool(kept and wrong)}{wrong}"
