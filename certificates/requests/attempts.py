r"""Attempts to prove a request, on pieces of the weights where needed; all requests of a loop.

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

from collections.abc import Iterable, Iterator
from dataclasses import replace

from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.requests.attraction_region import AttractionRegion
from takagi.certificates.requests.channel_norms import H2Norm, L2Gain, Peak
from takagi.certificates.requests.decay import Decay, common_function, faster_function
from takagi.certificates.requests.fuzzy_decay import FuzzyDecay
from takagi.certificates.requests.invariant_ellipsoid import InputLimits, InvariantEllipsoid
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.set_level import box_rows
from takagi.certificates.requests.loop.weight_pieces import grid
from takagi.certificates.requests.observer import ObservedFeedback, ObserverError
from takagi.certificates.requests.request import Attempt, Request
from takagi.certificates.requests.robustness import GainRounding
from takagi.certificates.requests.sampled_loop import SampledLoop
from takagi.certificates.requests.transient import Transient
from takagi.models.errors import ModelError

METHOD_OF_PAIRS = "rules and means of pairs as vertices; a mean that fails excludes nothing"
# Blends with shares in halves, quarters and eighths of the rules, or of each premise's weights;
# their largest number, and how often blends at which a candidate failed are added.
SHARE_DENOMINATORS, MOST_POINTS, MOST_ROUNDS = (2, 4, 8), 260, 10


def attempted(request: Request, loop: ClaimedLoop) -> Attempt:
    """Return the best attempt: on the whole simplex, or else on pieces of the weights.

    Raises
    ------
    ModelError : the request makes no sense for this loop.
    """
    if isinstance(request, AttractionRegion | SampledLoop):
        # It is about the plant itself; or, while the command is held, the law's weights differ from
        # the plant's: blends of one set of weights do not describe the loop.
        return request.attempt(loop)
    pairs = loop.is_double_sum or isinstance(request, ObserverError | ObservedFeedback)
    falls = request.includes_decay
    points = grid(loop.exact, SHARE_DENOMINATORS[0], MOST_POINTS) if pairs else []
    tried: tuple[str, ...] = ()
    attempt = None
    if len(points) <= loop.exact.rules or not falls or _may_fall(loop):
        attempt = request.attempt(loop)
        tried = (METHOD_OF_PAIRS, *attempt.tried) if pairs else attempt.tried
        if attempt.checked.verdict is not Verdict.UNDECIDED:
            return attempt
    for denominator in () if isinstance(request, FuzzyDecay) else SHARE_DENOMINATORS:
        points = grid(loop.exact, denominator, MOST_POINTS) if pairs else []
        if len(points) <= loop.exact.rules:
            break
        for _ in range(MOST_ROUNDS):
            loop_at_points = loop.at(points)
            if falls and not _may_fall(loop_at_points):
                reason = f"V falls along {len(points)} blends of the loop for no common P"
                return replace(attempt or request.attempt(loop), tried=(*tried, reason))
            attempt_at_points = request.attempt(loop_at_points)
            tried = (*tried, f"{len(points)} blends of the loop", *attempt_at_points.tried)
            if attempt_at_points.checked.verdict is not Verdict.UNDECIDED:
                return replace(attempt_at_points, tried=tried)
            assert loop_at_points.cuts is not None
            failed = [p for p in dict.fromkeys(loop_at_points.cuts.failed) if p not in points]
            points = [*points, *failed]
            if not failed:
                break
        attempt = attempt or attempt_at_points
    if isinstance(request, FuzzyDecay) and pairs:
        # A common P is a special case of a scheduled P(h), so it proves that claim too.
        common = attempted(Decay(request.decay_rate), loop)
        if common.proved:
            return replace(common, tried=(*tried, "one P for all weights", *common.tried))
    return replace(attempt or request.attempt(loop), tried=tried)


def _may_fall(loop: ClaimedLoop) -> bool:
    """Return whether some V decreases at all blends; otherwise no other claim is tried."""
    if common_function(loop, 0.0).status != "infeasible":
        return True
    return faster_function(loop, 0.0) is not None


def attempts_at_all(
    loop: ClaimedLoop, *, decay_rate: float | None = None
) -> tuple[list[Attempt], list[str]]:
    """Return (attempts, notes): decay first, proved or not; of the others those that are proved.

    Claims that cannot be proved are left out of the certificate and listed in the notes. Without
    decay nothing else is tried, because the other claims include it.

    ``decay_rate`` : the requested alpha [1/s]; None takes the largest rate found.
    """
    decay = attempted(Decay(decay_rate), loop)
    if not decay.proved:
        return [decay], ["without decay nothing else was tried"]
    attempts, notes = proved_of(requests_for(loop), loop)
    return [decay, *attempts], notes


def proved_of(requests: Iterable[Request], loop: ClaimedLoop) -> tuple[list[Attempt], list[str]]:
    """Return the attempts that are proved, and a note for each request that is not."""
    proved: list[Attempt] = []
    notes: list[str] = []
    for request in requests:
        name = type(request).__name__
        try:
            attempt = attempted(request, loop)
        except ModelError as error:
            notes.append(f"{name}: {error}")
            continue
        if attempt.proved:
            proved.append(attempt)
        else:
            words = attempt.tried[-1] if attempt.tried else "nothing was tried"
            notes.append(f"{name}: not proved ({attempt.checked.text}; last: {words})")
    return proved, notes


def requests_for(loop: ClaimedLoop) -> Iterator[Request]:
    """Yield the requests other than decay for which a loop has the matrices and the box.

    With a box, an invariant ellipsoid is requested; with gains also bounds of the inputs on it.
    Rates of inputs are requested only if they need no bound on how fast the memberships change.
    Norms are requested from the model's disturbance to its output, if the model has both.
    """
    exact = loop.exact
    yield Transient()
    if loop.gains is not None:
        yield GainRounding()
    if len(box_rows(loop)):
        yield InvariantEllipsoid()
        if loop.gains is not None:
            yield InputLimits(rates=len(exact.K) == 1 or exact.is_discrete)
        bounded = exact.other_box or {}
        if exact.E and exact.disturbances and all(k in bounded for k in exact.disturbances):
            yield InvariantEllipsoid(disturbance_bounds="box")
    if exact.E and exact.C:
        yield L2Gain(energy_bound="largest")
        yield H2Norm()
        yield Peak()
