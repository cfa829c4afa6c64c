"""The numbers of the effort-sharing law that trade calm for margin, and how far each may be moved.

Each lever makes the loop that runs slower, or takes lag out of it.  Its position is a share from 0,
where the settings stand, to 1, the end of its range; in between it is geometric:

    lever              from 0 to 1                      it raises margins because
    low-pass           corner times 4                   less lag at every frequency
    integral           integral shares times 0.3        less lag below the crossover
    wind filter        time times 2.5, at most 100 s    estimate and law answer each other later
    bandwidth growth   down to 1                        less gain at high wind
    bandwidth          both bandwidths times 0.4        less gain

They are put back in the reverse of this order where less is enough: what costs the machine least
is kept, what costs overspeed is given back first.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from takagi.certificates.design.turbine.settings import DesignSettings
from takagi.lmi.turbine.effort import EffortSettings

if TYPE_CHECKING:
    from collections.abc import Collection

LONGEST_FILTER = 100.0  # s; what the command line allows


@dataclass(frozen=True, slots=True)
class Lever:
    """One lever.

    Attributes
    ----------
    name : in words;  unit : of its number.
    options : options of the command line that fix it where they are given.
    end : settings -> the number at the end of its range.
    number : settings -> the number now.
    moved : (settings, number, its ratio to the number before) -> settings.
    why : what it does to the margins.
    """

    name: str
    unit: str
    options: tuple[str, ...]
    end: Callable[[DesignSettings], float]
    number: Callable[[DesignSettings], float]
    moved: Callable[[DesignSettings, float, float], DesignSettings]
    why: str

    def at(self, asked: DesignSettings, share: float) -> DesignSettings:
        """Return the settings with this lever at a share of its range, in two digits."""
        start, end = self.number(asked), self.end(asked)
        if share <= 0 or start <= 0 or start == end:
            return asked
        number = float(f"{start * (end / start) ** share:.2g}")
        return self.moved(asked, number, number / start)


def effort_of(asked: DesignSettings) -> EffortSettings:
    """Return what is asked of the gains, the defaults if nothing is."""
    return asked.effort or EffortSettings()


def _integral(asked: DesignSettings, number: float, ratio: float) -> DesignSettings:
    partial = float(f"{ratio * effort_of(asked).partial_integral_share:.2g}")
    effort = replace(effort_of(asked), integral_share=number, partial_integral_share=partial)
    return replace(asked, effort=effort)


def _bandwidth(asked: DesignSettings, number: float, ratio: float) -> DesignSettings:
    partial = float(f"{ratio * effort_of(asked).partial_bandwidth:.2g}")
    effort = replace(effort_of(asked), bandwidth=number, partial_bandwidth=partial)
    return replace(asked, effort=effort)


def _growth(asked: DesignSettings, number: float, _: float) -> DesignSettings:
    return replace(asked, effort=replace(effort_of(asked), bandwidth_growth=number))


LEVERS = (
    Lever(
        "low-pass on the speed",
        "rad/s",
        ("speed_filter",),
        lambda s: 4 * s.speed_filter,
        lambda s: s.speed_filter,
        lambda s, number, _: replace(s, speed_filter=number),
        "less lag",
    ),
    Lever(
        "integral share",
        "",
        (),
        lambda s: 0.3 * effort_of(s).integral_share,
        lambda s: effort_of(s).integral_share,
        _integral,
        "less lag below the crossover",
    ),
    Lever(
        "wind filter",
        "s",
        ("wind_filter",),
        lambda s: max(s.wind_filter, min(2.5 * s.wind_filter, LONGEST_FILTER)),
        lambda s: s.wind_filter,
        lambda s, number, _: replace(s, wind_filter=number),
        "the estimate moves the law less",
    ),
    Lever(
        "bandwidth growth",
        "",
        ("bandwidth_growth",),
        lambda _: 1.0,
        lambda s: max(1.0, effort_of(s).bandwidth_growth),
        _growth,
        "less gain at high wind",
    ),
    Lever(
        "bandwidth",
        "1/s",
        ("bandwidth",),
        lambda s: 0.4 * effort_of(s).bandwidth,
        lambda s: effort_of(s).bandwidth,
        _bandwidth,
        "less gain",
    ),
)


def free_levers(given: Collection[str]) -> tuple[Lever, ...]:
    """Return the levers that no given option fixes."""
    return tuple(lever for lever in LEVERS if not set(lever.options) & set(given))


def positioned(
    asked: DesignSettings, levers: tuple[Lever, ...], shares: tuple[float, ...]
) -> DesignSettings:
    """Return the settings with every lever at its share."""
    found = asked
    for lever, share in zip(levers, shares, strict=True):
        found = lever.at(found, share)
    return found


def lever_changes(before: DesignSettings, after: DesignSettings) -> tuple[str, ...]:
    """Return what was moved, in words: "wind filter 12 to 15 s (the estimate ... less)"."""
    found = []
    for lever in LEVERS:
        old, new = lever.number(before), lever.number(after)
        if old != new:
            unit = f" {lever.unit}" if lever.unit else ""
            found.append(f"{lever.name} {old:g} to {new:g}{unit} ({lever.why})")
    return tuple(found)
