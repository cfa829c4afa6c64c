"""A sweep of a law: the points of a grid as tasks, and their results as rows of one table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from pathlib import Path
from types import MappingProxyType
from typing import Any

from takagi.certificates.document.certificate_file import files_sha256
from takagi.certificates.sweep import effort_sharing, published
from takagi.certificates.sweep.axis import Axis, AxisKind
from takagi.certificates.sweep.tasks import RESULTS, Task, Tell, canonical, run_tasks
from takagi.models.errors import ModelError
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.loader import TurbineFile, load_turbine, model_files

# The laws that can be swept, by their names in files, with the quantities that --over knows.
LAWS: Mapping[str, tuple[AxisKind, ...]] = MappingProxyType(
    {
        "paper": published.AXES,
        "paper-two-integrators": published.AXES,
        "coherent": effort_sharing.AXES,
    }
)
Row = dict[str, Any]


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
    tell: Tell | None = None,
) -> Sweep:
    """Return every point of a grid; results are kept in ``folder``/results and not made again.

    Parameters
    ----------
    law : one of ``LAWS``.
    workers, tell : see ``run_tasks``.

    Raises
    ------
    ModelError : a wind outside the turbine's range; a process that was killed from outside.
    OSError : a result cannot be written.
    """
    turbine = source.model
    inputs: dict[str, Any] = {"law": law, "files": files_sha256(source.files)}
    grid = [axis for axis in axes if axis.name != published.WIND]
    if LAWS[law] is published.AXES:
        winds = next((axis.values for axis in axes if axis.name == published.WIND), None)
        inputs["winds"] = list(winds or published.default_winds(turbine))
        published.require_winds(turbine, inputs["winds"])
    grid_points = list(product(*(axis.values for axis in grid)))
    tasks = []
    for values in grid_points:
        at = dict(zip((axis.name for axis in grid), values, strict=True))
        tasks.append(Task(f"{__name__}:point", str(source.name), {**inputs, "at": at}))
    results, resumed = run_tasks(tasks, folder / RESULTS, workers=workers, tell=tell)
    rows = []
    for values, result in zip(grid_points, results, strict=True):
        if "error" in result:
            result = {"verdict": "FAILED", "reason": result["error"]}
        rows.append(dict(zip((axis.label for axis in grid), values, strict=True)) | result)
    return Sweep(law, turbine.name, tuple(grid), tuple(rows), resumed)


def point(source: str, inputs: Mapping[str, Any]) -> Row:
    """Return the result of a task; what cannot be is UNDECIDED, with the reason."""
    turbine = _turbine(source, canonical(inputs["files"]))
    try:
        if inputs["law"] == "coherent":
            return effort_sharing.point(turbine, inputs["at"])
        return published.point(inputs["law"], turbine, inputs["at"], inputs["winds"])
    except ModelError as error:
        return {"verdict": "UNDECIDED", "reason": str(error)}


@lru_cache(maxsize=1)
def _turbine(source: str, files: str) -> Turbine:
    """Return the turbine of the files with these hashes; read once in each process."""
    if canonical(files_sha256(model_files(source))) != files:
        raise RuntimeError(f"a file of model {source} was changed while the sweep ran")
    return load_turbine(source)
