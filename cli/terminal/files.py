"""The files that a design wrote, the reason where there is none, and the result of a check."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from takagi.cli.command import UNPROVED

if TYPE_CHECKING:
    from takagi.certificates.audit.trusted_lines import File, Trusted
    from takagi.certificates.design.design import NoDesign
    from takagi.reports.ci_formats import CheckedFile

# File or folder -> its purpose; `figures` is a folder with several files.
PURPOSES = {
    "gains.json": "the law to load into a controller: schedule, gains, limits, units",
    "certificate.json": "the claims with every number that proves them",
    "report.html": "model, gains, margins, poles and responses, to read in a browser",
    "figures": "the report's figures, one file each",
    "design.json": "the rest of the design: report, appendix and simulate read it",
    "model": "a copy of the model's files",
}
FOLDERS = ("figures", "model")
LARGEST = 10**300


def print_files(out: Path, files: Mapping[str, bytes | str]) -> None:
    """Print what was written, one line for each file or folder with its purpose."""
    print(f"\n{out}")
    width = max(map(len, PURPOSES)) + 2
    for name, purpose in PURPOSES.items():
        if name in FOLDERS:
            count = sum(file.startswith(f"{name}/") for file in files)
            if count:
                print(f"  {name + '/':<{width}}{purpose} ({count})")
        elif name in files:
            print(f"  {name:<{width}}{purpose}")


def tell_none(outcome: NoDesign, *, as_json: bool = False) -> int:
    """Print why there is no design, and return the exit status for it.  Nothing was written."""
    if as_json:
        print(json.dumps({"verdict": "UNDECIDED", "reason": outcome.reason}, indent=2))
    else:
        print(f"Not proved, nothing written: {outcome.reason}", file=sys.stderr)
    return UNPROVED


def claim_lines(checked: CheckedFile) -> list[str]:
    """Return a line for each claim, and one for what this claim assumes, if it assumes anything.

    The line has its verdict, its name in quotes, and the checker's sentence.  The name is a free
    text of the file.  Without quotes it could be taken for a sentence of the checker.
    """
    width = max((len(claim.verdict.name) for claim in checked.claims), default=0)
    lines = []
    for claim in checked.claims:
        name = json.dumps(claim.name, ensure_ascii=False)
        lines.append(f"  {claim.verdict.name:<{width}}  {name}: {claim.text}")
        if claim.assumes:
            lines.append(f"  {'':<{width}}  assumes: {'; '.join(claim.assumes)}")
    return lines


def claims_as_data(checked: CheckedFile) -> dict[str, Any]:
    """Return verdict and claims as plain data, each claim with its assumptions and figures."""
    # Imported here: help is printed without any room of the checker.
    from takagi.certificates.checker.words.figure import Figure

    claims = [
        {
            "name": claim.name,
            "verdict": claim.verdict.name,
            "text": claim.text,
            "assumes": list(claim.assumes),
            "figures": [
                {"name": figure.name, "value": float(figure.value), "unit": figure.unit}
                for figure in claim.figures
                if isinstance(figure, Figure) and figure.value is not None
                # JSON has no number that a float does not hold.
                if abs(figure.value) < LARGEST
            ],
        }
        for claim in checked.claims
    ]
    return {"verdict": checked.verdict.name, "claims": claims, "assumes": list(checked.assumes)}


_HEAD = ("file of certificates/checker", "lines of code", "executed")


def trusted_text(trusted: Trusted) -> str:
    """Return a table of the files with their sum, and a note on the code of the sentences."""
    total = (f"{len(trusted.files)} files", str(trusted.lines), str(trusted.executed))
    rows = [_HEAD, *((f.path, str(f.lines), str(f.executed)) for f in trusted.files), total]
    width = max(len(row[0]) for row in rows)
    table = [f"  {row[0]:<{width}}  {row[1]:>13}  {row[2]:>8}" for row in rows]
    words = sum(file.lines for file in trusted.words)
    said = (
        f"The sentences were made afterwards, by {words} lines of words/ that cannot change a "
        "verdict. Trusted besides: Python and its standard library."
    )
    return "\n".join(["The verdict ran through:", *table, said])


def as_data(trusted: Trusted) -> dict[str, Any]:
    """Return the same for JSON."""
    return {
        "files": [_row(file) for file in trusted.files],
        "lines": trusted.lines,
        "executed": trusted.executed,
        "words": [_row(file) for file in trusted.words],
    }


def _row(file: File) -> dict[str, Any]:
    return {"file": file.path, "lines": file.lines, "executed": file.executed}
