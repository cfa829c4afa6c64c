"""A comparison of designs as one page: verdicts, links, and every figure that differs, in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from takagi.reports.baseline.changes import listed_changes
from takagi.reports.baseline.comparison import BOX, CertificateComparison, Moved
from takagi.reports.baseline.words import (
    failures,
    gain_lines,
    share_in_words,
    summary_lines,
    values_in_words,
    verdict,
    word_of,
)


@dataclass(frozen=True, slots=True)
class ComparedDesign:
    """A design of the page.

    place : its folder or certificate, as the user wrote it.
    verdict : of its certificate, such as ``"PROVED"``.
    report : link to its report, relative to the page; "" without one.
    comparison : with the first design; None of the first.
    """

    place: str
    verdict: str
    report: str = ""
    comparison: CertificateComparison | None = None


class _Cell(NamedTuple):
    """A figure of a design: its text, what the change means, and the class that colours it."""

    text: str
    means: str = ""
    kind: str = ""


def as_html(designs: Sequence[ComparedDesign], *, name: str) -> str:
    """Return designs of one plant as one page that loads nothing; the first is the base.

    Every difference is given in words too, never by its colour alone.

    designs : the first without a comparison, all others with one.
    name : of the plant.
    """
    # Imported here: only a page needs the templates.
    from takagi.reports.page.assembly import report_files
    from takagi.reports.page.text import Section

    rows, same = _table(designs)
    content = {
        "designs": [_card(design) for design in designs],
        "rows": rows,
        "same": same,
        "details": [(d.place, _lists(d.comparison)) for d in designs if d.comparison],
    }
    return report_files(
        "plant",
        [Section("comparison", "Comparison", content)],
        title=name,
        verdict="comparison of designs",
        subtitle=f"Comparison of {len(designs)} designs",
        units="Numbers carry the units of the certificates.",
        styles=("style.css", "comparison.css"),
    ).html


def _card(design: ComparedDesign) -> dict[str, Any]:
    """Return what the top of the page says of a design."""
    compared = design.comparison
    card = {"place": design.place, "verdict": design.verdict, "report": design.report}
    if compared is None:
        return {**card, "result": "base", "kind": "", "head": "The others are compared with it."}
    overall = verdict(compared.moved, compared.gains)
    if compared.passes:
        result, head = (
            "not worse",
            f"No figure got worse by more than {_percent(compared)}; {overall}.",
        )
    else:
        result, head = "worse", f"{', '.join(failures(compared))}; {overall}."
    return {**card, "result": result, "kind": "good" if compared.passes else "bad", "head": head}


def _percent(compared: CertificateComparison) -> str:
    return f"{float(100 * compared.tolerance):g} %"


# Claim, figure with its unit, value of the base (None for a profile), and which of those alike.
_Key = tuple[str, str, object, int]


def _table(designs: Sequence[ComparedDesign]) -> tuple[list[tuple[str, str, list[_Cell]]], int]:
    """Return (figure, claim, a cell a design) where any design differs, and how many do not."""
    compared = [design.comparison for design in designs if design.comparison]
    columns = [_column(comparison) for comparison in compared]
    keys = list(dict.fromkeys(key for column in columns for key in column))
    rows = []
    for key in keys:
        moved = [column.get(key) for column in columns]
        # A figure whose claim is lost in one of them differs there.
        if all(not row.change if row else key[0] == BOX for row in moved):
            continue
        base = next(row for row in moved if row is not None)
        cells = [_Cell("by wind" if base.place else values_in_words(base)[0])]
        cells += [_cell(row, key[0], _percent(c)) for row, c in zip(moved, compared, strict=True)]
        rows.append((key[1], key[0], cells))
    return rows, len(keys) - len(rows)


def _column(compared: CertificateComparison) -> dict[_Key, Moved]:
    """Return the figures of a comparison by what is the same in all comparisons with one base."""
    column: dict[_Key, Moved] = {}
    for row in compared.moved:
        figure = f"{row.figure} [{row.unit}]" if row.unit else row.figure
        old = None if row.place else row.old
        alike = sum(key[:3] == (row.claim, figure, old) for key in column)
        column[row.claim, figure, old, alike] = row
    return column


def _cell(row: Moved | None, claim: str, allowed: str) -> _Cell:
    if row is None and claim == BOX:
        return _Cell("none", "no such variable")
    if row is None:
        return _Cell("lost", "not proved here, or about something else", "bad")
    old, new = values_in_words(row)
    if not row.change:
        return _Cell("by wind" if row.place else new, "the same")
    kind = "good" if row.change > 0 else "bad" if row.worse else "open"
    means = f"{word_of(row)}, {share_in_words(row)}" + f" (over {allowed})" * row.worse
    return _Cell(f"{old} to {new}, {row.place}" if row.place else new, means, kind)


def _lists(compared: CertificateComparison) -> list[tuple[str, list[str]]]:
    """Return (title, lines) of what the table of figures does not show."""
    lists = (
        ("Lost claims", [f"{claim}: {why}" for claim, why in compared.lost.items()]),
        ("New claims", list(compared.added)),
        ("Gains", list(gain_lines(compared))),
        ("Summary", summary_lines(compared)),
        ("Parameters, gains and options that differ", listed_changes(compared.changed)),
    )
    return [(title, lines) for title, lines in lists if lines]
