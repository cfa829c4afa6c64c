r"""The ramp by which two actuators share one effort, and the slopes of its secants.

    psi(s) = 0                      s <= -e
             (s + e)^2 / (4 e)      -e <= s <= e,    e the overlap
             s                      e <= s

psi is convex and continuously differentiable, 0 <= psi' <= 1, and psi(s) - psi(-s) = s: what one
actuator delivers, psi(U), less what the other takes, psi(-U), is the effort U.  The secant from a
rest r has the slope

    F(s) = (psi(s) - psi(r)) / (s - r),      psi(-s) - psi(-r) = -(1 - F(s)) (s - r),

the share of the first actuator in the motion from r; the other has 1 - F.  F does not decrease,
because psi is convex, so that its range over an interval is that of the ends.

Here psi is exact; ``takagi.models.ramps.effort_ramp`` has it in floating point.
"""

from __future__ import annotations

from fractions import Fraction

from takagi.models.intervals.interval import Interval


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
