"""Ranges of winds: their union, and the gaps between them."""

from __future__ import annotations

from fractions import Fraction

Span = tuple[Fraction, Fraction]


def merged(spans: list[Span]) -> list[Span]:
    """Return the union of closed ranges as disjoint ones."""
    found: list[Span] = []
    for low, high in sorted(spans):
        if found and low <= found[-1][1]:
            found[-1] = found[-1][0], max(high, found[-1][1])
        else:
            found.append((low, high))
    return found


def gaps(span: Span, covered: list[Span]) -> list[Span]:
    """Return the parts of a range outside ``covered``, whose ranges are disjoint and ordered."""
    low, left = span[0], []
    for start, stop in covered:
        if stop <= low or start >= span[1]:
            continue
        if start > low:
            left.append((low, start))
        low = stop
    return [*left, (low, span[1])] if low < span[1] else left
