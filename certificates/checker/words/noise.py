"""The assumptions of a verdict about white noise, in words."""

from __future__ import annotations

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, Stack


def in_which_sense(family: PolytopicLoop, entering: Stack) -> str:
    """Return the stochastic integral (Ito), if the result depends on its definition."""
    if family.is_discrete or all(one == entering[0] for one in entering):
        return ""
    return " in Ito's sense (it enters by a matrix that moves, so that other noise may do more)"


def unforeseeing(family: PolytopicLoop) -> str:
    """Return the assumption on weights without a formula, or with a signal in it."""
    granted = family.rules > 1 and family.scheduled_by is None
    granted = granted or (len(family.K) > 1 and not family.shared_weights)
    known = {*family.states, *(family.inputs if family.K else ())}
    signals = ", ".join(name for name in family.scheduled_by or () if name not in known)
    free = "weights" if granted else f"values of {signals}"
    unaware = f" for {free} that do not depend on the noise at the same instant"
    return unaware if granted or signals else ""
