"""Best-first bisection of boxes, whatever a box is and however it is enclosed.

Also the range of any function that has an interval enclosure.
"""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval

Ends: TypeAlias = tuple[Any, Any]  # two exact numbers of one ordered type, smaller first
Box = TypeVar("Box")


class NoBound(ModelError):
    """No finite bound was found near some point: a pole, or not distinguishable from one."""


class Bounded(NamedTuple):
    """The result of evaluating one box.

    Attributes
    ----------
    outer : ends that contain every value of f there; None where it cannot decide.
    attained : ends of values that f takes there, each on the cautious side; None if unknown.
    axis : the side to halve next; None when the box is a point.
    """

    outer: Ends | None
    attained: Ends | None
    axis: int | None


class SearchResult(NamedTuple):
    """Result of a search: ``outer`` and ``attained`` ends, and boxes that cover the domain."""

    outer: Ends
    attained: Ends
    boxes: int


def search(
    bound: Callable[[Box], Bounded],
    halve: Callable[[Box, int], tuple[Box, Box]],
    roots: Sequence[Box],
    *,
    tolerance: Fraction,
    most_boxes: int,
    tell: Callable[[Box], str],
    attained: Ends | None = None,
    refine: Callable[[Box], Bounded] | None = None,
) -> SearchResult:
    """Return the range of f over the union of the roots; both ends from one set of boxes.

    The box that holds the worse end is halved, until each end exceeds an attained value by no
    more than ``tolerance`` times the width of what is attained.

    Raises
    ------
    NoBound : ``bound`` cannot decide even on small boxes (a pole).
    ModelError : nothing is attained.

    Source: Moore, Kearfott, Cloud (2009), Introduction to Interval Analysis, ch. 11.
    """
    tree = _Tree(bound, halve, tell, refine)
    tree.widen(attained)
    for root in roots:
        tree.add(root)
    for _ in range(most_boxes):
        worst = tree.worst(tolerance)
        if worst is None or not tree.split(worst):
            break
    return tree.result()


class _Tree(Generic[Box]):
    """Boxes examined so far; those that are not halved cover the domain."""

    def __init__(
        self,
        bound: Callable[[Box], Bounded],
        halve: Callable[[Box, int], tuple[Box, Box]],
        tell: Callable[[Box], str],
        refine: Callable[[Box], Bounded] | None,
    ) -> None:
        self.look, self.halve, self.tell, self.refine = bound, halve, tell, refine
        self.refined: set[int] = set()
        self.places: list[Box | None] = []
        self.looks: list[Bounded] = []
        self.halved: set[int] = set()
        self.unknown: deque[int] = deque()
        self.by_lower: list[tuple[Any, int]] = []
        self.by_upper: list[tuple[Any, int]] = []
        self.attained: Ends | None = None

    def add(self, box: Box) -> None:
        self.places.append(box)
        self.looks.append(self.look(box))
        self._enter(len(self.looks) - 1)

    def _enter(self, index: int) -> None:
        """Queue a box by its evaluated bounds; entries of an earlier look are skipped later."""
        bounds = self.looks[index]
        if bounds.outer is None:
            self.unknown.append(index)
        else:
            heapq.heappush(self.by_lower, (bounds.outer[0], index))
            heapq.heappush(self.by_upper, (-bounds.outer[1], index))
        self.widen(bounds.attained)

    def _clean(self) -> None:
        """Drop entries of halved boxes and of earlier looks from the heads of the queues."""
        for heap, end, sign in ((self.by_lower, 0, 1), (self.by_upper, 1, -1)):
            while heap:
                key, index = heap[0]
                outer = self.looks[index].outer
                if index not in self.halved and outer is not None and key == sign * outer[end]:
                    break
                heapq.heappop(heap)

    def widen(self, values: Ends | None) -> None:
        """Take further attained values into account."""
        if values is not None:
            low, high = values
            if self.attained is not None:
                low, high = min(low, self.attained[0]), max(high, self.attained[1])
            self.attained = (min(low, high), max(low, high))

    def worst(self, tolerance: Fraction) -> int | None:
        """Return the box to halve; None when both ends are near enough."""
        if self.unknown:
            # Boxes without a bound come first: while one is left, no end of the range is known.
            return self.unknown[0]
        self._clean()
        if self.attained is None:
            return self.by_upper[0][1]
        low, high = self.attained
        below, above = low - self.by_lower[0][0], -self.by_upper[0][0] - high
        size = max(-low, high)
        # A width lost in the rounding of numbers of this size cannot be asked for.
        allowed = max((high - low) * tolerance.numerator / tolerance.denominator, size / 2**80)
        if below <= allowed and above <= allowed:
            return None
        return self.by_lower[0][1] if below > above else self.by_upper[0][1]

    def split(self, index: int) -> bool:
        """Evaluate a box more tightly, or halve it; False when it cannot be halved."""
        box = self.places[index]
        if self.refine and box is not None and index not in self.refined:
            if self.looks[index].outer is not None:
                self.refined.add(index)
                self.looks[index] = self.refine(box)
                self._enter(index)
                return True
        axis = self.looks[index].axis
        if axis is None or box is None:
            return False
        if self.looks[index].outer is None:
            self.unknown.popleft()
        self.places[index] = None
        self.halved.add(index)
        for half in self.halve(box, axis):
            self.add(half)
        return True

    def result(self) -> SearchResult:
        if self.unknown:
            raise self._no_bound(self.unknown[0])
        self._clean()
        if self.attained is None:
            raise ModelError("the function has no finite value at any sample; bound it by hand")
        outer = self.by_lower[0][0], -self.by_upper[0][0]
        return SearchResult(outer, self.attained, len(self.looks) - len(self.halved))

    def _no_bound(self, index: int) -> NoBound:
        box = self.places[index]
        where = "" if box is None else self.tell(box)
        return NoBound(
            f"no finite bound near {where}: the function seems to have a pole there; shrink "
            "the box, make what is singular inside another function a premise of its own, or give "
            "the bounds yourself"
        )


