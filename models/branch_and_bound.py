"""Rigorous range of a function over boxes: best-first bisection of any interval enclosure."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from itertools import count
from typing import TypeAlias

from takagi.models.enclosure.interval import Interval
from takagi.models.errors import ModelError

__all__ = ["Box", "Range", "range_over"]

Box: TypeAlias = tuple[Interval, ...]
Enclose: TypeAlias = Callable[[Box], Interval | None]
Changes: TypeAlias = Callable[[Box], Sequence[float]]


@dataclass(frozen=True, slots=True)
class Range:
    """What is known of {f(x) : x in the boxes}.

    Attributes
    ----------
    outer : contains every value of f.
    inner : reaches from one attained value to another; what outer has more is the price of
        stopping early.
    boxes : number of boxes whose enclosures prove ``outer``.
    """

    outer: Interval
    inner: Interval
    boxes: int


def range_over(
    enclose: Enclose,
    boxes: Sequence[Box],
    *,
    changes: Changes | None = None,
    tolerance: Fraction = Fraction(1, 1000),
    most_boxes: int = 4000,
) -> Range:
    """Return an enclosure of the range of f over the union of the boxes.

    Parameters
    ----------
    enclose : an interval that contains f over a box, shrinking to f(x) with the box; None where
        it cannot tell.  A box of zero width is a point.
    changes : how much f may change along each side of a box, roughly; the side with the largest
        change is halved.  None takes the sides of the first box as equally important.
    tolerance : excess allowed at each end, as a share of the width of the range.
    most_boxes : per end; when it is reached the bound is valid and less tight.

    Raises
    ------
    ModelError : no box, or ``enclose`` cannot tell even on tiny boxes (a pole).

    Source: Moore, Kearfott, Cloud (2009), Introduction to Interval Analysis, ch. 11.
    """
    if not boxes:
        raise ModelError("no box was given; a range needs at least one")
    search = _Search(enclose, changes or partial(_shares, boxes[0]), tolerance, most_boxes)
    attained = search.attained([sample for box in boxes for sample in _samples(box)])
    upper, attained, above = search.run(boxes, 1, attained)
    lower, attained, below = search.run(boxes, -1, attained)
    return Range(Interval(lower, upper), attained, max(above, below))


@dataclass(frozen=True, slots=True)
class _Search:
    enclose: Enclose
    changes: Changes
    tolerance: Fraction
    most_boxes: int

    def attained(self, points: Sequence[Box], known: Interval | None = None) -> Interval:
        """Return an interval between two attained values, wider than the one already known."""
        values = [value for point in points if (value := self.enclose(point)) is not None]
        if known is not None:
            values.append(known)
        if not values:
            raise ModelError("the function has no finite value at any sample; bound it by hand")
        # Ends of a value's own enclosure are taken on the cautious side.
        low, high = min(v.upper for v in values), max(v.lower for v in values)
        if known is not None:
            low, high = min(low, known.lower), max(high, known.upper)
        return Interval(min(low, high), max(low, high))

    def run(
        self, boxes: Sequence[Box], sign: int, known: Interval
    ) -> tuple[Fraction, Interval, int]:
        """Return (bound, attained values, boxes) for the maximum (sign 1) or minimum (-1)."""
        number = count()
        heap = [(self._key(box, sign), next(number), box) for box in boxes]
        heapq.heapify(heap)
        for _ in range(self.most_boxes):
            key, _, box = heap[0]
            best = known.upper if sign > 0 else -known.lower
            if key is not _UNKNOWN and -key - best <= self.tolerance * known.width:
                break
            halves = self._halves(box)
            if halves is None:
                break
            heapq.heappop(heap)
            known = self.attained([_centre(half) for half in halves], known)
            for half in halves:
                heapq.heappush(heap, (self._key(half, sign), next(number), half))
        if heap[0][0] is _UNKNOWN:
            where = ", ".join(str(side) for side in heap[0][2])
            raise ModelError(
                f"no finite bound near {where}: the function seems to have a pole there; shrink "
                "the box, or give the bounds yourself"
            )
        return sign * -heap[0][0], known, len(heap)

    def _key(self, box: Box, sign: int) -> Fraction:
        """Return minus the optimistic value, so that the heap's first box is the one to split."""
        found = self.enclose(box)
        if found is None:
            return _UNKNOWN
        return -found.upper if sign > 0 else found.lower

    def _halves(self, box: Box) -> tuple[Box, Box] | None:
        """Halve the side along which f changes most; None for a point."""
        changes = self.changes(box)
        side = max(range(len(box)), key=lambda index: (changes[index], box[index].width))
        if box[side].width == 0:
            return None
        middle = box[side].centre
        parts = Interval(box[side].lower, middle), Interval(middle, box[side].upper)
        first, second = ((*box[:side], part, *box[side + 1 :]) for part in parts)
        return first, second


# Sorts before every finite key: a box that cannot be bounded is split first.
_UNKNOWN = Fraction(-(10**300))


def _centre(box: Box) -> Box:
    return tuple(Interval(side.centre, side.centre) for side in box)


def _shares(whole: Box, box: Box) -> list[float]:
    """Return each side's width as a share of the whole's."""
    return [float(b.width / w.width) if w.width else 0.0 for b, w in zip(box, whole, strict=True)]


def _samples(box: Box) -> list[Box]:
    """Return the centre and the two ends of the box's diagonal."""
    lower = tuple(Interval(side.lower, side.lower) for side in box)
    upper = tuple(Interval(side.upper, side.upper) for side in box)
    return [_centre(box), lower, upper]
