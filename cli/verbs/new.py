"""`takagi new`: write the file of a plant or turbine that is elsewhere, or in somebody's head."""

from __future__ import annotations

import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from takagi.cli.command import PROVED, run_command
from takagi.cli.runs.new_plant import (
    TEMPLATE,
    PlantOptions,
    Questions,
    entries_of_options,
    named_ranges,
    plant_of_text,
)

if TYPE_CHECKING:
    from takagi.models import Plant


def _repeated(option: str, words: str) -> typer.models.OptionInfo:
    info: typer.models.OptionInfo = typer.Option(option, metavar="TEXT", help=words)
    return info


def _place(option: str, metavar: str, words: str) -> typer.models.OptionInfo:
    info: typer.models.OptionInfo = typer.Option(option, metavar=metavar, help=words)
    return info


def new(
    out: Annotated[Path, typer.Argument(metavar="FILE.toml", help="The file to write.")],
    matrices: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[CSV]...", help="A.csv B.csv [C.csv [D.csv]], with --from-linear."),
    ] = None,
    *,
    states: Annotated[
        list[str] | None,
        _repeated("--state", '"theta = -60..60 deg, rest 0: what it is"; one for each, in order.'),
    ] = None,
    inputs: Annotated[
        list[str] | None, _repeated("--input", "As --state; the range is the input's limit.")
    ] = None,
    disturbances: Annotated[
        list[str] | None, _repeated("--disturbance", "As --state: what comes from outside.")
    ] = None,
    parameters: Annotated[
        list[str] | None,
        _repeated("--parameter", '"m = 2 kg", "m = 0.9..1.1 kg" or "c = 0.1*sqrt(k*m)".'),
    ] = None,
    equations: Annotated[
        list[str] | None,
        _repeated("--equation", '"theta = omega": the right-hand side of theta\'.'),
    ] = None,
    measured: Annotated[
        list[str] | None, _repeated("--measured", "A state that the law has, if not all.")
    ] = None,
    name: Annotated[str | None, typer.Option(help="Name of the plant.")] = None,
    sample_time: Annotated[
        float | None,
        typer.Option(metavar="SECONDS", help="The equations then give x(t + T) in place of x'."),
    ] = None,
    no_units: Annotated[bool, typer.Option("--no-units", help="Do not compare units.")] = False,
    from_linear: Annotated[
        bool, typer.Option("--from-linear", help="Read the matrices of the CSV files.")
    ] = False,
    from_mat: Annotated[
        Path | None, _place("--from-mat", "FILE", "Read A, B, ... of a MAT-file, or vertices.")
    ] = None,
    from_fast_lin: Annotated[
        Path | None, _place("--from-fast-lin", "FILE", "Read a .lin file of OpenFAST.")
    ] = None,
    from_rosco: Annotated[
        Path | None,
        _place(
            "--from-rosco", "DIR", "A turbine: ROSCO's tuning file or DISCON.IN, or its folder."
        ),
    ] = None,
    from_openfast: Annotated[
        Path | None, _place("--from-openfast", "DIR", "A turbine: an OpenFAST deck, or its .fst.")
    ] = None,
    table: Annotated[
        Path | None, _place("--table", "FILE", "Its Cp_Ct_Cq table, where no file names it.")
    ] = None,
    figures: Annotated[
        list[str] | None,
        _repeated("--figure", '"pitch.minimum = 2 deg": in place of what the files have.'),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace the file.")] = False,
) -> int:
    """Write the file of a plant or turbine, ready for `takagi design`.

    Without options it asks at a terminal, and writes a template where there is none. With --state,
    --input, --equation, ... it writes this plant. The --from options read a model that exists;
    beside those of matrices, --state and --input give names and ranges.

    Exit status: 0 written; 2 misuse, and nothing is written.
    """
    from takagi.cli.output_place import require_file_place
    from takagi.models.errors import ModelError
    from takagi.reports.output import write_folder

    if out.suffix != ".toml":
        raise ModelError(f"{out}: was given; the file to write comes first, and ends in .toml")
    if out.exists() and not force:
        raise ModelError(f"{out}: is there already; give another name, or --force to replace it")
    require_file_place(out)
    options = PlantOptions(
        name,
        states or (),
        inputs or (),
        disturbances or (),
        parameters or (),
        equations or (),
        measured or (),
        sample_time,
        no_units,
    )
    turbine = {k: p for k, p in (("rosco", from_rosco), ("openfast", from_openfast)) if p}
    _require_one_way(
        {
            "--from-linear": from_linear,
            "--from-mat": from_mat is not None,
            "--from-fast-lin": from_fast_lin is not None,
            "--from-rosco or --from-openfast": bool(turbine),
        },
        options,
        matrices=bool(matrices),
        of_turbine=bool(table or figures),
    )
    if turbine:
        from takagi.models.sources.turbine_deck import turbine_files

        files, assumed = turbine_files(turbine, stem=out.stem, table=table, stated=figures or ())
        told = [f"{out}: a turbine, with {', '.join(list(files)[1:])}"]
        told += assumed
    else:
        if from_linear or from_mat or from_fast_lin:
            plant = _of_matrices(options, out, matrices or [], from_mat, from_fast_lin)
            text = _text_of_plant(plant, out)
        elif options.given:
            text = _text(entries_of_options(options, out.stem), out)
        elif sys.stdin is not None and sys.stdin.isatty():
            text = _asked(out)
        else:
            text = _text(entries_of_options(TEMPLATE, out.stem), out)
        files, told = {out.name: text}, [_about(plant_of_text(out, text), out)]
        if not (options.given or from_linear or from_mat or from_fast_lin or sys.stdin.isatty()):
            told.append("a template, since nothing was given: change it")
    write_folder(out.parent, files)
    print("\n  ".join(told))
    print(f"\nNext\n  takagi design {out} --out build/{out.stem}")
    return PROVED


