"""`takagi new`: write the file of a plant or turbine that is elsewhere, or in somebody's head."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Annotated, Any

import typer

from takagi.cli.command import PROVED, run_command
from takagi.cli.options.given import declared, option_of
from takagi.cli.output_place import require_file_place
from takagi.cli.runs.new_plant import (
    TEMPLATE,
    asked_text,
    plant_entries,
    plant_of_text,
    variable_entry,
)
from takagi.models.errors import ModelError
from takagi.reports.output import write_file, write_folder

_OF_PLANT, _SOURCES, _OF_TURBINE = map(declared, ("new-plant", "new-sources", "new-turbine"))
OPTIONS = (*_OF_PLANT, *_SOURCES, *_OF_TURBINE, *declared("new-ci"))
# What may stand beside matrices.
_NAMED = ("state", "input", "disturbance", "name", "sample_time")


def new(
    out: Annotated[Path, typer.Argument(metavar="FILE.toml", help="The file to write.")],
    matrices: Annotated[
        list[Path] | None,
        typer.Argument(metavar="[CSV]...", help="A.csv B.csv [C.csv [D.csv]], with --from-linear."),
    ] = None,
    *,
    force: bool = False,
    **options: Any,
) -> int:
    """Write the file of a plant or turbine, ready for `takagi design`."""
    if options["ci"] is not None:
        return _write_workflow(out, {**options, "matrices": matrices}, force=force)
    if out.suffix != ".toml":
        raise ModelError(f"{out}: was given; the file to write comes first, and ends in .toml")
    if out.exists() and not force:
        raise ModelError(f"{out}: is there already; give another name, or --force to replace it")
    require_file_place(out)
    given = {name: value for name, value in options.items() if value}
    sources = _checked_sources(given, matrices=bool(matrices))
    if any(source in sources for source in ("from_rosco", "from_openfast")):
        files, remarks = _turbine(out, given)
    else:
        heading = [
            f"Written by `takagi new`. Next: takagi design {out.name} --out build/{out.stem}"
        ]
        asked = not given and sys.stdin is not None and sys.stdin.isatty()
        if sources:
            text = _text_of_matrices(out, given, matrices or [], heading)
        elif asked:
            text = asked_text(out.stem, lambda answers: _text(out, answers, heading))
        else:
            text = _text(out, given or TEMPLATE, heading)
        files, remarks = {out.name: text}, []
        if not given and not asked:
            remarks = ["a template, since nothing was given: change it"]
    write_folder(out.parent, files)
    print("\n  ".join([f"{out}: written", *remarks]))
    print(f"\nNext\n  takagi design {out} --out build/{out.stem}")
    return PROVED


run = partial(run_command, "new", new, options=OPTIONS)


def _write_workflow(subject: Path, options: Mapping[str, Any], *, force: bool) -> int:
    """Write the workflow for a file or folder that is there; nothing is replaced without force."""
    from takagi.cli.runs.ci_workflow import workflow

    other = [name for name, value in options.items() if value and name != "ci"]
    if other:
        words = "CSV files were" if other[0] == "matrices" else f"{option_of(other[0])} was"
        raise ModelError(f"{words} given beside --ci, which is about a plant that is there")
    made = workflow(options["ci"], subject)
    if made.path.exists() and not force:
        raise ModelError(
            f"{made.path}: is there already; move it away, or --force to replace it. Nothing was "
            "written"
        )
    write_file(made.path, made.text)
    print("\n  ".join([f"{made.path}: written", *made.remarks]))
    print(f"\nNext\n  git add {made.path} {subject}")
    return PROVED


def _checked_sources(given: Mapping[str, Any], *, matrices: bool) -> list[str]:
    """Return where the model comes from; refuse options that are about different things."""
    sources = [source.name for source in _SOURCES if source.name in given]
    turbine = bool(sources) and set(sources) <= {"from_rosco", "from_openfast"}
    if len(sources) > 1 and not turbine:
        listed = " and ".join(map(option_of, sources))
        raise ModelError(f"{listed} were given; a file has one source")
    if matrices != ("from_linear" in sources):
        raise ModelError(
            "the files of matrices and --from-linear go together: takagi new FILE.toml "
            "--from-linear A.csv B.csv"
        )
    for further in (*_OF_PLANT, *_OF_TURBINE):
        of_turbine = further in _OF_TURBINE
        allowed = turbine if of_turbine else not sources or (not turbine and further.name in _NAMED)
        if further.name in given and not allowed:
            beside = option_of(sources[0]) if sources else "no turbine's files"
            raise ModelError(
                f"{option_of(further.name)} was given beside {beside}; leave it out"
                + (" (--figure changes a turbine)" if turbine else "")
            )
    return sources


def _turbine(out: Path, given: Mapping[str, Any]) -> tuple[dict[str, str], list[str]]:
    """Return the files of a turbine, and what was assumed."""
    from takagi.models.sources.turbine_deck import turbine_files

    places = {
        kind: given[f"from_{kind}"] for kind in ("rosco", "openfast") if f"from_{kind}" in given
    }
    return turbine_files(
        places, stem=out.stem, table=given.get("table"), stated=given.get("figure", ())
    )


def _text(out: Path, options: Mapping[str, Any], heading: list[str]) -> str:
    """Return the text of a plant by its options; ModelError where they are none."""
    from takagi.models.plant_files.writer import entries_text

    text = entries_text(plant_entries(options, out.stem), heading)
    plant_of_text(out, text)
    return text


def _text_of_matrices(
    out: Path, given: Mapping[str, Any], matrices: list[Path], heading: list[str]
) -> str:
    """Return the text of a linear plant, with the names, units and ranges of the options."""
    from dataclasses import replace

    from takagi.models import from_csv, from_lin, from_mat, plant_text

    names: dict[str, Any] = {}
    ranges, units = {}, {}
    for what in ("state", "input", "disturbance"):
        entries = dict(map(variable_entry, given.get(what, ())))
        names[f"{what}s"] = list(entries) or None
        for name, entry in entries.items():
            if "rest" in entry:
                raise ModelError(
                    f"{name}: a rest was given, and matrices are about theirs; leave it out"
                )
            units[name] = entry.get("unit", "-")
            if "range" in entry:
                ranges[name] = entry["range"]
    names |= {"ranges": ranges, "units": units}
    if "sample_time" in given:
        names["sample_time"] = given["sample_time"]
    if "from_fast_lin" in given:
        if "sample_time" in given:
            raise ModelError("--sample-time was given, and a .lin file is about x'; leave it out")
        plant = from_lin(given["from_fast_lin"], **names)
    elif "from_mat" in given:
        plant = from_mat(given["from_mat"], **names)
    else:
        plant = from_csv(matrices, **names)
    text = plant_text(replace(plant, name=given.get("name") or out.stem), heading)
    plant_of_text(out, text)
    return text
