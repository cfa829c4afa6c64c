"""`takagi verify`: what can be proved of an LMI or conic problem that another program wrote."""

from __future__ import annotations

import json
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from takagi.cli.command import PROVED, UNPROVED, run_command
from takagi.cli.output_place import require_file_place
from takagi.cli.progress import progress
from takagi.cli.terminal.rows import claim_lines, claims_as_data
from takagi.reports.output import write_file

if TYPE_CHECKING:
    from takagi.certificates.claims.problem_verification import Verification


def verify(
    problem: Annotated[
        Path,
        typer.Argument(
            metavar="PROBLEM",
            help="An SDPA file (.dat-s), CBF (.cbf), SeDuMi's A, b, c, K (.mat, as YALMIP exports "
            "them), or cvxpy's data (.npz, written by takagi.lmi.save_cvxpy).",
        ),
    ],
    solution: Annotated[
        Path | None,
        typer.Argument(
            metavar="SOLUTION",
            help="A solver's solution: CSDP's file, or JSON with x and, if known, y. Without one "
            "the problem is solved here.",
        ),
    ] = None,
    out: Path | None = None,
    *,
    as_json: bool = False,
) -> int:
    """Say what is proved of a linear matrix inequality or conic problem."""
    if out is not None:
        require_file_place(out)
    from takagi.lmi.problem_files.reading import read_problem_file, read_solution_file

    with progress(f"takagi verify {problem}") as tell:
        tell("reading")
        read = read_problem_file(problem)
        given = None if solution is None else read_solution_file(solution, read)
        from takagi.certificates.claims.problem_verification import verify

        verification = verify(read, given, tell=tell)
        if out is not None:
            from takagi.certificates.document.certificate_file import dumps

            write_file(out, dumps(verification.document))
    _print(problem, out, verification, as_json=as_json)
    return PROVED if verification.settled else UNPROVED


def _print(problem: Path, out: Path | None, verification: Verification, *, as_json: bool) -> None:
    if as_json:
        data: dict[str, Any] = claims_as_data(verification.checked)
        data |= {"verdict": verification.verdict.name}
        data |= {"settled": verification.settled, "notes": list(verification.notes)}
        print(json.dumps(data, indent=2))
        return
    print(f"{problem}: {verification.verdict.name}")
    print("\n".join(claim_lines(verification.checked)))
    for note in verification.notes:
        print(f"  {note}")
    if out is not None:
        print(f"\n{out}\n\nNext\n  takagi check {out}")


run = partial(run_command, "verify", verify)
