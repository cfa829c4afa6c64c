"""The effort-sharing law tuned for the machine: a front of settings, each of which is PROVED.

Settings are chosen by differential evolution (Storn and Price 1997, scipy) for what the validation
plant does in turbulence, in the turbine's own steps around rated wind and in its gusts.  Relative
quantities are those of the law over those of the reference controller in the same winds.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from takagi.certificates.design.turbine.design import design_turbine
from takagi.certificates.design.turbine.scale import default_settings
from takagi.certificates.design.turbine.settings import DesignSettings, check_limits
from takagi.certificates.document.certificate_file import files_sha256
from takagi.certificates.sweep.tasks import RESULTS, Task, Tell, canonical, run_tasks
from takagi.lmi.turbine.effort import EffortSettings
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.simulation.closed_loop import History
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.loader import TurbineFile
from takagi.reports.output import read_words
from takagi.reports.simulation.laws import chosen_laws
from takagi.reports.simulation.runs import run_simulation
from takagi.reports.simulation.winds import requested_winds
from takagi.reports.study.overlap import (
    REFERENCE,
    SHORTEST,
    TURBULENCE,
    studied_law,
)

LAW = "coherent"
MEANS, SEEDS, DURATION = (9.0, 11.0, 13.0, 15.0, 18.0), 2, 600.0
# Recovered: rotor speed and power stay within this share of rated [-].
RECOVERED = 0.01
STEP_TIME = 200.0
# Members of a generation for each lever.
MEMBERS = 4
# Values of levers have these digits, because they identify a point and are typed by a user.
DIGITS = 3
# Points of the front that are proved.
MOST_PROVED = 5
# Weight of what misses a requirement, in units of the requirement's own scale.
PENALTY = 10.0


@dataclass(frozen=True, slots=True)
class Lever:
    """A setting that is varied; ``option`` of `takagi design` takes its value.

    ``low`` and ``high`` are shares of the turbine's default, but of its own unit where ``plain``.
    """

    option: str
    unit: str
    low: float
    high: float
    plain: bool = False

    def bounds(self, settings: DesignSettings) -> tuple[float, float]:
        """Return the ends of the range for a turbine."""
        default = 1.0 if self.plain else self.value(settings)
        return self.low * default, self.high * default

    def value(self, settings: DesignSettings) -> float:
        """Return the value that the settings have."""
        if self.option in _EFFORT:
            return float(getattr(settings.effort or EffortSettings(), _EFFORT[self.option]))
        return float(getattr(settings, _SETTINGS[self.option]))


_SETTINGS = {
    "wind-filter": "wind_filter",
    "pitch-effectiveness-share": "effectiveness_share",
    "overlap": "overlap",
}
_EFFORT = {"bandwidth": "bandwidth", "bandwidth-growth": "bandwidth_growth"}
LEVERS = (
    Lever("wind-filter", "s", 0.15, 1.5),
    Lever("bandwidth", "1/s", 0.6, 1.6),
    Lever("bandwidth-growth", "-", 1.0, 2.0, plain=True),
    Lever("pitch-effectiveness-share", "-", 0.7, 1.4),
    Lever("overlap", "rad/s^2", 0.5, 2.0),
)


@dataclass(frozen=True, slots=True)
class Quantity:
    """What a loop does, as one number.

    Attributes
    ----------
    unit : as typed behind a number.
    larger : whether more is better.
    scale : a difference that matters, in the unit.
    words : for the table's legend.
    """

    name: str
    unit: str
    larger: bool
    scale: float
    words: str


QUANTITIES = tuple(
    Quantity(name, **stated) for name, stated in read_words("study/words.toml")["tuning"].items()
)
_NAMED = {quantity.name: quantity for quantity in QUANTITIES}
_REQUIRED = re.compile(r"([a-z-]+)\s*(<=|>=)?\s*([-+]?[0-9.]+)\s*(%|s|kN ?m)?")


@dataclass(frozen=True, slots=True)
class Requirement:
    """A quantity and its limit, in the quantity's unit."""

    quantity: Quantity
    limit: float

    def missed(self, value: float) -> float:
        """Return by how many scales of the quantity a value misses the limit, 0 for none."""
        short = self.limit - value if self.quantity.larger else value - self.limit
        return math.inf if math.isnan(value) else max(short, 0.0) / self.quantity.scale

    def __str__(self) -> str:
        sign = ">=" if self.quantity.larger else "<="
        return f"{self.quantity.name} {sign} {self.limit:g} {self.quantity.unit}".rstrip()


