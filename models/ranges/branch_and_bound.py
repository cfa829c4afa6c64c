"""Rigorous range of a function over boxes from any interval enclosure of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import partial
from typing import TYPE_CHECKING, TypeAlias

from takagi.models.errors import ModelError
from takagi.models.intervals.box_search import Bounded, Ends, search
from takagi.models.intervals.interval import Interval

if TYPE_CHECKING:
    from takagi.models.ranges.evidence import Evidence

Box: TypeAlias = tuple[Interval, ...]
Enclose: TypeAlias = Callable[[Box], Interval | None]
Changes: TypeAlias = Callable[[Box], Sequence[float]]


@dataclass(frozen=True, slots=True)
class Range:
    """Outer and inner bounds of the set {f(x) : x in the boxes}.

    Attributes
    ----------
    outer : contains every value of f.
    inner : reaches from one attained value to another; the excess of outer is due to stopping
        early.
    boxes : number of boxes whose enclosures prove ``outer``.
    evidence : what ``replay`` recomputes ``outer`` from without a search; None where the maker
        of the range offers none.
    """

    outer: Interval
    inner: Interval
    boxes: int
    evidence: Evidence | None = field(default=None, repr=False, compare=False)


def range_over(
    enclose: Enclose,
    boxes: Sequence[Box],
    *,
    changes: Changes | None = None,
    tolerance: Fraction = Fraction(1, 1000),
    most_boxes: int = 8000,
) -> Range:
    """Return an enclosure of the range of f over the union of the boxes.

    Parameters
    ----------
    enclose : an interval that contains f over a box, shrinking to f(x) with the box; None where
        it cannot decide.  A box of zero width is a point.
    changes : how much f may change along each side of a box, roughly; the side with the largest
        change is halved.  None takes the sides of the first box as equally important.
    tolerance : excess allowed at each end, as a share of the width of the range.
    most_boxes : when it is reached the bounds are valid and less tight.

    Raises
    ------
    ModelError : no box, or ``enclose`` cannot decide even on tiny boxes (a pole).
    """
    if not boxes:
        raise ModelError("no box was given; a range needs at least one")
    found = search(
        partial(_look, enclose, changes or partial(_shares, boxes[0])),
        _halves,
        boxes,
        tolerance=tolerance,
        most_boxes=most_boxes,
        tell=lambda box: ", ".join(str(side) for side in box),
        attained=_attained(enclose, [point for box in boxes for point in _diagonal(box)]),
    )
    return Range(Interval(*found.outer), Interval(*found.attained), found.boxes)


def _look(enclose: Enclose, changes: Changes, box: Box) -> Bounded:
    attained = _attained(enclose, [tuple(Interval(side.centre, side.centre) for side in box)])
    outer = enclose(box)
    size = changes(box)
    axis = max(range(len(box)), key=lambda index: (size[index], box[index].width), default=None)
    if axis is not None and box[axis].width == 0:
        axis = None
    return Bounded(None if outer is None else (outer.lower, outer.upper), attained, axis)


def _halves(box: Box, axis: int) -> tuple[Box, Box]:
    middle = box[axis].centre
    parts = Interval(box[axis].lower, middle), Interval(middle, box[axis].upper)
    first, second = ((*box[:axis], part, *box[axis + 1 :]) for part in parts)
    return first, second


def _attained(enclose: Enclose, points: Sequence[Box]) -> Ends | None:
    """Return the ends of values at points, each on the cautious side of its own enclosure."""
    values = [value for point in points if (value := enclose(point)) is not None]
    return (min(v.upper for v in values), max(v.lower for v in values)) if values else None


def _diagonal(box: Box) -> tuple[Box, Box]:
    """Return the two ends of the box's diagonal."""
    lower = tuple(Interval(side.lower, side.lower) for side in box)
    upper = tuple(Interval(side.upper, side.upper) for side in box)
    return lower, upper


def _shares(whole: Box, box: Box) -> list[float]:
    """Return each side's width as a share of the whole's."""
    return [float(b.width / w.width) if w.width else 0.0 for b, w in zip(box, whole, strict=True)]
