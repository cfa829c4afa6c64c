"""The requests for a certificate, one per file; ``certify(model, claims=[...])``.

A request is a frozen dataclass with ``attempt(loop) -> Attempt``: it searches a candidate in
floating point, rounds it to short decimals, and lets the checker decide. If this fails, it tries a
weaker claim and reports this.

    Decay                V = x'Px decays, one P for all blends
    FuzzyDecay           V = x'P(h)x decays, P scheduled by the weights
    Poles                eigenvalues of every blend in a region
    GainRounding         the admissible error of every gain
    BoxEnlargement       how much wider the premises' ranges may be
    Transient            overshoot and settling time that follow from it
    InvariantEllipsoid   a set in the model's box that no solution leaves: region of attraction
    InputLimits          amplitudes and rates of the inputs on such a set
    L2Gain, H2Norm       gain of energy; variance under white noise
    Peak                 gain of peaks, for bounded disturbances
    ObserverError        decay of an observer's error
    ObservedLoop         plant and observer of a law with measured outputs stay in a set
    ObservedFeedback     decay of the loop with u = -K xhat
    SampledLoop          decay with a law that runs every T seconds and holds its command
    attempts_at_all      all requests that apply to a loop

``loop/`` has the loop and the search tools; ``no_common_decay`` searches evidence that no common
function exists; ``fuzzy_pieces`` and ``on_pieces`` work on pieces of the weights.

Importing this package loads no large module: a name is imported when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.requests.all_claims import attempts_at_all
    from takagi.certificates.requests.box_enlargement import BoxEnlargement
    from takagi.certificates.requests.decay import Decay
    from takagi.certificates.requests.fuzzy_decay import FuzzyDecay
    from takagi.certificates.requests.gain_rounding import GainRounding
    from takagi.certificates.requests.h2_norm import H2Norm
    from takagi.certificates.requests.input_limits import InputLimits
    from takagi.certificates.requests.invariant_ellipsoid import InvariantEllipsoid
    from takagi.certificates.requests.l2_gain import L2Gain
    from takagi.certificates.requests.loop.loop import ClaimedLoop, Loop
    from takagi.certificates.requests.observed_loop import ObservedLoop
    from takagi.certificates.requests.observer import ObservedFeedback, ObserverError
    from takagi.certificates.requests.peak import Peak
    from takagi.certificates.requests.pole_region import Poles
    from takagi.certificates.requests.request import Attempt, Request
    from takagi.certificates.requests.sampled_loop import SampledLoop
    from takagi.certificates.requests.transient import Transient

__all__ = [
    "Attempt",
    "BoxEnlargement",
    "ClaimedLoop",
    "Decay",
    "FuzzyDecay",
    "GainRounding",
    "H2Norm",
    "InputLimits",
    "InvariantEllipsoid",
    "L2Gain",
    "Loop",
    "ObservedFeedback",
    "ObservedLoop",
    "ObserverError",
    "Peak",
    "Poles",
    "Request",
    "SampledLoop",
    "Transient",
    "attempts_at_all",
]

__getattr__, __dir__ = lazy_names(__name__, __all__)
