"""Fatigue over the overlap of torque and pitch, the study that Schulte (2024) announces.

Each law is simulated on the validation plant, in turbulence about some mean winds, with its
observer in the loop, and proved as in a sweep.  An overlap of 0 is the hard switch between the same
regional gains.  Settings that are not varied are those of a design.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.design.turbine.settings import check_limits
from takagi.certificates.document.certificate_file import files_sha256
from takagi.certificates.sweep.sweep import (
    SPEED,
    TORQUE,
    WIND,
    Axis,
    AxisKind,
    default_winds,
    effort_sharing_point,
    parse_axes,
    windows_result,
)
from takagi.certificates.sweep.tasks import RESULTS, Task, Tell, canonical, run_tasks
from takagi.models.errors import ModelError
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.loader import TurbineFile
from takagi.reports.simulation.laws import ChosenLaws, chosen_laws
from takagi.reports.simulation.runs import run_simulation
from takagi.reports.simulation.winds import requested_winds

CENTRED, EFFORT = "centred-overlap", "overlap"
SEEDS, DURATION, SHORTEST = 6, 600.0, 10.0
MEANS = tuple(float(v) for v in range(8, 17))
TURBULENCE = "B"
# A switch proves nothing, and so does the reference controller.
SWITCHED, REFERENCE, LAWS_PROVED = "switched", "baseline", ("paper", "coherent")


@dataclass(frozen=True, slots=True)
class Series:
    """A way to vary the overlap.

    Attributes
    ----------
    law : in files;  setting : of a design, that is varied;  fixed : those set beside it.
    shares : of the design's default that are studied unless values are given.
    """

    kind: AxisKind
    law: str
    setting: str
    shares: tuple[float, ...]
    words: str
    fixed: tuple[tuple[str, float], ...] = ()


_SPEEDS = (0.0, 0.1, 0.2, 0.4, 0.6, 0.8, 1.0)
SERIES = (
    Series(
        AxisKind(SPEED, "rad/s", closed=True), "paper", "speed_overlap", _SPEEDS,
        "Schulte's law, ramp as designed",
    ),
    Series(
        AxisKind(CENTRED, "rad/s", closed=True), "paper", "speed_overlap",
        (0.0, 0.1, 0.2, 0.6, 1.0, 1.5, 2.0), "Schulte's law, ramp around the set-point",
        (("ramp_placement", 0.5),),
    ),
    Series(
        AxisKind(TORQUE, "N m"), "paper", "torque_overlap", (0.25, 0.5, 1.0, 2.0),
        "Schulte's law, torque window",
    ),
    Series(
        AxisKind(EFFORT, "rad/s^2"), "coherent", "overlap", (0.2, 0.5, 1.0, 2.0, 3.0, 5.0),
        "effort-sharing law",
    ),
)  # fmt: skip
KINDS = (*(series.kind for series in SERIES), AxisKind(WIND, "m/s"))


@dataclass(frozen=True, slots=True)
class Point:
    """One overlap: the series and its value; None is the reference controller, beside them all."""

    series: Series | None
    value: float = 0.0

    @property
    def asked(self) -> dict[str, Any]:
        """Law and changed settings, as inputs of a task."""
        if self.series is None:
            return {"law": REFERENCE, "settings": {}}
        if self.value == 0:
            return {"law": SWITCHED, "settings": {}}
        settings = {self.series.setting: self.value, **dict(self.series.fixed)}
        return {"law": self.series.law, "settings": settings}

    @property
    def name(self) -> str:
        """What varies, for machines."""
        return self.series.kind.name if self.series else "reference"

    @property
    def words(self) -> dict[str, object]:
        """The first cells of the point's row in a table: law and overlap."""
        if self.series is None:
            return {"law": "reference controller", "overlap": ""}
        return {"law": self.series.words, "overlap": f"{self.value:g} {self.series.kind.unit}"}


@dataclass(frozen=True, slots=True, eq=False)
class OverlapStudy:
    """A finished study.

    Attributes
    ----------
    means : winds [m/s];  seeds : of each;  duration : of a run [s].
    points : in their order;  proofs : what is proved of each, None where nothing can be.
    runs : of each point, a row a mean wind and seed: ``wind``, ``seed``, ``diverged`` and metrics.
    resumed, tasks : how many results were there before, and how many there are.
    """

    turbine: Turbine
    means: tuple[float, ...]
    seeds: int
    duration: float
    points: tuple[Point, ...]
    proofs: tuple[Mapping[str, Any] | None, ...]
    runs: tuple[tuple[Mapping[str, Any], ...], ...]
    resumed: int
    tasks: int

    @property
    def failed(self) -> list[str]:
        """What ended in an error or diverged, in words."""
        words = [proof["error"] for proof in self.proofs if proof and "error" in proof]
        return words + [run["reason"] for runs in self.runs for run in runs if run["reason"]]


def study_axes(written: Sequence[str]) -> tuple[Axis, ...]:
    """Return the axes of texts such as ``speed-overlap=0,0.1,0.5``, see ``parse_axes``."""
    return parse_axes(written, KINDS)


