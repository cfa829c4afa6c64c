"""Cells in the gaps between proved cells: with functions that suit both, sought jointly.

A gap is filled with cells of its own, found more patiently than elsewhere: from first boxes of
several sizes and shapes, and with a slower ``Pace``.  Then the functions at the ends of these cells
and of some proved neighbours are sought at once (``joint_program``).  The neighbours keep their
rates of the wind, but for the share ``KEPT``: else the gap stays.
Nothing is proved here.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise

from takagi.certificates.checker.turbine.running_loop.inputs import Span
from takagi.certificates.checker.turbine.running_loop.moving_claim import MovingCell
from takagi.certificates.claims.turbine.running_loop.candidate import Subject, box_of_size
from takagi.certificates.claims.turbine.running_loop.cell_chain import Asked, held
from takagi.certificates.claims.turbine.running_loop.moving_cell import (
    SLOW,
    USUAL,
    Fitted,
    Moves,
    Pace,
    as_fitted,
    enlarged,
    fitted,
    function_at,
)
from takagi.certificates.claims.turbine.running_loop.running_loop_claim import PLACES

# The first boxes, as fractions of the largest of the claim at constant winds, and shares of their
# side "schedule": at a corner of the reference speed a box of the usual shape is narrower than the
# ranges that it has to hold.
FIRST_BOXES = (Fraction(1, 10), Fraction(1, 20), Fraction(1, 40), Fraction(1, 80))
SHORTER = (Fraction(1), Fraction(1, 2), Fraction(1, 4))
# Rates of the wind [m/s^2]: the first that is tried, the least, and the step; then the least width
# of a cell [m/s].
FIRST_RATE, LEAST_RATE, STEP, NARROW = 1e-3, 7e-4, 1.3, Fraction(1, 25)
# The most by which the rate changes with the wind [m/s^2 per m/s], between the middles of cells.
STEEPEST = 0.006
# How many proved cells on each side get new functions at their inner ends.
NEIGHBOURS = (2, 4)
# Shares of a rate: that all cells of the gap are tried with, that a cell is stated with when the
# functions are known, and that a proved neighbour keeps.
SCALES, STATED, KEPT = (1.0, 0.65), (1.15, 1.0, 0.9, 0.8, 0.65, 0.5), (1.15, 1.0, 0.985, 0.97)
# alpha that is asked for in the gap [1/s].
DECAY = 0.012


def gaps(cells: Sequence[MovingCell], within: Span) -> list[Span]:
    """Return the winds between ``within`` that no cell covers."""
    ends = [within[0], *(v for cell in cells for v in cell.winds), within[1]]
    return [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if a < b]


def bridged(
    subject: Subject,
    cells: Sequence[MovingCell],
    own: Sequence[Fitted],
    moves: Mapping[Span, Moves],
) -> list[MovingCell] | None:
    """Return the cells with a gap filled, or None.

    Parameters
    ----------
    own : cells that cover the gap, each by itself.
    moves : the room that each cell needs to be entered, by its winds.
    """
    below = [cell for cell in cells if cell.winds[1] <= own[0].winds[0]]
    above = [cell for cell in cells if cell.winds[0] >= own[-1].winds[1]]
    for scale in SCALES:
        for count in NEIGHBOURS:
            left, right = _chained(below[::-1], count)[::-1], _chained(above, count)
            rest = below[: len(below) - len(left)], above[len(right) :]
            shared = {v for part in rest for cell in part for v in cell.winds}
            graded = _graded(own, left, right, scale)
            filled = _joined(subject, left, graded, right, shared, moves)
            if filled is not None:
                return [*rest[0], *filled, *rest[1]]
    return None


def apart(
    subject: Subject, cells: Sequence[MovingCell], own: Sequence[Fitted]
) -> list[MovingCell] | None:
    """Return the cells with those of a gap that touch no other cell, as one more range, or None.

    It is for a gap that is not filled, as the longer range would need more room than there is.
    """
    taken = {v for cell in cells for v in cell.winds}
    own = [one for one in own if not taken & {*one.winds}]
    for scale in SCALES if own else ():
        filled = _joined(subject, [], _graded(own, [], [], scale), [], (), {})
        if filled is not None:
            return sorted([*cells, *filled], key=lambda one: one.winds)
    return None


def _chained(cells: Sequence[MovingCell], count: int) -> list[MovingCell]:
    """Return at most so many of the first cells, without a gap between them and without pieces."""
    found = list(cells[:1])
    for one, other in pairwise(cells[:count]):
        if not {*one.winds} & {*other.winds}:
            break
        found.append(other)
    return found


def own_cells(subject: Subject, gap: Span, enough: float) -> list[Fitted]:
    """Return cells that cover the gap, each by itself, or nothing.

    Parameters
    ----------
    enough : no cell is halved for a larger rate than this [m/s^2].
    """
    nodes = [v for v in subject.law.wind if gap[0] < v < gap[1]]
    found: list[Fitted] = []
    for winds in pairwise([gap[0], *nodes, gap[1]]):
        part = _parts(subject, winds, found[-1] if found else None, enough)
        if part is None:
            return []
        found += part
    return found


def _parts(
    subject: Subject, winds: Span, before: Fitted | None, enough: float
) -> list[Fitted] | None:
    """Return the cells of winds within one interval of the tables, or None where one is missing."""
    low, high = winds
    found = _fastest(subject, winds, before)
    if high - low > NARROW * 3 / 2 and (found is None or found.rate < enough):
        middle = Fraction(round((low + high) / 2 * PLACES), PLACES)
        half = _fastest(subject, (low, middle), found or before)
        if found is None or (half is not None and half.rate > found.rate * 1.1):
            first = None if half is None else _parts(subject, (low, middle), half, enough)
            second = None if first is None else _parts(subject, (middle, high), first[-1], enough)
            return None if first is None or second is None else first + second
    return None if found is None else [found]


def _fastest(subject: Subject, winds: Span, before: Fitted | None) -> Fitted | None:
    """Return the cell with the largest rate that is found, by steps."""
    found = next(filter(None, _first_cells(subject, winds, before)), None)
    while found is not None:
        sides = enlarged(subject, found.sides, STEP)
        larger, _ = fitted(subject, winds, found.rate * STEP, sides, (), found.pace)
        if larger is None:
            break
        found = larger
    return found


def _first_cells(subject: Subject, winds: Span, before: Fitted | None) -> Iterator[Fitted | None]:
    """Yield what is found from one box after another, first from the neighbour's."""
    paces: tuple[Pace, ...] = (USUAL, SLOW)
    if before is not None:
        for slower in (1.0, STEP**2):
            sides = enlarged(subject, before.sides, 1 / slower)
            for pace in paces:
                yield fitted(subject, winds, before.rate / slower, sides, (), pace)[0]
    rate = FIRST_RATE
    while rate >= LEAST_RATE:
        for pace in paces:
            for size in FIRST_BOXES:
                usual = box_of_size(subject, size)
                for share in SHORTER:
                    sides = replace(usual, schedule=share * usual.schedule)
                    yield fitted(subject, winds, rate, sides, (), pace)[0]
        rate /= STEP


