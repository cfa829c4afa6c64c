"""`takagi appendix`: the design as LaTeX, to compile alone or to take into a paper."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

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

if TYPE_CHECKING:
    from takagi.certificates.turbine_design import TurbineDesign

__all__ = ["appendix", "run"]

_MAIN, _BODY, _FIGURES = "appendix.tex", "appendix-body.tex", "figures"


def run(arguments: Sequence[str]) -> int:
    """Run the verb; return its exit status."""
    return run_command("appendix", appendix, arguments)


def appendix(
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
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, for machines.")] = False,
) -> int:
    """Design for MODEL as `takagi design` does, and write the LaTeX appendix.

    Leaves appendix.tex, which compiles alone, appendix-body.tex for a paper of your own, and the
    figures as PDF: all of them, or none.

    Exit status: 0 PROVED; 1 not proved, or no such design exists; 2 misuse.
    """
    require_folder_place(out, files=[_MAIN, _BODY], folders=[_FIGURES])
    with progress(f"takagi appendix {model}") as tell:
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
            return finished.tell(as_json=as_json)
        from takagi.reports.appendix import appendix_files
        from takagi.reports.output import write_folder

        files = appendix_files(finished, tell=tell)
        tell(f"writing {out}")
        write_folder(out, files)
    _print(finished, out, list(files), as_json=as_json)
    return PROVED if finished.checked.verdict.name == "PROVED" else UNPROVED


def _print(finished: TurbineDesign, out: Path, names: list[str], *, as_json: bool) -> None:
    verdict = finished.checked.verdict.name
    if as_json:
        print(json.dumps({"verdict": verdict, "files": [str(out / n) for n in names]}, indent=2))
        return
    figures = sum(name.startswith(f"{_FIGURES}/") for name in names)
    print(f"{out / _MAIN}: {verdict}, {figures} figures")
    print(f"\nCompile\n  cd {out} && pdflatex {_MAIN} && pdflatex {_MAIN} && pdflatex {_MAIN}")
    print(f"Take into a paper\n  \\input{{{_BODY.removesuffix('.tex')}}}; its first lines name the "
          "packages")  # fmt: skip
