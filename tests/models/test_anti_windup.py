"""The effort-sharing law's integral limit: a loop that was out of reach comes back soon."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from numpy.typing import NDArray

from takagi.models.laws.effort_sharing.law import EffortGains, EffortSharingLaw
from takagi.models.laws.effort_sharing.schedule import effort_schedule
from takagi.models.simulation.closed_loop import History, simulate
from takagi.models.simulation.turbine_plant import design_plant
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.loader import nrel5mw
from tests.winds import constant_wind

Array = NDArray[np.float64]
FAULT = (5.0, 45.0)


@dataclass(frozen=True)
class Stuck:
    """A wind estimate that stands at 20 m/s from 5 to 45 s, and is true else."""

    wind: float

    def initial_state(self, rotor_speed: float, wind: float) -> Array:
        return np.zeros(1)

    def wind_estimate(self, state: Array) -> float:
        return 20.0 if FAULT[0] <= state[0] < FAULT[1] else self.wind

    def state_rate(self, state: Array, rotor_speed: float, pitch: float, torque: float) -> Array:
        return np.ones(1)


@pytest.fixture(scope="module")
def turbine() -> Turbine:
    return nrel5mw()


def faulty(turbine: Turbine, limit: float) -> History:
    """Return 90 s at 14 m/s with an estimate that is 6 m/s too high for 40 s."""
    schedule = effort_schedule(turbine)
    count = len(schedule.wind)
    gains = EffortGains(np.full(count, 0.6), np.full(count - 1, 0.15))
    law = replace(EffortSharingLaw.of(turbine, schedule, gains), integral_limit=limit)
    return simulate(design_plant(turbine), law, constant_wind(14.0, 90.0), observer=Stuck(14.0))


@pytest.mark.slow
def test_the_limit_shortens_the_way_back(turbine: Turbine) -> None:
    """Far outside the certified set |x| stops at its limit; overspeed after the fault is halved."""
    held, free = faulty(turbine, 0.1), faulty(turbine, 10.0)
    rated = turbine.rated_rotor_speed
    after = held.time > FAULT[1]

    assert np.abs(held.law_states[:, 0]).max() == pytest.approx(0.1, abs=1e-12)
    assert np.abs(free.law_states[:, 0]).max() > 0.2
    assert held.rotor_speed.min() < 0.95 * rated
    overspeed = [float(run.rotor_speed[after].max() / rated - 1) for run in (held, free)]
    assert overspeed[0] < 0.06 and overspeed[0] < 0.6 * overspeed[1]


@pytest.mark.slow
def test_it_recovers_within_a_minute(turbine: Turbine) -> None:
    """Speed within 2.5 % of rated from 30 s after the fault on, 1 % from 44 s on.

    That is the filter of 12 s on the estimate, which forgets 6 m/s.  The integral is inside again.
    """
    history = faulty(turbine, 0.1)
    late, last = (history.time > FAULT[1] + after for after in (30.0, 44.0))
    off = np.abs(history.rotor_speed / turbine.rated_rotor_speed - 1)

    assert off[late].max() < 0.025
    assert off[last].max() < 0.01
    assert np.abs(history.law_states[last, 0]).max() < 0.05
