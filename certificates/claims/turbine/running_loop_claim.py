"""The candidate of a claim of kind ``running-loop``: cells over all winds of the law's tables.

Each interval of the tables is one cell, with the largest box for which a function is found.  Where
none is found, or where the box is small and the halves have larger boxes, the interval is halved,
down to a least width.  A part without a function is a gap: the claim does not cover it, and its
sentence names it.
Nothing is proved here.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields
from fractions import Fraction
from itertools import pairwise
from typing import Any

from takagi.certificates.checker.kernel.reader import read_text
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.rotor import Plant
from takagi.certificates.checker.turbine.running_loop.inputs import STATED, Machine, Sides, Span
from takagi.certificates.checker.turbine.running_loop.running_claim import StatedCell
from takagi.certificates.claims.turbine.running_candidate import (
    SIZES,
    Subject,
    running_candidate,
    size_of_box,
)
from takagi.models.errors import ModelError

# The required decay rate [1/s], and the wake's length over the rotor's radius: 40 to 80 m for a
# radius of 63 m.
DECAY, WAKE = 0.004, (0.635, 1.27)
# The least width of a cell if no function is found, and if the box is small [m/s]; a box is small
# below this share of the largest one.
LEAST_WIDTH, LEAST_SMALL_WIDTH, SMALL_SIZE = Fraction(1, 250), Fraction(1, 80), Fraction(1, 10)
WIND_DENOMINATOR = 10_000


def running_loop_claim(
    model: Mapping[str, Any],
    gains: Mapping[str, Any],
    controller: Mapping[str, Any],
    inertia: Sequence[float],
) -> dict[str, Any]:
    """Return the claim as plain data.

    Parameters
    ----------
    model, gains : as the certificate states them.
    controller : the gain file's members ``observer`` and ``measurement``; others are not used.
    inertia : true over nominal, from the least to the greatest.

    Raises
    ------
    Refused : the law has no filter of the measured speed or of the wind, or no cell was found.
    ModelError : the controller's observer or filters are no objects.
    """
    radius = float(model["rotor_radius"])
    wake_length = [float(f"{share * radius:.2g}") for share in WAKE]
    head = {
        "kind": "running-loop",
        "decay_rate": DECAY,
        "uncertainty": {"inertia": list(inertia), "wake_length": wake_length},
        **_stated_controller(controller, gains),
    }
    subject = loop_subject(model, gains, head)
    cells = list(cells_over_winds(subject))
    if not cells:
        raise Refused("no quadratic function was found at any wind")
    winds = _joined(cells)
    nodes = subject.law.wind
    return {
        "name": f"running loop, {float(nodes[0]):g} to {float(nodes[-1]):g} m/s",
        **head,
        "winds": [_row(pair) for pair in winds],
        "cells": [_data(cell) for cell in cells],
    }


def _stated_controller(
    controller: Mapping[str, Any], gains: Mapping[str, Any]
) -> dict[str, dict[str, Any]]:
    """Return the numbers of observer and filters that a claim repeats from the gain file.

    Raises
    ------
    Refused : one of them is missing, or the law has no filter of the wind estimate.
    ModelError : one of them is no object.
    """
    if any(key not in controller for key in STATED):
        raise Refused("the gain file has no observer, or no low-pass on the measured speed")
    for key, names in STATED.items():
        if not isinstance(controller[key], Mapping):
            raise ModelError(
                f"controller[{key!r}] is {controller[key]!r}; an object with "
                f"{', '.join(names)} is needed, as gains.json has it: give that one, or "
                "leave the member out for a law without it"
            )
    if not gains["wind_filter"] > 0:
        raise Refused("the law has no filter of the wind estimate")
    return {
        key: {name: controller[key][name] for name in names if name in controller[key]}
        for key, names in STATED.items()
    }


def loop_subject(
    model: Mapping[str, Any], gains: Mapping[str, Any], claim: Mapping[str, Any]
) -> Subject:
    """Return turbine, law and machine as the checker reads them; ``claim`` needs no cells."""
    data = read_text(json.dumps({"model": model, "gains": gains, "claim": claim}), "candidate")
    machine = Machine.read(data["claim"], data["model"], data["gains"], "claim")
    plant, law = Plant.read(data["model"]), Law.read(data["gains"])
    return Subject(plant, law, machine, Fraction(str(claim["decay_rate"])))


def cells_over_winds(subject: Subject) -> Iterator[StatedCell]:
    """Yield the cells, in the order of their winds."""
    hint = 0
    for winds in pairwise(subject.law.wind):
        for cell in _cells(subject, winds, hint):
            hint = _place(cell)
            yield cell


def _cells(subject: Subject, winds: Span, hint: int) -> Iterator[StatedCell]:
    """Yield the cells of one interval; ``hint`` is the place of the last cell's size."""
    cell_of_interval = _largest(subject, winds, hint)
    low, high = winds
    middle = Fraction(round((low + high) / 2 * WIND_DENOMINATOR), WIND_DENOMINATOR)
    halves = ((low, middle), (middle, high))
    if cell_of_interval is not None and not _is_small(subject, cell_of_interval, halves):
        yield cell_of_interval
    elif high - low >= 2 * LEAST_WIDTH:
        for half in halves:
            for cell in _cells(subject, half, hint):
                hint = _place(cell)
                yield cell


def _largest(subject: Subject, winds: Span, hint: int) -> StatedCell | None:
    """Return the cell with the largest box, or None; sizes change slowly over wind."""
    best, _ = running_candidate(subject, winds, sizes=SIZES[hint:])
    index = hint if best is None else _place(best)
    while best is not None and 0 < index <= hint:
        larger, _ = running_candidate(subject, winds, sizes=SIZES[index - 1 : index])
        if larger is None:
            break
        best, index = larger, index - 1
    return best


def _is_small(subject: Subject, cell: StatedCell, halves: tuple[Span, Span]) -> bool:
    """Return whether a box is small, and narrower cells would have a larger one."""
    index = _place(cell)
    if SIZES[index] >= SMALL_SIZE or halves[0][1] - halves[0][0] < LEAST_SMALL_WIDTH or index == 0:
        return False
    larger = SIZES[index - 1 : index]
    return any(running_candidate(subject, half, sizes=larger)[0] is not None for half in halves)


def _place(cell: StatedCell) -> int:
    return SIZES.index(size_of_box(cell.sides))


def _joined(cells: Sequence[StatedCell]) -> list[Span]:
    """Return the ranges of winds that cells cover."""
    joined: list[Span] = []
    for low, high in (cell.winds for cell in cells):
        if joined and joined[-1][1] == low:
            joined[-1] = (joined[-1][0], high)
        else:
            joined.append((low, high))
    return joined


def _data(cell: StatedCell) -> dict[str, Any]:
    """Return a cell as plain data, with floats that print as the short decimals of the cell."""
    return {
        "wind": _row(cell.winds),
        "sides": {side.name: float(getattr(cell.sides, side.name)) for side in fields(Sides)},
        "P": [_row(row) for row in cell.P],
        "multipliers": [
            {name: float(value) for name, value in by_name.items()} for by_name in cell.multipliers
        ],
    }


def _row(values: Any) -> list[float]:
    return [float(value) for value in values]
