"""All claims about a loop: every request that applies to it, and its result."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from numpy.typing import ArrayLike

from takagi.certificates.requests.box_enlargement import BoxEnlargement
from takagi.certificates.requests.decay import Decay
from takagi.certificates.requests.gain_rounding import GainRounding
from takagi.certificates.requests.h2_norm import H2Norm
from takagi.certificates.requests.input_limits import InputLimits
from takagi.certificates.requests.invariant_ellipsoid import InvariantEllipsoid
from takagi.certificates.requests.l2_gain import L2Gain
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.valid_level import box_rows
from takagi.certificates.requests.observer import ObservedFeedback, ObserverError
from takagi.certificates.requests.on_pieces import attempted
from takagi.certificates.requests.peak import Peak
from takagi.certificates.requests.request import Attempt, Request
from takagi.certificates.requests.transient import Transient
from takagi.models.errors import ModelError


def attempts_at_all(
    loop: ClaimedLoop, *, decay_rate: float | None = None, observer: ArrayLike | None = None
) -> tuple[list[Attempt], list[str]]:
    """Return (attempts, notes): decay first, proved or not; of the others those that are proved.

    Claims that cannot be proved are left out of the certificate and listed in the notes. Without
    decay nothing else is tried, because the other claims include it.

    Parameters
    ----------
    decay_rate : the requested alpha [1/s]; None takes the largest rate found.
    observer : L, (r, n, p) or (n, p), of an observer for the loop; None for none.
    """
    first = attempted(Decay(decay_rate), loop)
    if not first.proved:
        return [first], ["without decay nothing else was tried"]
    found, notes = proved_of(requests_for(loop, observer=observer), loop)
    return [first, *found], notes


def proved_of(requests: Iterable[Request], loop: ClaimedLoop) -> tuple[list[Attempt], list[str]]:
    """Return the attempts that are proved, and a note for each request that is not."""
    found: list[Attempt] = []
    notes: list[str] = []
    for request in requests:
        name = type(request).__name__
        try:
            attempt = attempted(request, loop)
        except ModelError as error:
            notes.append(f"{name}: {error}")
            continue
        if attempt.proved:
            found.append(attempt)
        else:
            words = attempt.tried[-1] if attempt.tried else "nothing was tried"
            notes.append(f"{name}: not proved ({attempt.checked.text}; last: {words})")
    return found, notes


def requests_for(loop: ClaimedLoop, *, observer: ArrayLike | None = None) -> Iterator[Request]:
    """Yield the requests other than decay for which a loop has the matrices and the box.

    With a box, an invariant ellipsoid is requested; with gains also bounds of the inputs on it.
    Rates of inputs are requested only if they need no bound on how fast the memberships change.
    Norms are requested from the model's disturbance to its output, if the model has both.
    """
    exact = loop.exact
    yield Transient()
    if loop.gains is not None:
        yield GainRounding()
    if loop.model.premises:
        yield BoxEnlargement()
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
    if observer is not None:
        yield ObserverError(observer)
        if loop.gains is not None:
            yield ObservedFeedback(observer)
