r"""``running-loop``: the turbine's loop as it runs, with its observer, settles at constant winds.

The loop has the law, the gain file's observer, its filters of the measured speed and of the wind
estimate, its limits of rates, the pitch drive and one state of the wake (``equations``).  In each
cell of winds, with a box around the rest, every factor of the loop is enclosed over the box, and,
exactly, for every piece of the share of pitch

    -(2 xi'P xi' + 2 alpha xi'P xi + sum tau_i (z_i^2 - w_i^2)) > 0  for all (xi, w) but zero,
    side^2 P > h'h                                                   for every side of the box.

Then at every constant wind of the cell no motion leaves V = xi'P xi <= 1, and V falls at least as
exp(-2 alpha t).  The claim states cells, sides, P, tau and alpha; all else is computed here.

Evidence: ``winds`` (ranges that the cells cover exactly), ``decay_rate``, ``uncertainty``
(``inertia``, ``wake_length``), ``observer``, ``measurement``, ``cells`` of ``wind``, ``sides``,
``P`` and ``multipliers``, for each piece by the factor's name.

Not promised: varying winds; motions that start outside the sets; a sampled law; noise; a
second-order pitch drive; a torque lag; flexible shaft, tower or blades.

Derived in docs/running-loop.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.reader import listed, matrix, member, number, numbers
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.kernel.result import Found, Verdict
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.running_loop.cell import Cell, cut, factors
from takagi.certificates.checker.turbine.running_loop.equations import (
    FACTORS,
    Rows,
    decay_form,
    equations,
    rows,
    states,
)
from takagi.certificates.checker.turbine.running_loop.inputs import (
    Machine,
    Sides,
    Span,
    other_than_the_controller,
)
from takagi.certificates.checker.turbine.running_loop.limits import limit_failure
from takagi.certificates.checker.turbine.running_loop.quadratic_forms import (
    is_surely_definite,
    squared_reaches,
)

MOST_CELLS, MOST_PIECES = 500, 8


@dataclass(frozen=True)
class StatedCell:
    """One cell as the claim states it."""

    winds: Span
    sides: Sides
    P: Rows
    multipliers: list[dict[str, Fraction]]

    @classmethod
    def read(cls, stated: Any, order: int, where: str) -> StatedCell:
        """Return it; refuses winds that do not increase and a P of another size."""
        low, high = numbers(stated, "wind", where, 2)
        if not low < high:
            raise CertificateError(f"{where}.wind: the two winds must increase")
        P = matrix(stated, "P", where)
        if len(P) != order or len(P[0]) != order:
            raise CertificateError(f"{where}.P: {order} rows of {order} numbers are needed")
        pieces = listed(stated, "multipliers", where, 1, MOST_PIECES)
        rows = []
        for i, row in enumerate(pieces):
            place = f"{where}.multipliers[{i}]"
            if not isinstance(row, dict) or not set(row) <= FACTORS:
                raise CertificateError(f"{place}: numbers by the names of the factors are needed")
            rows.append({name: number(row, name, place) for name in row})
        return cls((low, high), Sides.read(stated, where), P, rows)


def check_running_loop(claim: Any, data: Any, where: str) -> Found:
    """Return the verdict on one claim, with what fails and where.

    Parameters
    ----------
    data : the whole file.

    Raises
    ------
    CertificateError : a part is missing or is not what it has to be; also an observer or filters
        that are not those of the certificate's ``controller``.
    """
    plant, law, machine = _stated_loop(claim, data, where)
    decay = number(claim, "decay_rate", where)
    cells = [
        StatedCell.read(cell, states(machine), f"{where}.cells[{i}]")
        for i, cell in enumerate(listed(claim, "cells", where, 1, MOST_CELLS))
    ]
    winds = _stated_winds(claim, cells, where)
    said = {"law": law, "winds": winds}
    if decay <= 0:
        return Found(Verdict.UNDECIDED, "running_loop", said | {"why": "no rate is claimed"})
    failures = [
        (cell.winds, reason)
        for cell in cells
        if (reason := cell_failure(plant, law, machine, cell, decay))
    ]
    if failures:
        return Found(Verdict.UNDECIDED, "running_loop", said | {"failures": failures})
    proved = {"machine": machine, "decay": decay, "cells": cells}
    return Found(Verdict.PROVED, "running_loop", said | proved)


def _stated_loop(claim: Any, data: Any, where: str) -> tuple[Plant, Law, Machine]:
    """Return plant, law, and observer and filters of a claim; ``data`` is the whole file.

    Raises
    ------
    CertificateError : a part is missing or is not what it has to be; also an observer or filters
        that are not those of the certificate's ``controller``.
    """
    model, gains = member(data, "model", "certificate"), member(data, "gains", "certificate")
    plant, law = Plant.read(model), Law.read(gains)
    if (plant.pitch_min, plant.pitch_max) != (law.pitch_min, law.pitch_max):
        raise CertificateError("gains: pitch limits differ from the model's")
    machine = Machine.read(claim, model, gains, where)
    if other := other_than_the_controller(claim, data, where):
        raise CertificateError(f"{where}.{other}")
    return plant, law, machine


def _stated_winds(claim: Any, cells: Sequence[StatedCell], where: str) -> list[Span]:
    """Return the claim's ranges of winds; refuses cells that do not cover exactly these.

    The cells come in the order of their winds and do not overlap.
    """
    ranges: list[Span] = []
    for row in listed(claim, "winds", where, 1, MOST_CELLS):
        low, high = numbers({"winds": row}, "winds", where, 2)
        ranges.append((low, high))
    covered: list[Span] = []
    for one in cells:
        low, high = one.winds
        if covered and low < covered[-1][1]:
            raise CertificateError(f"{where}.cells: the cells overlap, or are not in order")
        if covered and low == covered[-1][1]:
            covered[-1] = (covered[-1][0], high)
        else:
            covered.append((low, high))
    if covered != ranges:
        raise CertificateError(f"{where}.winds: these are not just the winds of the cells")
    return ranges


def cell_failure(
    plant: Plant, law: Law, machine: Machine, stated: StatedCell, decay: Fraction
) -> str:
    """Return what is not proved about one cell, or nothing."""
    try:
        cell = Cell(plant, law, machine, stated.winds, stated.sides)
        span = factors(cell)
        return (
            limit_failure(cell)
            or _box_failure(cell, span, stated.P)
            or _decay_failure(cell, span, stated, decay)
        )
    except Refused as reason:
        return str(reason)


def _box_failure(cell: Cell, span: dict[str, Span], P: Rows) -> str:
    """Return whether P is not positive definite, or which side of the box {V <= 1} may leave."""
    wanted = rows(cell, span)
    reached = squared_reaches(P, [h for h, _ in wanted.values()])
    if reached is None:
        return "P is not symmetric positive definite"
    for (name, (_, bound)), square in zip(wanted.items(), reached, strict=True):
        if bound <= 0 or square >= bound**2:
            return f"the set leaves its box in {name.replace('_', ' ')}"
    return ""


def _decay_failure(cell: Cell, span: dict[str, Span], stated: StatedCell, decay: Fraction) -> str:
    """Return what fails in the decay inequality of a piece of the share of pitch, or nothing."""
    parts = cut(cell.share, len(stated.multipliers))
    for tau, held in zip(stated.multipliers, parts, strict=True):
        signals, rates = equations(cell, span, held)
        if missing := [name for name in signals.names if name not in tau]:
            return f"there is no multiplier of the {missing[0]}"
        if min(tau.values()) <= 0:
            return "a multiplier is not positive"
        weights = [tau[name] for name in signals.names]
        if not is_surely_definite(decay_form(signals, rates, stated.P, weights, decay)):
            return "the decay inequality fails"
    return ""
