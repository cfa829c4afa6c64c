"""`takagi design`: from a turbine or another plant to gains, certificate and report."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from takagi.cli.command import run_command
from takagi.cli.errors import PROVED, UNPROVED
from takagi.cli.options.design_options import Model
from takagi.cli.options.model_kind import DESIGN_OPTIONS, design_options_of
from takagi.cli.output_place import require_folder_place
from takagi.cli.progress import Tell, progress
from takagi.cli.runs.turbine import Unprovable, design_asked

if TYPE_CHECKING:
    from takagi.certificates.design.turbine.design import TurbineDesign

__all__ = ["PURPOSES", "design", "print_files", "run"]

# What lands in the folder, and what each is for; `figures` holds several.
PURPOSES = {
    "gains.json": "the law to load into a controller: schedule, gains, limits, units",
    "certificate.json": "the claims with every number that proves them",
    "report.html": "model, gains, margins, poles and responses, to read in a browser",
    "figures": "the report's figures, one file each",
}
_FOLDERS = ("figures",)


def run(arguments: Sequence[str]) -> int:
    """Run the verb; return its exit status."""
    return run_command("design", design, arguments, groups=DESIGN_OPTIONS)


def design(
    model: Model,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The folder to write.")],
    *,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, for machines.")] = False,
    **options: Any,
) -> int:
    """Design a controller for MODEL, prove what is claimed of it, and report.

    Leaves gains.json, certificate.json, report.html and figures/ in DIR: all of them, or none.
    A plant without inputs is analysed, and has no gains.

    Exit status: 0 PROVED; 1 not proved, or no such design exists; 2 misuse.
    """
    require_folder_place(out, files=[n for n in PURPOSES if n not in _FOLDERS], folders=_FOLDERS)
    kind, asked = design_options_of(model, options)
    if kind == "plant":
        from takagi.cli.verbs.design_plant import design_plant_folder

        return design_plant_folder(model, out, asked, as_json=as_json)
    with progress(f"takagi design {model}") as tell:
        finished = design_asked(model, tell, **asked)
        if isinstance(finished, Unprovable):
            return finished.tell(as_json=as_json)
        files = _write(finished, out, tell)
    _print(finished, model, out, files, as_json=as_json)
    return PROVED if finished.checked.verdict.name == "PROVED" else UNPROVED


def _write(finished: TurbineDesign, out: Path, tell: Tell) -> Mapping[str, bytes | str]:
    from takagi.reports.output import write_folder
    from takagi.reports.turbine_folder import design_files

    files: Mapping[str, bytes | str] = design_files(finished, tell=tell)
    tell(f"writing {out}")
    write_folder(out, files)
    return files


def _print(
    finished: TurbineDesign,
    model: str,
    out: Path,
    files: Mapping[str, bytes | str],
    *,
    as_json: bool,
) -> None:
    from takagi.cli.terminal.turbine_summary import as_data, as_text

    if as_json:
        print(
            json.dumps(
                {**as_data(finished), "files": [str(out / name) for name in files]}, indent=2
            )
        )
        return
    print(as_text(finished))
    print_files(out, files)
    print(f"\nNext\n  takagi check {out / 'certificate.json'} --gains {out / 'gains.json'}")
    law = out / "gains.json"
    print(f"  takagi simulate {model} --law-from {law} --out {out / 'simulation'}")


def print_files(out: Path, files: Mapping[str, bytes | str]) -> None:
    """Print what was written, one line a file or folder, and what each is for."""
    print(f"\n{out}")
    width = max(map(len, PURPOSES)) + 2
    for name, purpose in PURPOSES.items():
        if name in _FOLDERS:
            count = sum(file.startswith(f"{name}/") for file in files)
            if count:
                print(f"  {name + '/':<{width}}{purpose} ({count})")
        elif name in files:
            print(f"  {name:<{width}}{purpose}")