def run_overlap_study(
    source: TurbineFile,
    axes: Sequence[Axis],
    folder: Path,
    *,
    seeds: int = SEEDS,
    duration: float = DURATION,
    workers: int | None = None,
    scheduler: str | None = None,
    tell: Tell | None = None,
) -> OverlapStudy:
    """Return every overlap of the axes in every wind; results are kept in ``folder``/results.

    Parameters
    ----------
    axes : of ``KINDS``, each varied alone; without one of overlaps all series at their shares.
    seeds : of turbulence of class B at each mean wind;  duration : of a run [s].
    workers, scheduler, tell : see ``run_tasks``.

    Raises
    ------
    ModelError : an overlap that no law has, a wind outside the range, a duration too short; what
        ``run_tasks`` refuses.
    """
    turbine = source.model
    means = next((axis.values for axis in axes if axis.name == WIND), MEANS)
    require_runs(seeds, duration)
    requested_winds(turbine, [str(v) for v in means], duration=duration)
    points = _points(turbine, axes)
    inputs: dict[str, Any] = {"files": files_sha256(source.files)}
    wind = {"seeds": list(range(1, seeds + 1)), "duration": duration}

    def task(function: Callable[..., Any], **more: Any) -> Task:
        return Task(f"{__name__}:{function.__name__}", turbine, {**inputs, **more})

    proofs = [
        task(proof, **point.asked) if point.asked["law"] in LAWS_PROVED else None
        for point in points
    ]
    motions = [[task(motion, **point.asked, mean=v, **wind) for v in means] for point in points]
    # The same law may stand in several series.
    ordered = [each for p, m in zip(proofs, motions, strict=True) for each in (p, *m) if each]
    results, resumed = run_tasks(
        ordered, folder / RESULTS, workers=workers, scheduler=scheduler, tell=tell
    )
    by_file = {each.file: result for each, result in zip(ordered, results, strict=True)}
    return OverlapStudy(
        turbine, means, seeds, duration, points,
        tuple(by_file[each.file] if each else None for each in proofs),
        tuple(
            tuple(run for v, each in zip(means, group, strict=True)
                  for run in runs_at(v, by_file[each.file]))
            for group in motions
        ),
        resumed, len(by_file),
    )  # fmt: skip


def require_runs(seeds: int, duration: float) -> None:
    """Raise ModelError for no seeds, or runs [s] that are too short."""
    if seeds < 1 or duration < SHORTEST:
        raise ModelError(
            f"{seeds} seeds and a duration of {duration:g} s were given; at least 1 seed and "
            f"{SHORTEST:g} s are needed"
        )


def _points(turbine: Turbine, axes: Sequence[Axis]) -> tuple[Point, ...]:
    """Return all points, the limits of whose settings are checked."""
    given = {axis.name: axis.values for axis in axes if axis.name != WIND}
    designed = default_settings(turbine)
    points = [Point(None)] if turbine.baseline is not None else []
    for series in SERIES:
        default = getattr(designed, series.setting)
        values = tuple(float(f"{share * default:.6g}") for share in series.shares)
        points += [
            Point(series, value) for value in given.get(series.kind.name, () if given else values)
        ]
    for point in points:
        law, settings = point.asked["law"], point.asked["settings"]
        if law in LAWS_PROVED:
            check_limits(turbine, replace(designed, law=law, **settings))
    return tuple(points)


def runs_at(mean: float, result: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the runs of a task's result, each with its mean wind [m/s]."""
    if "error" in result:
        return [{"wind": mean, "seed": None, "reason": result["error"]}]
    return [{"wind": mean, **run} for run in result["runs"]]


def proof(turbine: Turbine, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Return a task's result: what the independent checker proves of the law, as in a sweep."""
    try:
        if inputs["law"] == "coherent":
            return effort_sharing_point(turbine, inputs["settings"])
        law = studied_law(turbine, _asked(inputs)).laws["paper"]
        result = windows_result(law, default_winds(turbine))  # type: ignore[arg-type]
        return {**result, "windows": len(result["windows"])}
    except ModelError as error:
        return {"verdict": "UNDECIDED", "reason": str(error)}


def motion(turbine: Turbine, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Return a task's result: a law in turbulence about one mean wind, seed by seed."""
    chosen = studied_law(turbine, _asked(inputs))
    words = [f"turbulent:{inputs['mean']!r}:{TURBULENCE}:{seed}" for seed in inputs["seeds"]]
    winds = requested_winds(turbine, words, duration=inputs["duration"])
    simulation = run_simulation(turbine, chosen, winds, series=False)
    rows = []
    for seed, run in zip(inputs["seeds"], simulation.runs, strict=True):
        reason = "" if run.metrics else f"{run.law}, {run.wind}: {run.remarks()[0]}"
        rows.append({"seed": seed, "reason": reason} | (asdict(run.metrics) if run.metrics else {}))
    return {"runs": rows}


def _asked(inputs: Mapping[str, Any]) -> str:
    return canonical({"law": inputs["law"], "settings": inputs["settings"]})


@lru_cache(maxsize=2)
def studied_law(turbine: Turbine, asked: str) -> ChosenLaws:
    """Return a law with its observer and its filter of the measured speed."""
    inputs = json.loads(asked)
    settings = replace(default_settings(turbine), **inputs["settings"])
    return chosen_laws(turbine, [inputs["law"]], settings=settings)
