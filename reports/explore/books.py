"""What the page asks: a book of designs with sliders, of a plant or of a finished turbine."""

from __future__ import annotations

import asyncio
import hashlib
import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any, Protocol

from takagi.certificates.document.certificate_file import provenance
from takagi.certificates.sweep.store import canonical
from takagi.reports.explore.axes import Axis, Steps, command_of, grid_of, options_at
from takagi.reports.explore.workers import Worker

if TYPE_CHECKING:
    from takagi.models.plant_files.loader import PlantFile
    from takagi.reports.explore.plant_cell import Cell, SettingsOf


class Book(Protocol):
    """Designs by the positions of sliders; all answers are JSON."""

    @property
    def title(self) -> str: ...

    @property
    def axes(self) -> Sequence[Axis]: ...

    @property
    def panels(self) -> Sequence[Mapping[str, Any]]:
        """Lines over the first slider, which belong to all positions."""

    def progress(self) -> tuple[int, int]:
        """Return how many designs are ready, and of how many."""

    def nearest(self, steps: Steps) -> Mapping[str, Any]:
        """Return the design at a position, or else the nearest that is ready."""

    async def exact(self, steps: Steps) -> Mapping[str, Any] | None:
        """Return the design at a position; None if another one was asked for meanwhile."""

    async def fill(self) -> None:
        """Compute what is missing, in the background."""

    def close(self) -> None:
        """End all processes."""


def cache_folder(source: PlantFile, place: Path | None) -> Path:
    """Return where the designs of a plant's file are kept, by its content and by all versions.

    Parameters
    ----------
    place : of all plants; None for ``takagi`` in the user's folder for caches.
    """
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    files = [hashlib.sha256(path.read_bytes()).hexdigest() for path in source.files]
    covered = canonical({"files": files, "versions": provenance({}, {})["versions"]})
    digest = hashlib.sha256(covered.encode()).hexdigest()[:12]
    return (place or base / "takagi" / "explore") / f"{Path(source.name).stem}-{digest}"


@dataclass(eq=False)
class PlantBook:
    """Designs of one plant.

    Attributes
    ----------
    axes : the sliders;  cells : position -> design, of this run alone.
    folder : where designs are kept.
    """

    source: PlantFile
    axes: tuple[Axis, ...]
    folder: Path
    settings_of: SettingsOf
    cells: dict[Steps, Cell]
    _asked: Steps = ()
    _seconds: list[float] = field(default_factory=list)
    _workers: list[Worker] = field(default_factory=list)
    _running: dict[Steps, asyncio.Task[Cell | None]] = field(default_factory=dict)

    @property
    def title(self) -> str:
        """The name of the plant."""
        return self.source.model.name

    @property
    def panels(self) -> Sequence[Mapping[str, Any]]:
        """See ``Book``: a plant has none."""
        return ()

    def progress(self) -> tuple[int, int]:
        """See ``Book``."""
        grid = grid_of(self.axes)
        return sum(steps in self.cells for steps in grid), len(grid)

    def nearest(self, steps: Steps) -> Mapping[str, Any]:
        """See ``Book``; only designs count as near, and the position itself whatever it has."""
        self._asked = steps
        designs = [at for at, cell in self.cells.items() if "none" not in cell]
        shown = steps if steps in self.cells else min(designs, key=lambda at: _distance(at, steps))
        return self._answer(shown, steps)

    async def exact(self, steps: Steps) -> Mapping[str, Any] | None:
        """See ``Book``."""
        self._asked = steps
        if steps not in self.cells:
            task = self._running.get(steps)
            cell = await (task or self._made(self._process(0), steps))
            if cell is None:
                return None
            self.cells[steps] = cell
        return self._answer(steps, steps)

    def _answer(self, shown: Steps, steps: Steps) -> Mapping[str, Any]:
        cell = self.cells[shown]
        if shown in grid_of(self.axes):
            origin = "precomputed"
        else:
            origin = (
                f"designed now in {cell['seconds']:.2g} s" if cell["new"] else "designed before"
            )
        return {
            "cell": cell,
            "exact": shown == steps,
            "origin": origin,
            "shown": list(shown),
            "command": command_of(self.source, options_at(self.axes, shown), shown),
            "expected": median(self._seconds) if self._seconds else None,
        }

    async def fill(self) -> None:
        """See ``Book``: the grid's designs, those near the page's position first."""
        waiting = [steps for steps in grid_of(self.axes) if steps not in self.cells]
        while waiting:
            steps = min(waiting, key=lambda at: _distance(at, self._asked or at))
            waiting.remove(steps)
            if steps in self.cells:
                continue
            task = asyncio.ensure_future(self._made(self._process(1), steps))
            self._running[steps] = task
            cell = await task
            del self._running[steps]
            if cell is not None:
                self.cells[steps] = cell

    def _process(self, number: int) -> Worker:
        while len(self._workers) <= number:
            self._workers.append(Worker(str(self.source.name), self.settings_of))
        return self._workers[number]

    async def _made(self, worker: Worker, steps: Steps) -> Cell | None:
        place = self.folder / "-".join(map(str, steps))
        cell = await worker.cell(options_at(self.axes, steps), place)
        if cell is not None and cell["new"]:
            self._seconds.append(cell["seconds"])
        return cell

    def close(self) -> None:
        """See ``Book``."""
        for worker in self._workers:
            worker.end()


def _distance(one: Steps, other: Steps) -> int:
    return sum(abs(a - b) for a, b in zip(one, other, strict=True))


@dataclass(frozen=True, eq=False)
class TurbineBook:
    """The wind cells of a finished design, all there from the start."""

    title: str
    axes: tuple[Axis, ...]
    cells: Sequence[Cell]
    command: str
    panels: Sequence[Mapping[str, Any]]

    def progress(self) -> tuple[int, int]:
        """See ``Book``."""
        return len(self.cells), len(self.cells)

    def nearest(self, steps: Steps) -> Mapping[str, Any]:
        """See ``Book``."""
        return {
            "cell": self.cells[steps[0]],
            "exact": True,
            "origin": "read from the design's folder; its certificate was checked when it was read",
            "shown": list(steps),
            "command": self.command,
            "expected": None,
        }

    async def exact(self, steps: Steps) -> Mapping[str, Any]:
        """See ``Book``."""
        return self.nearest(steps)

    async def fill(self) -> None:
        """See ``Book``: nothing is missing."""

    def close(self) -> None:
        """See ``Book``: there are no processes."""


def plant_book(
    source: PlantFile, settings_of: SettingsOf, place: Path | None, tell: Any
) -> PlantBook | str:
    """Return the book of a plant with its first design, which the sliders are made around.

    The reason where the plant's file has no design.

    Raises
    ------
    ModelError : a plant that cannot be designed, or that has nothing to turn.
    """
    from takagi.models.errors import ModelError
    from takagi.reports.explore.axes import axes_of
    from takagi.reports.explore.plant_cell import made_cell, read_checked

    if not source.model.inputs:
        raise ModelError(
            f"{source.name}: a plant without inputs has nothing to turn; 'takagi design "
            f"{source.name} --out DIR' analyses it"
        )
    folder = cache_folder(source, place)
    first = folder / "first"
    cell = made_cell(source, {}, first, settings_of, tell)
    if "none" in cell:
        return str(cell["none"])
    axes = axes_of(source, read_checked(first, source, settings_of(source, {})))
    return PlantBook(source, axes, folder, settings_of, {(0,) * len(axes): cell})


def as_json(value: Any) -> bytes:
    """Return JSON without NaN, as the page reads it."""
    return json.dumps(value, allow_nan=False, separators=(",", ":")).encode()