run = partial(run_command, "new", new)


def _require_one_way(
    ways: dict[str, bool], options: PlantOptions, *, matrices: bool, of_turbine: bool
) -> None:
    """Refuse options that are about different things."""
    from takagi.models.errors import ModelError

    given = [way for way, taken in ways.items() if taken]
    if len(given) > 1:
        raise ModelError(f"{' and '.join(given)} were given; a file has one source")
    if matrices != ways["--from-linear"]:
        raise ModelError(
            "the files of matrices and --from-linear go together: takagi new FILE.toml "
            "--from-linear A.csv B.csv"
        )
    if of_turbine and not ways["--from-rosco or --from-openfast"]:
        raise ModelError(
            "--table and --figure are of a turbine; give --from-rosco or --from-openfast"
        )
    other = {
        "--parameter": options.parameters,
        "--equation": options.equations,
        "--measured": options.measured,
        "--no-units": options.no_units,
    }
    refused = [option for option, value in other.items() if value]
    if given and refused:
        raise ModelError(f"{refused[0]} was given beside {given[0]}, which has the equations")
    if ways["--from-rosco or --from-openfast"] and options.given:
        raise ModelError(
            "a plant's option was given beside a turbine's files; --figure changes a turbine"
        )


def _of_matrices(
    options: PlantOptions, out: Path, matrices: list[Path], mat: Path | None, lin: Path | None
) -> Plant:
    """Return the plant of files of matrices, with the names and ranges of the options."""
    from dataclasses import replace

    from takagi.models.files.units import parse_unit
    from takagi.models.sources.lin_file import from_lin
    from takagi.models.sources.linear import from_csv, from_mat

    names: dict[str, Any] = {}
    ranges: dict[str, Any] = {}
    units: dict[str, str] = {}
    for what in ("states", "inputs", "disturbances"):
        names[what], ends, written = named_ranges(getattr(options, what))
        ranges |= ends
        units |= written
    if lin is not None:
        plant = from_lin(lin, **names, ranges=ranges)
    else:
        step = {} if options.sample_time is None else {"sample_time": options.sample_time}
        given = {**names, "ranges": ranges, **step}
        plant = from_csv(matrices, **given) if mat is None else from_mat(mat, **given)
    changed: dict[str, Any] = {
        what: tuple(
            replace(v, unit=parse_unit(units[v.name]).si, written=units[v.name])
            if v.name in units
            else v
            for v in getattr(plant, what)
        )
        for what in names
    }
    return replace(plant, name=options.name or out.stem, **changed)


def _heading(out: Path) -> list[str]:
    return [f"Written by `takagi new`. Next: takagi design {out.name} --out build/{out.stem}"]


def _text(entries: dict[str, object], out: Path) -> str:
    from takagi.models.plant_files.writer import entries_text

    return entries_text(entries, _heading(out))


def _text_of_plant(plant: Plant, out: Path) -> str:
    from takagi.models.plant_files.writer import plant_text

    return plant_text(plant, _heading(out))


def _asked(out: Path) -> str:
    """Return the text of the plant that is asked for, as soon as it is one."""
    from takagi.models.errors import ModelError

    questions = Questions(out.stem)
    questions.ask_all()
    while True:
        text = _text(questions.entries, out)
        try:
            plant_of_text(out, text)
            return text
        except ModelError as error:
            if not questions.ask_again(str(error)):
                raise


def _about(plant: Plant, out: Path) -> str:
    """Return what was written, in one line."""
    counts = [
        (len(plant.states), "state"),
        (len(plant.inputs), "input"),
        (len(plant.disturbances), "signal from outside"),
        (len(plant.parameters), "parameter"),
    ]
    parts = [
        f"{count} {word.replace('signal', 'signals') if count > 1 and ' ' in word else word}"
        + ("s" if count > 1 and " " not in word else "")
        for count, word in counts
        if count
    ]
    return f"{out}: {', '.join(parts)}"
