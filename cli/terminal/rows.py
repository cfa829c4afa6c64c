"""Rows of a summary: a word, and text wrapped behind it; coloured where a terminal shows it."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

from takagi.cli.command import UNPROVED

if TYPE_CHECKING:
    from takagi.certificates.audit.trusted_lines import File, Trusted
    from takagi.certificates.design.design import NoDesign
    from takagi.reports.ci_formats import CheckedFile
    from takagi.reports.sections.plant.summary import SummaryRow

_ANSI = {"red": 31, "green": 32, "yellow": 33}
WIDTH, INDENT = 100, " " * 15
_TIE = "\N{NO-BREAK SPACE}"
_SHORT = 60  # characters of a part that is not broken


def headline(verdict: str, name: str, remark: str, *, proved: bool, part: bool = False) -> str:
    """Return the verdict and the model's name, with a remark at the right.

    Parameters
    ----------
    part : whether less is proved than the file states; the verdict is yellow then.
    """
    text = f"{verdict}  {name}"
    space = max(3, WIDTH - len(text) - len(remark))
    colour = "yellow" if part else "green"
    (shown,) = coloured([verdict], colour if proved else "red")
    return f"{shown}  {name}{' ' * space}{remark}"


def row_lines(word: str, text: str) -> list[str]:
    """Return the word and its text, broken into indented lines of at most 100 characters."""
    start = f"  {word}".ljust(len(INDENT))
    filled = fill(
        text, WIDTH, initial_indent=start, subsequent_indent=INDENT, break_on_hyphens=False
    )
    return filled.replace(_TIE, " ").splitlines()


def summary_lines(row: SummaryRow) -> list[str]:
    """Return the lines of a row of the summary, in yellow where less is proved than stated."""
    shown = (*row.parts, row.basis) if row.numbers and row.basis else row.parts
    text = ", ".join(map(unbroken, shown)).replace("+, ", "+ ")
    if row.partial:
        # Tied to its figures, unless both together would be too long for a line.
        tie = _TIE if len(row.parts[-1]) + len(row.shortfall) < WIDTH - len(INDENT) - 4 else " "
        text += f"{tie}<-{_TIE}{unbroken(row.shortfall)}"
    if row.regulator:
        text += f"; {unbroken(row.regulator)}"
    return coloured(row_lines(row.name, text), "yellow" if row.partial else None)


def row_as_data(row: SummaryRow) -> dict[str, Any]:
    """Return a row of the summary as plain data."""
    return {
        "name": row.name,
        "text": row.text,
        "regulator": row.regulator or None,
        "proved": row.proved,
        "basis": row.basis or None,
        "less_than_stated": row.partial,
        "claim": row.claim or None,
        "assumes": list(row.assumes),
        "numbers": [asdict(number) for number in row.numbers],
    }


def wrapped_claims(checked: CheckedFile, *, but: str = "") -> list[str]:
    """Return the claims in full with their own assumptions, those of one verdict left out."""
    lines = []
    for claim in checked.claims:
        if claim.verdict.name != but:
            lines.append(f"  {claim.verdict.name:<{len(INDENT) - 3}} {claim.name}")
            assumed = [f"assumes: {'; '.join(claim.assumes)}"] if claim.assumes else []
            for text in (claim.text, *assumed):
                lines += row_lines("", text)
    return lines


def unbroken(part: str) -> str:
    """Return a short part with no-break spaces, so that it stays on one line; else its shares."""
    return part.replace(" ", _TIE) if len(part) < _SHORT else part.replace(" %", f"{_TIE}%")


def coloured(lines: list[str], colour: str | None) -> list[str]:
    """Return the lines in a colour; as they are where no terminal shows them or NO_COLOR is set."""
    if colour is None or not sys.stdout.isatty() or os.environ.get("NO_COLOR"):
        return lines
    return [f"\x1b[{_ANSI[colour]}m{line}\x1b[0m" for line in lines]


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
