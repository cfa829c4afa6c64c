r"""The effort ramp: how one demanded rotor deceleration is shared between torque and pitch.

    psi(s) = 0                    for s <= -eps
             (s + eps)^2 / 4 eps  for |s| <= eps
             s                    for s >= eps

so that psi(s) - psi(-s) = s, 0 <= psi' <= 1, and psi'(s) + psi'(-s) = 1: what one actuator does
not deliver the other does.  In the words of the coupling filter, f1 = psi' and f2 = 1 - psi'.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from takagi.models.arrays import Floats


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
