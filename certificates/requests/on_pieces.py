r"""Proves a request on pieces of the weights if the whole simplex does not prove it.

Three methods, in order of cost:

    pairs        the claim for the means of all pairs of rules
    points       a candidate from single blends of the loop: rules, halves, quarters of them
    pieces       that candidate, on ever smaller pieces, until it holds for all means of pairs

Blends at which a candidate fails are added to the points.  If no function exists for the points,
then none exists for the loop, and these points are the evidence.  If a function exists with some
margin, a sufficient number of pieces proves it.  So with more points and pieces one of the two
results is reached, except in limiting cases without margin.
"""

from __future__ import annotations

from dataclasses import replace

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.requests.decay import Decay, common_function, faster_function
from takagi.certificates.requests.exit_probability import ExitProbability
from takagi.certificates.requests.fuzzy_decay import FuzzyDecay
from takagi.certificates.requests.gain_rounding import GainRounding
from takagi.certificates.requests.h2_norm import H2Norm
from takagi.certificates.requests.input_limits import InputLimits
from takagi.certificates.requests.invariant_ellipsoid import InvariantEllipsoid
from takagi.certificates.requests.l2_gain import L2Gain
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.weight_points import grid
from takagi.certificates.requests.observer import ObservedFeedback, ObserverError
from takagi.certificates.requests.peak import Peak
from takagi.certificates.requests.request import Attempt, Request
from takagi.certificates.requests.sampled_loop import SampledLoop
from takagi.certificates.requests.transient import Transient

# Claims that include decay: one P for which V decreases at all blends.
FALLING = (
    ExitProbability,
    GainRounding,
    H2Norm,
    InputLimits,
    InvariantEllipsoid,
    L2Gain,
    Peak,
    Transient,
)
# Blends with shares in halves, quarters and eighths of the rules, or of each premise's weights;
# and their largest number.
WHOLE = "rules and means of pairs as vertices; a mean that fails excludes nothing"
PARTS, MOST_POINTS, ROUNDS = (2, 4, 8), 260, 10


def attempted(request: Request, loop: ClaimedLoop) -> Attempt:
    """Return the best attempt: on the whole simplex, or else on pieces of the weights.

    Raises
    ------
    ModelError : the request makes no sense for this loop.
    """
    if isinstance(request, SampledLoop):
        # While the command is held, the law's weights differ from the plant's: blends of one set of
        # weights do not describe the loop.
        return request.attempt(loop)
    pairs = loop.is_double_sum or isinstance(request, ObserverError | ObservedFeedback)
    falls = isinstance(request, FALLING)
    points = grid(loop.exact, PARTS[0], MOST_POINTS) if pairs else []
    tried: tuple[str, ...] = ()
    found = None
    if len(points) <= loop.exact.rules or not falls or _may_fall(loop):
        found = request.attempt(loop)
        tried = (WHOLE, *found.tried) if pairs else found.tried
        if found.checked.verdict is not Verdict.UNDECIDED:
            return found
    for parts in () if isinstance(request, FuzzyDecay) else PARTS:
        points = grid(loop.exact, parts, MOST_POINTS) if pairs else []
        if len(points) <= loop.exact.rules:
            break
        for _ in range(ROUNDS):
            at = loop.at(points)
            if falls and not _may_fall(at):
                why = f"V falls along {len(points)} blends of the loop for no common P"
                return replace(found or request.attempt(loop), tried=(*tried, why))
            again = request.attempt(at)
            tried = (*tried, f"{len(points)} blends of the loop", *again.tried)
            if again.checked.verdict is not Verdict.UNDECIDED:
                return replace(again, tried=tried)
            assert at.cuts is not None
            fresh = [point for point in dict.fromkeys(at.cuts.failed) if point not in points]
            points = [*points, *fresh]
            if not fresh:
                break
        found = found or again
    if isinstance(request, FuzzyDecay) and pairs:
        # A common P is a special case of a scheduled P(h), so it proves that claim too.
        common = attempted(Decay(request.decay_rate), loop)
        if common.proved:
            return replace(common, tried=(*tried, "one P for all weights", *common.tried))
    return replace(found or request.attempt(loop), tried=tried)


def _may_fall(loop: ClaimedLoop) -> bool:
    """Return whether some V decreases at all blends; otherwise no other claim is tried."""
    if common_function(loop, 0.0).status != "infeasible":
        return True
    return faster_function(loop, 0.0) is not None
