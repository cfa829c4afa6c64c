"""The candidate of a claim of kind ``running-rate``: ranges of winds in which the wind may move.

First each cell gets a box and the largest rate of the wind, by steps, for which the set of a
quadratic function fits the box; with ``cuts`` also in pieces of the schedule wind's range.
Then each end of a cell gets the function that serves the cells on both sides, and each cell the
largest rate that holds with the functions at its ends.  Where a cell has no function, or a rate
below ``LEAST_RATE``, there is a gap.  Last, gaps are filled where that is found (``bridges``), with
the rates of the cells beside them as they are.  The wind of the claim stays on one side of a gap
that remains.
Nothing is proved here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from fractions import Fraction
from itertools import pairwise
from typing import Any

from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.running_loop.carried import carried_failures
from takagi.certificates.checker.turbine.running_loop.cell import Cell
from takagi.certificates.checker.turbine.running_loop.inputs import Sides, Span
from takagi.certificates.checker.turbine.running_loop.moving_claim import (
    Kept,
    MovingCell,
    examined,
)
from takagi.certificates.checker.turbine.running_loop.signals import Rows
from takagi.certificates.claims.turbine.running_loop.bridges import apart, bridged, gaps, own_cells
from takagi.certificates.claims.turbine.running_loop.candidate import Subject, box_of_size
from takagi.certificates.claims.turbine.running_loop.entered_cells import moves_to_enter, with_room
from takagi.certificates.claims.turbine.running_loop.moving_cell import (
    Cuts,
    Fitted,
    Moves,
    enlarged,
    fitted,
    function_at,
    refitted,
    stated_cell,
)
from takagi.certificates.claims.turbine.running_loop.running_loop_claim import (
    PLACES,
    claim_head,
    joined,
    loop_subject,
)

# Rates of the wind [m/s^2]: the first that is tried, the least that is claimed, and the step.
FIRST_RATE, LEAST_RATE, STEP = 0.002, 1e-3, 1.3
# The first box, as a fraction of the largest of the claim at constant winds.
FIRST_BOX = Fraction(1, 10)
# A cell is halved where that allows a larger rate, down to these widths [m/s]: the second where
# the rate is small.
WIDE, NARROW, SMALL_RATE = Fraction(1, 5), Fraction(1, 25), 2e-3
# The most by which the rate changes with the wind [m/s^2 per m/s]: a set grows about as the rate,
# and while the wind moves it can shrink only as fast as motions decay.
STEEPEST = 0.006
# Rounds of functions at the ends and boxes that hold their sets.
ROUNDS = 2
# Shares of a cell's rate that are tried with the functions at its ends.
SHARES = (1.3, 1.15, 1.0, 0.85, 0.7, 0.55, 0.4, 0.28)


def running_rate_claim(
    model: Mapping[str, Any],
    gains: Mapping[str, Any],
    controller: Mapping[str, Any],
    inertia: Sequence[float],
    within: Span | None = None,
    cuts: Cuts = (),
) -> dict[str, Any]:
    """Return the claim as plain data.

    Parameters
    ----------
    model, gains, controller, inertia : as ``running_loop_claim`` takes them.
    within : only intervals of the law's tables inside these winds [m/s]; all unless given.
    cuts : where the side "schedule" of a cell's box is divided, as shares of it from -1 to 1, if
        the cell bears a larger rate so.

    Raises
    ------
    Refused : the law has no filter of the measured speed or of the wind, or no cell was found.
    """
    head = claim_head(model, gains, controller, inertia)
    subject = loop_subject(model, gains, head)
    cells = [
        cell
        for part in runs(graded(subject, fitted_cells(subject, within, cuts)))
        for cell in _proved(subject, part)
    ]
    cells = caught_up(subject, cells)
    if not cells:
        raise Refused("no quadratic function was found in moving wind")
    nodes = subject.law.wind
    cells = without_gaps(subject, cells, within or (nodes[0], nodes[-1]))
    del head["decay_rate"]
    return {
        "name": f"running loop in moving wind, {float(nodes[0]):g} to {float(nodes[-1]):g} m/s",
        **head,
        "kind": "running-rate",
        **stated_cells(cells),
    }


def stated_cells(cells: Sequence[MovingCell]) -> dict[str, Any]:
    """Return the members ``winds``, ``functions`` and ``cells`` as plain data."""
    functions = {v: P for cell in cells for v, P in zip(cell.winds, cell.ends, strict=True)}
    return {
        "winds": [_row(pair) for pair in joined(cells)],
        "functions": [
            {"wind": float(v), "P": [_row(row) for row in functions[v]]} for v in sorted(functions)
        ],
        "cells": [_data(cell) for cell in cells],
    }


def fitted_cells(subject: Subject, within: Span | None = None, cuts: Cuts = ()) -> list[Fitted]:
    """Return cells with box and rate, in the order of their winds."""
    found: list[Fitted] = []
    for low, high in pairwise(subject.law.wind):
        if within is None or within[0] <= low < high <= within[1]:
            found += _cells(subject, (low, high), found[-1] if found else None, cuts)
    return found


def _cells(subject: Subject, winds: Span, before: Fitted | None, cuts: Cuts) -> Iterator[Fitted]:
    """Yield the cells of a range; ``before`` is the last cell below it."""
    low, high = winds
    found = _fastest(subject, winds, before, cuts)
    middle = Fraction(round((low + high) / 2 * PLACES), PLACES)
    slow = found is None or found.rate < SMALL_RATE
    if high - low > (NARROW if slow else WIDE) * 3 / 2:
        start = found or before
        half = _fastest(subject, (low, middle), start, cuts)
        if half is not None and (found is None or half.rate > found.rate * 1.1):
            for part in ((low, middle), (middle, high)):
                for cell in _cells(subject, part, half, cuts):
                    half = cell
                    yield cell
            return
        if half is None and found is None and high - low > 3 * NARROW:
            yield from _cells(subject, (low, middle), before, cuts)
            yield from _cells(subject, (middle, high), before, cuts)
            return
    if found is not None:
        yield found


def _fastest(subject: Subject, winds: Span, before: Fitted | None, cuts: Cuts) -> Fitted | None:
    """Return the cell with the largest rate that is found, by steps from its neighbour's."""
    if before is None:
        rate, sides = FIRST_RATE, box_of_size(subject, FIRST_BOX)
    else:
        rate, sides = before.rate, before.sides
    found, _ = fitted(subject, winds, rate, sides)
    while found is None and rate > LEAST_RATE:
        rate, sides = rate / STEP**2, enlarged(subject, sides, 1 / STEP**2)
        found, _ = fitted(subject, winds, rate, sides)
    while found is not None:
        larger, _ = fitted(subject, winds, found.rate * STEP, enlarged(subject, found.sides, STEP))
        if larger is None:
            break
        found = larger
    if found is None or found.rate < LEAST_RATE:
        return None
    while cuts:
        sides = enlarged(subject, found.sides, STEP)
        larger, _ = fitted(subject, winds, found.rate * STEP, sides, cuts)
        if larger is None:
            break
        found = larger
    return found


