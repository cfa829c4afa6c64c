"""Searches a smaller uncertainty that a joint analysis covers, for an error message."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.claims.turbine.effort_sharing import effort_sharing_candidate
from takagi.models.intervals.interval import Interval
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.effort_sharing.loop_cell import LoopBox, LoopUncertainty
from takagi.models.turbine.data import Turbine

# Fractions of the requested interval's excess over 1 that are tried, the largest first.
SHARES = (Fraction(1, 2), Fraction(1, 4), Fraction(1, 8), Fraction(1, 16))
DIGITS = 3


def smaller_uncertainty(
    turbine: Turbine, law: EffortSharingLaw, box: LoopBox, uncertainty: LoopUncertainty
) -> str:
    """Return, in words, a part of the uncertainty for which a common function is found.

    It tries an inertia interval of a half to a sixteenth of the excess over nominal, then only the
    wake of the surface. It uses floating point and the given gains. Empty if none of them helps.
    """
    span = uncertainty.inertia
    for share in SHARES if span.width else ():
        narrow = _narrowed(span, share)
        smaller = LoopUncertainty(narrow, uncertainty.frozen_wake, uncertainty.power_coefficient)
        if effort_sharing_candidate(turbine, law, box=box, uncertainty=smaller).P is not None:
            low, high = float(narrow.lower), float(narrow.upper)
            return f"with these gains inertia {low:g} to {high:g} of nominal would do"
    if uncertainty.frozen_wake:
        smaller = LoopUncertainty(
            span, frozen_wake=False, power_coefficient=uncertainty.power_coefficient
        )
        if effort_sharing_candidate(turbine, law, box=box, uncertainty=smaller).P is not None:
            return "without the frozen wake it would do: lower the file's sensitivity or factor"
    return ""


def _narrowed(span: Interval, share: Fraction) -> Interval:
    """Return the interval around 1 with a fraction of each side's width, rounded towards 1."""
    scale = 10**DIGITS
    low, high = (1 - span.lower) * share * scale, (span.upper - 1) * share * scale
    return Interval(1 - Fraction(int(low), scale), 1 + Fraction(int(high), scale))
