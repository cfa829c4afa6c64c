"""A comparison of designs as one page: verdicts, links, and every figure that differs, in words."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import asdict
from fractions import Fraction
from typing import Any, NamedTuple

from takagi.certificates.checker.words.rounded import at_least, at_most
from takagi.reports.baseline.comparison import (
    BOX,
    CertificateComparison,
    GainSize,
    Moved,
    listed_changes,
)
from takagi.reports.ci_formats import markdown_cell
from takagi.reports.output import read_words
from takagi.reports.page.text import Section

# Relative change of a figure that rounding on another processor may cause.
ROUNDING = 1e-3
# A ratio of gains nearer to 1 than this is not mentioned.
_ALIKE = 0.005


def word_of(row: Moved) -> str:
    """Return what a change means, such as ``"slower"``; empty where nothing has changed."""
    if not row.change:
        return ""
    better = row.change > 0
    if row.claim == BOX:
        return "wider box" if better else "narrower box"
    for start, (good, bad) in read_words("baseline/words.toml").items():
        if row.figure.startswith(start):
            return str(good if better else bad)
    return "better" if better else "worse"


def verdict(rows: Sequence[Moved], gains: Iterable[GainSize]) -> str:
    """Return on the whole what got better and what worse, in one phrase.

    A figure that got worse within the tolerance counts too, because the phrase is about the
    direction of the change; changes within rounding do not count.
    """
    judged = [(row.change > 0, word_of(row)) for row in rows if abs(float(row.change)) > ROUNDING]
    good = list(dict.fromkeys(word for better, word in judged if better))
    bad = list(dict.fromkeys(word for better, word in judged if not better))
    partly = "partly " if good and bad else ""
    sides = (("better", good), ("worse", bad))
    phrase = ", ".join(f"{partly}{side} ({', '.join(words)})" for side, words in sides if words)
    if not phrase:
        phrase = "no figure changed"
        phrase += f" by more than {100 * ROUNDING:g} %" if any(row.change for row in rows) else ""
    sizes = gain_words(gains)
    return f"{phrase}; {sizes}" if sizes else phrase


def gain_words(gains: Iterable[GainSize]) -> str:
    """Return how the largest gains compare; empty where they are alike or cannot be compared."""
    ratios = [gain.ratio for gain in gains if gain.ratio is not None]
    if not ratios or all(abs(ratio - 1) < _ALIKE for ratio in ratios):
        return ""
    low, high = min(ratios), max(ratios)
    if low > 1 - _ALIKE:
        return f"larger gains, up to {high:.3g} times"
    if high < 1 + _ALIKE:
        return f"smaller gains, down to {low:.3g} times"
    return f"gains from {low:.3g} to {high:.3g} times the old ones"


def listed(compared: CertificateComparison) -> dict[str, list[str]]:
    """Return kind -> lines of what the table of figures does not show."""
    summary = [f"{c.name}: {c.old or 'nothing'} -> {c.new or 'nothing'}" for c in compared.summary]
    gains = [
        f"{gain.name}: {'larger' if gain.new > gain.old else 'smaller'}, at most {gain.old:.6g} "
        f"before and {gain.new:.6g} now"
        for gain in compared.gains
        if gain.old != gain.new
    ]
    return {
        "lost": [f"{name}: {why}" for name, why in compared.lost.items()],
        "new": list(compared.added),
        "gains": gains,
        "summary": summary,
        "changed": listed_changes(compared.changed),
    }


_LARGEST = 10**300
# Digits of a figure: more than the first where two that differ would look the same.
_DIGITS = (6, 9, 12, 17, 34)


def as_text(compared: CertificateComparison, *, source: str) -> str:
    """Return the comparison in lines; of unchanged figures only the number is given."""
    rows = [
        (word, means, claim, figure, f"{went} from {old} to {new}", f"({share})")
        for word, means, claim, figure, went, old, new, share in _rows(compared)
    ]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)] if rows else []
    lines = [_head(compared, source)]
    lines += [
        "  " + "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
    lists = listed(compared)
    for kind in ("lost", "new", "gains"):
        lines += [f"  {kind:<8}{line}" for line in lists[kind]]
    same = len(compared.moved) - len(rows)
    if same:
        lines.append(f"  {same} figure{'s are' if same > 1 else ' is'} the same")
    lines += [f"  {line}" for line in lists["summary"]]
    if lists["changed"]:
        lines += ["What changed", *(f"  {line}" for line in lists["changed"])]
    return "\n".join(lines)


def as_markdown(compared: CertificateComparison, *, source: str) -> str:
    """Return the comparison for a pull request: every figure that moved, and what changed."""
    lines = [f"### {markdown_cell(_head(compared, source))}", ""]
    rows = list(_rows(compared))
    if rows:
        lines += [
            "| | Means | Claim | Figure | | Old | New | Change |",
            "|---|---|---|---|---|---|---|---|",
        ]
        lines += ["| " + " | ".join(map(markdown_cell, row)) + " |" for row in rows]
        lines.append("")
    for kind, texts in listed(compared).items():
        head = "" if kind == "summary" else f"{kind}: "
        lines += [f"- {head}{markdown_cell(text)}" for text in texts]
    return "\n".join(lines).rstrip() + "\n"


def as_data(compared: CertificateComparison) -> dict[str, Any]:
    """Return the comparison as plain data; numbers that are not finite are None."""
    return {
        "passes": compared.passes,
        "verdict": verdict(compared.moved, compared.gains),
        "tolerance": float(compared.tolerance),
        "figures": [
            {
                "claim": row.claim,
                "figure": row.figure,
                "unit": row.unit,
                "wind": row.place or None,
                "old": _plain(row.old),
                "new": _plain(row.new),
                "change": _plain(row.change),
                "worse": row.worse,
                "means": word_of(row) or None,
            }
            for row in compared.moved
        ],
        "gains": [{"gain": gain.name, "old": gain.old, "new": gain.new} for gain in compared.gains],
        "summary": [asdict(change) for change in compared.summary],
        "lost": [{"claim": name, "reason": why} for name, why in compared.lost.items()],
        "added": list(compared.added),
        "changed": [asdict(change) for change in compared.changed],
    }


def _head(compared: CertificateComparison, source: str) -> str:
    """Return the first line: what failed, and what got better or worse on the whole."""
    overall = verdict(compared.moved, compared.gains)
    why = ", ".join(failures(compared)) or f"nothing got worse by more than {_percent(compared)}"
    return f"Against {source}: {why}; {overall}"


def failures(compared: CertificateComparison) -> list[str]:
    """Return why a comparison does not pass, a phrase each; [] where it passes."""
    worse, lost = sum(row.worse for row in compared.moved), len(compared.lost)
    allowed = _percent(compared)
    phrases = [f"{_counted(worse, 'figure')} got worse by more than {allowed}"] if worse else []
    return [*phrases, *([f"{_counted(lost, 'claim')} lost"] if lost else [])]


def _counted(count: int, noun: str) -> str:
    return f"{count} {noun}{'s' if count > 1 else ''}"


def _rows(compared: CertificateComparison) -> Iterator[tuple[str, ...]]:
    """Yield word, meaning, claim, figure, which way it went, old and new, and by how much."""
    for row in compared.moved:
        if not row.change:
            continue
        word = "WORSE" if row.worse else "worse" if row.change < 0 else "better"
        figure = f"{row.figure} [{row.unit}]" if row.unit else row.figure
        if row.place:
            figure += f", {row.place}"
        went = "rose" if row.new > row.old else "fell"
        values = values_in_words(row)
        yield (word, word_of(row), row.claim, figure, went, *values, share_in_words(row))


def share_in_words(row: Moved) -> str:
    """Return the relative change, rounded towards the worse side."""
    word = "worse" if row.change < 0 else "better"
    if not isinstance(row.change, Fraction):
        return word
    if row.change < 0:
        return f"{at_most(-100 * row.change, 3)} % worse"
    return f"{at_least(100 * row.change, 3)} % better"


def values_in_words(row: Moved) -> tuple[str, str]:
    """Return both values; with more digits than usual if they would otherwise look equal."""
    for digits in _DIGITS:
        old, new = _number(row.old, digits), _number(row.new, digits)
        if old != new or row.old == row.new:
            break
    return old, new


def _number(value: Fraction | float, digits: int) -> str:
    return at_least(value, digits) if isinstance(value, Fraction) else "none"


def _plain(value: Fraction | float) -> float | None:
    """Return a float; None for what is infinite, and for what no float can hold."""
    return float(value) if -_LARGEST < value < _LARGEST else None


class ComparedDesign(NamedTuple):
    """A design of the page.

    Attributes
    ----------
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

    Parameters
    ----------
    designs : the first without a comparison, all others with one.
    name : of the plant.
    """
    # Imported here: only a page needs the templates.
    from takagi.reports.page.assembly import report_files

    rows, same = _table(designs)
    content = {
        "designs": [_card(design) for design in designs],
        "rows": rows,
        "same": same,
        "details": [
            (
                d.place,
                [(LISTS[kind], lines) for kind, lines in listed(d.comparison).items() if lines],
            )
            for d in designs
            if d.comparison
        ],
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
        head = f"No figure got worse by more than {_percent(compared)}; {overall}."
        return {**card, "result": "not worse", "kind": "good", "head": head}
    head = f"{', '.join(failures(compared))}; {overall}."
    return {**card, "result": "worse", "kind": "bad", "head": head}


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


LISTS = {
    "lost": "Lost claims",
    "new": "New claims",
    "gains": "Gains",
    "summary": "Summary",
    "changed": "Parameters, gains and options that differ",
}
