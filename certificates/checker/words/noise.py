"""The assumptions of a verdict about white noise, in words."""

from __future__ import annotations

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, Stack


def in_which_sense(loop: PolytopicLoop, entering: Stack) -> str:
    """Return the stochastic integral (Ito), if the result depends on its definition."""
    if loop.is_discrete or all(one == entering[0] for one in entering):
        return ""
    return " in Ito's sense (it enters by a matrix that moves, so that other noise may do more)"


def unforeseeing(loop: PolytopicLoop) -> str:
    """Return the assumption on weights without a formula, or with a signal in it."""
    granted = loop.rules > 1 and loop.scheduled_by is None
    granted = granted or (len(loop.K) > 1 and not loop.shared_weights)
    known = {*loop.states, *(loop.inputs if loop.K else ())}
    signals = ", ".join(name for name in loop.scheduled_by or () if name not in known)
    free = "weights" if granted else f"values of {signals}"
    unaware = f" for {free} that do not depend on the noise at the same instant"
    return unaware if granted or signals else ""
