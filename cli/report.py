"""`takagi report`: the report and its figures alone."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from takagi.cli.command import run_command
from takagi.cli.design_options import (
    Bandwidth,
    EquilibriumWake,
    Inertia,
    Law,
    Model,
    Overlap,
    SpeedOverlap,
    SpeedSetpoint,
    TorqueOverlap,
)
from takagi.cli.design_run import Unprovable, design_asked
from takagi.cli.errors import PROVED, UNPROVED
from takagi.cli.output_place import require_folder_place
from takagi.cli.progress import progress

__all__ = ["report", "run"]

_REPORT, _FIGURES = "report.html", "figures"


def run(arguments: Sequence[str]) -> int:
    """Run the verb; return its exit status."""
    return run_command("report", report, arguments)


def report(
    model: Model,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="The folder to write.")],
    law: Law = "coherent",
    overlap: Overlap = None,
    speed_overlap: SpeedOverlap = None,
    torque_overlap: TorqueOverlap = None,
    speed_setpoint: SpeedSetpoint = None,
    bandwidth: Bandwidth = None,
    inertia: Inertia = None,
    equilibrium_wake: EquilibriumWake = False,
) -> int:
    """Design for MODEL as `takagi design` does, and write report.html and figures/ alone.

    Exit status: 0 PROVED; 1 not proved, or no such design exists; 2 misuse.
    """
    require_folder_place(out, files=[_REPORT], folders=[_FIGURES])
    with progress(f"takagi report {model}") as tell:
        finished = design_asked(
            model,
            tell,
            law=law,
            overlap=overlap,
            speed_overlap=speed_overlap,
            torque_overlap=torque_overlap,
            speed_setpoint=speed_setpoint,
            bandwidth=bandwidth,
            inertia=inertia,
            equilibrium_wake=equilibrium_wake,
        )
        if isinstance(finished, Unprovable):
            return finished.tell()
        from takagi.reports.design_folder import design_files
        from takagi.reports.output import write_folder

        files = design_files(finished, tell=tell)
        write_folder(out, {name: files[name] for name in files if _of_report(name)})
    print(f"{out / _REPORT}: {finished.checked.verdict.name}")
    return PROVED if finished.checked.verdict.name == "PROVED" else UNPROVED


def _of_report(name: str) -> bool:
    return name == _REPORT or name.startswith(f"{_FIGURES}/")
