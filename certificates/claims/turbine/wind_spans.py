"""Ranges of winds in floating point: their union, and what they leave of a range."""

from __future__ import annotations

from collections.abc import Sequence

Span = tuple[float, float]


def merged(spans: Sequence[Span], *, reach: float = 0.0) -> list[Span]:
    """Return the union as disjoint ranges, in order; those at most ``reach`` apart become one."""
    found: list[Span] = []
    for low, high in sorted(spans):
        if found and low <= found[-1][1] + reach:
            found[-1] = found[-1][0], max(high, found[-1][1])
        else:
            found.append((low, high))
    return found


def gaps(span: Span, covered: Sequence[Span]) -> list[Span]:
    """Return the parts of a range outside ``covered``, whose ranges are disjoint and ordered."""
    low, left = span[0], []
    for start, stop in covered:
        if stop <= low or start >= span[1]:
            continue
        if start > low:
            left.append((low, start))
        low = stop
    return [*left, (low, span[1])] if low < span[1] else left