def graded(subject: Subject, cells: Sequence[Fitted]) -> list[Fitted]:
    """Return the cells with rates that change slowly with the wind, and boxes for these rates."""
    found = []
    for cell in cells:
        low, high = cell.winds
        near = [
            other.rate
            + STEEPEST * float(max(other.winds[0] - high, low - other.winds[1], Fraction(0)))
            for other in cells
        ]
        rate = min(near)
        box = enlarged(subject, cell.sides, max(rate / cell.rate, 0.3))
        at, _ = fitted(subject, cell.winds, rate, box)
        if at is None and cell.cuts:
            at, _ = fitted(subject, cell.winds, rate, box, cell.cuts)
        if at is not None:
            found.append(at)
    return found


def runs(cells: Sequence[Fitted]) -> list[list[Fitted]]:
    """Return the cells by ranges without a gap."""
    found: list[list[Fitted]] = []
    for cell in cells:
        if found and found[-1][-1].winds[1] == cell.winds[0]:
            found[-1].append(cell)
        else:
            found.append([cell])
    return found


def _proved(subject: Subject, cells: Sequence[Fitted]) -> Iterator[MovingCell]:
    """Yield the cells of one range that hold with the functions at their ends."""
    ends: list[Rows | None] = []
    for _ in range(ROUNDS):
        ends = [
            function_at(subject, cells[max(i - 1, 0) : i + 1])[0] for i in range(len(cells) + 1)
        ]
        cells = [
            cell if low is None or high is None else refitted(subject, cell, (low, high))
            for cell, low, high in zip(cells, ends, ends[1:], strict=False)
        ]
    for cell, low, high in zip(cells, ends, ends[1:], strict=False):
        if low is not None and high is not None:
            rates = [share * cell.rate for share in SHARES]
            found, _ = stated_cell(subject, cell, (low, high), rates)
            if found is not None:
                yield found


