r"""Ramps that hand one quantity over to another.

The effort ramp shares one demanded rotor deceleration between torque and pitch:

    psi(s) = 0                    for s <= -eps
             (s + eps)^2 / 4 eps  for |s| <= eps
             s                    for s >= eps

so that psi(s) - psi(-s) = s, 0 <= psi' <= 1, and psi'(s) + psi'(-s) = 1: what one actuator does
not deliver the other does.  In the words of the coupling filter, f1 = psi' and f2 = 1 - psi'.

psi is convex, so the secant from a rest r,

    F(s) = (psi(s) - psi(r)) / (s - r),      psi(-s) - psi(-r) = -(1 - F(s)) (s - r),

does not decrease in s: its range over an interval is that of the ends.  F is the share of the first
actuator in the motion from r; the other has 1 - F.  ``effort_ramp`` and its slope are for floats;
``ramp``, its slope and F are exact.

The membership pair w_1 + w_2 = 1 of ``Ramp``, with s = (x - start)/width held to [0, 1]:

    linear   w_2 = s                  0 <= dw_2/dx <= 1/width      (continuous)
    smooth   w_2 = 3 s^2 - 2 s^3      0 <= dw_2/dx <= 3/(2 width)  (C1)

Without a width it is a switch: w_2 = 0 below the start, and 1 from there on.

The published law names the pair and its overlap but not its shape, nor where it lies relative to
rated speed; both are parameters here, and docs/laws.md says so.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean
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


Shape: TypeAlias = Literal["linear", "smooth"]


@dataclass(frozen=True, slots=True)
class Ramp:
    """w_2(x) from 0 at ``start`` to 1 at ``start + width``; w_1 = 1 - w_2.

    Attributes
    ----------
    start : where w_2 leaves 0, in the unit of x.
    width : the overlap, in the unit of x; 0 is a switch.
    shape : "linear" (continuous) or "smooth" (C1 cubic).

    Raises
    ------
    ModelError : a width below 0, a number that is not finite, an unknown shape.
    """

    start: float
    width: float
    shape: Shape = "smooth"

    def __post_init__(self) -> None:
        if not (math.isfinite(self.start) and math.isfinite(self.width) and self.width >= 0):
            raise ModelError(
                f"ramp from {self.start!r} over a width of {self.width!r} was given; finite "
                "numbers and a width above 0, or 0 for a switch, are needed"
            )
        if self.shape not in get_args(Shape):
            raise ModelError(
                f"ramp shape {self.shape!r} was given; it is one of "
                f"{', '.join(get_args(Shape))}{did_you_mean(str(self.shape), get_args(Shape))}"
            )

    @property
    def end(self) -> float:
        """start + width: from here on w_2 = 1."""
        return self.start + self.width

    def at(self, x: float) -> float:
        """Return w_2(x) for one number: what a control loop calls."""
        if self.width == 0.0:
            return float(x >= self.start)
        s = (x - self.start) / self.width
        if s <= 0.0:
            return 0.0
        if s >= 1.0:
            return 1.0
        return s if self.shape == "linear" else s * s * (3.0 - 2.0 * s)

    def __call__(self, x: ArrayLike) -> Floats:
        """Return w_2(x), elementwise."""
        return np.asarray(np.vectorize(self.at, otypes=[float])(x))

    def weights(self, x: ArrayLike) -> Floats:
        """Return (w_1, w_2) stacked on the first axis; both in [0, 1], sum 1."""
        second = self(x)
        return np.stack((1.0 - second, second))


def rated_speed_ramp(
    rated_speed: float, *, overlap: float, placement: float = 0.5, shape: Shape = "smooth"
) -> Ramp:
    """Return the ramp over ``overlap`` [rad/s] with a share ``placement`` of it above rated speed.

    Parameters
    ----------
    rated_speed : rotor speed [rad/s].
    overlap : width of the ramp, epsilon_omega [rad/s].
    placement : 0 ends the ramp at rated speed (w_2 = 1 there), 0.5 centres it, 1 starts it at
        rated speed (w_2 = 0 there).  Numbers outside [0, 1] shift it further.
    shape : see ``Ramp``.

    Raises
    ------
    ModelError : as ``Ramp``, or a placement that is not finite.
    """
    if not math.isfinite(placement):
        raise ModelError(
            f"ramp placement {placement!r} was given; a finite share of the overlap is needed: "
            "0 below rated speed, 0.5 around it, 1 above it"
        )
    return Ramp(rated_speed - (1.0 - placement) * overlap, overlap, shape)
