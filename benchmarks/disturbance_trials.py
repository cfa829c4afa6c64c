"""Tests whether a law settles, oscillates or diverges after a start or a gust.

Every run begins at the equilibrium (or at the trim, where the law has none) at a constant wind that
the law knows, and is disturbed once. Its final behaviour is classified:

    lost      the table was left, or the final speed is over 5 % of rated from the equilibrium
    cycles    pitch still oscillates by more than 0.2 deg, and by more than half of its earlier
    amplitude
    stays     anything else
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from trial_plant import TrialLaw, TrialRotor, advance

from takagi.models.arrays import Floats

Codes = NDArray[np.int64]

STAYS, CYCLES, LOST = 0, 1, 2
STEP, DURATION, JUDGED = 0.025, 90.0, 20.0
PITCH_MOVES, HALF, SPEED_OFF = np.radians(0.2), 0.5, 0.05
BEGINS = 5.0


@dataclass(frozen=True, slots=True)
class Disturbance:
    """A start away from the equilibrium speed, or a gust of wind of the form 1 - cos.

    Attributes
    ----------
    speed : deviation of the start from the equilibrium [fraction of rated speed].
    gust : height [m/s];  lasts : of the gust [s].
    """

    name: str
    speed: float = 0.0
    gust: float = 0.0
    lasts: float = 10.0

    def wind(self, time: float) -> float:
        """Return the wind speed that the gust adds [m/s]."""
        s = (time - BEGINS) / self.lasts
        return self.gust * (1 - np.cos(2 * np.pi * s)) / 2 if 0 < s < 1 else 0.0


DISTURBANCES = (
    Disturbance("speed −0.1 %", speed=-0.001),
    Disturbance("speed −1 %", speed=-0.01),
    Disturbance("speed −3 %", speed=-0.03),
    Disturbance("speed +3 %", speed=0.03),
    Disturbance("speed −6 %", speed=-0.06),
    Disturbance("gust +1 m/s", gust=1.0),
    Disturbance("gust −1 m/s", gust=-1.0),
    Disturbance("gust +3 m/s", gust=3.0),
    Disturbance("gust −3 m/s", gust=-3.0),
)


@dataclass(frozen=True, slots=True, eq=False)
class TrialOutcome:
    """Results of n runs.

    Attributes
    ----------
    code : STAYS, CYCLES or LOST;  moves : peak to peak of pitch in the end [rad].
    fastest, slowest : rotor speed over all the run [rad/s].
    """

    code: Codes
    moves: Floats
    fastest: Floats
    slowest: Floats


def tried(
    rotor: TrialRotor,
    law: TrialLaw,
    rest: Floats,
    wind: Floats,
    disturbances: Sequence[Disturbance],
    *,
    rated_speed: float,
) -> TrialOutcome:
    """Return the result of each run.

    Parameters
    ----------
    rest : (3 + m, n) where each run begins: omega, beta, beta' and the law's own states.
    wind : (n,) [m/s];  disturbances : one per run.
    """
    state, settled = rest.copy(), rest[0].copy()
    state[0] += rated_speed * np.array([d.speed for d in disturbances])
    kinds = sorted(set(disturbances), key=lambda d: d.name)
    which = np.array([kinds.index(d) for d in disturbances])
    lost = np.zeros(len(wind), dtype=bool)
    fastest, slowest = state[0].copy(), state[0].copy()
    books = [_Swing(len(wind)), _Swing(len(wind))]
    for n in range(round(DURATION / STEP)):
        time = n * STEP
        winds = [
            wind + np.array([k.wind(t) for k in kinds])[which]
            for t in (time, time + STEP / 2, time + STEP)
        ]
        after, _ = advance(rotor, law, state, (winds[0], winds[1], winds[2]), STEP)
        ratio = after[0] * rotor.radius / winds[2]
        lost |= ~rotor.surface.inside(ratio, after[1]) | ~np.isfinite(after).all(axis=0)
        # A lost run is stopped at its last state: beyond the table its motion has no meaning.
        state = np.where(lost, state, after)
        fastest, slowest = np.maximum(fastest, state[0]), np.minimum(slowest, state[0])
        left = DURATION - time
        if left <= 2 * JUDGED:
            books[left <= JUDGED].enter(state)
    before, last = books
    lost |= np.abs(last.mean - settled) > SPEED_OFF * rated_speed
    cycles = (last.moves > PITCH_MOVES) & (last.moves > HALF * before.moves)
    code = np.where(lost, LOST, np.where(cycles, CYCLES, STAYS))
    return TrialOutcome(code, last.moves, fastest, slowest)


class _Swing:
    """Peak-to-peak pitch and mean speed over a time interval."""

    def __init__(self, count: int) -> None:
        self.low, self.high = np.full(count, np.inf), np.full(count, -np.inf)
        self.sum, self.entries = np.zeros(count), 0

    def enter(self, state: Floats) -> None:
        """Record the present state."""
        self.low, self.high = np.minimum(self.low, state[1]), np.maximum(self.high, state[1])
        self.sum, self.entries = self.sum + state[0], self.entries + 1

    @property
    def moves(self) -> Floats:
        """Peak to peak of pitch [rad]."""
        return np.asarray(self.high - self.low)

    @property
    def mean(self) -> Floats:
        """Mean speed [rad/s]."""
        return np.asarray(self.sum / max(self.entries, 1))
