"""A comparison as a table for the terminal, as Markdown, and as plain data."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.words.shown import at_least
from takagi.reports.baseline.changes import listed_changes
from takagi.reports.baseline.comparison import Comparison, Moved

__all__ = ["as_data", "as_markdown", "as_text"]

_LARGEST = 10**300


def as_text(found: Comparison, *, source: str) -> str:
    """Return the comparison in lines; figures that are the same are counted alone."""
    rows = [_cells(moved) for moved in found.moved if moved.change]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)] if rows else []
    lines = [_head(found, source)]
    lines += [
        "  " + "  ".join(c.ljust(w) for c, w in zip(row, widths, strict=True)).rstrip()
        for row in rows
    ]
    lines += [f"  lost    {name}: {why}" for name, why in found.lost.items()]
    lines += [f"  new     {name}" for name in found.added]
    same = len(found.moved) - len(rows)
    if same:
        lines.append(f"  {same} figure{'s are' if same > 1 else ' is'} the same")
    if found.changed:
        lines += ["What changed", *(f"  {line}" for line in listed_changes(found.changed))]
    return "\n".join(lines)


def as_markdown(found: Comparison, *, source: str) -> str:
    """Return the comparison for a pull request: every figure that moved, and what changed."""
    lines = [f"### {_escaped(_head(found, source))}", ""]
    rows = [_cells(moved) for moved in found.moved if moved.change]
    if rows:
        lines += ["| | Claim | Figure | Old | | New | Change |", "|---|---|---|---|---|---|---|"]
        lines += ["| " + " | ".join(map(_escaped, row)) + " |" for row in rows]
        lines.append("")
    lines += [f"- lost: {_escaped(f'{name}: {why}')}" for name, why in found.lost.items()]
    lines += [f"- new: {_escaped(name)}" for name in found.added]
    lines += [f"- changed: {_escaped(line)}" for line in listed_changes(found.changed)]
    return "\n".join(lines).rstrip() + "\n"


def as_data(found: Comparison) -> dict[str, Any]:
    """Return the comparison as plain data; what is not finite is None."""
    return {
        "passes": found.passes,
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
            }
            for moved in found.moved
        ],
        "lost": [{"claim": name, "reason": why} for name, why in found.lost.items()],
        "added": list(found.added),
        "changed": [
            {"part": c.part, "place": c.place, "old": c.old, "new": c.new} for c in found.changed
        ],
    }


def _head(found: Comparison, source: str) -> str:
    allowed = f"tolerance {float(100 * found.tolerance):g} %"
    if found.passes:
        return f"Against {source}: nothing got worse ({allowed})"
    worse = len(found.lost) + sum(moved.worse for moved in found.moved)
    return f"Against {source}: {worse} got worse ({allowed})"


def _cells(moved: Moved) -> tuple[str, ...]:
    word = "WORSE" if moved.worse else "less" if moved.change < 0 else "more"
    figure = f"{moved.figure} [{moved.unit}]" if moved.unit else moved.figure
    if moved.place:
        figure += f", {moved.place}"
    return (word, moved.claim, figure, _number(moved.old), "->", _number(moved.new), _share(moved))


def _share(moved: Moved) -> str:
    if not isinstance(moved.change, Fraction):
        return ""
    return f"({'+' if moved.change > 0 else ''}{at_least(100 * moved.change, 3)} %)"


def _number(value: Fraction | float) -> str:
    return at_least(value, 6) if isinstance(value, Fraction) else "none"


def _plain(value: Fraction | float) -> float | None:
    """Return a float; None for what is infinite, and for what no float can hold."""
    return float(value) if -_LARGEST < value < _LARGEST else None


def _escaped(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")
