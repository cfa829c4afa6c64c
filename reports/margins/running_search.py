"""The margins of the loop that runs where they are least: all winds, then all plants there."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence, Set
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from takagi.reports.margins.running_loop import NOMINAL, NoEquilibrium, RunningLoops
from takagi.reports.margins.running_over_wind import PLANTS, RunningMargins, running_margins

# Step of wind for the nominal plant [m/s]; all plants are measured at every whole wind.
FINE = 0.2
# A least disk margin is least as far as this to both sides [m/s]: two steps, so that noise of the
# linearisation in one of them makes no place.
AROUND = 0.4


@dataclass(frozen=True, slots=True, eq=False)
class SearchedMargins:
    """Margins over all winds.

    rows : by wind, the machine as its file says first.
    whole : winds with all plants, at which nothing special happens: whole ones, and both ends.
    least : winds with all plants between them: a disk margin of the machine as its file says is
        locally least there, a loop begins or ends to act, or a margin of another plant is less
        than at the winds around.
    none : winds at which the loop has no rest.
    """

    rows: tuple[RunningMargins, ...]
    whole: tuple[float, ...]
    least: tuple[float, ...]
    none: tuple[float, ...]


def searched_margins(loops: RunningLoops) -> SearchedMargins:
    """Return the margins from cut-in to cut-out: finely, and for all plants where it counts.

    Raises ModelError: what ``running_margins`` refuses, but for a missing rest.
    """
    turbine = loops.plant.turbine
    found: dict[float, list[RunningMargins]] = {}
    none = []
    for wind in winds_between(turbine.cut_in, turbine.cut_out, FINE):
        try:
            found[wind] = list(running_margins(loops, [wind], plants=[NOMINAL]))
        except NoEquilibrium:
            none.append(wind)
    whole = [v for v in winds_between(turbine.cut_in, turbine.cut_out, 1.0) if v in found]
    nominal = [rows[0] for rows in found.values()]
    least = sorted((_least_winds(nominal) | _first_and_last(nominal)) - set(whole))
    others = [plant for plant in PLANTS if plant != NOMINAL]
    for wind in (*whole, *least):
        found[wind] += running_margins(loops, [wind], plants=others)
    # The other plants are weakest elsewhere: follow each margin down from where it is least so far.
    every = {*whole, *least}
    for kind in ("gain", "phase", "delay", "disk", "both"):
        for wind in _downhill(found, every, kind):
            found[wind] += running_margins(loops, [wind], plants=others)
            every.add(wind)
            least.append(wind)
    least.sort()
    rows = tuple(row for wind in sorted(found) for row in found[wind])
    return SearchedMargins(rows, tuple(whole), tuple(least), tuple(none))


def _size(row: RunningMargins, kind: str) -> float:
    """Return the least margin of a kind among the loops, or the disk margin of both at once."""
    if kind == "both":
        return row.both.alpha
    sizes = (m.disk.alpha if kind == "disk" else getattr(m, kind) for _, m in row.loops)
    return min(sizes, default=math.inf)


def _downhill(
    found: Mapping[float, Sequence[RunningMargins]], every: Set[float], kind: str
) -> Iterator[float]:
    """Yield the winds to look at next with all plants, until the least has both neighbours.

    ``every`` are the winds with all plants; who asks adds each wind that is yielded, and its rows.
    """

    def value(wind: float) -> float:
        return min(_size(row, kind) for row in found[wind])

    winds = sorted(found)
    while every:
        place = winds.index(min(sorted(every), key=value))
        around = (winds[k] for k in (place - 1, place + 1) if 0 <= k < len(winds))
        new = next((wind for wind in around if wind not in every), None)
        if new is None:
            return
        yield new


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


def _first_and_last(rows: Sequence[RunningMargins]) -> set[float]:
    """Return the first and the last wind at which each loop acts, and where it has a gap.

    Its gain begins with a finite value there: a margin may be least at that end, without being
    locally least.
    """
    found: set[float] = set()
    for loop in ("torque", "pitch"):
        acts = [loop in dict(row.loops) for row in rows]
        for k, (row, here) in enumerate(zip(rows, acts, strict=True)):
            before, after = acts[max(k - 1, 0)], acts[min(k + 1, len(rows) - 1)]
            if here and not (before and after):
                found.add(row.wind)
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
