r"""What is asked for, on pieces of the weights where the whole does not show it.

Three ways, from cheap to dear:

    pairs        the claim for the means of all pairs of rules
    points       a candidate from blends that the loop takes: rules, halves, quarters of them
    pieces       that candidate, on pieces of the weights until all means of their pairs have it

Blends at which a candidate fails on the way join the points.  If no function serves at the points,
none serves at all, and these points are the reason.  If one
does with room to spare, enough pieces show it.  So with ever more points and pieces one of the two
comes out, except on the very edge.
"""

from __future__ import annotations

from dataclasses import replace

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.requests.blend_points import grid
from takagi.certificates.requests.loop import Loop
from takagi.certificates.requests.observer import ObservedFeedback, ObserverError
from takagi.certificates.requests.request import Attempt, Request

__all__ = ["attempted"]

# Blends in halves, quarters, eighths of the rules, or of each premise's weights, at most so many.
PARTS, MOST_POINTS, ROUNDS = (2, 4, 8), 260, 10


def attempted(request: Request, loop: Loop) -> Attempt:
    """Return the best attempt: on the whole, or else on pieces of the weights.

    Raises
    ------
    ModelError : what is asked makes no sense for this loop.
    """
    found = request.attempt(loop)
    pairs = loop.is_double_sum or isinstance(request, ObserverError | ObservedFeedback)
    if found.checked.verdict is not Verdict.UNDECIDED or not pairs:
        return found
    tried = found.tried
    for parts in PARTS:
        points = grid(loop.family, parts, MOST_POINTS)
        if len(points) <= loop.family.rules:
            break
        for _ in range(ROUNDS):
            at = loop.at(points)
            again = request.attempt(at)
            tried = (*tried, f"{len(points)} blends of the loop", *again.tried)
            if again.checked.verdict is not Verdict.UNDECIDED:
                return replace(again, tried=tried)
            assert at.cuts is not None
            fresh = [point for point in dict.fromkeys(at.cuts.failed) if point not in points]
            points = [*points, *fresh]
            if not fresh:
                break
    return replace(found, tried=tried)
