"""`takagi export`: a law as code for other tools, or a certificate for a proof assistant."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from textwrap import fill
from typing import Annotated, cast

import typer

from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.cli.command import PROVED, run_command
from takagi.cli.options.turbine_options import law_in_files
from takagi.cli.output_place import require_file_place, require_folder_place
from takagi.cli.progress import progress
from takagi.models.errors import ModelError
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.targets import (
    TARGETS,
    ExportSettings,
    Precision,
    certified,
    exported,
    proof_lines,
)
from takagi.reports.output import write_file, write_folder


def export(
    given: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="The folder of a design, or its gains.json; with --coq, its certificate.json; "
            "with --law reference a turbine's TOML file or built-in name.",
        ),
    ],
    *,
    to: str | None = None,
    out: Path | None = None,
    precision: str = "double",
    sample_time: float | None = None,
    without: list[str] | None = None,
    law: str | None = None,
    certificate: Path | None = None,
    coq: Path | None = None,
) -> int:
    """Write a law as code that other tools run, with the decimals that are proved."""
    if given.is_dir():
        given = _of_folder(given, coq)
    if (coq is None) == (to is None):
        raise ModelError(
            "give one of --to TARGET --out DIR (a gain file as code) and --coq FILE (a "
            "certificate's matrices); `takagi export --help` lists the targets"
        )
    if coq is not None:
        return _coq(given, coq)
    if out is None:
        raise ModelError(f"--to {to} needs --out DIR, the folder to write")
    program = _program(given, law_in_files(law), without or [])
    return _code(program, str(to), out, precision, sample_time, (given, certificate))


_LISTED = "\n\n".join(f"--to {target.word}: {target.tools}." for target in TARGETS)
run = partial(run_command, "export", export, listed=_LISTED)


def _of_folder(folder: Path, coq: Path | None) -> Path:
    """Return the gain file of a design's folder, or for Coq its certificate."""
    from takagi.reports.design_folder import design_folder

    design = design_folder(folder)
    file = design.certificate if coq is not None else design.gains
    if file is None:
        raise ModelError(f"{folder}: is an analysis without gains; there is no law to export")
    return file


def _program(given: Path, law: str | None, without: list[str]) -> ControllerProgram:
    from takagi.reports.code.program_reading import read_controller

    if law is None:
        return read_controller(given, without=without)
    if law != "baseline":
        raise ModelError(
            f"--law {law!r} was given; it is reference, or left out: a gain file has one law"
        )
    # Imported here: a gain file needs no turbine.
    from takagi.models.turbine.loader import load_turbine
    from takagi.reports.code.baseline import baseline_program

    return baseline_program(load_turbine(str(given)), without=without)


def _code(
    program: ControllerProgram,
    to: str,
    out: Path,
    precision: str,
    sample_time: float | None,
    places: tuple[Path, Path | None],
) -> int:
    settings = ExportSettings(cast(Precision, precision), sample_time)
    if to == "mat":
        model, claims = certified(*places, program)
        settings = replace(settings, model=model, claims=claims)
    require_folder_place(out)
    exports = exported(to, program, settings)
    write_folder(out, exports.files)
    print(f"{out}: {program.name}, {len(exports.files)} files")
    # The file's own word: neither the proof nor its numbers are read here.
    gains, beside = places[0], places[1] or places[0].with_name("certificate.json")
    for line in proof_lines(program)[:3]:
        line = line.replace("CERTIFICATE", str(beside)).replace("GAINS", str(gains))
        print(fill(line, 98, initial_indent="  ", subsequent_indent="    "))
    width = max(map(len, exports.use)) + 2
    for name, line in exports.use.items():
        print(f"  {name:<{width}}{line}")
    return PROVED


def _coq(certificate: Path, coq: Path) -> int:
    from takagi.certificates.coq.coq_export import coq_file

    require_file_place(coq)
    try:
        with progress(f"takagi export {certificate}"):
            exported = coq_file(certificate)
    except CertificateError as refusal:
        # A claim that is not proved is named without the file.
        named = str(refusal).startswith(f"{certificate}:")
        raise CertificateError(f"{certificate}: " * (not named) + f"{refusal}") from refusal
    write_file(coq, exported.text)
    print(f"{coq}: {exported.count} matrices of {len(exported.matrices)} claims")
    print(f"Check it with: coqc {coq}")
    return PROVED