IntervalBox: TypeAlias = tuple[Interval, ...]
Enclose: TypeAlias = Callable[[IntervalBox], Interval | None]
Changes: TypeAlias = Callable[[IntervalBox], Sequence[float]]


@dataclass(frozen=True, slots=True)
class Range:
    """Outer and inner bounds of the set {f(x) : x in the boxes}.

    Attributes
    ----------
    outer : contains every value of f.
    inner : reaches from one attained value to another; the excess of outer is due to stopping
        early.
    boxes : number of boxes whose enclosures prove ``outer``.
    words : how the bounds were proved, e.g. ``"ball arithmetic, 12 boxes"``.
    """

    outer: Interval
    inner: Interval
    boxes: int
    words: str = ""


def range_over(
    enclose: Enclose,
    boxes: Sequence[IntervalBox],
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
    corners = [
        tuple(Interval(getattr(side, end), getattr(side, end)) for side in box)
        for box in boxes
        for end in ("lower", "upper")
    ]
    result = search(
        partial(_bounded, enclose, changes or partial(_shares, boxes[0])),
        _halves,
        boxes,
        tolerance=tolerance,
        most_boxes=most_boxes,
        tell=lambda box: ", ".join(str(side) for side in box),
        attained=_attained(enclose, corners),
    )
    return Range(Interval(*result.outer), Interval(*result.attained), result.boxes)


def _bounded(enclose: Enclose, changes: Changes, box: IntervalBox) -> Bounded:
    attained = _attained(enclose, [tuple(Interval(side.centre, side.centre) for side in box)])
    outer = enclose(box)
    size = changes(box)
    axis = max(range(len(box)), key=lambda index: (size[index], box[index].width), default=None)
    if axis is not None and box[axis].width == 0:
        axis = None
    return Bounded(None if outer is None else (outer.lower, outer.upper), attained, axis)


def _halves(box: IntervalBox, axis: int) -> tuple[IntervalBox, IntervalBox]:
    middle = box[axis].centre
    half_sides = Interval(box[axis].lower, middle), Interval(middle, box[axis].upper)
    first, second = ((*box[:axis], half_side, *box[axis + 1 :]) for half_side in half_sides)
    return first, second


def _attained(enclose: Enclose, points: Sequence[IntervalBox]) -> Ends | None:
    """Return the ends of values at points, each on the cautious side of its own enclosure."""
    values = [value for point in points if (value := enclose(point)) is not None]
    return (min(v.upper for v in values), max(v.lower for v in values)) if values else None


def _shares(root: IntervalBox, box: IntervalBox) -> list[float]:
    """Return each side's width as a share of the whole's."""
    return [float(b.width / w.width) if w.width else 0.0 for b, w in zip(box, root, strict=True)]
