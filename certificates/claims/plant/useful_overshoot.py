"""A proved bound of the overshoot is claimed where it says something: the best, or none."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from takagi.certificates.requests.loop.decimals import rounded_up
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.on_pieces import attempted
from takagi.certificates.requests.request import Attempt
from takagi.certificates.requests.transient import Transient
from takagi.models.arrays import Floats

# A motion from the invariant set stays in the box anyway.  A bound of k times says more only to
# starts within 1/k of the box, and a set that reaches a tenth of the box is called little of it.
USEFUL = 10.0
SETS = ("invariant-ellipsoid", "input-limits")
NAME = "overshoot and settling time, states over their half-widths of the invariant set"


def useful_overshoot(loop: ClaimedLoop, found: list[Attempt]) -> tuple[list[Attempt], list[str]]:
    """Return the proved attempts with a useful bound of the overshoot or none, and notes.

    A bound above 10 is asked for again with the states over their half-widths of the proved set:
    a state without a range has no other natural size.  If that is above 10 too, none is claimed,
    and the note says so.
    """
    kept, notes = [], []
    for attempt in found:
        if attempt.claim["kind"] != "transient" or _overshoot(attempt) <= USEFUL:
            kept.append(attempt)
            continue
        scales = _half_widths(found)
        again = None
        if scales is not None:
            again = attempted(Transient(scales=scales, name=NAME), loop)
        proved = [attempt, *([again] if again is not None and again.proved else [])]
        best = min(proved, key=_overshoot)
        if _overshoot(best) <= USEFUL:
            kept.append(best)
        else:
            notes.append(
                f"Transient: an overshoot of at most {_overshoot(best):.4g} times is proved, which "
                "says nothing beside the invariant set, and is not claimed"
            )
    return kept, notes


def _overshoot(attempt: Attempt) -> float:
    return float(Fraction(str(attempt.claim["overshoot"])))


def _half_widths(found: list[Attempt]) -> Floats | None:
    """Return (n,) of the first proved set, to two digits; None without one."""
    claim = next((a.claim for a in found if a.claim["kind"] in SETS), None)
    if claim is None:
        return None
    P = np.array([[float(Fraction(str(entry))) for entry in row] for row in claim["P"]])
    reach = np.sqrt(float(Fraction(str(claim["level"]))) * np.diag(np.linalg.inv(P)))
    return np.array([rounded_up(float(size), 2) for size in reach])
