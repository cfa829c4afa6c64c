"""Books of designs with sliders, of a plant or a finished turbine, and the process for them."""

from __future__ import annotations

import asyncio
import hashlib
import multiprocessing
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any

from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.document.certificate_file import provenance
from takagi.certificates.sweep.tasks import canonical, start_process
from takagi.models.errors import ModelError
from takagi.models.loading import read_model
from takagi.reports.explore.axes import Axis, Steps, axes_of, command_of, grid_of, options_at
from takagi.reports.explore.plant_cell import Cell, SettingsOf, made_cell, read_checked

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.sharedctypes import Synchronized

    from takagi.models.plant_files.loader import PlantFile


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
class Book:
    """The designs that a page shows, by the positions of its sliders; all answers are JSON.

    Attributes
    ----------
    cells : position -> design, of this run alone.
    grid : the positions that are computed in the background.
    command_at : position -> the command that makes its design.
    panels : lines over the first slider, which belong to all positions.
    folder : where designs are kept.
    workers : one for what the page asks for, one for the grid; none where every cell is there.
    """

    title: str
    axes: tuple[Axis, ...]
    cells: dict[Steps, Cell]
    grid: Sequence[Steps]
    command_at: Callable[[Steps], str]
    panels: Sequence[Mapping[str, Any]] = ()
    folder: Path = Path()
    workers: Sequence[Worker] = ()
    _asked: Steps = ()
    _seconds: list[float] = field(default_factory=list)
    _running: dict[Steps, asyncio.Task[Cell | None]] = field(default_factory=dict)

    def progress(self) -> tuple[int, int]:
        """Return how many designs of the grid are ready, and of how many."""
        return sum(steps in self.cells for steps in self.grid), len(self.grid)

    def nearest(self, steps: Steps) -> Mapping[str, Any]:
        """Return what a position has, or else the nearest design that is ready."""
        self._asked = steps
        if steps in self.cells:
            return self._answer(steps, steps)
        designs = (at for at, cell in self.cells.items() if "none" not in cell)
        return self._answer(min(designs, key=lambda at: _distance(at, steps)), steps)

    async def exact(self, steps: Steps) -> Mapping[str, Any] | None:
        """Return what a position has; None if another one was asked for meanwhile."""
        self._asked = steps
        if steps not in self.cells:
            task = self._running.get(steps)
            cell = await (task or self._made(self.workers[0], steps))
            if cell is None:
                return None
            self.cells[steps] = cell
        return self._answer(steps, steps)

    async def fill(self) -> None:
        """Compute the grid, what is near to the page's position first."""
        waiting = [steps for steps in self.grid if steps not in self.cells]
        while waiting:
            steps = min(waiting, key=lambda at: _distance(at, self._asked or at))
            waiting.remove(steps)
            if steps in self.cells:
                continue
            task = asyncio.ensure_future(self._made(self.workers[1], steps))
            self._running[steps] = task
            cell = await task
            del self._running[steps]
            if cell is not None:
                self.cells[steps] = cell

    def close(self) -> None:
        """End all processes."""
        for worker in self.workers:
            worker.end()

    async def _made(self, worker: Worker, steps: Steps) -> Cell | None:
        place = self.folder / "-".join(map(str, steps))
        cell = await worker.cell(options_at(self.axes, steps), place)
        if cell is not None and cell["new"]:
            self._seconds.append(cell["seconds"])
        return cell

    def _answer(self, shown: Steps, steps: Steps) -> Mapping[str, Any]:
        cell = self.cells[shown]
        if shown in self.grid:
            origin = "precomputed" if self.workers else "read from the design's folder"
        else:
            done = "sought" if "none" in cell else "designed"
            origin = f"{done} now in {cell['seconds']:.2g} s" if cell["new"] else f"{done} before"
        return {
            "cell": cell,
            "exact": shown == steps,
            "origin": origin,
            "shown": shown,
            "command": self.command_at(shown),
            "expected": median(self._seconds) if self._seconds else None,
        }


def _distance(one: Steps, other: Steps) -> int:
    return sum(abs(a - b) for a, b in zip(one, other, strict=True))


