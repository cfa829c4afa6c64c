"""Laws side by side in the same winds: the paper's scenario, and what happens across rated wind."""

from __future__ import annotations

import copyreg
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from multiprocessing import get_context
from types import MappingProxyType

import numpy as np

from takagi.models.errors import ModelError
from takagi.models.laws.protocol import Law
from takagi.models.laws.sampled import SampledLaw
from takagi.models.simulation.closed_loop import Observer, simulate
from takagi.models.simulation.history import History
from takagi.models.simulation.metrics import Metrics, measure
from takagi.models.simulation.turbine_plant import SimulatedTurbine, validation_plant
from takagi.models.simulation.turbulence import same_turbulence
from takagi.models.simulation.wind import WindSeries, gust_wind, step_wind
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import rated_wind

PAPER_MEANS = (8.0, 11.5, 14.0)
PAPER_INTENSITY = 0.18
# Chosen because it shows what the scenario is for: the highest wind is above rated for three
# quarters of the time and leaves it once, the middle one crosses rated, the lowest never does.
PAPER_SEED = 59
PAPER_DURATION = 60.0
PAPER_PERIOD = 600.0

Progress = Callable[[float], None]


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """One law in one wind; ``label`` names the law in tables.  Can be sent to another process.

    ``law`` may be sampled in its own time; ``time_step`` None lets the sampling choose it.
    """

    label: str
    plant: SimulatedTurbine
    law: Law | SampledLaw
    wind: WindSeries
    observer: Observer | None = None
    time_step: float | None = None
    skip: float = 0.0


@dataclass(frozen=True, slots=True, eq=False)
class Result:
    """What a case gave: its label, the wind's name, the record and its metrics."""

    label: str
    wind_name: str
    history: History
    metrics: Metrics

    def row(self) -> dict[str, str | float]:
        """Return one row of the table: law, wind, then the metrics by title with unit."""
        return {"law": self.label, "wind": self.wind_name, **self.metrics.row()}


def published_winds(
    turbine: Turbine,
    *,
    means: Sequence[float] = PAPER_MEANS,
    intensity: float = PAPER_INTENSITY,
    duration: float = PAPER_DURATION,
    seed: int = PAPER_SEED,
) -> tuple[WindSeries, ...]:
    """Return winds with one turbulence and different means, cut from a period of 600 s or more.

    Parameters
    ----------
    means : of the whole period [m/s].   intensity : at a point [-].   duration : [s].

    Source: Schulte (2024), Coherent Design of Wind Turbine Controllers, simulation results: the
    highest wind mostly in region 3 with intervals in region 2, the lowest in partial load only.
    The figures' own wind is not published; seed and intensity are our choice.
    """
    return same_turbulence(
        means,
        intensity,
        duration,
        seed,
        rotor_radius=turbine.rotor_radius,
        hub_height=turbine.hub_height,
        period=max(duration, PAPER_PERIOD),
    )


def transition_winds(turbine: Turbine, *, duration: float = 120.0) -> tuple[WindSeries, ...]:
    """Return four winds across rated wind: step up, step down, gust, ramp 8 to 14 to 8 m/s.

    The steps go from 1.5 m/s below rated wind to 1.5 m/s above and back; the gust is the extreme
    operating gust at rated wind; the ramp takes the middle 80 % of the duration.
    """
    rated = round(rated_wind(turbine), 2)
    low, high = rated - 1.5, rated + 1.5
    ramp = WindSeries(
        np.array([0.0, 0.1, 0.5, 0.9, 1.0]) * duration,
        np.array([8.0, 8.0, 14.0, 8.0, 8.0]),
        "ramp 8 to 14 to 8 m/s",
    )
    return (
        step_wind(low, high, duration),
        step_wind(high, low, duration),
        gust_wind(rated, duration, rotor_radius=turbine.rotor_radius),
        ramp,
    )


