"""The candidate of a claim of kind ``schedule-rate``: one range of schedule winds, one rate.

The intervals of the law's tables in the range are cut into equal cells, and functions are sought
for all cells at once, linear between knots that lie about 1 m/s apart.  A first box of each cell
grows until it holds the set that its own ranges allow.  Then each cell gets the multipliers for the
rounded functions.  Nothing is proved here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from math import isqrt
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.running_loop.inputs import Span
from takagi.certificates.checker.turbine.running_loop.signals import Rows
from takagi.certificates.checker.turbine.scheduled_loop.schedule_claim import (
    KeptAtSchedule,
    StatedScheduleCell,
    examined,
)
from takagi.certificates.checker.turbine.scheduled_loop.schedule_inputs import ScheduleSides
from takagi.certificates.claims.turbine.running_loop.candidate import Subject, decimal
from takagi.certificates.claims.turbine.running_loop.running_loop_claim import (
    claim_head,
    loop_subject,
)
from takagi.certificates.claims.turbine.scheduled_loop.posed_cells import (
    LIMITED,
    posed_cells,
    rounded_box,
)
from takagi.certificates.claims.turbine.scheduled_loop.schedule_program import (
    Place,
    ScheduleLoop,
    functions,
    weights,
)
from takagi.models.arrays import Floats

# alpha of the claim [1/s], and its share with which functions are sought: the rest is left for
# rounding.
DECAY, FASTER = 0.022, 1.02
# The most width of a cell, and the distance of the knots of P [m/s].
WIDEST, KNOTS = 0.3, 1.0
# First sides of a box per rate of the wind [s].
FIRST_BOX = {
    "speed": 1.2, "measured": 1.2, "pitch": 0.8, "signal": 1.6, "wind": 17.0, "estimate": 20.0,
}  # fmt: skip
# Repetitions until the boxes hold their sets; how much wider a box is made, and the most growth.
REPETITIONS, WIDER, GROWTH = 10, 1.02, 2.0
DIGITS = 1000


def schedule_rate_claim(
    model: Mapping[str, Any],
    gains: Mapping[str, Any],
    controller: Mapping[str, Any],
    inertia: Sequence[float],
    within: Span,
    rate: float,
    tell: Callable[[str], None] | None = None,
) -> dict[str, Any]:
    """Return the claim as plain data.

    Parameters
    ----------
    model, gains, controller, inertia : as ``running_loop_claim`` takes them.
    within : the intervals of the law's tables inside these winds [m/s] are the schedule winds.
    rate : the largest rate of the wind [m/s^2].
    tell : called with a word before each program is solved, and before each cell.

    Raises
    ------
    Refused : the law has no filter of the measured speed or of the wind, no interval of the tables
        lies in the range, or no function was found.
    """
    said = _silent if tell is None else tell
    head = claim_head(model, gains, controller, inertia)
    subject = loop_subject(model, gains, head)
    winds, knots = _edges(subject, within)
    try:
        tables, boxes = _searched(subject, winds, knots, rate, said)
        cells, kept = _stated(subject, winds, knots, tables, boxes, rate, said)
    except np.linalg.LinAlgError as reason:
        # A solver's function that is singular, or not positive, up to rounding.
        raise Refused("no quadratic function was found about the schedule wind") from reason
    low = winds[0][0] + _above(kept[0].wind[0])
    high = winds[-1][1] - _above(kept[-1].wind[1])
    if not low < high:
        raise Refused("the lag of the schedule wind is wider than the range")
    del head["decay_rate"]
    found = {v: one for cell in cells for v, one in zip(cell.winds, cell.ends, strict=True)}
    return {
        "name": f"loop about the schedule wind, {float(low):g} to {float(high):g} m/s",
        **head,
        "kind": "schedule-rate",
        "winds": [[float(low), float(high)]],
        "functions": [
            {"wind": float(v), "P": [_row(row) for row in found[v]]} for v in sorted(found)
        ],
        "cells": [_data(cell) for cell in cells],
    }


def _silent(words: str) -> None:
    """Take a word on progress when nobody asked for it."""


def _above(square: Fraction) -> Fraction:
    """Return a number of three decimals above the square root."""
    return Fraction(isqrt(square.numerator * DIGITS**2 // square.denominator) + 1, DIGITS)


def _edges(subject: Subject, within: Span) -> tuple[list[Span], list[Fraction]]:
    """Return the cells and the winds between which P is linear."""
    parts = [
        (low, high)
        for low, high in pairwise(subject.law.wind)
        if within[0] <= low < high <= within[1]
    ]
    if not parts:
        raise Refused("no interval of the law's tables lies in the range")
    cells: list[Span] = []
    knots = [parts[0][0]]
    for low, high in parts:
        count = -(-(high - low) // Fraction(WIDEST))
        edges = [
            Fraction(f"{float(low + (high - low) * i / count):.7g}") for i in range(int(count))
        ]
        cells += pairwise([low, *edges[1:], high])
        if high - knots[-1] >= Fraction(KNOTS) * 9 / 10:
            knots.append(high)
    if knots[-1] != parts[-1][1]:
        knots[-1 if len(knots) > 1 else 1 :] = [parts[-1][1]]
    return cells, knots


def _searched(
    subject: Subject,
    winds: Sequence[Span],
    knots: Sequence[Fraction],
    rate: float,
    tell: Callable[[str], None],
) -> tuple[list[Floats], list[ScheduleSides]]:
    """Return P at the knots, and boxes that hold the sets."""
    first = {name: x * rate for name, x in FIRST_BOX.items()}
    gain = _steepest(subject, (winds[0][0], winds[-1][1]))
    boxes = [rounded_box(subject, gain, first) for _ in winds]
    for k in range(REPETITIONS):
        tell(f"attempt {k + 1} of {REPETITIONS} at most")
        posed = posed_cells(subject, winds, boxes, rate)
        places = [_ends(cell, knots) for cell in winds]
        found = functions(posed.loops, places, len(knots), FASTER * DECAY)
        if found is None:
            break
        t, tables = found
        filled = [
            _filled(loop, names, [_between(place, tables) for place in ends])
            for loop, names, ends in zip(posed.loops, posed.names, places, strict=True)
        ]
        if not np.all(np.isfinite([list(one.values()) for one in filled])):
            break
        back = np.linalg.inv(posed.unit)
        if t >= 1:
            fitting = [
                _tightened(box, loop, [_between(place, tables) for place in ends])
                for box, loop, ends in zip(boxes, posed.loops, places, strict=True)
            ]
            return [back.T @ one @ back for one in tables], fitting
        boxes = [
            rounded_box(
                subject,
                gain,
                {
                    name: float(getattr(box, name)) * min(x * WIDER, GROWTH)
                    for name, x in one.items()
                },
            )
            for box, one in zip(boxes, filled, strict=True)
        ]
    raise Refused("no quadratic function was found about the schedule wind")


def _tightened(box: ScheduleSides, loop: ScheduleLoop, ends: Sequence[Floats]) -> ScheduleSides:
    """Return the box with the sides that bound the rate of what is sent close to the sets."""
    filled = dict(zip(LIMITED, _shares(loop.limits, ends).tolist(), strict=True))
    close = {
        name: Fraction(f"{float(getattr(box, name)) * min(filled[name] * WIDER, 1.0):.4g}")
        for name in ("measured_rate", "innovation")
    }
    return replace(box, **close)


def _filled(loop: ScheduleLoop, names: Sequence[str], ends: Sequence[Floats]) -> dict[str, float]:
    """Return by side the share of it that the sets at both ends reach."""
    return dict(zip(names, _shares(loop.rows, ends).tolist(), strict=True))


def _shares(rows: Floats, ends: Sequence[Floats]) -> Floats:
    """Return the largest of each row on the sets at both ends."""
    found = [np.sqrt(np.einsum("ri,ij,rj->r", rows, np.linalg.inv(one), rows)) for one in ends]
    return np.asarray(np.max(found, axis=0))


def _between(place: Place, tables: Sequence[Floats]) -> Floats:
    return (1 - place.share) * tables[place.j] + place.share * tables[place.j + 1]


def _ends(winds: Span, knots: Sequence[Fraction]) -> tuple[Place, Place]:
    j = max(i for i, knot in enumerate(knots[:-1]) if knot <= winds[0])
    width = knots[j + 1] - knots[j]
    low, high = (float((v - knots[j]) / width) for v in winds)
    return Place(j, low, float(width)), Place(j, high, float(width))


def _steepest(subject: Subject, winds: Span) -> Fraction:
    """Return the largest pitch per signal; between nodes of the tables it is monotone."""
    law = subject.law
    return max(
        gamma / b
        for v, gamma, b in zip(law.wind, law.gamma, law.effectiveness, strict=True)
        if winds[0] <= v <= winds[1]
    )


def _stated(
    subject: Subject,
    winds: Sequence[Span],
    knots: Sequence[Fraction],
    tables: Sequence[Floats],
    boxes: Sequence[ScheduleSides],
    rate: float,
    tell: Callable[[str], None],
) -> tuple[list[StatedScheduleCell], list[KeptAtSchedule]]:
    """Return the cells with rounded functions and multipliers, and what is proved of each."""
    posed = posed_cells(subject, winds, boxes, rate)
    known: dict[Fraction, Rows] = {}
    cells: list[StatedScheduleCell] = []
    kept: list[KeptAtSchedule] = []
    for cell, loop, names, ends in zip(
        winds, posed.loops, posed.factors, [_ends(one, knots) for one in winds], strict=True
    ):
        tell(f"proof, cell {len(cells) + 1} of {len(winds)}")
        for v, place in zip(cell, ends, strict=True):
            known.setdefault(v, _rounded(_between(place, tables)))
        exact = known[cell[0]], known[cell[1]]
        low, high = (posed.unit.T @ np.array(one, dtype=np.float64) @ posed.unit for one in exact)
        found = weights(loop, (low, high), float(cell[1] - cell[0]))
        if found is None:
            raise Refused("no multipliers were found about the schedule wind")
        stated = StatedScheduleCell(
            winds=cell,
            ends=exact,
            wind_rate=Fraction(f"{rate:.4g}"),
            decay=Fraction(f"{found.decay:.5g}"),
            residual_share=Fraction(f"{found.residual_share:.5g}"),
            sides=boxes[len(cells)],
            multipliers={
                name: tuple(
                    decimal(float(tau[i] / loop.scale[i] ** 2)) for tau in found.multipliers
                )
                for i, name in enumerate(names)
            },
        )
        proved = examined(posed.cells[len(cells)], stated, posed.lead)
        if isinstance(proved, str):
            raise Refused(f"{float(cell[0]):g} to {float(cell[1]):g} m/s: {proved}")
        cells.append(stated)
        kept.append(proved)
    return cells, kept


def _rounded(P: Floats) -> Rows:
    n = len(P)
    return [[decimal((P[i, j] + P[j, i]) / 2) for j in range(n)] for i in range(n)]


def _data(cell: StatedScheduleCell) -> dict[str, Any]:
    """Return a cell as plain data, with floats that print as the short decimals of the cell."""
    return {
        "wind": _row(cell.winds),
        "wind_rate": float(cell.wind_rate),
        "decay_rate": float(cell.decay),
        "residual_share": float(cell.residual_share),
        "sides": {
            name: float(getattr(cell.sides, name)) for name in ScheduleSides.__dataclass_fields__
        },
        "multipliers": {name: _row(pair) for name, pair in cell.multipliers.items()},
    }


def _row(values: Any) -> list[float]:
    return [float(value) for value in values]
