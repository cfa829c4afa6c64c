"""Boxes with the room that a cell needs to be entered from the others of its range.

The gain file's rate limits hold torque and pitch back for a while where the wind enters a cell
with another feed-forward or lead (``checker...carried``).  The set of a cell must leave so much
room in its box that the law was in the cell's ranges all that time.  Where two ranges without a gap
become one, more is needed than the search for each has left: the box is widened, and the functions
stay.
Nothing is proved here.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from math import sqrt

from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.running_loop import carried, limits, moving_claim
from takagi.certificates.checker.turbine.running_loop.cell import Cell, size
from takagi.certificates.claims.turbine.running_loop.candidate import Subject
from takagi.certificates.claims.turbine.running_loop.cell_chain import Asked, held
from takagi.certificates.claims.turbine.running_loop.moving_cell import (
    Moves,
    as_fitted,
    stated_cell,
    with_moves,
)
from takagi.certificates.claims.turbine.running_loop.running_loop_claim import joined

# Rounds of boxes, which change what is needed.
ROUNDS = 4
# Shares of its rate of the wind that a proved cell keeps, and how many cells on each side of one
# get new functions with it.
KEPT, BESIDE = (1.0, 0.985, 0.97), 2


def moves_to_enter(
    cells: Sequence[Cell], boxed: Sequence[Cell] | None = None
) -> list[Moves] | None:
    """Return of each cell of a range without a gap the room that its bounds need, by side.

    ``None`` where a command may move as fast as its limit: no room is enough then.

    Parameters
    ----------
    boxed : the cells whose boxes decide how fast all moves; all of them unless given.
    """
    boxed = boxed or cells
    law, machine, limit = cells[0].law, cells[0].machine, cells[0].plant.rate_limit
    ranges = [carried.Passed(cell, ((), ())).ranges for cell in cells]
    whole = [
        (min(both[i][0] for both in ranges), max(both[i][1] for both in ranges)) for i in (0, 1)
    ]
    moved = [limits.motion(cell) for cell in boxed]
    rates = {
        "schedule": max(one.schedule for one in moved),
        "effort": max(one.effort for one in moved),
        "signal": max(one.signal for one in moved),
    }
    fastest = [limits.command_rates(cell, *map(size, whole)) for cell in boxed]
    found: list[Moves] = []
    for own in ranges:
        moves: Moves = {}
        for i, most in enumerate((machine.torque_rate, limit)):
            spare = most - max(both[i] for both in fastest)
            beyond = max(whole[i][1] - own[i][1], own[i][0] - whole[i][0])
            left = beyond * rates["schedule"] * (law.effort_torque if i == 0 else 1)
            if left > 0 and spare <= 0:
                return None
            for name in carried.DECIDING[i] if left > 0 else ():
                moves[name] = max(float(left / spare * rates[name]), moves.get(name, 0.0))
        found.append(moves)
    return found


def with_room(
    subject: Subject, cells: Sequence[moving_claim.MovingCell]
) -> list[moving_claim.MovingCell] | None:
    """Return the cells in boxes that have the room, or None where a cell does not hold so.

    One cell at the end of a range may be left out instead.
    """
    found, left_out = list(cells), 0
    for _ in range(ROUNDS):
        narrow = _narrow(subject, found)
        if narrow is None:
            return None
        if not narrow:
            return found
        for i, moves in narrow.items():
            wider = _widened(subject, found[i], moves)
            if wider is not None:
                found[i] = wider
                continue
            again = _again(subject, found, i, narrow)
            if again is None:
                if left_out or _is_inside(found, i):
                    return None
                left_out += 1
                del found[i]
                break
            found = again
    return None


def _is_inside(cells: Sequence[moving_claim.MovingCell], i: int) -> bool:
    """Return whether a cell has another on both sides."""
    others = {v for k, cell in enumerate(cells) if k != i for v in cell.winds}
    return set(cells[i].winds) <= others


def _narrow(subject: Subject, cells: Sequence[moving_claim.MovingCell]) -> dict[int, Moves] | None:
    """Return the cells that have too little room, and what they need."""
    found: dict[int, Moves] = {}
    kept = [
        moving_claim.examined(subject.plant, subject.law, subject.machine, one) for one in cells
    ]
    for low, high in joined(cells):
        run = {
            i: one.passed
            for i, one in enumerate(kept)
            if isinstance(one, moving_claim.Kept) and low <= one.winds[0] and one.winds[1] <= high
        }
        moves = moves_to_enter([one.cell for one in run.values()])
        if moves is None:
            return None
        for k, (i, one) in enumerate(run.items()):
            rooms = [*one.rooms[0]] * (k > 0) + [*one.rooms[1]] * (k < len(run) - 1)
            if any(
                sqrt(square) + move >= bound
                for name, move in moves[k].items()
                for square, bound in (room[name] for room in rooms)
            ):
                found[i] = moves[k]
    return found


def _widened(
    subject: Subject, stated: moving_claim.MovingCell, moves: Moves
) -> moving_claim.MovingCell | None:
    """Return the cell with its functions and the room, or None."""
    at = as_fitted(stated)
    try:
        sides = with_moves(subject, at.winds, at.sides, stated.ends, moves)
    except Refused:
        return None
    rates = [share * at.rate for share in KEPT]
    return stated_cell(subject, replace(at, sides=sides), stated.ends, rates)[0]


def _again(
    subject: Subject, cells: Sequence[moving_claim.MovingCell], i: int, moves: Mapping[int, Moves]
) -> list[moving_claim.MovingCell] | None:
    """Return the cells with new functions at the ends of one and of its neighbours, or None."""
    low, high = i, i + 1
    while low > max(0, i - BESIDE) and cells[low - 1].winds[1] == cells[low].winds[0]:
        low -= 1
    while (
        high < min(len(cells), i + 1 + BESIDE) and cells[high - 1].winds[1] == cells[high].winds[0]
    ):
        high += 1
    rest = [*cells[:low], *cells[high:]]
    shared = {v for cell in rest for v in cell.winds}
    part = cells[low:high]
    first = {v: P for cell in part for v, P in zip(cell.winds, cell.ends, strict=True)}
    asked = [
        Asked(as_fitted(one), float(one.decay), KEPT, moves.get(k, {}))
        for k, one in enumerate(part, start=low)
    ]
    found = held(subject, asked, first, {v: P for v, P in first.items() if v in shared})
    return None if found is None else [*cells[:low], *found, *cells[high:]]
