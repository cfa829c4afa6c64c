"""Best-first bisection of boxes, whatever a box is and however it is enclosed."""

from __future__ import annotations

import heapq
from collections import deque
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

from takagi.models.errors import ModelError

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
    method : letter of the enclosure that was used.
    rough : ends by a cheaper enclosure, with its letter; for the evidence.
    """

    outer: Ends | None
    attained: Ends | None
    axis: int | None
    method: str = ""
    rough: tuple[Ends, str] | None = None


class SearchResult(NamedTuple):
    """Result of a search: ``outer`` and ``attained`` ends, boxes, and one tree for each root.

    A tree is written in preorder: the number of the halved side, then lower and upper half; or
    the letter of the method that encloses f on the leaf.  Sides are numbered "0123...9AB...Z".
    """

    outer: Ends
    attained: Ends
    boxes: int
    trees: tuple[str, ...]


SIDES = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZ"


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
    return tree.found(len(roots))


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
        self.halves: dict[int, tuple[int, int]] = {}
        self.unknown: deque[int] = deque()
        self.by_lower: list[tuple[Any, int]] = []
        self.by_upper: list[tuple[Any, int]] = []
        self.attained: Ends | None = None

    def add(self, box: Box) -> int:
        index = len(self.looks)
        self.places.append(box)
        self.looks.append(self.look(box))
        self._enter(index)
        return index

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
                if index not in self.halves and outer is not None and key == sign * outer[end]:
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
        first, second = self.halve(box, axis)
        self.places[index] = None
        self.halves[index] = self.add(first), self.add(second)
        return True

    def found(self, roots: int) -> SearchResult:
        if self.unknown:
            raise self._no_bound(self.unknown[0])
        self._clean()
        if self.attained is None:
            raise ModelError("the function has no finite value at any sample; bound it by hand")
        outer = self.by_lower[0][0], -self.by_upper[0][0]
        boxes = len(self.looks) - len(self.halves)
        return SearchResult(
            outer, self.attained, boxes, tuple(self._text(i, outer) for i in range(roots))
        )

    def _no_bound(self, index: int) -> NoBound:
        box = self.places[index]
        where = "" if box is None else self.tell(box)
        return NoBound(
            f"no finite bound near {where}: the function seems to have a pole there; shrink "
            "the box, make what is singular inside another function a premise of its own, or give "
            "the bounds yourself"
        )

    def _text(self, root: int, outer: Ends) -> str:
        letters, waiting = [], [root]
        while waiting:
            index = waiting.pop()
            bounds = self.looks[index]
            if index in self.halves:
                letters.append(SIDES[bounds.axis or 0])
                waiting += reversed(self.halves[index])
            elif bounds.rough and outer[0] <= bounds.rough[0][0] and bounds.rough[0][1] <= outer[1]:
                letters.append(bounds.rough[1])
            else:
                letters.append(bounds.method)
        return "".join(letters)
