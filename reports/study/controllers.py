"""Controllers of one turbine side by side: the same plant, the same winds, many seeds.

Each law runs on the validation plant in turbulence of class B about each mean wind.  A run starts
at rest; its first ``SETTLING`` seconds are not counted, in which a law without a state of rest,
such as ROSCO's, finds its torque.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from takagi.certificates.document.certificate_file import files_sha256
from takagi.certificates.sweep.tasks import RESULTS, Task, Tell, canonical, run_tasks
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.simulation.closed_loop import Diverged, History
from takagi.models.simulation.scenario import measure
from takagi.models.simulation.wind import WindSeries
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.loader import TurbineFile
from takagi.reports.output import read_words
from takagi.reports.simulation.runs import PlantParts, run_simulation, simulation_plant
from takagi.reports.simulation.winds import requested_winds
from takagi.reports.study.overlap import (
    TURBULENCE,
    require_runs,
    runs_at,
    studied_law,
)
from takagi.reports.study.rosco import (
    RETUNED,
    Tuning,
    filed_tuning,
    require_rosco,
    retuned,
    shipped_tuning,
    simulate_rosco,
)

OURS, REFERENCE, ROSCO = "effort-sharing", "reference", "rosco-"
# By the name that is typed: the name in files.
LAWS = {OURS: "coherent", "schulte": "paper", "switched": "switched", REFERENCE: "baseline"}
WORDS: Mapping[str, str] = read_words("study/words.toml")["laws"]
MEANS = tuple(float(v) for v in range(4, 25, 2))
SEEDS, DURATION, SETTLING = 6, 600.0, 30.0
# What --rosco takes beside NAME=FILE.
TUNINGS = ("shipped", "shipped-unshaved", "retuned", "retuned-unshaved", "all")


@dataclass(frozen=True, slots=True, eq=False)
class ControllersStudy:
    """A finished study.

    Attributes
    ----------
    laws : in their order;  means : winds [m/s];  seeds : of each;  duration : that is counted [s].
    runs : of each law, a row a mean wind and seed: ``wind``, ``seed``, ``reason`` and metrics.
    resumed, tasks : how many results were there before, and how many there are.
    """

    turbine: Turbine
    laws: tuple[str, ...]
    means: tuple[float, ...]
    seeds: int
    duration: float
    runs: Mapping[str, tuple[Mapping[str, Any], ...]]
    resumed: int
    tasks: int

    @property
    def failed(self) -> list[str]:
        """What diverged or ended in an error, in words."""
        return [run["reason"] for law in self.laws for run in self.runs[law] if run["reason"]]

    @property
    def finished(self) -> tuple[str, ...]:
        """The laws that reached the end of every wind."""
        return tuple(x for x in self.laws if not any(run["reason"] for run in self.runs[x]))

    @property
    def compared(self) -> str | None:
        """The law that the others are compared with; None if there is none but one."""
        if len(self.finished) < 2:
            return None
        return REFERENCE if REFERENCE in self.finished else self.finished[0]

    def values(self, law: str, name: str) -> Any:
        """Return a metric of a law that finished, (winds, seeds)."""
        return np.array([run[name] for run in self.runs[law]]).reshape(len(self.means), self.seeds)


def words_of(law: str) -> str:
    """Return what a law is called in tables."""
    return WORDS.get(law, f"ROSCO, {law.removeprefix(ROSCO)}")


def study_laws(turbine: Turbine, names: Sequence[str]) -> tuple[str, ...]:
    """Return the laws of names, all that the turbine has without one; ModelError for others."""
    known = [name for name in LAWS if name != REFERENCE or turbine.baseline is not None]
    for name in names:
        if name not in LAWS:
            raise ModelError(
                f"--law {name} was given; choose from {', '.join(LAWS)}{did_you_mean(name, LAWS)}"
            )
        if name not in known:
            _ = turbine.reference_controller  # Raises: says what its file lacks.
    return tuple(dict.fromkeys(names)) or tuple(known)


def rosco_tunings(turbine: Turbine, texts: Sequence[str]) -> dict[str, Tuning]:
    """Return the tunings of ``TUNINGS`` and NAME=FILE, by the name that the law gets.

    Raises
    ------
    ModelError : the package is missing, or has no such tuning; a file that is none.
    """
    asked = [name for text in texts for name in (TUNINGS[:-1] if text == "all" else [text])]
    if asked:
        require_rosco()
    tunings: dict[str, Tuning] = {}
    for text in dict.fromkeys(asked):
        name, _, file = text.partition("=")
        if file and name not in TUNINGS:
            tunings[ROSCO + name] = filed_tuning(Path(file))
        elif text in TUNINGS:
            made = _shipped if text.startswith("shipped") else _retuned
            tuning = made(turbine)
            shaved = not text.endswith("-unshaved")
            tunings[ROSCO + text] = tuning if shaved else tuning.without_shaving()
        else:
            raise ModelError(
                f"--rosco {text} was given; one of {', '.join(TUNINGS)} is needed, or "
                f"NAME=DISCON.IN with another name{did_you_mean(text, TUNINGS)}"
            )
    return tunings


@lru_cache(maxsize=1)
def _shipped(turbine: Turbine) -> Tuning:
    return shipped_tuning(turbine)


@lru_cache(maxsize=1)
def _retuned(turbine: Turbine) -> Tuning:
    return retuned(turbine, *RETUNED)


def run_controllers_study(
    source: TurbineFile,
    folder: Path,
    *,
    laws: Sequence[str] = (),
    rosco: Sequence[str] = (),
    means: Sequence[float] = MEANS,
    seeds: int = SEEDS,
    duration: float = DURATION,
    workers: int | None = None,
    scheduler: str | None = None,
    tell: Tell | None = None,
) -> ControllersStudy:
    """Return every law in every wind; results are kept in ``folder``/results.

    Parameters
    ----------
    laws : of ``LAWS``; none takes all that the turbine has.
    rosco : of ``TUNINGS``, or NAME=FILE; none runs no ROSCO.
    means : of the wind [m/s], increasing;  seeds : of each;  duration : of a run, counted [s].
    workers, scheduler, tell : see ``run_tasks``.

    Raises
    ------
    ModelError : a law or tuning that is not there, a wind outside the range, a duration too short;
        what ``run_tasks`` refuses.
    """
    turbine = source.model
    names = study_laws(turbine, laws)
    require_runs(seeds, duration)
    winds = tuple(sorted(set(means)))
    requested_winds(turbine, [str(v) for v in winds], duration=duration + SETTLING)
    tunings = rosco_tunings(turbine, rosco)
    inputs: dict[str, Any] = {"files": files_sha256(source.files)}
    inputs |= {"seeds": list(range(1, seeds + 1)), "duration": duration}

    def task(law: str, mean: float) -> Task:
        more: dict[str, Any] = {"law": law, "mean": mean}
        if law in tunings:
            more["tuning"] = asdict(tunings[law])
        return Task(f"{__name__}:motion", turbine, {**inputs, **more})

    every = (*names, *tunings)
    # The slow ones first, so that no process waits for the last of them.
    tasks = {(law, v): task(law, v) for law in reversed(every) for v in winds}
    results, resumed = run_tasks(
        list(tasks.values()), folder / RESULTS, workers=workers, scheduler=scheduler, tell=tell
    )
    by_task = dict(zip(tasks, results, strict=True))
    runs = {law: tuple(run for v in winds for run in runs_at(v, by_task[law, v])) for law in every}
    return ControllersStudy(turbine, every, winds, seeds, duration, runs, resumed, len(tasks))


def motion(turbine: Turbine, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Return a task's result: a law in turbulence about one mean wind, seed by seed."""
    law = str(inputs["law"])
    rows = []
    for seed in inputs["seeds"]:
        (wind,) = requested_winds(
            turbine,
            [f"turbulent:{inputs['mean']!r}:{TURBULENCE}:{seed}"],
            duration=inputs["duration"] + SETTLING,
        )
        row: dict[str, Any] = {"seed": seed, "reason": ""}
        if "tuning" in inputs:
            history = _rosco_run(turbine, inputs, wind)
        else:
            asked = canonical({"law": LAWS[law], "settings": {}})
            (run,) = run_simulation(turbine, studied_law(turbine, asked), [wind]).runs
            history = run.history or run.remarks()[0]
        if isinstance(history, str):
            row["reason"] = f"{words_of(law)}, {wind.name}: {history}"
        else:
            row |= asdict(measure(_counted(history), turbine))
        rows.append(row)
    return {"runs": rows}


def _rosco_run(turbine: Turbine, inputs: Mapping[str, Any], wind: WindSeries) -> History | str:
    plant = simulation_plant(turbine, PlantParts())
    try:
        return simulate_rosco(plant, inputs["law"], Tuning(**inputs["tuning"]), wind)
    except Diverged as end:
        return str(end)


def _counted(history: History) -> History:
    """Return the record from ``SETTLING`` on."""
    first = int(np.searchsorted(history.time - history.time[0], SETTLING - 1e-9))
    every = {field.name: getattr(history, field.name) for field in fields(history)}
    late: dict[str, Any] = {k: v[first:] for k, v in every.items() if isinstance(v, np.ndarray)}
    return replace(history, **late)
