"""Processes that design: each keeps the solvers and the plant's derivation loaded."""

from __future__ import annotations

import asyncio
import multiprocessing
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from takagi.certificates.sweep.tasks import start_process

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from multiprocessing.sharedctypes import Synchronized

    from takagi.reports.explore.axes import Axis
    from takagi.reports.explore.plant_cell import Cell, SettingsOf

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
    from takagi.certificates.design.plant.design import design_plant
    from takagi.models.loading import read_model
    from takagi.models.plant_files.loader import PlantFile, load_plant
    from takagi.reports.explore.axes import axes_of
    from takagi.reports.explore.plant_cell import made_cell, read_checked

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