def published_scenario(
    turbine: Turbine,
    laws: Mapping[str, Law | SampledLaw],
    *,
    observer: Observer | None,
    plant: SimulatedTurbine | None = None,
    winds: Sequence[WindSeries] | None = None,
    time_step: float | None = None,
    skip: float = 0.0,
    processes: int = 1,
    progress: Progress | None = None,
) -> tuple[Result, ...]:
    """Return every law in the paper's three winds, laws in their order, winds within.

    Parameters
    ----------
    laws : label -> law.
    observer : in the loop of every law; None shows the laws the true wind.
    plant : None takes ``validation_plant(turbine)``.   winds : None takes ``published_winds``.
    skip : dropped before measuring [s]; every loop starts at the equilibrium of its first wind.
    processes, progress : see ``run_cases``.

    Raises
    ------
    ModelError : no law, a loop that diverges, or skip that leaves nothing.
    """
    chosen = published_winds(turbine) if winds is None else winds
    used = validation_plant(turbine) if plant is None else plant
    return run_cases(
        _cases(used, laws, chosen, observer, time_step, skip),
        processes=processes,
        progress=progress,
    )


def transition_scenario(
    turbine: Turbine,
    laws: Mapping[str, Law | SampledLaw],
    *,
    observer: Observer | None,
    plant: SimulatedTurbine | None = None,
    time_step: float | None = None,
    processes: int = 1,
    progress: Progress | None = None,
) -> tuple[Result, ...]:
    """Return every law in the winds of ``transition_winds``; options of ``published_scenario``."""
    return published_scenario(
        turbine,
        laws,
        observer=observer,
        plant=plant,
        winds=transition_winds(turbine),
        time_step=time_step,
        processes=processes,
        progress=progress,
    )


def run_cases(
    cases: Sequence[Case], *, processes: int = 1, progress: Progress | None = None
) -> tuple[Result, ...]:
    """Return the results in the order of the cases.

    Parameters
    ----------
    processes : 1 runs here; more start as many new processes, which pays from about ten runs of
        600 s.  A script that asks for them keeps its work under ``if __name__ == "__main__":``.
    progress : called with the share done, in (0, 1]; case by case with more processes.

    Raises
    ------
    ModelError : processes below 1, or what ``simulate`` and ``measure`` raise.
    """
    if processes < 1:
        raise ModelError(f"{processes} processes were asked; at least 1 is needed")
    if processes == 1:
        return tuple(_run_here(cases, progress))
    # Started afresh, not forked: safe beside threads, and the same on every system.
    with ProcessPoolExecutor(processes, mp_context=get_context("spawn")) as pool:
        found = []
        for result in pool.map(_run, cases):
            # Arrays come back writable; building the record again locks them.
            found.append(replace(result, history=replace(result.history)))
            if progress is not None:
                progress(len(found) / len(cases))
    return tuple(found)


def _run_here(cases: Sequence[Case], progress: Progress | None) -> Iterator[Result]:
    for number, case in enumerate(cases):
        if progress is None:
            yield _run(case)
        else:
            yield _run(case, _part(progress, number, len(cases)))


def _part(progress: Progress, number: int, total: int) -> Progress:
    return lambda share: progress((number + share) / total)


def _run(case: Case, progress: Progress | None = None) -> Result:
    history = simulate(
        case.plant,
        case.law,
        case.wind,
        observer=case.observer,
        time_step=case.time_step,
        progress=progress,
    )
    metrics = measure(history, case.plant.turbine, skip=case.skip)
    return Result(case.label, case.wind.name, history, metrics)


def _cases(
    plant: SimulatedTurbine,
    laws: Mapping[str, Law | SampledLaw],
    winds: Sequence[WindSeries],
    observer: Observer | None,
    time_step: float | None,
    skip: float,
) -> list[Case]:
    if not laws:
        raise ModelError("no law was given; at least one is needed")
    return [
        Case(label, plant, law, wind, observer, time_step, skip)
        for label, law in laws.items()
        for wind in winds
    ]


def _read_only(content: dict[object, object]) -> MappingProxyType[object, object]:
    return MappingProxyType(content)


def _proxy_parts(proxy: MappingProxyType[object, object]) -> tuple[object, ...]:
    return _read_only, (dict(proxy),)


# A turbine's table of figures is a read-only view, which pickle does not know how to send.
copyreg.pickle(MappingProxyType, _proxy_parts)  # type: ignore[arg-type]
