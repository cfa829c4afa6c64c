"""Margins of the loop that runs, over wind, inertia and wake; its modes beside the crossover.

What can be asked is refused before the long work: a sampling that the modes do not fit in, a wind
that the observer cannot see.  A mode that the loop crosses over at is named with the margins, since
it is a loop that runs, with a margin.  All figures are floating point: measured, and not proved.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from contextlib import suppress
from dataclasses import dataclass, replace
from itertools import pairwise
from math import pi
from typing import NamedTuple

import numpy as np

from takagi.models.arrays import Complex, Floats
from takagi.models.errors import ModelError
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.simulation.turbine_plant import SimulatedTurbine
from takagi.reports.margins.margins import DiskMargin, Margins, disk_of, loop_margins
from takagi.reports.margins.response import broken_loops
from takagi.reports.margins.running_loop import (
    NOMINAL,
    WAKES,
    NoEquilibrium,
    PlantChoice,
    RunningLoop,
    RunningLoops,
)

# The machine as its file says, then the ends of what is not known.
PLANTS = (NOMINAL, *((factor, wake) for factor in (0.9, 1.1) for wake in WAKES))
# A loop below this gain at every frequency does nothing.
SILENT = 1e-6
# Samples a period of the fastest mode, at least: fewer, and its phase is the sampling's.
SAMPLES_A_PERIOD = 6.0
# Around a mode, as a share of its frequency: it is inside the crossover where |L| reaches 1 there.
NEAR_MODE = 0.15


class Mode(NamedTuple):
    """A mode that the loop should not meet: its name and frequency [rad/s]."""

    name: str
    frequency: float


@dataclass(frozen=True, slots=True, eq=False)
class RunningMargins:
    """The margins of one loop at one wind, for one plant.

    Attributes
    ----------
    wind [m/s]; inertia : factor on the nominal one.   wake : one of ``WAKES``.
    torque, pitch : margins of the loop broken there; None where that command does not answer.
    both : disk margin of both at once, independent of each other.
    decay_rate : of the slowest mode of the closed loop [1/s]; negative for an unstable one.
    modes_met : "torque" or "pitch" -> modes at which that loop's gain reaches 1.
    kinks : parts with two slopes here; the figures are then the worse of both sides.
    """

    wind: float
    inertia: float
    wake: str
    torque: Margins | None
    pitch: Margins | None
    both: DiskMargin
    decay_rate: float
    modes_met: tuple[tuple[str, Mode], ...]
    kinks: tuple[str, ...]

    @property
    def loops(self) -> tuple[tuple[str, Margins], ...]:
        """The loops that act, with their names."""
        named = zip(COMMANDS, (self.torque, self.pitch), strict=True)
        return tuple((name, margins) for name, margins in named if margins is not None)

    @property
    def nominal(self) -> bool:
        """Whether this is the turbine as its file says."""
        return (self.inertia, self.wake) == NOMINAL


def running_margins(
    loops: RunningLoops, winds: Sequence[float], *, plants: Sequence[PlantChoice] = PLANTS
) -> tuple[RunningMargins, ...]:
    """Return the margins of the loop that runs: validation plant, observer, filters, sampling.

    Parameters
    ----------
    loops : as ``RunningLoops.of`` makes them.
    winds : steady ones [m/s].
    plants : (factor on the nominal inertia, one of ``WAKES``); wakes in equilibrium and frozen are
        the ends of the pitch effectiveness.

    Returns
    -------
    One entry a wind and plant, in the order given.

    Raises
    ------
    ModelError : a sampling too slow for the modes, or a wind outside cut-in to cut-out or where
        more wind gives no more torque, so that the observer cannot estimate it.
    NoEquilibrium : a ModelError; the loop has no equilibrium at a wind.
    """
    modes = plant_modes(loops.plant)
    require_sampling(loops.program.sample_time, modes)
    winds = [float(wind) for wind in winds]
    for wind in winds:
        loops.rest(wind)
    found = []
    for wind in winds:
        first, *others = loops.sides(wind)
        for plant in plants:
            sides = [loops.at(wind, plant, first)]
            if _chosen(sides[0].kinks):
                sides += [loops.at(wind, plant, side) for side in others]
            found.append(worst_of_sides([_margins(loop, plant, modes) for loop in sides]))
    return tuple(found)


def worst_of_sides(rows: Sequence[RunningMargins]) -> RunningMargins:
    """Return the worst of every margin over the sides of a kink, each perhaps of another side."""
    met = dict.fromkeys(mode for row in rows for mode in row.modes_met)
    return replace(
        min(rows, key=lambda row: row.both.alpha),
        torque=_worst([row.torque for row in rows]),
        pitch=_worst([row.pitch for row in rows]),
        decay_rate=min(row.decay_rate for row in rows),
        modes_met=tuple(met),
    )


def _worst(sides: Sequence[Margins | None]) -> Margins | None:
    acting = [found for found in sides if found is not None]
    if not acting:
        return None
    up = min(acting, key=lambda m: m.gain_increase)
    phase = min(acting, key=lambda m: m.phase)
    return replace(
        min(acting, key=lambda m: m.disk.alpha),
        gain_increase=up.gain_increase,
        gain_increase_frequency=up.gain_increase_frequency,
        gain_decrease=max(m.gain_decrease for m in acting),
        phase=phase.phase,
        phase_frequency=phase.phase_frequency,
        delay=min(m.delay for m in acting),
    )


def plant_modes(plant: SimulatedTurbine) -> tuple[Mode, ...]:
    """Return the tower's and the torsion mode of a plant, those that it has."""
    turbine, found = plant.turbine, []
    if plant.tower:
        found.append(Mode("tower", float(np.sqrt(turbine.tower_stiffness / turbine.tower_mass))))
    if plant.torsion:
        found.append(Mode("torsion", plant.torsion_frequency))
    return tuple(found)


