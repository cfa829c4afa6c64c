r"""Ratios of simulated quantities to their certified bounds; a correct certificate gives at most 1.

set               V / 1                                  peaks        |h xi| / p_h
rotor speed       (omega - max omega*) / p_e
torque asked      (T_rated - T) / T_rated, before the limiter at 0
pitch asked       (beta_ref - beta_min) / (beta_max - beta_min), before the limiter
least pitch       0, and above 1 where beta < beta_min
decay             d_k over the mean rate at which (xi - xi*)' P (xi - xi*) has fallen so far
common decay      the same with R and d; both at constant wind alone
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from takagi.certificates.campaign.loop import CertifiedLoop
from takagi.certificates.campaign.motion import At, Demand, Drive, ramp, rates
from takagi.certificates.campaign.plants import DIRECTIONS, quadratic
from takagi.models.arrays import Floats

DECAYS = ("decay", "common decay")
BOUNDS = (
    *("set", "speed error", "effort lag", "speed signal", "integral", "rotor speed"),
    *("torque asked", "pitch asked", "least pitch", *DECAYS),
)
BISECTIONS = 60
# Below these distances to the equilibrium rounding dominates, so decay is not compared.
NEAREST, NEARLY_THERE = 1e-12, 1e-14


class RunEquilibrium(NamedTuple):
    """The equilibrium (0, 0, x*) of runs at constant wind, and V and the R-form at the start."""

    integral: Floats
    first: Floats
    first_common: Floats


def shares(loop: CertifiedLoop, state: Floats, xi: Floats, demand: Demand) -> Floats:
    """Return (9, n): the ratio to each bound except the decays, in the order of ``BOUNDS``."""
    reach = loop.pitch_max - loop.pitch_min
    below = loop.pitch_min - state[1]
    return np.stack(
        [
            quadratic(loop.P, xi),
            *(np.abs(DIRECTIONS @ xi) / loop.peaks[:, None]),
            (state[0] - loop.tables[0].max()) / loop.peaks[0],
            (loop.rated_torque - demand.torque) / loop.rated_torque,
            (demand.pitch - loop.pitch_min) / reach,
            np.where(below > 0, 1 + below / reach, 0.0),
        ]
    )


def run_equilibrium(loop: CertifiedLoop, at: At, drive: Drive, xi: Floats) -> RunEquilibrium:
    """Return the equilibrium of runs at constant wind, by bisection over x at e = zeta = 0."""
    low = np.full(len(at.wind), -2 * loop.peaks[3])
    high = -low
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        pitch = loop.pitch_min + ramp(at.effort - at.gain * middle, loop.overlap) / at.effectiveness
        moved, _ = rates(loop, np.stack([at.speed, pitch, middle]), at, drive)
        # e' grows with x: a larger x asks for less effort.
        low = np.where(moved[0] < 0, middle, low)
        high = np.where(moved[0] < 0, high, middle)
    rest = (low + high) / 2
    off = xi - np.stack([0 * rest, 0 * rest, rest])
    return RunEquilibrium(rest, quadratic(loop.P, off), quadratic(loop.R, off))


def decay_shares(
    loop: CertifiedLoop, rest: RunEquilibrium, drive: Drive, xi: Floats, time: Floats
) -> Floats:
    """Return (2, n): certified over observed mean rate, in P and in R; 0 where nothing is left."""
    off = xi - np.stack([0 * rest.integral, 0 * rest.integral, rest.integral])
    certified = (loop.decay_rate[drive.cell], np.full(len(time), loop.common_rate))
    found = []
    for M, first, rate in zip((loop.P, loop.R), rest[1:], certified, strict=True):
        left = quadratic(M, off)
        tells = (time > 0) & (first > NEAREST) & (left > NEARLY_THERE * first)
        fallen = np.log(np.where(tells, first, 1.0) / np.where(tells, left, 1.0))
        share = np.divide(2 * rate * time, fallen, out=np.full(len(time), np.inf), where=fallen > 0)
        found.append(np.where(tells & (rate > 0), share, 0.0))
    return np.stack(found)
