"""Margins of the loop that runs, over wind, inertia and wake; its modes beside the crossover.

What can be asked is refused before the long work: a sampling that the modes do not fit in, a wind
that the observer cannot see.  A mode that the loop crosses over at is named with the margins, since
it is a loop that runs, with a margin.  All figures are floating point: measured, and not proved.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from takagi.models.arrays import Complex
from takagi.models.errors import ModelError
from takagi.models.simulation.turbine_plant import SimulatedTurbine
from takagi.reports.margins.margins import DiskMargin, Margins, disk_of, loop_margins
from takagi.reports.margins.response import BrokenLoops, broken_loops
from takagi.reports.margins.running_loop import (
    NOMINAL,
    WAKES,
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


@dataclass(frozen=True, slots=True)
class Mode:
    """A mode that the loop should not meet: its name and frequency [rad/s]."""

    name: str
    frequency: float


@dataclass(frozen=True, slots=True, eq=False)
class RunningMargins:
    """The margins of one loop at one wind, for one plant.

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
        named = (("torque", self.torque), ("pitch", self.pitch))
        return tuple((name, found) for name, found in named if found is not None)

    @property
    def nominal(self) -> bool:
        """Whether this is the turbine as its file says."""
        return (self.inertia, self.wake) == NOMINAL


def running_margins(
    loops: RunningLoops, winds: Sequence[float], *, plants: Sequence[PlantChoice] = PLANTS
) -> tuple[RunningMargins, ...]:
    """Return the margins of the loop that runs: validation plant, observer, filters, sampling.

    loops : as ``RunningLoops.of`` makes them.
    winds : steady ones [m/s].
    plants : (factor on the nominal inertia, one of ``WAKES``); wakes in equilibrium and frozen are
        the ends of the pitch effectiveness.

    Returns
    -------
    One entry a wind and plant, in the order given.

    Raises ModelError: a sampling too slow for the modes, or a wind outside cut-in to cut-out or
        where more wind gives no more torque, so that the observer cannot estimate it.
    Raises NoEquilibrium: a ModelError; the loop has no equilibrium at a wind.
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
    down = max(acting, key=lambda m: m.gain_decrease)
    phase = min(acting, key=lambda m: m.phase)
    return replace(
        min(acting, key=lambda m: m.disk.alpha),
        gain_increase=up.gain_increase,
        gain_increase_frequency=up.gain_increase_frequency,
        gain_decrease=down.gain_decrease,
        gain_decrease_frequency=down.gain_decrease_frequency,
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
    acting = {name: getattr(broken, name) for name in ("torque", "pitch") if _acts(broken, name)}
    margins = {name: loop_margins(response) for name, response in acting.items()}
    met = tuple(
        (name, mode)
        for name, response in acting.items()
        for mode in modes
        if _reaches_one(response.evaluate, mode)
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


def _acts(broken: BrokenLoops, name: str) -> bool:
    response = getattr(broken, name)
    return float(np.abs(response.values_beyond).max()) > SILENT


def _reaches_one(evaluate: Callable[..., Complex], mode: Mode) -> bool:
    near = mode.frequency * np.linspace(1 - NEAR_MODE, 1 + NEAR_MODE, 301)
    return float(np.abs(evaluate(near)).max()) >= 1.0


def require_sampling(sample_time: float, modes: Sequence[Mode]) -> None:
    """Refuse a sampling [s] in which a period of a mode has too few samples.

    Raises ModelError: names the mode, and how often is enough.
    """
    found = slow_sampling(sample_time, modes)
    if found is not None:
        raise ModelError(found)


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