def plant_book(source: PlantFile, settings_of: SettingsOf, place: Path | None) -> Book | str:
    """Return the book of a plant with its first design, which the sliders are made around.

    The reason where the plant's file has no design.

    Raises
    ------
    ModelError : a plant that has nothing to turn.
    """
    if not source.entry.inputs:
        raise ModelError(
            f"{source.name}: a plant without inputs has nothing to turn; 'takagi design "
            f"{source.name} --out DIR' analyses it"
        )
    folder = cache_folder(source, place)
    workers = (Worker(str(source.name), settings_of), Worker(str(source.name), settings_of))
    cell, axes = workers[0].first(folder / "first")
    if "none" in cell:
        return str(cell["none"])
    return Book(
        source.entry.name or Path(source.name).stem,
        axes,
        {(0,) * len(axes): cell},
        grid_of(axes),
        lambda steps: command_of(source, options_at(axes, steps), steps),
        folder=folder,
        workers=workers,
    )


ENDED = "The process that designs was ended from outside, perhaps for want of memory; try again."


class Worker:
    """One process with one task at a time.

    A task is dropped, at the next step of its design, as soon as a newer one is asked for.
    """

    def __init__(self, model: str, settings_of: SettingsOf) -> None:
        self._arguments = (model, settings_of)
        # A fresh interpreter: a copy would inherit the locks of the server's threads.
        self._context = multiprocessing.get_context("spawn")
        self._newest: Synchronized[int] = self._context.Value("q", 0)
        self._lock = asyncio.Lock()
        self._ended = False
        self._start()

    def _start(self) -> None:
        self._pipe, theirs = self._context.Pipe()
        self._process = self._context.Process(
            target=_serve, args=(theirs, self._newest, *self._arguments), daemon=True
        )
        self._process.start()
        theirs.close()

    def first(self, folder: Path) -> tuple[Cell, tuple[Axis, ...]]:
        """Return the design without options, and the sliders around it; () where it has none."""
        try:
            self._pipe.send((0, None, folder))
            answer: tuple[Cell, tuple[Axis, ...]] = self._pipe.recv()
        except (EOFError, OSError):
            return {"none": ENDED}, ()
        return answer

    async def cell(self, options: Mapping[str, Any], folder: Path) -> Cell | None:
        """Return the design with the options; None if a newer one was asked for meanwhile."""
        self._newest.value += 1
        # Whoever waits may go; the answer must leave the pipe all the same.
        return await asyncio.shield(self._answered(self._newest.value, options, folder))

    async def _answered(self, number: int, options: Mapping[str, Any], folder: Path) -> Cell | None:
        async with self._lock:
            if number != self._newest.value:
                return None
            try:
                return await asyncio.to_thread(self._ask, (number, options, folder))
            except (EOFError, OSError):
                if not self._ended:
                    self._start()
                return {"none": ENDED, "new": True, "seconds": 0.0}

    def _ask(self, task: tuple[int, Mapping[str, Any], Path]) -> Cell | None:
        self._pipe.send(task)
        answer: Cell | None = self._pipe.recv()
        return answer

    def end(self) -> None:
        """End the process at once."""
        self._ended = True
        self._process.kill()


class _Stale(Exception):
    """A newer task was asked for."""


def _serve(
    pipe: Connection, newest: Synchronized[int], model: str, settings_of: SettingsOf
) -> None:
    """Answer tasks until the pipe is closed."""
    start_process()
    from takagi.models.plant_files.loader import PlantFile, load_plant

    source = read_model(model)
    assert isinstance(source, PlantFile)  # the server looked
    while True:
        try:
            number, options, folder = pipe.recv()
        except EOFError:
            return

        def tell(_: str, number: int = number) -> None:
            if newest.value != number:
                raise _Stale

        try:
            answer = made_cell(source, options or {}, folder, settings_of, tell)
        except _Stale:
            answer = None
        except Exception as error:
            words = " ".join(str(error).split())
            answer = {"none": f"internal error ({type(error).__name__}: {words})", "new": True}
            answer["seconds"] = 0.0
        if options is not None:
            pipe.send(answer)
            continue
        assert answer is not None  # nothing newer was asked for
        settings = settings_of(source, {})
        made = "none" not in answer
        pipe.send((answer, axes_of(source, read_checked(folder, source, settings)) if made else ()))
        if not answer["new"]:
            # The smallest design loads the solvers before the page asks for one.
            design_plant(load_plant("cart_pole_2rules"))