def caught_up(subject: Subject, cells: Sequence[MovingCell]) -> list[MovingCell]:
    """Return the cells that may be entered from their neighbours, as the checker decides it."""
    given = subject.plant, subject.law, subject.machine
    found = [(one, kept) for one in cells if isinstance(kept := examined(*given, one), Kept)]
    while True:
        winds = joined([one for one, _ in found])
        lag = {
            ends
            for low, high in winds
            for ends, _ in carried_failures(
                [kept.passed for _, kept in found if low <= kept.winds[0] and kept.winds[1] <= high]
            )
        }
        if not lag:
            return [one for one, _ in found]
        found = [(one, kept) for one, kept in found if one.winds not in lag]


def without_gaps(subject: Subject, cells: list[MovingCell], within: Span) -> list[MovingCell]:
    """Return the cells with every gap filled for which that is found, as far as ``within``.

    A range that becomes longer needs more room where its cells are entered.
    """
    nodes = [v for v in subject.law.wind if within[0] <= v <= within[1]]
    # From the top: a filled gap may leave out a cell below it.
    while left := [gap for gap in gaps(cells, (nodes[0], nodes[-1])) if gap[1] <= within[1]]:
        gap = left[-1]
        within = (within[0], gap[0])
        beside = [float(one.wind_rate) for one in cells if set(one.winds) & set(gap)]
        own = own_cells(subject, gap, max(beside))
        filled = bridged(subject, cells, own, _moves(subject, cells, own)) if own else None
        roomy = with_room(subject, filled) if filled else None
        cells = roomy or apart(subject, cells, own) or cells
    return cells


def _moves(
    subject: Subject, cells: Sequence[MovingCell], own: Sequence[Fitted]
) -> dict[Span, Moves]:
    """Return the room that each cell needs if all of these are found, by its winds."""
    given = subject.plant, subject.law, subject.machine
    proved = [Cell(*given, one.winds, one.sides) for one in cells]
    posed = sorted(
        [*proved, *(Cell(*given, one.winds, one.sides) for one in own)], key=lambda one: one.winds
    )
    found: dict[Span, Moves] = {}
    for low, high in joined(posed):
        run = [one for one in posed if low <= one.winds[0] and one.winds[1] <= high]
        # A cell of a gap has a wider box by itself than it will have.
        needs = moves_to_enter(run, [one for one in run if one in proved])
        found |= dict(zip([one.winds for one in run], needs or [{}] * len(run), strict=True))
    return found


def _data(cell: MovingCell) -> dict[str, Any]:
    """Return a cell as plain data, with floats that print as the short decimals of the cell."""
    return {
        "wind": _row(cell.winds),
        **({"schedule_cuts": _row(cell.cuts)} if cell.cuts else {}),
        "wind_rate": float(cell.wind_rate),
        "decay_rate": float(cell.decay),
        "residual_share": float(cell.residual_share),
        "sides": {one.name: float(getattr(cell.sides, one.name)) for one in fields(Sides)},
        "multipliers": [
            {name: _row(pair) for name, pair in piece.items()} for piece in cell.multipliers
        ],
    }


def _row(values: Any) -> list[float]:
    return [float(value) for value in values]
