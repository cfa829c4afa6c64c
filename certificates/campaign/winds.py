r"""Wind inputs within the class: random, sine, switching, and worst-case inputs that see the state.

At every step a player returns fractions in [-1, 1] of the cell's wind error and wind rate, the
wake's fraction in [0, 1], and the position of c_P in its range, 0 to 1.  Greedy players choose
those that make

    d/dt xi' Q xi = 2 xi' Q xi'

With Q = P this increases V, with Q = R the function of the common decay, with Q = h h' one bound.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from takagi.certificates.campaign.loop import CertifiedLoop
from takagi.certificates.campaign.motion import At, Demand, Drive, demanded, error_state, rates
from takagi.certificates.campaign.plants import DIRECTIONS
from takagi.models.arrays import Floats

# Mean times between two switches, and angular frequencies of waves: one decade to either side of
# the loop's natural frequency, which is near 0.3 rad/s.
SHORTEST, LONGEST = 0.1, 30.0
SLOWEST, FASTEST = 0.02, 5.0


class Seen(NamedTuple):
    """The inputs of a player for n runs: time [s], the last step [s], state, schedule, plants."""

    time: Floats
    last: Floats
    state: Floats
    at: At
    drive: Drive


class DisturbanceShares(NamedTuple):
    """Shares of wind error and wind rate in [-1, 1], of wake and of the range of c_P in [0, 1]."""

    error: Floats
    rate: Floats
    wake: Floats
    power: Floats


Player = Callable[[Seen], DisturbanceShares]
Maker = Callable[[CertifiedLoop, int, np.random.Generator], Player]


def calm(loop: CertifiedLoop, count: int, draw: np.random.Generator) -> Player:
    """Constant wind, v = v_s, and a constant plant: the conditions of the decay claim."""
    none, wake, power = np.zeros(count), _fixed(count, draw), _fixed(count, draw)
    return lambda seen: DisturbanceShares(none, none, wake, power)


def steady(loop: CertifiedLoop, count: int, draw: np.random.Generator) -> Player:
    """The largest wind error throughout, of either sign; the schedule wind is constant."""
    error, wake, power = draw.choice([-1.0, 1.0], count), _fixed(count, draw), _fixed(count, draw)
    none = np.zeros(count)
    return lambda seen: DisturbanceShares(error, none, wake, power)


def switches(loop: CertifiedLoop, count: int, draw: np.random.Generator) -> Player:
    """Random telegraph signals: error, rate, wake and c_P jump between their limits."""
    mean = np.exp(draw.uniform(np.log(SHORTEST), np.log(LONGEST), (4, count)))
    signs = draw.choice([-1.0, 1.0], (4, count))

    def play(seen: Seen) -> DisturbanceShares:
        flipped = draw.random((4, count)) < -np.expm1(-seen.last / mean)
        signs[flipped] *= -1
        return _of(signs)

    return play


def waves(loop: CertifiedLoop, count: int, draw: np.random.Generator) -> Player:
    """Sine waves of error, rate, wake and c_P, each with its own frequency and phase."""
    frequency = np.exp(draw.uniform(np.log(SLOWEST), np.log(FASTEST), (4, count)))
    phase = draw.uniform(0, 2 * np.pi, (4, count))

    def play(seen: Seen) -> DisturbanceShares:
        return _of(np.sin(frequency * seen.time + phase))

    return play


def wandering(loop: CertifiedLoop, count: int, draw: np.random.Generator) -> Player:
    """Coloured noise, cut at the ends of the class."""
    mean = np.exp(draw.uniform(np.log(SHORTEST), np.log(LONGEST), (4, count)))
    noise = draw.standard_normal((4, count))

    def play(seen: Seen) -> DisturbanceShares:
        kept = np.exp(-seen.last / mean)
        noise[:] = kept * noise + np.sqrt(1 - kept**2) * draw.standard_normal((4, count))
        return _of(np.clip(noise, -1, 1))

    return play


def against_set(loop: CertifiedLoop, count: int, draw: np.random.Generator) -> Player:
    """Maximise the growth of V = xi' P xi."""
    return _greedy(loop, np.broadcast_to(loop.P, (count, 3, 3)))


def against_settling(loop: CertifiedLoop, count: int, draw: np.random.Generator) -> Player:
    """Maximise the growth of xi' R xi, the function of the common decay rate."""
    return _greedy(loop, np.broadcast_to(loop.R, (count, 3, 3)))


