"""`takagi compare`: designs of one plant, side by side."""

from __future__ import annotations

import json
import os
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated
from urllib.parse import quote

import typer

from takagi.cli.command import PROVED, UNPROVED, run_command
from takagi.cli.progress import progress
from takagi.cli.runs.previous_certificate import TOLERANCE, compared, read_baseline, tolerance_of
from takagi.models.errors import ModelError
from takagi.reports.output import write_file

if TYPE_CHECKING:
    from takagi.reports.sections.plant.summary import SummaryRow


def compare(
    old: Annotated[
        Path, typer.Argument(metavar="OLD", help="A design's folder, or its certificate.")
    ],
    new: Annotated[
        list[Path], typer.Argument(metavar="NEW...", help="Other ones of the same plant.")
    ],
    tolerance: str = TOLERANCE,
    summary: Path | None = None,
    html: Path | None = None,
    as_json: bool = False,
) -> int:
    """Compare designs of one plant by their certificates: each NEW with OLD."""
    share = tolerance_of(tolerance)
    # A folder without a design is refused before anything is read for long.
    places = {place: _file(place) for place in (old, *new)}
    rows = {place: _summary_of(place) for place in places}
    from takagi.reports.baseline.comparison import plant_name, summary_changes
    from takagi.reports.baseline.page import as_data, as_markdown, as_text

    read = {place: read_baseline(certificate) for place, certificate in places.items()}
    before, source = read[old], str(places[old])
    by_place = {}
    for place in new:
        comparison = compared(before, read[place], share)
        if rows[old] and rows[place]:
            changes = summary_changes(rows[old], rows[place])
            comparison = replace(comparison, summary=changes)
        by_place[place] = comparison
    comparisons = {str(places[place]): comparison for place, comparison in by_place.items()}
    # A heading says which of several it is.
    several = len(comparisons) > 1
    heads = {place: f"{place}\n" if several else "" for place in comparisons}
    if summary is not None:
        texts = (f"{heads[k]}\n" * several + as_markdown(c, source=source)
                 for k, c in comparisons.items())  # fmt: skip
        write_file(summary, "\n".join(texts))
    if html is not None:
        from takagi.reports.baseline.page import ComparedDesign, as_html

        designs = [
            ComparedDesign(
                str(place),
                read[place].checked.verdict.name,
                _report_beside(places[place], html),
                comparison,
            )
            for place, comparison in ((old, None), *by_place.items())
        ]
        write_file(html, as_html(designs, name=plant_name(before.document["model"])))
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
    from takagi.reports.design_folder import read_design, summary_of

    with progress(f"takagi compare {path}: summary") as tell:
        try:
            return summary_of(read_design(path, tell=tell))
        except (ModelError, CertificateError) as error:
            typer.echo(f"{path}: compared by its certificate alone: {error}", err=True)
            return ()


def _report_beside(certificate: Path, page: Path) -> str:
    """Return the link from a page to the report beside a certificate; "" where there is none."""
    from takagi.reports.design_folder import REPORT

    report = certificate.with_name(REPORT)
    if not report.is_file():
        return ""
    # A page that goes to a stream lies in no folder.
    folder = Path() if page.exists() and not page.is_file() else page.parent
    return quote(Path(os.path.relpath(report, folder)).as_posix())


def _file(path: Path) -> Path:
    """Return the certificate of a design's folder; a file is kept."""
    if path.is_file():
        return path
    from takagi.reports.design_folder import CERTIFICATE, design_file

    return design_file(path, CERTIFICATE)
