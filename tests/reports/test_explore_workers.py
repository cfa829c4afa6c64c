"""The explorer's processes: a newer question drops an older one, and a lost process is replaced."""

from __future__ import annotations

import asyncio
import multiprocessing
from pathlib import Path
from typing import Any

import pytest

from takagi.cli.options.plant_options import plant_settings
from takagi.models.plant_files.loader import PlantFile
from takagi.reports.explore.books import ENDED, Book, Worker

pytestmark = pytest.mark.slow


def test_a_newer_question_drops_the_older(tmp_path: Path) -> None:
    worker = Worker("cart_pole_2rules", plant_settings)

    async def ask() -> list[Any]:
        options = ({"settle": "3s"}, {"settle": "2s"}, {"settle": "4s"})
        asked = (worker.cell(o, tmp_path / o["settle"]) for o in options)
        return await asyncio.gather(*asked)

    try:
        *older, newest = asyncio.run(ask())
    finally:
        worker.end()
    assert older == [None, None]
    assert newest["proved"]
    assert not (tmp_path / "3s").exists() and not (tmp_path / "2s").exists()


def test_a_process_that_is_killed_is_replaced(tmp_path: Path) -> None:
    before = set(multiprocessing.active_children())
    worker = Worker("cart_pole_2rules", plant_settings)
    (process,) = set(multiprocessing.active_children()) - before
    process.kill()
    process.join()

    async def ask() -> list[Any]:
        first = await worker.cell({"settle": "3s"}, tmp_path / "one")
        return [first, await worker.cell({"settle": "3s"}, tmp_path / "two")]

    try:
        lost, found = asyncio.run(ask())
    finally:
        worker.end()
    assert lost["none"] == ENDED
    assert found["proved"]


def test_the_grid_is_filled_and_the_page_waits_for_what_runs(tmp_path: Path) -> None:
    from takagi.reports.explore.axes import Axis, command_of

    source = PlantFile.of("cart_pole_2rules")
    workers = [Worker("cart_pole_2rules", plant_settings) for _ in range(2)]
    axis = Axis("settle", "Settling time", ({}, {"settle": "3s"}), ("as the file says", "3 s"))
    cells: dict[tuple[int, ...], Any] = {}
    book = Book(
        "Plant",
        (axis,),
        cells,
        [(0,), (1,)],
        lambda at: command_of(source, axis.options[at[0]], at),
        folder=tmp_path,
        workers=workers,
    )

    async def ask() -> Any:
        filling = asyncio.ensure_future(book.fill())
        await asyncio.sleep(0)
        answer = await book.exact((0,))
        await filling
        return answer

    try:
        answer = asyncio.run(ask())
    finally:
        book.close()
    assert answer is not None and answer["exact"] and answer["origin"] == "precomputed"
    assert book.progress() == (2, 2)
    assert book.nearest((1,))["command"].startswith("takagi design cart_pole_2rules --settle 3s")
