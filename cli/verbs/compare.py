"""`takagi compare`: two designs of one plant, side by side."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from takagi.cli.command import PROVED, UNPROVED, run_command
from takagi.cli.runs.previous_certificate import (
    TOLERANCE,
    TOLERANCE_HELP,
    read_baseline,
    tolerance_of,
)


def run(arguments: Sequence[str]) -> int:
    """Run the verb; return its exit status."""
    return run_command("compare", compare, arguments)


def compare(
    old: Annotated[
        Path, typer.Argument(metavar="OLD", help="A design's folder, or its certificate.")
    ],
    new: Annotated[Path, typer.Argument(metavar="NEW", help="Another one of the same plant.")],
    tolerance: Annotated[str, typer.Option(metavar="SHARE", help=TOLERANCE_HELP)] = TOLERANCE,
    summary: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the comparison as Markdown.")
    ] = None,
    html: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the comparison as a page.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, for machines.")] = False,
) -> int:
    """Compare two designs of one plant by their certificates.

    Both certificates are replayed first. Exit status: 0 nothing got worse; 1 something got worse;
    2 misuse, or a file that is refused.
    """
    share = tolerance_of(tolerance)
    old, new = _file(old), _file(new)
    from takagi.reports.baseline.comparison import compare_certificates, plant_name
    from takagi.reports.baseline.words import as_data, as_html, as_markdown, as_text
    from takagi.reports.output import write_file

    first, second = read_baseline(old), read_baseline(new)
    found = compare_certificates(
        first.document,
        second.document,
        checked_old=first.checked,
        checked_new=second.checked,
        tolerance=share,
    )
    if summary is not None:
        write_file(summary, as_markdown(found, source=str(old)))
    if html is not None:
        name = plant_name(second.document["model"])
        write_file(html, as_html(found, name=name, old=str(old), new=str(new)))
    if as_json:
        print(json.dumps({"old": str(old), "new": str(new), **as_data(found)}, indent=2))
    else:
        print(as_text(found, source=str(old)))
    return PROVED if found.passes else UNPROVED


def _file(path: Path) -> Path:
    """Return the certificate of a design's folder; a file is kept."""
    if not path.is_dir():
        return path
    from takagi.reports.design_folder import CERTIFICATE, design_file

    return design_file(path, CERTIFICATE)
