r"""``invariant-ellipsoid``: {x'Px <= c} lies in the model's box, and no solution leaves it.

So the model equals its plant along every solution that starts inside.  Without disturbance the set
is a region of attraction: every such solution tends to 0.  ``invariant_set`` has the inequalities
and the evidence; ``box_of_validity`` has the inequalities about the box, for states and for inputs
u = -K_j x.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 5.2 and 6.1.3.
"""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.kernel.reader import text
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.kinds.invariant_set import read_invariant_set
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop


def check_invariant_ellipsoid(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return the verdict on a claim with the evidence of ``invariant_set``."""
    name = text(claim, "name", where)
    held = read_invariant_set(claim, loop, where)
    why = held.why_not(loop)
    if why:
        return Claim(name, Verdict.UNDECIDED, why)
    said = {"name": name, "loop": loop, "held": held}
    return Found(Verdict.PROVED, "invariant_ellipsoid", said)
