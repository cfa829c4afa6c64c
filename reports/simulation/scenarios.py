"""The winds to choose from, by the name of their scenario."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isfinite
from types import MappingProxyType

import numpy as np

from takagi.models.errors import ModelError, did_you_mean
from takagi.models.simulation.scenario import PAPER_DURATION, PAPER_SEED, published_winds
from takagi.models.simulation.wind import WindSeries, gust_wind, step_wind
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import rated_wind

# An hour at 50 samples a second: a longer record adds no information and needs much memory.
LONGEST = 3600.0
# Half the height of the steps around rated wind [m/s].
HALF_STEP = 1.5

Winds = Callable[[Turbine, float, int], tuple[WindSeries, ...]]


@dataclass(frozen=True, slots=True)
class Scenario:
    """Winds by name.

    Attributes
    ----------
    about : one line for tables and help.
    duration : of every wind unless asked otherwise [s].
    seeded : whether the winds depend on a seed.
    winds : (turbine, duration [s], seed) -> the winds.
    """

    about: str
    duration: float
    seeded: bool
    winds: Winds


def scenario_winds(
    turbine: Turbine, name: str, *, duration: float | None = None, seed: int | None = None
) -> tuple[WindSeries, ...]:
    """Return the winds of a scenario.

    Parameters
    ----------
    name : one of ``SCENARIOS``.
    duration : [s]; None takes the scenario's.
    seed : 0 or more, for winds that have one; None takes that of the paper's scenario.

    Raises
    ------
    ModelError : an unknown scenario; a duration that is too short or above an hour; a seed below
        0, or for winds without chance.
    """
    if name not in SCENARIOS:
        raise ModelError(
            f"scenario {name!r} is not known{did_you_mean(name, SCENARIOS)}; choose one of "
            f"{', '.join(SCENARIOS)}"
        )
    chosen = SCENARIOS[name]
    asked = chosen.duration if duration is None else duration
    if not (isfinite(asked) and 0 < asked <= LONGEST):
        raise ModelError(
            f"duration {asked:g} s was given; it must be above 0 and at most {LONGEST:g} s (for "
            "more of the same turbulence, simulate several seeds)"
        )
    if seed is not None and not chosen.seeded:
        raise ModelError(
            f"seed {seed} was given, but scenario {name!r} has no turbulence; leave the seed out"
        )
    if seed is not None and seed < 0:
        raise ModelError(f"seed {seed} was given; it must be 0 or more")
    return chosen.winds(turbine, asked, PAPER_SEED if seed is None else seed)


def _steps(turbine: Turbine, duration: float, seed: int) -> tuple[WindSeries, ...]:
    rated = round(rated_wind(turbine), 2)
    low, high = rated - HALF_STEP, rated + HALF_STEP
    begin = duration / 4
    return (
        step_wind(low, high, duration, begin=begin),
        step_wind(high, low, duration, begin=begin),
    )


def _gusts(turbine: Turbine, duration: float, seed: int) -> tuple[WindSeries, ...]:
    rated = round(rated_wind(turbine), 2)
    means = (rated - 2.5, rated, rated + 4.5)
    radius = turbine.rotor_radius
    # Early, so that most of the record shows how the loop settles.
    begin = min(30.0, duration / 4)
    return tuple(gust_wind(v, duration, rotor_radius=radius, begin=begin) for v in means)


def _ramps(turbine: Turbine, duration: float, seed: int) -> tuple[WindSeries, ...]:
    share = np.array([0.0, 0.1, 0.5, 0.9, 1.0])
    speed = np.array([8.0, 8.0, 14.0, 8.0, 8.0])
    return (WindSeries(share * duration, speed, "ramp 8 to 14 to 8 m/s"),)


SCENARIOS: Mapping[str, Scenario] = MappingProxyType(
    {
        "paper": Scenario(
            "three turbulent winds, the same turbulence at different means",
            PAPER_DURATION,
            True,
            published_winds,
        ),
        "step": Scenario(
            f"steps from {HALF_STEP:g} m/s below rated wind to as much above, and back",
            120.0,
            False,
            _steps,
        ),
        "gust": Scenario(
            "the extreme operating gust of IEC 61400-1 below, at and above rated wind",
            90.0,
            False,
            _gusts,
        ),
        "ramp": Scenario("from 8 to 14 m/s and back, across rated wind", 180.0, False, _ramps),
    }
)
