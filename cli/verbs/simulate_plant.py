"""`takagi simulate` for a plant: what is run, and how its numbers are shown on a terminal."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from takagi.certificates.design.design import NoDesign
from takagi.cli.command import PROVED, UNPROVED
from takagi.cli.options.given import Options, declared, refuse_designing
from takagi.cli.options.plant_options import PLANT_OPTIONS, plant_scenario, values_in_si
from takagi.cli.output_place import require_folder_place
from takagi.cli.progress import Tell, progress
from takagi.cli.runs.plant import PlantMaker
from takagi.cli.terminal.rows import tell_none
from takagi.models.errors import ModelError
from takagi.reports.output import write_folder

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.plant.entries import VariableEntry
    from takagi.models.plant_files.loader import PlantFile
    from takagi.reports.simulation.plant_words import PlantSimulation

_WIDTH = 100  # in a pipe or a file there is no terminal to fit into
_FILES, _FOLDERS = ("responses.csv", "simulation.json", "summary.md"), ("figures",)


OPTIONS: Options = (
    *declared("simulate-plant", "simulate-plant-scenario", "simulate-shared"),
    *PLANT_OPTIONS,
)
# Options that are not about a design.
_OWN = ("gains", "start", "reference", "disturbance", "noise", "seed", "sample_time")


def simulate(
    source: PlantFile,
    out: Path | None,
    options: Mapping[str, Any],
    *,
    duration: float | None,
    as_json: bool,
) -> int:
    """Design or read the gains, run the plant, print a table; return the exit status."""
    if out is not None:
        require_folder_place(out, files=_FILES, folders=_FOLDERS)
    states = source.entry.all_states
    starts = [values_in_si("--start", [text], states) for text in options["start"] or []]
    signals = _references(source)
    jumps = [values_in_si("--reference", [text], signals) for text in options["reference"] or []]
    design_options = {name: options[name] for name in options if name not in _OWN}
    if duration is not None and not 0 < duration < float("inf"):
        raise ModelError(f"option --duration: {duration:g} was given; it must be positive")
    scenario = plant_scenario(source.entry, options, duration=duration)
    if options["gains"] is not None:
        refuse_designing(design_options)
    written: list[str] = []
    with progress(f"takagi simulate {source.name}") as tell:
        design, gains = _designed(PlantMaker(source, design_options), options["gains"], tell)
        if isinstance(design, NoDesign):
            return tell_none(design, as_json=as_json)
        from takagi.reports.simulation import plant as simulation

        tell("runs")
        program = None
        if gains is not None and scenario.sample_time is not None:
            from takagi.reports.code.program_reading import read_controller

            program = read_controller(gains)
        run = simulation.simulate_plant(
            design,
            starts=starts or ([] if jumps else None),
            references=jumps or None,
            duration=duration,
            scenario=scenario,
            program=program,
        )
        if out is not None:
            tell("figures and tables")
            files = simulation.simulation_files(run)
            write_folder(out, files)
            written = [str(out / name) for name in files]
    data = simulation.simulation_data(run)
    if as_json:
        print(json.dumps({**data, "files": written}, indent=2))
    else:
        _print(run, data, written)
    return PROVED if run.all_ended else UNPROVED


def _designed(
    maker: PlantMaker, given: Path | None, tell: Tell
) -> tuple[PlantDesign | NoDesign, Path | None]:
    """Return the design of a folder, the proof of a gain file, or a new design; and the gain file.

    Of a new design there is no gain file.
    """
    if given is None:
        return maker.design(tell), None
    if not given.is_dir():
        return maker.with_gains(given, tell), given
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.reports.design_folder import design_folder, read_design

    design = read_design(given, tell=tell)
    assert isinstance(design, PlantDesign)  # the folder's model is the maker's
    return design, design_folder(given).gains


def _references(source: PlantFile) -> dict[str, VariableEntry]:
    """Return the references with the units that the file gives them."""
    from takagi.models.plant.entries import VariableEntry

    entry, entries = source.entry, {}
    for name, reference in entry.reference.items():
        followed = entry.outputs.get(reference.follow, entry.states.get(reference.follow))
        followed_unit = "-" if followed is None else followed.unit
        entries[name] = VariableEntry(unit=reference.unit or followed_unit)
    return entries


def _print(run: PlantSimulation, data: Mapping[str, Any], written: list[str]) -> None:
    from textwrap import fill

    from rich import box
    from rich.console import Console
    from rich.table import Table

    from takagi.reports.simulation.plant_words import columns

    width = None if sys.stdout.isatty() else _WIDTH
    console = Console(file=sys.stdout, width=width, highlight=False)
    print(f"{run.loop.plant.name}, the plant itself under its law; figures in the file's units")
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    heads, rows = columns(run)
    for k, head in enumerate(heads):
        justify: Any = "right" if k else "left"
        table.add_column(_plain(head), justify=justify, vertical="bottom", overflow="fold")
    for row in rows:
        table.add_row(*map(_plain, row))
    console.print(table)
    print()
    for note in data["notes"]:
        print(fill(note, _WIDTH, subsequent_indent="  "))
    if written:
        names = ", ".join(Path(name).name for name in written[: len(_FILES)])
        print(f"\n{Path(written[0]).parent}\n  {names}, figures/")


def _plain(text: str) -> str:
    return text.replace("[", "\\[")
