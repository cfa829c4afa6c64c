"""`takagi report`: the report and its figures alone."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, TypeAlias

import typer

from takagi.cli.command import run_command
from takagi.cli.errors import PROVED, UNPROVED
from takagi.cli.options.design_options import Model
from takagi.cli.options.model_kind import DESIGN_OPTIONS, design_options_of
from takagi.cli.output_place import require_folder_place
from takagi.cli.progress import Tell, progress
from takagi.cli.runs.turbine import Unprovable, design_asked

__all__ = ["report", "run"]

Written: TypeAlias = tuple[Mapping[str, bytes | str], str]  # name -> content, and the verdict
_REPORT, _FIGURES = "report.html", "figures"


def run(arguments: Sequence[str]) -> int:
    """Run the verb; return its exit status."""
    return run_command("report", report, arguments, groups=DESIGN_OPTIONS)


def report(
    model: Model,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The folder to write.")],
    **options: Any,
) -> int:
    """Design for MODEL as `takagi design` does, and write report.html and figures/ alone.

    Exit status: 0 PROVED; 1 not proved, or no such design exists; 2 misuse.
    """
    require_folder_place(out, files=[_REPORT], folders=[_FIGURES])
    kind, asked = design_options_of(model, options)
    with progress(f"takagi report {model}") as tell:
        found = (_plant if kind == "plant" else _turbine)(model, tell, asked)
        if isinstance(found, Unprovable):
            return found.tell()
        from takagi.reports.output import write_folder

        files, verdict = found
        write_folder(out, {name: files[name] for name in files if _of_report(name)})
    print(f"{out / _REPORT}: {verdict}")
    return PROVED if verdict == "PROVED" else UNPROVED


def _turbine(model: str, tell: Tell, options: Mapping[str, Any]) -> Written | Unprovable:
    finished = design_asked(model, tell, **options)
    if isinstance(finished, Unprovable):
        return finished
    from takagi.reports.turbine_folder import design_files

    return design_files(finished, tell=tell), finished.checked.verdict.name


def _plant(model: str, tell: Tell, options: Mapping[str, Any]) -> Written | Unprovable:
    from takagi.cli.runs.plant import plant_asked, verdict_words

    finished = plant_asked(model, tell, options)
    if isinstance(finished, Unprovable):
        return finished
    from takagi.reports.plant_folder import plant_files

    return plant_files(finished, tell=tell), verdict_words(finished)


def _of_report(name: str) -> bool:
    return name == _REPORT or name.startswith(f"{_FIGURES}/")
