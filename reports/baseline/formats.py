"""A comparison as a table for the terminal, as Markdown, and as plain data.

A figure rises or falls, and is better or worse by an unsigned relative change, since the better
direction depends on the figure.  A word such as "slower" states the meaning.  ``WORSE`` means a
failure, ``worse`` is within the tolerance.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.words.rounded import at_least, at_most
from takagi.reports.baseline.changes import listed_changes
from takagi.reports.baseline.comparison import CertificateComparison, Moved
from takagi.reports.baseline.words import verdict, word_of
from takagi.reports.ci_formats import markdown_cell

_LARGEST = 10**300
# Digits of a figure: more than the first where two that differ would look the same.
_DIGITS = (6, 9, 12, 17, 34)


def as_text(found: CertificateComparison, *, source: str) -> str:
    """Return the comparison in lines; of unchanged figures only the number is given."""
    rows = [
        (word, means, claim, figure, f"{went} from {old} to {new}", f"({share})")
        for word, means, claim, figure, went, old, new, share in _rows(found)
    ]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)] if rows else []
    lines = [_head(found, source)]
    lines += [
        "  " + "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
    lines += [f"  lost    {name}: {why}" for name, why in found.lost.items()]
    lines += [f"  new     {name}" for name in found.added]
    lines += [f"  gains   {one}" for one in _gains(found)]
    same = len(found.moved) - len(rows)
    if same:
        lines.append(f"  {same} figure{'s are' if same > 1 else ' is'} the same")
    if found.changed:
        lines += ["What changed", *(f"  {line}" for line in listed_changes(found.changed))]
    return "\n".join(lines)


def as_markdown(found: CertificateComparison, *, source: str) -> str:
    """Return the comparison for a pull request: every figure that moved, and what changed."""
    lines = [f"### {markdown_cell(_head(found, source))}", ""]
    rows = list(_rows(found))
    if rows:
        lines += [
            "| | Means | Claim | Figure | | Old | New | Change |",
            "|---|---|---|---|---|---|---|---|",
        ]
        lines += ["| " + " | ".join(map(markdown_cell, row)) + " |" for row in rows]
        lines.append("")
    lines += [f"- lost: {markdown_cell(f'{name}: {why}')}" for name, why in found.lost.items()]
    lines += [f"- new: {markdown_cell(name)}" for name in found.added]
    lines += [f"- gains: {markdown_cell(one)}" for one in _gains(found)]
    lines += [f"- changed: {markdown_cell(line)}" for line in listed_changes(found.changed)]
    return "\n".join(lines).rstrip() + "\n"


def as_data(found: CertificateComparison) -> dict[str, Any]:
    """Return the comparison as plain data; numbers that are not finite are None."""
    return {
        "passes": found.passes,
        "verdict": verdict(found.moved, found.gains),
        "tolerance": float(found.tolerance),
        "figures": [
            {
                "claim": moved.claim,
                "figure": moved.figure,
                "unit": moved.unit,
                "wind": moved.place or None,
                "old": _plain(moved.old),
                "new": _plain(moved.new),
                "change": _plain(moved.change),
                "worse": moved.worse,
                "means": word_of(moved) or None,
            }
            for moved in found.moved
        ],
        "gains": [{"gain": one.name, "old": one.old, "new": one.new} for one in found.gains],
        "lost": [{"claim": name, "reason": why} for name, why in found.lost.items()],
        "added": list(found.added),
        "changed": [
            {"part": c.part, "place": c.place, "old": c.old, "new": c.new} for c in found.changed
        ],
    }


def _head(found: CertificateComparison, source: str) -> str:
    """Return the first line: what failed, and what got better or worse on the whole."""
    allowed = f"by more than {float(100 * found.tolerance):g} %"
    whole = verdict(found.moved, found.gains)
    if found.passes:
        return f"Against {source}: nothing got worse {allowed}; {whole}"
    worse, lost = sum(moved.worse for moved in found.moved), len(found.lost)
    told = [f"{_counted(worse, 'figure')} got worse {allowed}"] if worse else []
    told += [f"{_counted(lost, 'claim')} lost"] if lost else []
    return f"Against {source}: {', '.join(told)}; {whole}"


def _gains(found: CertificateComparison) -> Iterator[str]:
    """Yield the gains whose largest size over the rules has changed, and how."""
    for one in found.gains:
        if one.old != one.new:
            went = "larger" if one.new > one.old else "smaller"
            yield f"{one.name}: {went}, at most {one.old:.6g} before and {one.new:.6g} now"


def _counted(count: int, what: str) -> str:
    return f"{count} {what}{'s' if count > 1 else ''}"


def _rows(found: CertificateComparison) -> Iterator[tuple[str, ...]]:
    """Yield word, meaning, claim, figure, which way it went, old and new, and by how much."""
    for moved in found.moved:
        if not moved.change:
            continue
        word = "WORSE" if moved.worse else "worse" if moved.change < 0 else "better"
        figure = f"{moved.figure} [{moved.unit}]" if moved.unit else moved.figure
        if moved.place:
            figure += f", {moved.place}"
        went = "rose" if moved.new > moved.old else "fell"
        yield (word, word_of(moved), moved.claim, figure, went, *_values(moved), _share(moved))


def _share(moved: Moved) -> str:
    """Return the relative change, rounded towards the worse side."""
    word = "worse" if moved.change < 0 else "better"
    if not isinstance(moved.change, Fraction):
        return word
    if moved.change < 0:
        return f"{at_most(-100 * moved.change, 3)} % worse"
    return f"{at_least(100 * moved.change, 3)} % better"


def _values(moved: Moved) -> tuple[str, str]:
    """Return both values; with more digits than usual if they would otherwise look equal."""
    for digits in _DIGITS:
        old, new = _number(moved.old, digits), _number(moved.new, digits)
        if old != new:
            break
    return old, new


def _number(value: Fraction | float, digits: int) -> str:
    return at_least(value, digits) if isinstance(value, Fraction) else "none"


def _plain(value: Fraction | float) -> float | None:
    """Return a float; None for what is infinite, and for what no float can hold."""
    return float(value) if -_LARGEST < value < _LARGEST else None