def quantity_named(name: str) -> Quantity:
    """Return a quantity; ModelError for an unknown name."""
    if name not in _NAMED:
        raise ModelError(
            f"{name!r} is not measured{did_you_mean(name, _NAMED)}; choose from {', '.join(_NAMED)}"
        )
    return _NAMED[name]


def requirements_of(written: str) -> tuple[Requirement, ...]:
    """Return what a text such as ``"energy >= -0.2 %, recovery 30s"`` asks.

    Raises
    ------
    ModelError : a part of another form, an unknown quantity, a sign or unit that it does not have,
        a quantity twice.
    """
    asked: dict[str, Requirement] = {}
    for part in filter(None, (piece.strip() for piece in written.split(","))):
        if part == "proved":
            # Every point of the front is, whether asked or not.
            continue
        match = _REQUIRED.fullmatch(part)
        if match is None:
            raise ModelError(
                f"--require: {part!r} was given; a quantity and its limit are needed, such as "
                '"energy >= -0.2 %, recovery 30s, peak-power 110 %"'
            )
        name, sign, number, unit = match.groups()
        quantity = quantity_named(name)
        direction = ">=" if quantity.larger else "<="
        if sign not in (None, direction) or (unit or quantity.unit).replace(" ", "") != (
            quantity.unit.replace(" ", "")
        ):
            unit_words = quantity.unit or "no unit: it is a ratio to the reference controller's"
            raise ModelError(
                f"--require: {part!r} was given; {name} takes {direction} and {unit_words}"
            )
        if name in asked:
            raise ModelError(f"--require: {name} was given twice; give each quantity once")
        asked[name] = Requirement(quantity, float(number))
    return tuple(asked.values())


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """Settings and what they do.

    Attributes
    ----------
    at : option -> value;  values : quantity -> number;  missed : see ``Tuning``.
    verdict : of the design with these settings, None where it was not sought;  reason : why not.
    """

    at: Mapping[str, float]
    values: Mapping[str, float]
    missed: float
    verdict: str | None = None
    reason: str = ""

    @property
    def command(self) -> str:
        """The options of `takagi design` that give it."""
        return " ".join(f"--{option} {value:g}" for option, value in self.at.items())


@dataclass(frozen=True, slots=True, eq=False)
class Tuning:
    """A finished search.

    Attributes
    ----------
    default : the turbine's own settings.
    front : points that no other one betters in the minimised and in every required quantity, the
        nearest to the requirements first; at most ``MOST_PROVED``, each with its verdict.
    tried : how many settings were simulated;  resumed, tasks : as of ``run_tasks``.
    """

    minimised: Quantity
    requirements: tuple[Requirement, ...]
    default: Candidate
    front: tuple[Candidate, ...]
    tried: int
    resumed: int
    tasks: int

    @property
    def best(self) -> Candidate | None:
        """The PROVED point that meets all requirements with the least minimised quantity.

        Without one, the PROVED point that misses them least; None where none is PROVED.
        """
        proved = [point for point in (self.default, *self.front) if point.verdict == "PROVED"]
        name = self.minimised.name
        return min(proved, key=lambda point: (point.missed, point.values[name]), default=None)