def _margins(loop: RunningLoop, plant: PlantChoice, modes: Sequence[Mode]) -> RunningMargins:
    broken = broken_loops(loop)
    acting = {
        name: response
        for name, response in zip(COMMANDS, broken, strict=False)
        if float(np.abs(response.values_beyond).max()) > SILENT
    }
    margins = {name: loop_margins(response) for name, response in acting.items()}
    around = np.linspace(1 - NEAR_MODE, 1 + NEAR_MODE, 301)
    met = tuple(
        (name, mode)
        for name, response in acting.items()
        for mode in modes
        if float(np.abs(response.evaluate(mode.frequency * around)).max()) >= 1.0
    )
    return RunningMargins(
        wind=loop.wind,
        inertia=plant[0],
        wake=plant[1],
        torque=margins.get("torque"),
        pitch=margins.get("pitch"),
        both=disk_of(broken.both),
        decay_rate=-float(loop.poles.real.max()),
        modes_met=met,
        kinks=_chosen(loop.kinks),
    )


def _chosen(kinks: tuple[str, ...]) -> tuple[str, ...]:
    """Return the kinks with a choice of sides; pitch at its stop goes inwards alone."""
    return tuple(kink for kink in kinks if not kink.startswith("pitch"))


def require_sampling(sample_time: float, modes: Sequence[Mode]) -> None:
    """Refuse a sampling [s] in which a period of a mode has too few samples.

    Raises
    ------
    ModelError : names the mode, and how often is enough.
    """
    if (why := slow_sampling(sample_time, modes)) is not None:
        raise ModelError(why)


def slow_sampling(sample_time: float, modes: Sequence[Mode]) -> str | None:
    """Return why a sampling [s] is too slow for the fastest mode, and the cure; None if it is not.

    The time that is advised is rounded down, so that it is accepted.
    """
    fastest = max(modes, key=lambda mode: mode.frequency, default=None)
    if fastest is None:
        return None
    period = 2 * np.pi / fastest.frequency
    longest = period / SAMPLES_A_PERIOD
    if sample_time <= longest:
        return None
    unit = 10.0 ** (np.floor(np.log10(longest)) - 1)
    return (
        f"the law is sampled every {sample_time:g} s, and the {fastest.name} mode has a period of "
        f"{period:.3g} s: less than {SAMPLES_A_PERIOD:g} samples a period; sample at least every "
        f"{np.floor(longest / unit) * unit:.2g} s"
    )


# Step of wind for the nominal plant [m/s]; all plants are measured at every whole wind.
FINE = 0.2
# A least disk margin is least as far as this to both sides [m/s]: two steps, so that noise of the
# linearisation in one of them makes no place.
AROUND = 0.4


