r"""Simulation of the law with its limits, the pitch drive and the rotor, for n runs at once.

    omega' = kappa (s_P c v^2 c_Q(omega R / v, beta) + Delta - n_g T_g / J)
    beta'  = sat((beta_ref - beta) / tau)
    x'     = -nu (omega - omega*)

The states are omega, beta, x, so the certificate's error coordinates (e, zeta, x) do not enter.
They are computed afterwards to compare them with its bounds.  Formulas and symbols are those
of docs/effort-sharing-loop.md.  Delta is a share w of the whole way to the frozen wake,

    Delta(beta; v_s) = -w int_{beta*}^{beta} (b_fw + s_P d(T_r/J)/dbeta) dbeta
              = -w (b_fw (beta - beta*) + s_P c v_s^2 (c_Q(lambda*, beta) - c_Q(lambda*, beta*))),

which belongs to the family for 0 <= w <= 1 where the integrand is not negative
(``plants.wake_fits``).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from takagi.certificates.campaign.loop import CertifiedLoop
from takagi.models.arrays import Floats, Indices

Cells = Indices
LEAST_WIND = 0.1


class At(NamedTuple):
    """The schedule at n winds v_s: tables, and the trim pitch with its torque c v_s^2 c_Q."""

    wind: Floats
    speed: Floats
    effort: Floats
    effectiveness: Floats
    gain: Floats
    limit: Floats
    trim_pitch: Floats
    trim_torque: Floats

    def of(self, runs: Cells) -> At:
        """Return the schedule of some of the runs."""
        return At(*(column[runs] for column in self))


class Drive(NamedTuple):
    """What acts on n runs during one step: all constant over it but v_s, which moves at ``rate``.

    Attributes
    ----------
    cell : wind cell;  error : v - v_s [m/s];  rate : v_s' [m/s^2].
    kappa : nominal over true inertia;  wake : w;  power : s_P, true over table's c_P [-].
    """

    cell: Cells
    error: Floats
    rate: Floats
    kappa: Floats
    wake: Floats
    power: Floats

    def of(self, runs: Cells) -> Drive:
        """Return what acts on some of the runs."""
        return Drive(self.cell[runs], *(column[runs] for column in self[1:]))


class Demand(NamedTuple):
    """The law's commands before its limits: torque [N m], pitch [rad]; and its effort U, F."""

    torque: Floats
    pitch: Floats
    effort: Floats
    shed: Floats
    share: Floats


def ramp(effort: Floats, overlap: float) -> Floats:
    """Return psi: 0 below -overlap, (s + overlap)^2 / 4 overlap on the ramp, s above."""
    bent = np.clip(effort + overlap, 0.0, 2 * overlap)
    return np.asarray(bent * bent / (4 * overlap) + np.maximum(effort - overlap, 0.0))


def at_wind(loop: CertifiedLoop, cell: Cells, wind: Floats) -> At:
    """Return the schedule of each run at its wind, which lies in its cell."""
    left, right = loop.wind[cell], loop.wind[cell + 1]
    share = (wind - left) / (right - left)
    low, high = loop.tables[:, cell], loop.tables[:, cell + 1]
    speed, effort, b, gain, limit = low + share * (high - low)
    trim = loop.pitch_min + ramp(effort, loop.overlap) / b
    torque = loop.torque_scale * wind**2 * loop.surface(speed * loop.rotor_radius / wind, trim)
    return At(wind, speed, effort, b, gain, limit, trim, torque)


def demanded(loop: CertifiedLoop, state: Floats, at: At, drive: Drive) -> Demand:
    """Return the law's commands, with its feed-forward of v_s'."""
    slope, k, rate = loop.slopes[:, drive.cell], drive.cell, drive.rate
    signal = state[0] - at.speed - state[2]
    effort = at.effort + at.gain * signal
    shed = ramp(effort, loop.overlap)
    kept = ramp(-effort, loop.overlap)
    share = np.clip((effort + loop.overlap) / (2 * loop.overlap), 0.0, 1.0)
    limit = loop.feedforward_limit[k]
    taken = np.clip(loop.inertia_feedforward[k] * rate, -limit, limit)
    moved = share * (slope[1] + slope[3] * signal) - shed * slope[2] / at.effectiveness
    pitch = loop.pitch_min + (shed + loop.pitch_lead * rate * moved) / at.effectiveness
    return Demand(
        loop.rated_torque - loop.effort_torque * (kept + taken), pitch, effort, shed, share
    )


def blowing(at: At, drive: Drive) -> Floats:
    """Return the wind v = v_s + error, limited below by a positive value."""
    return np.maximum(at.wind + drive.error, LEAST_WIND)


def rates(loop: CertifiedLoop, state: Floats, at: At, drive: Drive) -> tuple[Floats, Demand]:
    """Return (omega', beta', x') as (3, n), and what the law demands.

    Parameters
    ----------
    state : (3, n) omega [rad/s], beta [rad], x [rad/s].
    """
    speed, pitch, integral = state
    demand = demanded(loop, state, at, drive)
    torque = np.clip(demand.torque, 0.0, loop.rated_torque)
    reference = np.clip(demand.pitch, loop.pitch_min, loop.pitch_max)
    wind = blowing(at, drive)
    # One evaluation of the surface for both: at the actual rotor speed, and at omega* for the wake.
    ratio = np.concatenate([speed / wind, at.speed / at.wind]) * loop.rotor_radius
    found = loop.surface(ratio, np.concatenate([pitch, pitch]))
    n = len(speed)
    rotor = drive.power * loop.torque_scale * wind**2 * found[:n]
    own = drive.power * (loop.torque_scale * at.wind**2 * found[n:] - at.trim_torque)
    rotor -= drive.wake * (at.limit * (pitch - at.trim_pitch) + own)
    limit = loop.pitch_rate_limit
    e = speed - at.speed
    turn = -loop.integral_rate[drive.cell] * e
    held = (np.abs(integral) >= loop.integral_limit) & (turn * integral > 0)
    found = np.stack(
        [
            drive.kappa * (rotor - loop.gear_scale * torque),
            np.clip((reference - pitch) / loop.pitch_lag, -limit, limit),
            np.where(held, 0.0, turn),
        ]
    )
    return found, demand


def step(
    loop: CertifiedLoop, state: Floats, at: At, end: At, drive: Drive, duration: Floats
) -> tuple[Floats, Demand]:
    """Return the state one step of Runge-Kutta later, and the demand at its beginning.

    Parameters
    ----------
    at, end : the schedule at the step's two ends, within one cell.
    duration : (n,) [s].

    Source: the classical fourth-order method, Kutta (1901).
    """
    middle = at_wind(loop, drive.cell, (at.wind + end.wind) / 2)
    k1, demand = rates(loop, state, at, drive)
    k2, _ = rates(loop, state + duration / 2 * k1, middle, drive)
    k3, _ = rates(loop, state + duration / 2 * k2, middle, drive)
    k4, _ = rates(loop, state + duration * k3, end, drive)
    return state + duration / 6 * (k1 + 2 * k2 + 2 * k3 + k4), demand


def error_state(loop: CertifiedLoop, state: Floats, at: At, demand: Demand) -> Floats:
    """Return xi = (e, zeta, x) as (3, n), zeta = psi(U) - b (beta - beta_min)."""
    owed = demand.shed - at.effectiveness * (state[1] - loop.pitch_min)
    return np.stack([state[0] - at.speed, owed, state[2]])
