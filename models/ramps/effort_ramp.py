r"""The effort ramp: how one demanded rotor deceleration is shared between torque and pitch.

    psi(s) = 0                    for s <= -eps
             (s + eps)^2 / 4 eps  for |s| <= eps
             s                    for s >= eps

so that psi(s) - psi(-s) = s, 0 <= psi' <= 1, and psi'(s) + psi'(-s) = 1: what one actuator does
not deliver the other does.  In the words of the coupling filter, f1 = psi' and f2 = 1 - psi'.

psi is convex, so the secant from a rest r,

    F(s) = (psi(s) - psi(r)) / (s - r),      psi(-s) - psi(-r) = -(1 - F(s)) (s - r),

does not decrease in s: its range over an interval is that of the ends.  F is the share of the first
actuator in the motion from r; the other has 1 - F.

``effort_ramp`` and its slope are for floats; ``ramp``, its slope and F are exact.
"""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.intervals.interval import Interval


def effort_ramp(effort: ArrayLike, overlap: float) -> Floats:
    """Return psi(s), the part of the effort above the corner.

    Parameters
    ----------
    effort : s, any shape; in a turbine's law [rad/s^2].
    overlap : eps > 0 in the same unit, half the width over which both actuators act.
    """
    s = np.asarray(effort, dtype=np.float64)
    middle = (np.clip(s, -overlap, overlap) + overlap) ** 2 / (4 * overlap)
    return np.asarray(np.where(s > overlap, s, middle), dtype=np.float64)


def effort_ramp_slope(effort: ArrayLike, overlap: float) -> Floats:
    """Return psi'(s) in [0, 1], the share of a change of effort that pitch delivers."""
    s = np.asarray(effort, dtype=np.float64)
    return np.asarray(np.clip((s + overlap) / (2 * overlap), 0.0, 1.0), dtype=np.float64)


def ramp(s: Fraction, overlap: Fraction) -> Fraction:
    """Return psi(s), exactly."""
    if s <= -overlap:
        return Fraction(0)
    return s if s >= overlap else (s + overlap) ** 2 / (4 * overlap)


def ramp_slope(s: Fraction, overlap: Fraction) -> Fraction:
    """Return psi'(s) in [0, 1], exactly."""
    return min(max((s + overlap) / (2 * overlap), Fraction(0)), Fraction(1))


def share_value(s: Fraction, rest: Fraction, overlap: Fraction) -> Fraction:
    """Return F(s), exactly; the slope of psi where s is the rest."""
    if s == rest:
        return ramp_slope(rest, overlap)
    return (ramp(s, overlap) - ramp(rest, overlap)) / (s - rest)


def share_range(effort: Interval, rest: Fraction, overlap: Fraction) -> Interval:
    """Return the range of F over an interval of efforts, exactly."""
    return Interval(
        share_value(effort.lower, rest, overlap), share_value(effort.upper, rest, overlap)
    )