@dataclass(frozen=True, slots=True, eq=False)
class SearchedMargins:
    """Margins over all winds.

    Attributes
    ----------
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

    Raises
    ------
    ModelError : what ``running_margins`` refuses, but for a missing rest.
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
    for loop in COMMANDS:
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


LEAST_GAIN = 1.2
LEAST_PHASE = 10 * pi / 180
COMMANDS = ("torque", "pitch")
# Steps up to the least margin: instability may begin at a factor, and end at a larger one.
STEPS = 4


class SmallMargin(NamedTuple):
    """A margin ("gain", "phase" or "delay") of a command that is below the least one.

    ``share`` : of the least margin at which the loop is unstable, in steps; smaller is worse.
    """

    kind: str
    command: str
    share: float


def small_margins(loop: RunningLoop) -> tuple[SmallMargin, ...]:
    """Return the margins of a stable loop that are below the least ones."""
    shares = np.arange(1, STEPS + 1) / STEPS
    factors: Mapping[str, Callable[[float], tuple[complex, ...]]] = {
        "gain": lambda share: (LEAST_GAIN**share, LEAST_GAIN**-share),
        "phase": lambda share: (np.exp(1j * share * LEAST_PHASE),),
    }
    small = []
    for column, command in zip(np.eye(2), COMMANDS, strict=True):
        for kind, factors_of in factors.items():
            for share in shares.tolist():
                bent = (1 + (factor - 1) * column for factor in factors_of(share))
                if not all(_stable(loop.A, loop.B * each, loop.C) for each in bent):
                    small.append(SmallMargin(kind, command, share))
                    break
    # With both commands one sample later they are two states more.
    A = np.block([[loop.A, loop.B], [np.zeros((2, len(loop.A) + 2))]])
    B = np.vstack([np.zeros_like(loop.B), np.eye(2)])
    if not _stable(A, B, np.hstack([loop.C, np.zeros((2, 2))])):
        small.append(SmallMargin("delay", "torque and pitch", 1.0))
    return tuple(small)


def _stable(A: Floats, B: Floats | Complex, C: Floats) -> bool:
    return float(np.abs(np.linalg.eigvals(A - B @ C)).max()) < 1


# A loop counts as unstable where it grows faster than this [1/s]; less is the noise of differences.
GROWTH = 1e-4
# Where it decays slower than this [1/s], the nodes of the law's tables around are looked at, too.
CLOSE = 0.03


def loop_at(
    loops: RunningLoops, wind: float, plant: PlantChoice = NOMINAL, side: int | None = None
) -> RunningLoop | None:
    """Return the loop at a wind [m/s]; None where it has no equilibrium."""
    try:
        return loops.at(wind, plant, side)
    except NoEquilibrium:
        return None


def growths(
    loops: RunningLoops, winds: Sequence[float], plant: PlantChoice = NOMINAL
) -> dict[float, float]:
    """Return wind -> largest real part of the loop's poles [1/s], where it has a rest.

    At a node of the law's tables it is the larger one of both sides.
    """
    nodes, found = _nodes(loops), {}
    for wind in winds:
        sides = loops.sides(wind) if wind in nodes else loops.sides(wind)[:1]
        at_wind = [loop_at(loops, wind, plant, side) for side in sides]
        rates = [float(loop.poles.real.max()) for loop in at_wind if loop is not None]
        if rates:
            found[wind] = max(rates)
    return found


def growths_over_wind(loops: RunningLoops) -> dict[float, float]:
    """Return wind -> growth [1/s] from cut-in to cut-out, for the plant of the file.

    Every ``FINE`` m/s, and where the loop is close to growing at the nodes of the law's tables,
    too: between the winds it may grow faster.
    """
    turbine = loops.plant.turbine
    found = growths(loops, fine_winds(loops))
    close = [wind for wind, rate in found.items() if rate > -CLOSE]
    nodes = [w for w in _nodes(loops) if turbine.cut_in <= w <= turbine.cut_out]
    return found | growths(loops, [n for n in nodes if any(abs(n - w) < FINE for w in close)])


def unstable(loops: RunningLoops, winds: Sequence[float], plant: PlantChoice = NOMINAL) -> bool:
    """Return whether the loop grows at one of the winds."""
    return any(rate > GROWTH for rate in growths(loops, winds, plant).values())


def fine_winds(loops: RunningLoops) -> tuple[float, ...]:
    """Return the winds from cut-in to cut-out, every ``FINE`` m/s."""
    turbine = loops.plant.turbine
    return winds_between(turbine.cut_in, turbine.cut_out, FINE)


def decisive_winds(loops: RunningLoops) -> tuple[float, ...]:
    """Return the whole winds, and three where pitch begins to act: the weakest place of it."""
    turbine = loops.plant.turbine
    whole = winds_between(turbine.cut_in, turbine.cut_out, 1.0)
    acting = []
    for wind in fine_winds(loops):
        with suppress(NoEquilibrium):
            if loops.rest(wind).plant[1] > turbine.pitch_min:
                acting.append(wind)
    return tuple(sorted({*whole, *acting[:3]}))


def _nodes(loops: RunningLoops) -> list[float]:
    law = loops.program.law
    return law.schedule.wind.tolist() if isinstance(law, EffortSharingLaw) else []
