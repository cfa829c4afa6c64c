"""`takagi compare`: two certificates, or the gains of two files, side by side."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from takagi.cli.command import PROVED, UNPROVED, run_command
from takagi.cli.runs.previous_certificate import (
    TOLERANCE,
    TOLERANCE_HELP,
    read_baseline,
    tolerance_of,
)
from takagi.models.errors import ModelError

if TYPE_CHECKING:
    from takagi.reports.baseline.changes import Change

MOST_LISTED = 40


def run(arguments: Sequence[str]) -> int:
    """Run the verb; return its exit status."""
    return run_command("compare", compare, arguments)


def compare(
    old: Annotated[
        Path, typer.Argument(metavar="OLD", help="A design's folder, or a file of one.")
    ],
    new: Annotated[Path, typer.Argument(metavar="NEW", help="Another one of the same kind.")],
    tolerance: Annotated[str, typer.Option(metavar="SHARE", help=TOLERANCE_HELP)] = TOLERANCE,
    summary: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the comparison as Markdown.")
    ] = None,
    html: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the comparison as a page.")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON, for machines.")] = False,
) -> int:
    """Compare two certificates of one plant, or the laws of two gain files.

    Both certificates are replayed first. Exit status: 0 nothing got worse, or the laws are the
    same; 1 something got worse, or the laws differ; 2 misuse, or a file that is refused.
    """
    share = tolerance_of(tolerance)
    old, new = _file(old), _file(new)
    laws = _law(old), _law(new)
    if any(law is not None for law in laws):
        if summary is not None or html is not None:
            raise ModelError(
                "--summary and --html are about two certificates; leave them out for gain files"
            )
        return _laws(old, new, laws, as_json=as_json)
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


def _law(path: Path) -> Any:
    """Return the law of a gain file; None for what is taken for a certificate."""
    from takagi.certificates.checker.kernel.reader import read_json

    data = read_json(path)
    return data.get("law") if "claims" not in data else None


def _laws(old: Path, new: Path, laws: tuple[Any, Any], *, as_json: bool) -> int:
    from takagi.reports.baseline.changes import changes
    from takagi.reports.baseline.comparison import gain_sizes
    from takagi.reports.baseline.words import gain_words

    for path, law in zip((old, new), laws, strict=True):
        if not isinstance(law, Mapping):
            raise ModelError(f"{path}: not a gain file, and the other one is; give two of a kind")
    before, after = ({"model": None, "gains": law} for law in laws)
    found = list(changes(before, after))
    sizes = gain_words(gain_sizes(*laws))
    if as_json:
        listed = [{"place": c.place, "old": c.old, "new": c.new} for c in found]
        answer = {"old": str(old), "new": str(new), "same": not found, "sizes": sizes,
                  "changed": listed}  # fmt: skip
        print(json.dumps(answer, indent=2))
    else:
        print(_law_text(old, new, found, sizes))
    return UNPROVED if found else PROVED


def _law_text(old: Path, new: Path, found: Sequence[Change], sizes: str) -> str:
    if not found:
        return f"{old} and {new}: the same law, number by number"
    head = f"{old} and {new}: {len(found)} difference{'s' * (len(found) > 1)}"
    lines = [f"{head}; {sizes}" if sizes else head]
    lines += [f"  {c.place}: {c.old} -> {c.new}" for c in found[:MOST_LISTED]]
    more = len(found) - MOST_LISTED
    return "\n".join([*lines, *([f"  and {more} more"] if more > 0 else [])])