def tuned(
    source: TurbineFile,
    folder: Path,
    *,
    minimise: str,
    require: str = "",
    tries: int = 120,
    means: Sequence[float] = MEANS,
    seeds: int = SEEDS,
    duration: float = DURATION,
    workers: int | None = None,
    scheduler: str | None = None,
    tell: Tell | None = None,
) -> Tuning:
    """Return the front of settings; results are kept in ``folder``/results and not made again.

    Parameters
    ----------
    minimise, require : see ``QUANTITIES`` and ``requirements_of``.
    tries : settings to simulate, at least; whole generations are.
    means : mean winds of the turbulence [m/s];  seeds : of each;  duration : of a run [s].
    workers, scheduler, tell : see ``run_tasks``.

    Raises
    ------
    ModelError : an unknown quantity, a turbine without a reference controller, a wind outside its
        range, too few tries; what ``run_tasks`` refuses.
    """
    from scipy.optimize import Bounds, differential_evolution

    turbine, settings = source.model, default_settings(source.model)
    minimised, requirements = quantity_named(minimise), requirements_of(require)
    if turbine.baseline is None:
        raise ModelError(
            f"{turbine.name}: its file has no reference controller ([baseline]), against which "
            "loads and energy are measured"
        )
    generation = MEMBERS * len(LEVERS)
    if tries < generation or seeds < 1 or duration < SHORTEST:
        raise ModelError(
            f"{tries} tries, {seeds} seeds and {duration:g} s were given; at least {generation} "
            f"tries, 1 seed and {SHORTEST:g} s are needed"
        )
    requested_winds(turbine, [f"{v:g}" for v in means])
    inputs = {"files": files_sha256(source.files), "means": list(means), "seeds": seeds,
              "duration": duration}  # fmt: skip
    candidates: dict[str, Candidate] = {}
    counted = [0, 0]

    def results_of(function: Callable[..., Any], points: Sequence[Mapping[str, float]]) -> Any:
        name = f"{__name__}:{function.__name__}"
        tasks = [Task(name, turbine, {**inputs, "at": dict(at)}) for at in points]
        results, resumed = run_tasks(
            tasks, folder / RESULTS / function.__name__, workers=workers, scheduler=scheduler
        )
        counted[0] += resumed
        counted[1] += len({task.file for task in tasks})
        return results

    def measured(points: Sequence[Mapping[str, float]]) -> list[Candidate]:
        rows = []
        for at, result in zip(points, results_of(behaviour, points), strict=True):
            values = {name: math.nan for name in _NAMED} | result.get("values", {})
            missed = sum(asked.missed(values[asked.quantity.name]) for asked in requirements)
            rows.append(Candidate(at, values, missed, reason=result.get("error", "")))
            candidates[canonical(dict(at))] = rows[-1]
        if tell is not None:
            share = min(len(candidates) / tries, 1.0) * 0.8
            tell(f"{len(candidates)} settings simulated", share)
        return rows

    def costs(_: Callable[..., Any], members: Sequence[Floats]) -> list[float]:
        sign = -1.0 if minimised.larger else 1.0
        rows = []
        for point in measured([_rounded(member) for member in members]):
            value = sign * point.values[minimised.name] / minimised.scale
            rows.append(value + PENALTY * point.missed if math.isfinite(value) else math.inf)
        return rows

    start = {lever.option: lever.value(settings) for lever in LEVERS}
    (default,) = measured([start])
    low, high = np.transpose([lever.bounds(settings) for lever in LEVERS])
    # The stubs of scipy know no function in place of its pool of processes.
    batch: Any = costs
    differential_evolution(
        # The function of one member is never called.
        batch,
        Bounds(low, high),
        popsize=MEMBERS,
        maxiter=max(math.ceil(tries / generation) - 1, 0),
        tol=0.0,
        polish=False,
        updating="deferred",
        workers=batch,
        seed=1,
        x0=np.clip(list(start.values()), low, high),
    )
    names = [minimised.name, *(asked.quantity.name for asked in requirements)]
    front = _front(list(candidates.values()), names)
    front.sort(key=lambda point: (point.missed, point.values[minimised.name]))
    chosen = [default, *(point for point in front if point is not default)][: MOST_PROVED + 1]
    if tell is not None:
        tell(f"{len(chosen)} designs, each proved", 0.8)
    verdicts = results_of(proof, [point.at for point in chosen])
    judged = [
        replace(point, verdict=result.get("verdict", "FAILED"),
                reason=result.get("reason") or result.get("error", ""))
        for point, result in zip(chosen, verdicts, strict=True)
    ]  # fmt: skip
    return Tuning(minimised, requirements, judged[0], tuple(judged[1:]), len(candidates), *counted)


def _rounded(member: Floats) -> dict[str, float]:
    values = (float(f"{value:.{DIGITS}g}") for value in member)
    return dict(zip((lever.option for lever in LEVERS), values, strict=True))


def _front(points: Sequence[Candidate], names: Sequence[str]) -> list[Candidate]:
    """Return the points that no other one betters in every quantity named."""
    signs = np.array([-1.0 if _NAMED[name].larger else 1.0 for name in names])
    table = np.array([[point.values[name] for name in names] for point in points]) * signs
    kept = []
    for point, row in zip(points, table, strict=True):
        better = (table <= row).all(axis=1) & (table < row).any(axis=1)
        if np.isfinite(row).all() and not better.any():
            kept.append(point)
    return kept


