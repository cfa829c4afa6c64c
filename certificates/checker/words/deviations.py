"""The letters of a sentence that are deviations from an equilibrium value other than zero."""

from __future__ import annotations

from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop

MEANT = {
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
    told = [MEANT[a] for a in letters if a in loop.resting_elsewhere]
    star = ", with * for the point of rest" if any("*" in one for one in told) else ""
    return f"; here {', '.join(told)}{star}" if told else ""
