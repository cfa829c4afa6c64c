"""The loop that runs at many winds, and whether it keeps the least margins, by eigenvalues.

    gain    stable with one command times g and times 1/g, g up to ``LEAST_GAIN``
    phase   stable with one command times e^{j phi}, phi up to ``LEAST_PHASE``
    delay   stable with both commands one sample later

1 + g e^{j phi} L has a zero outside the unit circle exactly where A - B diag(g e^{j phi}, 1) C has
an eigenvalue there, so that no response over frequency is needed: a wind takes a millisecond.  The
conjugate matrix has the conjugate eigenvalues, which is why phi > 0 is enough.

The figures are small on purpose.  They are no design targets (those are given by ``--margins``):
below them a drive or a generator that differs a little from its file, or a controller that sends
one sample later, makes the loop oscillate.

All figures are floating point: measured, and not proved.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from math import pi
from typing import TypeAlias

import numpy as np

from takagi.models.arrays import Complex, Floats
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.protocol import SampledLaw
from takagi.models.simulation.turbine_plant import SimulatedTurbine
from takagi.models.turbine.wind_observer import WindObserver
from takagi.reports.margins.running_loop import (
    LoopEquilibrium,
    NoEquilibrium,
    RunningLoop,
    linearised_loop,
    loop_equilibrium,
    with_inertia,
)
from takagi.reports.margins.running_over_wind import NOMINAL
from takagi.reports.margins.running_search import FINE, winds_between

LEAST_GAIN = 1.2
LEAST_PHASE = 10 * pi / 180
COMMANDS = ("torque", "pitch")
# Steps up to the least margin: instability may begin at a factor, and end at a larger one.
STEPS = 4


@dataclass(frozen=True, slots=True)
class SmallMargin:
    """A margin that is below the least one.

    Attributes
    ----------
    kind : "gain", "phase" or "delay".
    command : "torque", "pitch" or, for the delay, "torque and pitch".
    share : of the least margin at which the loop is unstable, in steps; smaller is worse.
    """

    kind: str
    command: str
    share: float


def small_margins(loop: RunningLoop) -> tuple[SmallMargin, ...]:
    """Return the margins of a stable loop that are below the least ones."""
    shares = np.arange(1, STEPS + 1) / STEPS
    found = []
    for place, command in enumerate(COMMANDS):
        for kind in ("gain", "phase"):
            bad = [share for share in shares if not _keeps(loop, place, kind, float(share))]
            if bad:
                found.append(SmallMargin(kind, command, float(bad[0])))
    if not _stable(*_later(loop)):
        found.append(SmallMargin("delay", "torque and pitch", 1.0))
    return tuple(found)


def _keeps(loop: RunningLoop, place: int, kind: str, share: float) -> bool:
    if kind == "phase":
        return _stable_with(loop, place, np.exp(1j * share * LEAST_PHASE))
    factor = LEAST_GAIN**share
    return all(_stable_with(loop, place, one) for one in (factor, 1 / factor))


def _stable_with(loop: RunningLoop, place: int, factor: complex) -> bool:
    factors = np.ones(2, dtype=np.complex128)
    factors[place] = factor
    return _stable(loop.A, loop.B * factors, loop.C)


def _later(loop: RunningLoop) -> tuple[Floats, Floats, Floats]:
    """Return the loop with both commands one sample later: they are two states more."""
    n = len(loop.A)
    A, B, C = np.zeros((n + 2, n + 2)), np.zeros((n + 2, 2)), np.zeros((2, n + 2))
    A[:n, :n], A[:n, n:], B[n:], C[:, :n] = loop.A, loop.B, np.eye(2), loop.C
    return A, B, C


def _stable(A: Floats, B: Floats | Complex, C: Floats) -> bool:
    return float(np.abs(np.linalg.eigvals(A - B @ C)).max()) < 1


# As ``AskedMargins``: how often the law runs where nothing else is said [s].
SAMPLE = 0.02
# A loop counts as unstable where it grows faster than this [1/s]; less is the noise of differences.
GROWTH = 1e-4
# Where it decays slower than this [1/s], the nodes of the law's tables around are looked at, too.
CLOSE = 0.03

# Factor on the nominal inertia, and one of ``WAKES``.
PlantChoice: TypeAlias = tuple[float, str]


@dataclass(frozen=True, slots=True, eq=False)
class LoopsOverWind:
    """Plant, law and observer; the equilibria that were found are kept.

    Attributes
    ----------
    plant : with the filter of the measured speed.
    sample_time : of the program [s].
    rests : wind [m/s] -> where the loop rests, None for no equilibrium.  It depends on neither
        inertia nor wake.
    """

    plant: SimulatedTurbine
    law: EffortSharingLaw
    observer: WindObserver
    sample_time: float = SAMPLE
    rests: dict[float, LoopEquilibrium | None] = field(default_factory=dict)

    def other(
        self, *, plant: SimulatedTurbine | None = None, law: EffortSharingLaw | None = None
    ) -> LoopsOverWind:
        """Return the loop with another plant or law, of which no equilibrium is known yet."""
        return replace(self, plant=plant or self.plant, law=law or self.law, rests={})

    def at(
        self, wind: float, plant: PlantChoice = NOMINAL, side: int | None = None
    ) -> RunningLoop | None:
        """Return the loop at a wind [m/s]; None where it has no equilibrium.

        ``side`` : 1 for the slopes above the wind, -1 for those below; None for above, at cut-out
        below.
        """
        if wind not in self.rests:
            try:
                self.rests[wind] = loop_equilibrium(self.plant, self.law, self.observer, wind)
            except NoEquilibrium:
                self.rests[wind] = None
        rest = self.rests[wind]
        if rest is None:
            return None
        factor, wake = plant
        return linearised_loop(
            self.plant if factor == 1 else with_inertia(self.plant, factor),
            SampledLaw(self.law, self.sample_time, 0.0),
            self.observer,
            wind,
            rest=rest,
            wake=wake,
            side=self._sides(wind)[0] if side is None else side,
        )

    def over(
        self, winds: Sequence[float], plant: PlantChoice = NOMINAL
    ) -> Iterator[tuple[float, RunningLoop]]:
        """Yield (wind, loop) where the loop has an equilibrium."""
        for wind in winds:
            loop = self.at(wind, plant)
            if loop is not None:
                yield wind, loop

    def growths(self, winds: Sequence[float], plant: PlantChoice = NOMINAL) -> dict[float, float]:
        """Return wind -> largest real part of the loop's poles [1/s], where it has a rest.

        At a node of the law's tables it is the larger one of both sides.
        """
        sides = {wind: [self.at(wind, plant, side) for side in self._sides(wind)] for wind in winds}
        return {
            wind: max(growth_of(loop) for loop in loops if loop is not None)
            for wind, loops in sides.items()
            if loops[0] is not None
        }

    def growths_over_wind(self) -> dict[float, float]:
        """Return wind -> growth [1/s] from cut-in to cut-out, for the plant of the file.

        Every ``FINE`` m/s, and where the loop is close to growing at the nodes of the law's tables,
        too: between the winds it may grow faster.
        """
        turbine = self.plant.turbine
        found = self.growths(self.fine_winds())
        close = [wind for wind, rate in found.items() if rate > -CLOSE]
        nodes = [w for w in self._nodes() if turbine.cut_in <= w <= turbine.cut_out]
        near = [node for node in nodes if any(abs(node - wind) < FINE for wind in close)]
        return found | self.growths(near)

    def unstable(self, winds: Sequence[float], plant: PlantChoice = NOMINAL) -> bool:
        """Return whether the loop grows at one of the winds."""
        return any(rate > GROWTH for rate in self.growths(winds, plant).values())

    def fine_winds(self) -> tuple[float, ...]:
        """Return the winds from cut-in to cut-out, every ``FINE`` m/s."""
        turbine = self.plant.turbine
        return winds_between(turbine.cut_in, turbine.cut_out, FINE)

    def decisive_winds(self) -> tuple[float, ...]:
        """Return the whole winds, and three where pitch begins to act: the weakest place of it."""
        turbine = self.plant.turbine
        fine, whole = self.fine_winds(), winds_between(turbine.cut_in, turbine.cut_out, 1.0)
        acting = [wind for wind in fine if self._pitch_acts(wind)]
        return tuple(sorted({*whole, *acting[:3]}))

    def _nodes(self) -> list[float]:
        return [float(node) for node in self.law.schedule.wind]

    def _sides(self, wind: float) -> tuple[int, ...]:
        """Return the sides of a wind whose slopes may differ; the one that counts alone first."""
        if wind >= self.plant.turbine.cut_out:
            return (-1,)
        return (1, -1) if wind > self.plant.turbine.cut_in and wind in self._nodes() else (1,)

    def _pitch_acts(self, wind: float) -> bool:
        self.at(wind)
        rest = self.rests[wind]
        return rest is not None and rest.plant[1] > self.plant.turbine.pitch_min


def growth_of(loop: RunningLoop) -> float:
    """Return the largest real part of a loop's poles [1/s]."""
    return float(loop.poles.real.max())
