"""What is said of a loop: what a proof is about, its assumptions, its disturbance and output.

The assumptions are those about the model's box, its disturbance and white noise; letters of a
sentence that are deviations from another value than zero are explained.
"""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, Stack


def about(loop: PolytopicLoop) -> str:
    """Return e.g. ``every blend of 4 rules with their gains``."""
    if loop.rules == 1 and len(loop.K) <= 1:
        return "the loop"
    if not loop.K:
        return f"every blend of the {loop.rules} vertices"
    several = f"and any of {len(loop.K)} gains" if len(loop.K) > 1 else "with one gain"
    law = "with their gains" if loop.shared_weights else several
    blends = f"every blend of {loop.rules} rules" if loop.rules > 1 else "the one rule"
    return f"{blends} {law}"


def granted(loop: PolytopicLoop, *, disturbances_too: bool = True) -> str:
    """Return the ranges of the box that are assumed and not proved; empty for none."""
    proved = set(loop.inputs)
    if not disturbances_too:
        # Imported here: a kind that assumes all ranges does not need it.
        from takagi.certificates.checker.loop.box_of_validity import pushing

        proved |= pushing(loop)
    names = [name for name in loop.other_box or {} if name not in proved]
    stay = "stays" if len(names) == 1 else "stay"
    return f", while {', '.join(names)} {stay} in the model's box" if names else ""


def while_valid(loop: PolytopicLoop) -> str:
    """Return the statement that the model equals its plant only on a box; empty without a box.

    For matrices alone no claim proves that they contain a plant, so this is an assumption.
    """
    bounded = any(side is not None for side in loop.box) or loop.other_box
    plant = "a plant that the model contains" if loop.scheduled_by is None else "its plant"
    return f"; this also holds for {plant} while it stays in the model's box" if bounded else ""


def undisturbed(loop: PolytopicLoop) -> str:
    """Return the assumption that the model's disturbance is zero; empty without one."""
    return " without disturbance" if loop.E else ""


def in_which_sense(loop: PolytopicLoop, entering: Stack) -> str:
    """Return the stochastic integral (Ito), if the result depends on its definition."""
    if loop.is_discrete or all(matrix == entering[0] for matrix in entering):
        return ""
    return " in Ito's sense (it enters by a matrix that moves, so that other noise may do more)"


def unforeseeing(loop: PolytopicLoop) -> str:
    """Return the assumption on weights without a formula, or with a signal in it."""
    granted = loop.rules > 1 and loop.scheduled_by is None
    granted = granted or (len(loop.K) > 1 and not loop.shared_weights)
    loop_signals = {*loop.states, *(loop.inputs if loop.K else ())}
    signals = ", ".join(name for name in loop.scheduled_by or () if name not in loop_signals)
    free = "weights" if granted else f"values of {signals}"
    unaware = f" for {free} that do not depend on the noise at the same instant"
    return unaware if granted or signals else ""


DEVIATION_MEANINGS = {
    "x": "x is x - x*",
    "u": "u is u - u*",
    "y": "y is y less its value at rest",
    "w": "w is w - w*",
}


def deviations(loop: PolytopicLoop, letters: str) -> str:
    """Return a clause that explains these letters; empty if all equilibrium values are 0.

    Parameters
    ----------
    letters : of x, u, y, w: those that the sentence has, and that are the model's own.
    """
    meanings = [DEVIATION_MEANINGS[a] for a in letters if a in loop.resting_elsewhere]
    star = ", with * for the point of rest" if any("*" in meaning for meaning in meanings) else ""
    return f"; here {', '.join(meanings)}{star}" if meanings else ""


def rounded_channel(claim: Any, loop: PolytopicLoop) -> str:
    """Return a text about the source of w and of y."""
    alone = ", without the model's disturbance" if loop.E else ""
    is_of_model = claim["disturbance"] == "disturbances"
    source = "the model's disturbance" if is_of_model else f"added to u{alone}"
    if "entering" in claim:
        source += f" {', '.join(claim['entering'])}, the others at rest"
    return f"w {source}, y {'of the claim' if 'output' in claim else 'the output of the model'}"


def channel_deviations(claim: Any, loop: PolytopicLoop, letters: str = "") -> str:
    """Return the meaning of w, y and other letters with equilibrium values other than 0.

    A w that is added to u is no deviation; an output that the claim writes itself is of x and u.
    """
    moving_letters = {*letters, *("xu" if "output" in claim else "y")}
    moving_letters |= {"w"} if claim["disturbance"] == "disturbances" else set()
    return deviations(loop, "".join(a for a in "xuyw" if a in moving_letters))
