"""Winds in ranges: partial load, transition, full load; the law on one of them alone."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortGains, EffortSharingLaw
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import rated_wind

# The transition, as fractions of rated wind: 10 to 13 m/s for the NREL 5-MW turbine.
TRANSITION = (0.875, 1.135)
COLUMNS = ("wind", "rotor_speed", "trim_effort", "effectiveness", "effectiveness_limit")


@dataclass(frozen=True, slots=True)
class WindRange:
    """Schedule winds from ``low`` to ``high`` [m/s], with the name of the region."""

    name: str
    low: float
    high: float

    @property
    def words(self) -> str:
        """The name with its winds."""
        return f"{self.name}, {self.low:g} to {self.high:g} m/s"


def wind_ranges(turbine: Turbine) -> tuple[WindRange, ...]:
    """Return partial load, transition and full load; their inner ends are whole m/s."""
    rated = rated_wind(turbine)
    low, high = (float(round(share * rated)) for share in TRANSITION)
    return (
        WindRange("partial load", turbine.cut_in, low),
        WindRange("transition", low, high),
        WindRange("full load", high, turbine.cut_out),
    )


def law_on(law: EffortSharingLaw, low: float, high: float) -> EffortSharingLaw:
    """Return the law with its tables cut to the nodes that enclose [low, high] [m/s].

    While its schedule wind stays between the first and the last of these nodes, its commands are
    those of the whole law. So its proved claims hold for the whole law under such winds.

    Raises
    ------
    ModelError : a range that is empty or leaves the tables.
    """
    wind = law.schedule.wind
    if not wind[0] <= low < high <= wind[-1]:
        raise ModelError(
            f"winds {low:g} to {high:g} m/s were given; a range inside the law's "
            f"{wind[0]:g} to {wind[-1]:g} m/s is needed"
        )
    first = int(np.searchsorted(wind, low, side="right")) - 1
    last = int(np.searchsorted(wind, high, side="left"))
    nodes, cells = slice(first, last + 1), slice(first, last)
    ahead = law.feedforward
    return replace(
        law,
        schedule=replace(
            law.schedule, **{name: getattr(law.schedule, name)[nodes] for name in COLUMNS}
        ),
        gains=EffortGains(law.gains.proportional[nodes], law.gains.integral_rate[cells]),
        feedforward=replace(
            ahead, inertia=ahead.inertia[cells], effort_limit=ahead.effort_limit[cells]
        ),
    )
