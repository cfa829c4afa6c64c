"""What the page asks: a book of designs with sliders, of a plant or of a finished turbine."""

from __future__ import annotations

import asyncio
import hashlib
import os
import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from takagi.certificates.design.plant.gains import input_limits
from takagi.certificates.document.certificate_file import provenance
from takagi.certificates.sweep.store import canonical
from takagi.models.plant.plant import file_unit
from takagi.reports.explore.workers import Worker
from takagi.reports.loops.plant_claims import norm_settling_time, settling_time
from takagi.reports.loops.plant_loop import largest_commands, plant_loop
from takagi.reports.page.rounded_bounds import at_least
from takagi.reports.page.text import behind, name_of

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.plant_files.loader import PlantFile
    from takagi.reports.explore.plant_cell import Cell, SettingsOf

# Positions of the sliders; options of a design, by the names of their parameters.
Steps: TypeAlias = tuple[int, ...]
Options: TypeAlias = dict[str, Any]
FREE = "as the file says"
# Settling times, as multiples of the first design's.
TIMES = np.geomspace(0.4, 4.0, 12)
# Shares of an input's limit; multiples of the first design's command where there is none.
LIMITED, UNLIMITED = (0.25, 0.35, 0.5, 0.65, 0.8, 0.9), (0.3, 0.5, 0.7, 1.0, 1.5, 2.0)
# Shares of the states' ranges, all at once.
COVERED = (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)
# The grid has every second position of each slider.
GRID = 2


@dataclass(frozen=True, slots=True)
class Axis:
    """One slider.

    name : a word for the page's script;  label : the heading.
    options : of every position, the first without any;  words : what each position shows.
    """

    name: str
    label: str
    options: tuple[Options, ...]
    words: tuple[str, ...]


def axes_of(source: PlantFile, first: PlantDesign) -> tuple[Axis, ...]:
    """Return what can be turned, around the design that the plant's file asks for."""
    axes = [_settling(first), _limits(source, first), _starts(source, first)]
    return tuple(axis for axis in axes if len(axis.options) > 1)


def grid_of(axes: Sequence[Axis]) -> list[Steps]:
    """Return the positions that are computed in the background."""
    return list(product(*(range(0, len(axis.options), GRID) for axis in axes)))


def options_at(axes: Sequence[Axis], steps: Steps) -> Options:
    """Return the options of a position."""
    return {
        k: v for axis, step in zip(axes, steps, strict=True) for k, v in axis.options[step].items()
    }


def command_of(source: PlantFile, options: Mapping[str, Any], steps: Steps) -> str:
    """Return the command that makes the design of a position."""
    words = ["takagi", "design", str(source.name)]
    for name, value in options.items():
        for text in value if isinstance(value, list) else [value]:
            words += [f"--{name.replace('_', '-')}", text]
    place = "-".join([Path(source.name).stem, *map(str, steps)])
    return shlex.join([*words, "--out", f"build/{place}"])


def _settling(first: PlantDesign) -> Axis:
    loop = plant_loop(first)
    time = settling_time(loop) or (loop.decay_rate and norm_settling_time(loop.decay_rate))
    times = dict.fromkeys(f"{float(f'{time * factor:.2g}'):g}s" for factor in TIMES) if time else {}
    options: list[Options] = [{}, *({"settle": text} for text in times)]
    words = (FREE, *(f"{text[:-1]} s to 2 %" for text in times))
    return Axis("settle", "Settling time", tuple(options), words)


def _limits(source: PlantFile, first: PlantDesign) -> Axis:
    limits = input_limits(first.plant, first.model, first.settings)
    shares = LIMITED if limits else UNLIMITED
    if not limits:
        commands = largest_commands(plant_loop(first))
        limits = {name_of(label): size for label, size in commands if np.isfinite(size)}
    if set(limits) != set(source.entry.commanded):
        limits = {}
    variables = {v.name: v for v in first.plant.inputs}
    return _shared("limit", "Limits of the inputs", "input_limit", "|{}| <= {}", shares, {
        name: (size / file_unit(variables[name])[0], file_unit(variables[name])[1])
        for name, size in limits.items()
    })  # fmt: skip


def _starts(source: PlantFile, first: PlantDesign) -> Axis:
    sizes = {}
    for variable, label in zip(first.plant.states, first.model.states, strict=False):
        ends = first.model.box.get(label)
        # The gains of a plant with references are not sought from starts.
        if (
            ends is not None
            and variable.name in source.entry.all_states
            and not first.plant.references
        ):
            size, unit = file_unit(variable)
            sizes[variable.name] = min(abs(float(end)) for end in ends) / size, unit
    return _shared("starts", "Starts that must be covered", "initial", "{} to ±{}", COVERED, sizes)


def _shared(
    name: str,
    label: str,
    option: str,
    words: str,
    shares: Sequence[float],
    sizes: Mapping[str, tuple[float, str]],
) -> Axis:
    """Return the axis on which every variable takes the same share of its size."""
    options: list[Options] = [{}]
    shown = [FREE]
    for share in shares if sizes else ():
        # Rounded down: a limit beyond the range is none.
        numbers = {key: at_least(share * size, 2) for key, (size, _) in sizes.items()}
        options.append({option: [f"{key}={number}" for key, number in numbers.items()]})
        shown.append(
            ", ".join(
                words.format(k, number + behind(sizes[k][1])) for k, number in numbers.items()
            )
        )
    return Axis(name, label, tuple(options), tuple(shown))


def cache_folder(source: PlantFile, place: Path | None) -> Path:
    """Return where the designs of a plant's file are kept, by its content and by all versions.

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

    Raises ModelError: a plant that has nothing to turn.
    """
    from takagi.models.errors import ModelError

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