def _graded(
    own: Sequence[Fitted], left: Sequence[MovingCell], right: Sequence[MovingCell], scale: float
) -> list[Fitted]:
    """Return the cells of the gap with rates that change slowly with the wind."""
    near = [(_middle(one.winds), float(one.wind_rate)) for one in (*left, *right)]
    near += [(_middle(one.winds), one.rate) for one in own]
    return [
        replace(one, rate=scale * min(r + STEEPEST * abs(v - _middle(one.winds)) for v, r in near))
        for one in own
    ]


def _middle(winds: Span) -> float:
    return float(winds[0] + winds[1]) / 2


def _joined(
    subject: Subject,
    left: Sequence[MovingCell],
    own: Sequence[Fitted],
    right: Sequence[MovingCell],
    shared: Collection[Fraction],
    moves: Mapping[Span, Moves],
) -> list[MovingCell] | None:
    """Return the cells with functions that serve them all, or None.

    Parameters
    ----------
    left, right : the proved neighbours.
    shared : winds of other cells, whose functions stay.
    moves : the room that each cell needs, by its winds.
    """
    known = {v: P for cell in (*left, *right) for v, P in zip(cell.winds, cell.ends, strict=True)}
    ends = dict(known)
    for one, other in pairwise(own):
        if (found := function_at(subject, [one, other])[0]) is None:
            return None
        ends[one.winds[1]] = found
    for one, wind in ((own[0], own[0].winds[0]), (own[-1], own[-1].winds[1])):
        if wind not in ends:
            if (found := function_at(subject, [one])[0]) is None:
                return None
            ends[wind] = found
    asked = [
        *_kept(left, moves),
        *(Asked(one, DECAY, STATED, moves.get(one.winds, {})) for one in own),
        *_kept(right, moves),
    ]
    return held(subject, asked, ends, {v: P for v, P in known.items() if v in shared})


def _kept(cells: Sequence[MovingCell], moves: Mapping[Span, Moves]) -> list[Asked]:
    """Return what is asked of proved neighbours: their own decay, and nearly their rates."""
    return [
        Asked(as_fitted(one), float(one.decay), KEPT, moves.get(one.winds, {})) for one in cells
    ]
