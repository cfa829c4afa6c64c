"""`takagi compare`: designs of one plant, side by side."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from takagi.cli.command import PROVED, UNPROVED, run_command
from takagi.cli.options.given import AsJson
from takagi.cli.runs.previous_certificate import (
    TOLERANCE,
    TOLERANCE_HELP,
    compared,
    read_baseline,
    tolerance_of,
)

if TYPE_CHECKING:
    from takagi.reports.sections.plant.summary import SummaryRow


def compare(
    old: Annotated[
        Path, typer.Argument(metavar="OLD", help="A design's folder, or its certificate.")
    ],
    new: Annotated[
        list[Path], typer.Argument(metavar="NEW...", help="Other ones of the same plant.")
    ],
    tolerance: Annotated[str, typer.Option(metavar="SHARE", help=TOLERANCE_HELP)] = TOLERANCE,
    summary: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the comparison as Markdown.")
    ] = None,
    html: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Write the comparison as a page.")
    ] = None,
    as_json: AsJson = False,
) -> int:
    """Compare designs of one plant by their certificates: each NEW with OLD.

    All certificates are replayed first. Of designs' folders the summaries are compared too; they
    decide nothing, for their margins and simulated figures are not proved. Exit status: 0 nothing
    got worse; 1 something got worse; 2 misuse, or a file that is refused.
    """
    share = tolerance_of(tolerance)
    first_rows, rows = _summary_of(old), {place: _summary_of(place) for place in new}
    old, places = _file(old), {place: _file(place) for place in new}
    from takagi.reports.baseline.comparison import plant_name, summary_changes
    from takagi.reports.baseline.words import as_data, as_html, as_markdown, as_text
    from takagi.reports.output import write_file

    before, source = read_baseline(old), str(old)
    comparisons = {}
    for place, certificate in places.items():
        comparison = compared(before, read_baseline(certificate), share)
        if first_rows and rows[place]:
            changes = summary_changes(first_rows, rows[place])
            comparison = replace(comparison, summary=changes)
        comparisons[str(certificate)] = comparison
    # A heading says which of several it is.
    several = len(comparisons) > 1
    heads = {place: f"{place}\n" if several else "" for place in comparisons}
    if summary is not None:
        texts = (f"{heads[k]}\n" * several + as_markdown(c, source=source)
                 for k, c in comparisons.items())  # fmt: skip
        write_file(summary, "\n".join(texts))
    if html is not None:
        name = plant_name(before.document["model"])
        write_file(html, as_html(comparisons, name=name, old=source))
    if as_json:
        data = [{"old": source, "new": place, **as_data(c)} for place, c in comparisons.items()]
        print(json.dumps(data if several else data[0], indent=2))
    else:
        print("\n\n".join(heads[k] + as_text(c, source=source) for k, c in comparisons.items()))
    return PROVED if all(c.passes for c in comparisons.values()) else UNPROVED


run = partial(run_command, "compare", compare)


def _summary_of(path: Path) -> Sequence[SummaryRow]:
    """Return the rows of a design's folder; none of a certificate, or where it cannot be read."""
    if not path.is_dir():
        return ()
    from takagi.certificates.checker.kernel.refusal import CertificateError
    from takagi.cli.progress import progress
    from takagi.models.errors import ModelError
    from takagi.reports.design_folder import read_design, summary_of

    with progress(f"takagi compare {path}: summary") as tell:
        try:
            return summary_of(read_design(path, tell=tell))
        except (ModelError, CertificateError) as error:
            typer.echo(f"{path}: compared by its certificate alone: {error}", err=True)
            return ()


def _file(path: Path) -> Path:
    """Return the certificate of a design's folder; a file is kept."""
    if not path.is_dir():
        return path
    from takagi.reports.design_folder import CERTIFICATE, design_file

    return design_file(path, CERTIFICATE)
