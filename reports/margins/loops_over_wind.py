"""The loop that runs, linearised at many winds and for some plants, each only once."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import TypeAlias

from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.sampled import SampledLaw
from takagi.models.simulation.turbine_plant import SimulatedTurbine
from takagi.models.turbine.wind_observer import WindObserver
from takagi.reports.margins.running_equilibrium import (
    LoopEquilibrium,
    NoEquilibrium,
    loop_equilibrium,
)
from takagi.reports.margins.running_loop import RunningLoop, linearised_loop, with_inertia
from takagi.reports.margins.running_over_wind import NOMINAL
from takagi.reports.margins.running_search import FINE, winds_between

# As ``AskedMargins``: how often the law runs where nothing else is said [s].
SAMPLE = 0.02
# A loop counts as unstable where it grows faster than this [1/s]; less is the noise of differences.
GROWTH = 1e-4

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

    def at(self, wind: float, plant: PlantChoice = NOMINAL) -> RunningLoop | None:
        """Return the loop at a wind [m/s]; None where it has no equilibrium."""
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
            side=-1 if wind >= self.plant.turbine.cut_out else 1,
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
        """Return wind -> largest real part of the loop's poles [1/s], where it has a rest."""
        return {wind: growth_of(loop) for wind, loop in self.over(winds, plant)}

    def unstable(self, winds: Sequence[float], plant: PlantChoice = NOMINAL) -> bool:
        """Return whether the loop grows at one of the winds."""
        return any(growth_of(loop) > GROWTH for _, loop in self.over(winds, plant))

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

    def _pitch_acts(self, wind: float) -> bool:
        self.at(wind)
        rest = self.rests[wind]
        return rest is not None and rest.plant[1] > self.plant.turbine.pitch_min


def growth_of(loop: RunningLoop) -> float:
    """Return the largest real part of a loop's poles [1/s]."""
    return float(loop.poles.real.max())