def against_bounds(loop: CertifiedLoop, count: int, draw: np.random.Generator) -> Player:
    """Maximise the growth of one bounded quantity: speed error, effort lag or speed signal."""
    h = DIRECTIONS[draw.integers(3, size=count)]
    return _greedy(loop, h[:, :, None] * h[:, None, :])


def in_fits(loop: CertifiedLoop, count: int, draw: np.random.Generator) -> Player:
    """Increase V for a while, then decrease it or hold still: worst-case gusts."""
    push = _greedy(loop, np.broadcast_to(loop.P, (count, 3, 3)))
    mean = np.exp(draw.uniform(np.log(1.0), np.log(LONGEST), count))
    mood = draw.choice([-1.0, 0.0, 1.0], count)

    def play(seen: Seen) -> DisturbanceShares:
        changed = draw.random(count) < -np.expm1(-seen.last / mean)
        mood[changed] = draw.choice([-1.0, 0.0, 1.0], int(changed.sum()))
        answer = push(seen)
        return answer._replace(error=mood * answer.error, rate=mood * answer.rate)

    return play


# Name -> (maker, share of the runs).
PLAYERS: dict[str, tuple[Maker, float]] = {
    "calm": (calm, 0.16),
    "steady": (steady, 0.06),
    "switches": (switches, 0.16),
    "waves": (waves, 0.14),
    "wandering": (wandering, 0.10),
    "against the set": (against_set, 0.14),
    "against settling": (against_settling, 0.08),
    "against one bound": (against_bounds, 0.08),
    "in fits": (in_fits, 0.08),
}


def _of(signals: Floats) -> DisturbanceShares:
    """Return the answer of four signals in [-1, 1]."""
    return DisturbanceShares(signals[0].copy(), signals[1].copy(), *(1 + signals[2:]) / 2)


def _fixed(count: int, draw: np.random.Generator) -> Floats:
    """Return constant shares: a third 0, a third 1, the others between."""
    return np.asarray(np.clip(draw.uniform(-1.0, 2.0, count), 0.0, 1.0))


def _greedy(loop: CertifiedLoop, Q: Floats) -> Player:
    full, none = np.ones(len(Q)), np.zeros(len(Q))

    def play(seen: Seen) -> DisturbanceShares:
        still = seen.drive._replace(rate=none)
        demand = demanded(loop, seen.state, seen.at, still)
        gradient = np.einsum("nij,jn->in", Q, error_state(loop, seen.state, seen.at, demand))
        # More torque on the rotor moves e, and zeta by F gamma as much.
        push = gradient[0] + demand.share * seen.at.gain * gradient[1]
        error = np.where(push >= 0, 1.0, -1.0)
        wake = np.where(push * _wake_torque(loop, seen) >= 0, full, none)
        power = np.where(push >= 0, full, none)
        most = loop.wind_rate[seen.drive.cell]
        up, down = (
            _outward(loop, seen, seen.drive._replace(rate=sign * most, wake=wake), gradient)
            for sign in (1.0, -1.0)
        )
        return DisturbanceShares(error, np.where(up >= down, 1.0, -1.0), wake, power)

    return play


def _wake_torque(loop: CertifiedLoop, seen: Seen) -> Floats:
    """Return Delta of the frozen wake, for the table's c_P."""
    at, pitch = seen.at, seen.state[1]
    found = loop.surface(loop.rotor_radius * at.speed / at.wind, pitch)
    own = loop.torque_scale * at.wind**2 * found - at.trim_torque
    return np.asarray(-(at.limit * (pitch - at.trim_pitch) + own))


def _outward(loop: CertifiedLoop, seen: Seen, drive: Drive, gradient: Floats) -> Floats:
    """Return gradient' xi' under ``drive``."""
    moved, demand = rates(loop, seen.state, seen.at, drive)
    return np.asarray(np.einsum("in,in->n", gradient, error_rate(loop, seen, drive, moved, demand)))


def error_rate(
    loop: CertifiedLoop, seen: Seen, drive: Drive, moved: Floats, demand: Demand
) -> Floats:
    """Return (e', zeta', x'), (3, n), of states that move at ``moved``."""
    at, slope, rate = seen.at, loop.slopes[:, drive.cell], drive.rate
    e_rate = moved[0] - slope[0] * rate
    signal = seen.state[0] - at.speed - seen.state[2]
    effort_rate = (slope[1] + slope[3] * signal) * rate + at.gain * (e_rate - moved[2])
    angle = seen.state[1] - loop.pitch_min
    lag_rate = demand.share * effort_rate - slope[2] * rate * angle - at.effectiveness * moved[1]
    return np.stack([e_rate, lag_rate, moved[2]])
