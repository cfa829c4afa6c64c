"""The margins of the loop that runs where they are least: all winds, then all plants there."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from takagi.models.laws.protocol import Law
from takagi.models.simulation.closed_loop import Observer
from takagi.models.simulation.speed_filter import SpeedFilter
from takagi.models.turbine.data import Turbine
from takagi.reports.margins.running_equilibrium import NoEquilibrium
from takagi.reports.margins.running_over_wind import (
    NOMINAL,
    PLANTS,
    RunningMargins,
    running_margins,
)

# The machine as its file says is looked at so often, all plants at every whole wind [m/s].
FINE = 0.2
# A least disk margin is least as far as this to both sides [m/s].
AROUND = 1.0

Tell = Callable[[str], None]


@dataclass(frozen=True, slots=True, eq=False)
class SearchedMargins:
    """Margins over all winds.

    Attributes
    ----------
    rows : by wind, the machine as its file says first.
    whole : winds with all plants, at which nothing special happens: whole ones, and both ends.
    least : winds with all plants between them, at which a disk margin is locally least.
    none : winds at which the loop has no rest.
    """

    rows: tuple[RunningMargins, ...]
    whole: tuple[float, ...]
    least: tuple[float, ...]
    none: tuple[float, ...]


def searched_margins(
    turbine: Turbine,
    law: Law,
    observer: Observer,
    *,
    speed_filter: SpeedFilter | float | None,
    sample_time: float = 0.02,
    computation_time: float = 0.0,
) -> SearchedMargins:
    """Return the margins from cut-in to cut-out: finely, and for all plants where it counts.

    Parameters
    ----------
    speed_filter, sample_time, computation_time : see ``running_margins``.

    Raises
    ------
    ModelError : what ``running_margins`` refuses, but for a missing rest.
    """

    def at(wind: float, plants: Sequence[tuple[float, str]]) -> tuple[RunningMargins, ...]:
        return running_margins(
            turbine,
            law,
            observer,
            [wind],
            speed_filter=speed_filter,
            sample_time=sample_time,
            computation_time=computation_time,
            plants=plants,
        )

    found: dict[float, list[RunningMargins]] = {}
    none = []
    for wind in winds_between(turbine.cut_in, turbine.cut_out, FINE):
        try:
            found[wind] = list(at(wind, [NOMINAL]))
        except NoEquilibrium:
            none.append(wind)
    whole = [v for v in winds_between(turbine.cut_in, turbine.cut_out, 1.0) if v in found]
    nominal = [rows[0] for rows in found.values()]
    least = sorted(_least_winds(nominal) - set(whole))
    for wind in (*whole, *least):
        found[wind] += at(wind, [plant for plant in PLANTS if plant != NOMINAL])
    rows = tuple(row for wind in sorted(found) for row in found[wind])
    return SearchedMargins(rows, tuple(whole), tuple(least), tuple(none))


def winds_between(low: float, high: float, step: float) -> tuple[float, ...]:
    """Return the multiples of a step between two winds, and the two [m/s]."""
    count = range(math.ceil(low / step), math.floor(high / step + 1e-9) + 1)
    return tuple(sorted({low, high, *(round(k * step, 6) for k in count)}))


def _least_winds(rows: Sequence[RunningMargins]) -> set[float]:
    """Return where a disk margin is the least around, loop by loop."""
    found, winds = set(), np.array([row.wind for row in rows])
    for loop in ("torque", "pitch", "both"):
        alphas = np.array([_alpha(row, loop) for row in rows])
        for wind, alpha in zip(winds, alphas, strict=True):
            # Where the machine itself is unstable the other plants tell nothing more.
            if 0 < alpha <= np.nanmin(alphas[np.abs(winds - wind) <= AROUND], initial=math.inf):
                found.add(float(wind))
    return found


def _alpha(row: RunningMargins, loop: str) -> float:
    if loop == "both":
        return row.both.alpha
    margins = dict(row.loops).get(loop)
    return math.nan if margins is None else margins.disk.alpha


def wind_ranges(winds: Sequence[float], of: Sequence[float]) -> str:
    """Return some of all winds in words, neighbours as a range: "4 to 5.2 and 11 m/s"."""
    places = {wind: place for place, wind in enumerate(sorted(set(of)))}
    ordered = sorted(set(winds))
    cuts = [0, *(k + 1 for k, (a, b) in enumerate(pairwise(ordered)) if places[b] > places[a] + 1)]
    spans = [ordered[a:b] for a, b in pairwise([*cuts, len(ordered)])]
    words = [f"{s[0]:g}" if len(s) == 1 else f"{s[0]:g} to {s[-1]:g}" for s in spans]
    return f"{', '.join(words[:-1])} and {words[-1]} m/s" if words[1:] else f"{words[0]} m/s"
