"""A sweep of a law: its axes, as a user writes them, and all points of their grid as rows."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Any

from takagi.certificates.document.certificate_file import files_sha256
from takagi.certificates.sweep.points import (
    EFFORT_SHARING,
    PUBLISHED,
    WIND,
    AxisKind,
    default_winds,
    effort_sharing_point,
    published_point,
    require_winds,
)
from takagi.certificates.sweep.tasks import RESULTS, Task, Tell, run_tasks
from takagi.models.errors import ModelError, did_you_mean
from takagi.models.files.units import to_si, typed_figure
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.loader import TurbineFile

# The laws that can be swept, by their names in files, with the quantities that --over knows.
LAWS: Mapping[str, tuple[AxisKind, ...]] = MappingProxyType(
    {"paper": PUBLISHED, "coherent": EFFORT_SHARING}
)
Row = dict[str, Any]
# Values between the ends are short decimals, because they identify the point.
_DIGITS = 9
_COUNT = 100_000


@dataclass(frozen=True, slots=True)
class Axis:
    """A quantity with the values it takes, in its SI unit, increasing."""

    name: str
    unit: str
    values: tuple[float, ...]

    @property
    def label(self) -> str:
        """Name and unit, as at the head of a column."""
        return f"{self.name} [{self.unit}]"


def parse_axes(written: Sequence[str], kinds: Sequence[AxisKind]) -> tuple[Axis, ...]:
    """Return the axes that texts like ``speed-overlap=0.02:0.2:20`` ask for, in their order.

    A text is NAME=LOW:HIGH:COUNT (evenly spaced, both ends included) or NAME=VALUE,VALUE,...; a
    number may have a unit behind it (``torque-overlap=0.5kN m:5kN m:10``), else it is in SI.

    Raises
    ------
    ModelError : a name that is not known (the known ones are listed) or is given twice, a text of
        another form, a unit of another quantity, values that do not increase, a value beyond what
        the quantity allows, more than 100 000 points.
    """
    named, axes = {kind.name: kind for kind in kinds}, dict[str, Axis]()
    for text in written:
        name, _, values = text.partition("=")
        name = name.strip()
        if name not in named:
            raise ModelError(
                f"--over {text}: {name!r} cannot be swept{did_you_mean(name, named)}; known here: "
                + ", ".join(f"{kind.name} [{kind.unit}]" for kind in kinds)
            )
        if name in axes:
            raise ModelError(f"--over {text}: {name} was given before; give each axis once")
        try:
            axes[name] = _axis(named[name], values)
        except ModelError as error:
            raise ModelError(f"--over {text}: {error}") from error
    points = math.prod(len(axis.values) for axis in axes.values())
    if points > _COUNT:
        raise ModelError(f"{points} points were asked for; at most {_COUNT} are made in one sweep")
    return tuple(axes.values())


def _axis(kind: AxisKind, text: str) -> Axis:
    ends = text.split(":")
    if len(ends) not in (1, 3) or not text.strip():
        raise ModelError(f"write {kind.name}=LOW:HIGH:COUNT or {kind.name}=VALUE,VALUE,...")
    if len(ends) == 3:
        values = _spaced(_number(kind, ends[0]), _number(kind, ends[1]), ends[2])
    else:
        values = [_number(kind, number) for number in text.split(",")]
    for value in values:
        if not (0 < value or kind.closed and value == 0) or value > kind.highest:
            limit = f"{'at least' if kind.closed else 'above'} 0"
            limit += f" and at most {kind.highest:g}" if kind.highest < math.inf else ""
            raise ModelError(
                f"{value:g} {kind.unit} was given; {kind.name} must be {limit} {kind.unit}"
            )
    for low, high in zip(values, values[1:], strict=False):
        if not low < high:
            raise ModelError(f"{low:g} is followed by {high:g} {kind.unit}; values must increase")
    return Axis(kind.name, kind.unit, tuple(values))


def _spaced(low: float, high: float, count: str) -> list[float]:
    if not re.fullmatch(r"\s*[0-9]{1,6}\s*", count) or not 2 <= int(count) <= _COUNT:
        raise ModelError(
            f"{count!r} was given as the number of values; a whole number from 2 to {_COUNT} is "
            "needed"
        )
    n = int(count) - 1
    steps = [low + (high - low) * i / n for i in range(1, n)]
    return [low, *(float(f"{value:.{_DIGITS}g}") for value in steps), high]


def _number(kind: AxisKind, text: str) -> float:
    value, unit = typed_figure(text)
    # The unit's factor must not add further digits to a decimal that was typed.
    return float(f"{to_si(value, unit, kind.unit):.12g}") if unit else value


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """A finished sweep.

    Attributes
    ----------
    law : its name in files;  model : the turbine's name.
    axes : of the grid.  An axis of winds of a published law is not among them: each point examines
        all these winds.
    rows : one a point, in the order of the grid: the axes' values, then the result.  ``verdict`` is
        PROVED, PARTLY (some winds), UNDECIDED, or FAILED after an unforeseen error; ``windows`` are
        a published law's winds.
    resumed : how many points were computed before.
    """

    law: str
    model: str
    axes: tuple[Axis, ...]
    rows: tuple[Row, ...]
    resumed: int

    def counted(self) -> dict[str, int]:
        """Return verdict -> number of points."""
        verdicts = [row["verdict"] for row in self.rows]
        return {verdict: verdicts.count(verdict) for verdict in sorted(set(verdicts))}


def run_sweep(
    law: str,
    source: TurbineFile,
    axes: Sequence[Axis],
    folder: Path,
    *,
    workers: int | None = None,
    scheduler: str | None = None,
    tell: Tell | None = None,
) -> Sweep:
    """Return every point of a grid; results are kept in ``folder``/results and not made again.

    Parameters
    ----------
    law : one of ``LAWS``.
    workers, scheduler, tell : see ``run_tasks``.

    Raises
    ------
    ModelError : a wind outside the turbine's range; what ``run_tasks`` refuses.
    OSError : a result cannot be written.
    """
    inputs: dict[str, Any] = {"law": law, "files": files_sha256(source.files)}
    grid = [axis for axis in axes if axis.name != WIND]
    if LAWS[law] is PUBLISHED:
        default = default_winds(source.model)
        winds = next((axis.values for axis in axes if axis.name == WIND), default)
        inputs["winds"] = list(winds)
        require_winds(source.model, winds)
    grid_points = list(product(*(axis.values for axis in grid)))
    ats = [dict(zip((axis.name for axis in grid), values, strict=True)) for values in grid_points]
    results, resumed = run_tasks(
        [Task(f"{__name__}:point", source.model, {**inputs, "at": at}) for at in ats],
        folder / RESULTS,
        workers=workers,
        scheduler=scheduler,
        tell=tell,
    )
    rows = []
    for values, result in zip(grid_points, results, strict=True):
        if "error" in result:
            result = {"verdict": "FAILED", "reason": result["error"]}
        rows.append(dict(zip((axis.label for axis in grid), values, strict=True)) | result)
    return Sweep(law, source.model.name, tuple(grid), tuple(rows), resumed)


def point(turbine: Turbine, inputs: Mapping[str, Any]) -> Row:
    """Return the result of a task; what cannot be is UNDECIDED, with the reason."""
    try:
        if inputs["law"] == "coherent":
            return effort_sharing_point(turbine, inputs["at"])
        return published_point(inputs["law"], turbine, inputs["at"], inputs["winds"])
    except ModelError as error:
        return {"verdict": "UNDECIDED", "reason": str(error)}