# ------------------------------------------------------------------ tasks
def behaviour(turbine: Turbine, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Return a task's result: every quantity of the law with these settings."""
    try:
        chosen = chosen_laws(turbine, [LAW], settings=_settings(turbine, inputs["at"]))
    except ModelError as error:
        return {"error": str(error)}
    reference = _reference(turbine, canonical({k: inputs[k] for k in _WINDS}))
    words = _turbulence(inputs)
    turbulent = requested_winds(turbine, words, duration=inputs["duration"])
    runs = run_simulation(turbine, chosen, turbulent, series=False).runs
    steps = requested_winds(turbine, ["step"], duration=STEP_TIME)
    others = run_simulation(turbine, chosen, (steps[0], *requested_winds(turbine, ["gust"]))).runs
    if any(run.metrics is None for run in (*runs, *others)):
        return {"error": "a loop diverged"}
    metrics = [run.metrics for run in (*runs, *others) if run.metrics is not None]
    inside, outside = metrics[: len(runs)], metrics[len(runs) :]

    def ratios(name: str) -> Floats:
        per_wind = np.reshape([getattr(m, name) for m in inside], (len(inputs["means"]), -1))
        base = np.reshape(reference[name], per_wind.shape).mean(axis=1)
        # Below rated wind pitch may rest with both.
        return np.asarray(per_wind.mean(axis=1)[base > 0] / base[base > 0], np.float64)

    values = {
        "energy": 100 * (float(ratios("energy").min()) - 1),
        "overspeed": max(m.overspeed for m in inside),
        "torque-change": max(m.torque_change for m in inside),
        "recovery": _recovery(others[0].history, turbine),  # type: ignore[arg-type]
        "peak-power": max(m.peak_power for m in outside),
    } | {name: float(ratios(attribute).mean()) for name, attribute in _RATIOS.items()}
    return {"values": {name: float(f"{value:.6g}") for name, value in values.items()}}


_WINDS = ("means", "seeds", "duration")
_RATIOS = {
    "tower-del": "tower_del",
    "blade-del": "blade_del",
    "shaft-del": "shaft_del",
    "travel": "pitch_travel",
}


def proof(turbine: Turbine, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Return a task's result: what the checker says of the certificate of `takagi design`."""
    try:
        design = design_turbine(turbine, _settings(turbine, inputs["at"]))
    except ModelError as error:
        return {"verdict": "NO DESIGN", "reason": str(error)}
    failing = [claim for claim in design.checked.claims if claim.verdict.name != "PROVED"]
    if failing:
        return {"verdict": failing[0].verdict.name, "reason": failing[0].text}
    return {"verdict": "PROVED", "reason": ""}


def _recovery(history: History, turbine: Turbine) -> float:
    """Return how long after the step speed and power are outside 1 % of rated [s]."""
    begin = history.time[1:][np.diff(history.wind) != 0][0]
    power = history.electrical_power / turbine.rated_power - 1
    speed = history.rotor_speed / turbine.rated_rotor_speed - 1
    outside = history.time[(np.abs(power) > RECOVERED) | (np.abs(speed) > RECOVERED)]
    return max(float(outside.max(initial=begin) - begin), 0.0)


def _turbulence(inputs: Mapping[str, Any]) -> list[str]:
    seeds = range(1, inputs["seeds"] + 1)
    return [f"turbulent:{v!r}:{TURBULENCE}:{s}" for v in inputs["means"] for s in seeds]


def _settings(turbine: Turbine, at: Mapping[str, float]) -> DesignSettings:
    settings = default_settings(turbine)
    of_effort: dict[str, Any] = {_EFFORT[k]: v for k, v in at.items() if k in _EFFORT}
    direct: dict[str, Any] = {_SETTINGS[k]: v for k, v in at.items() if k in _SETTINGS}
    effort = replace(settings.effort or EffortSettings(), **of_effort)
    settings = replace(settings, effort=effort, **direct)
    check_limits(turbine, settings)
    return settings


@lru_cache(maxsize=1)
def _reference(turbine: Turbine, winds: str) -> dict[str, list[float]]:
    """Return the reference controller's metrics in the same turbulence, once in each process."""
    inputs = json.loads(winds)
    chosen = studied_law(turbine, canonical({"law": REFERENCE, "settings": {}}))
    asked = requested_winds(turbine, _turbulence(inputs), duration=inputs["duration"])
    runs = run_simulation(turbine, chosen, asked, series=False).runs
    names = ("energy", *_RATIOS.values())
    return {name: [float(getattr(run.metrics, name)) for run in runs] for name in names}
