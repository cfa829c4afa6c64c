"""What can be turned of a plant: positions of sliders, as options of `takagi design`."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from takagi.certificates.design.plant.gain_task import input_limits
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models.plant.plant import file_unit
from takagi.reports.loops.plant_claims import norm_settling_time, settling_time
from takagi.reports.loops.plant_loop import largest_commands, plant_loop
from takagi.reports.page.text import at_least, behind, name_of

if TYPE_CHECKING:
    from takagi.models.plant_files.loader import PlantFile

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

    Attributes
    ----------
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
