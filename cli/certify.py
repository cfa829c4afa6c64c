"""`takagi certify`: a certificate alone, for gains that exist or for a new design."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

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
    uncertainty_asked,
)
from takagi.cli.design_run import Unprovable, answered, design_asked
from takagi.cli.errors import PROVED, UNPROVED
from takagi.cli.output_place import require_file_place
from takagi.cli.progress import Tell, progress

if TYPE_CHECKING:
    from takagi.certificates.checker.result import Checked

__all__ = ["certify", "run"]

Outcome = tuple[Mapping[str, Any], "Checked"]
# What may be asked of a certificate for gains that exist; the rest is about making gains.
_OF_GIVEN_GAINS = ("inertia", "equilibrium_wake")


def run(arguments: Sequence[str]) -> int:
    """Run the verb; return its exit status."""
    return run_command("certify", certify, arguments)


def certify(
    model: Model,
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="FILE", help="The certificate to write.")
    ],
    gains: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="A gain file: certify its law as it stands."),
    ] = None,
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
    """Write a certificate for MODEL with the gains of a file, or with gains designed anew.

    With --gains, only --inertia and --equilibrium-wake apply: the law is in the file.

    Exit status: 0 PROVED; 1 not proved; 2 misuse.
    """
    require_file_place(out)
    options = {
        "law": law,
        "overlap": overlap,
        "speed_overlap": speed_overlap,
        "torque_overlap": torque_overlap,
        "speed_setpoint": speed_setpoint,
        "bandwidth": bandwidth,
        "inertia": inertia,
        "equilibrium_wake": equilibrium_wake,
    }
    with progress(f"takagi certify {model}") as tell:
        found = (
            _designed(model, tell, options)
            if gains is None
            else _given(model, gains, tell, options)
        )
        if isinstance(found, Unprovable):
            return found.tell(as_json=as_json)
        document, checked = found
        from takagi.certificates.document import dumps
        from takagi.reports.output import write_file

        write_file(out, dumps(document))
    _print(model, out, checked, gains, as_json=as_json)
    return PROVED if checked.verdict.name == "PROVED" else UNPROVED


def _designed(model: str, tell: Tell, options: Mapping[str, Any]) -> Outcome | Unprovable:
    found = design_asked(model, tell, **options)
    return found if isinstance(found, Unprovable) else (found.document, found.checked)


def _given(model: str, gains: Path, tell: Tell, options: Mapping[str, Any]) -> Outcome | Unprovable:
    from takagi.certificates.given_law import certify_law, coherent_law_from_data, read_law
    from takagi.models.turbine.loader import load_turbine, model_files

    _refuse_design_options(options)
    turbine = load_turbine(model)
    law = coherent_law_from_data(read_law(gains), source=str(gains))
    uncertainty = uncertainty_asked(options["inertia"], options["equilibrium_wake"])
    files = model_files(model)

    def work(noted: Tell) -> Outcome:
        return certify_law(turbine, law, uncertainty=uncertainty, files=files, tell=noted)

    return answered(work, tell, options)


def _refuse_design_options(options: Mapping[str, Any]) -> None:
    from takagi.models.errors import ModelError

    for name, value in options.items():
        if name not in _OF_GIVEN_GAINS and value not in (None, "coherent"):
            raise ModelError(
                f"option --{name.replace('_', '-')} is about designing gains, but --gains gives "
                "them; leave out one of the two"
            )


def _print(model: str, out: Path, checked: Checked, gains: Path | None, *, as_json: bool) -> None:
    from takagi.cli.design_summary import claims_as_data, claims_as_text

    if as_json:
        print(json.dumps({"certificate": str(out), **claims_as_data(checked)}, indent=2))
        return
    print(f"{out}: {checked.verdict.name}\n{claims_as_text(checked)}")
    companion = "" if gains is None else f" --gains {gains}"
    print(f"\nNext\n  takagi check {out}{companion}")
