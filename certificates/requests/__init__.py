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
    FuzzyL2Gain          gain of energy, by a function that depends on the weights
    L2Gain, H2Norm       gain of energy; variance under white noise
    ExitProbability      probability of leaving a set under white noise
    Peak                 gain of peaks, for bounded disturbances
    ObserverError        decay of an observer's error
    ObservedLoop         plant and observer of a law with measured outputs stay in a set
    ObservedFeedback     decay of the loop with u = -K xhat
    SampledLoop          decay with a law that runs every T seconds and holds its command
    attempts_at_all      all requests that apply to a loop

``loop/`` has the loop and the search tools; ``no_common_decay`` searches evidence that no common
function exists; ``scheduled_function`` writes one; ``fuzzy_pieces`` and ``on_pieces`` work on
pieces of the weights.

Importing this package loads no large module: a name is imported when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.requests.all_claims import attempts_at_all as attempts_at_all
    from takagi.certificates.requests.box_enlargement import BoxEnlargement as BoxEnlargement
    from takagi.certificates.requests.decay import Decay as Decay
    from takagi.certificates.requests.exit_probability import ExitProbability as ExitProbability
    from takagi.certificates.requests.fuzzy_decay import FuzzyDecay as FuzzyDecay
    from takagi.certificates.requests.fuzzy_l2_gain import FuzzyL2Gain as FuzzyL2Gain
    from takagi.certificates.requests.gain_rounding import GainRounding as GainRounding
    from takagi.certificates.requests.h2_norm import H2Norm as H2Norm
    from takagi.certificates.requests.input_limits import InputLimits as InputLimits
    from takagi.certificates.requests.invariant_ellipsoid import (
        InvariantEllipsoid as InvariantEllipsoid,
    )
    from takagi.certificates.requests.l2_gain import L2Gain as L2Gain
    from takagi.certificates.requests.loop.loop import ClaimedLoop as ClaimedLoop
    from takagi.certificates.requests.observed_loop import ObservedLoop as ObservedLoop
    from takagi.certificates.requests.observer import ObservedFeedback as ObservedFeedback
    from takagi.certificates.requests.observer import ObserverError as ObserverError
    from takagi.certificates.requests.peak import Peak as Peak
    from takagi.certificates.requests.pole_region import Poles as Poles
    from takagi.certificates.requests.request import Attempt as Attempt
    from takagi.certificates.requests.request import Request as Request
    from takagi.certificates.requests.sampled_loop import SampledLoop as SampledLoop
    from takagi.certificates.requests.transient import Transient as Transient

__getattr__, __dir__ = lazy_names(__name__)
