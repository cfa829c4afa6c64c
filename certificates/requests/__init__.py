"""The requests for a certificate, ``certify(model, claims=[...])``.

A request is a frozen dataclass with ``attempt(loop) -> Attempt``: it searches a candidate in
floating point, rounds it to short decimals, and lets the checker decide. If this fails, it tries a
weaker claim and reports this.

    Decay                V = x'Px decays, one P for all blends
    FuzzyDecay           V = x'P(h)x decays, P scheduled by the weights
    Poles                eigenvalues of every blend in a region
    GainRounding         the admissible error of every gain
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

``loop/`` has the loop and the search tools; ``attempts`` tries requests, also on pieces of the
weights.

Importing this package loads no large module: a name is imported when it is first used.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.requests.decay import Decay as Decay
    from takagi.certificates.requests.decay import Poles as Poles
    from takagi.certificates.requests.exit_probability import ExitProbability as ExitProbability
    from takagi.certificates.requests.fuzzy_decay import FuzzyDecay as FuzzyDecay
    from takagi.certificates.requests.fuzzy_l2_gain import FuzzyL2Gain as FuzzyL2Gain
    from takagi.certificates.requests.h2_norm import H2Norm as H2Norm
    from takagi.certificates.requests.invariant_ellipsoid import InputLimits as InputLimits
    from takagi.certificates.requests.invariant_ellipsoid import (
        InvariantEllipsoid as InvariantEllipsoid,
    )
    from takagi.certificates.requests.l2_gain import L2Gain as L2Gain
    from takagi.certificates.requests.observer import ObservedFeedback as ObservedFeedback
    from takagi.certificates.requests.observer import ObservedLoop as ObservedLoop
    from takagi.certificates.requests.observer import ObserverError as ObserverError
    from takagi.certificates.requests.peak import Peak as Peak
    from takagi.certificates.requests.robustness import GainRounding as GainRounding
    from takagi.certificates.requests.sampled_loop import SampledLoop as SampledLoop
    from takagi.certificates.requests.transient import Transient as Transient

__getattr__, __dir__ = lazy_names(__name__)
