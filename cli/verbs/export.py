"""`takagi export`: a certificate's matrices as a file that a proof assistant checks."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from takagi.cli.command import run_command
from takagi.cli.errors import PROVED, UNPROVED

__all__ = ["export", "run"]


def run(arguments: Sequence[str]) -> int:
    """Run the verb; return its exit status."""
    return run_command("export", export, arguments)


def export(
    certificate: Annotated[Path, typer.Argument(metavar="CERT", help="The certificate file.")],
    *,
    coq: Annotated[Path, typer.Option("--coq", metavar="FILE", help="Write this file for Coq.")],
) -> int:
    """Write a certificate's matrices for the proof assistant Coq (Rocq).

    Each claim becomes theorems: so many matrices are positive definite, or semidefinite. Check the
    file with `coqc FILE`; its kernel decides them by computation, and the proof that this decides
    them stands in the file.

    What is no matrix, such as the ranges of premises, is left to the checkers.

    Exit status: 0 the file is written; 1 written, but the second checker has not replayed all of a
    claim; 2 a claim does not hold, or the file is no certificate.
    """
    from takagi.certificates.coq import coq_file
    from takagi.certificates.cross_check.kernel.reading import Refusal, load
    from takagi.reports.output import write_file

    document = load(certificate)
    try:
        found = coq_file(document)
    except Refusal as refusal:
        raise Refusal(f"{certificate}: {refusal}") from refusal
    write_file(coq, found.text)
    print(f"{coq}: {found.count} matrices of {len(found.matrices)} claims")
    print(f"Check it with: coqc {coq}")
    for number, why in found.left_out.items():
        print(f"  claim {number}: {why}")
    return UNPROVED if found.left_out else PROVED
