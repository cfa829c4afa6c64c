"""`takagi report`: the report and its figures alone."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from takagi.certificates.design.design import NoDesign
from takagi.cli.command import PROVED, UNPROVED, run_command
from takagi.cli.options.turbine_options import Model
from takagi.cli.output_place import require_folder_place
from takagi.cli.progress import progress
from takagi.cli.runs.makers import DESIGN_OPTIONS, maker_of
from takagi.cli.terminal.files import tell_none

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
    maker = maker_of(model, options)
    with progress(f"takagi report {model}") as tell:
        finished = maker.design(tell)
        if isinstance(finished, NoDesign):
            return tell_none(finished)
        from takagi.reports.design_folder import design_files
        from takagi.reports.output import write_folder

        files = design_files(finished, tell=tell)
        write_folder(out, {name: files[name] for name in files if _of_report(name)})
    print(f"{out / _REPORT}: {finished.verdict_words}")
    return PROVED if finished.proved else UNPROVED


def _of_report(name: str) -> bool:
    return name == _REPORT or name.startswith(f"{_FIGURES}/")
