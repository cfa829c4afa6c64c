"""The requests for a certificate, ``certify(model, claims=[...])``; each loads when it is used."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.models.lazy_names import lazy_names

if TYPE_CHECKING:
    from takagi.certificates.requests.attraction_region import AttractionRegion as AttractionRegion
    from takagi.certificates.requests.channel_norms import H2Norm as H2Norm
    from takagi.certificates.requests.channel_norms import L2Gain as L2Gain
    from takagi.certificates.requests.channel_norms import Peak as Peak
    from takagi.certificates.requests.decay import Decay as Decay
    from takagi.certificates.requests.decay import Poles as Poles
    from takagi.certificates.requests.exit_probability import ExitProbability as ExitProbability
    from takagi.certificates.requests.fuzzy_decay import FuzzyDecay as FuzzyDecay
    from takagi.certificates.requests.fuzzy_decay import FuzzyL2Gain as FuzzyL2Gain
    from takagi.certificates.requests.invariant_ellipsoid import InputLimits as InputLimits
    from takagi.certificates.requests.invariant_ellipsoid import (
        InvariantEllipsoid as InvariantEllipsoid,
    )
    from takagi.certificates.requests.observer import ObservedFeedback as ObservedFeedback
    from takagi.certificates.requests.observer import ObservedLoop as ObservedLoop
    from takagi.certificates.requests.observer import ObserverError as ObserverError
    from takagi.certificates.requests.robustness import GainRounding as GainRounding
    from takagi.certificates.requests.sampled_loop import SampledLoop as SampledLoop
    from takagi.certificates.requests.transient import Transient as Transient

__getattr__, __dir__ = lazy_names(__name__)
