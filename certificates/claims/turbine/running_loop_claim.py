r"""The candidate of a claim of kind ``running-loop``: cells over all winds of the law's tables.

Each interval of the tables is one cell, with the largest box for which a function is found.  Where
none is found, or where the box is small and the halves have larger boxes, the interval is halved,
down to a least width.  A part without a function is a gap: the claim does not cover it, and its
sentence names it.
Nothing is proved here.

A quadratic function for the running loop at the winds of one cell.

The function is sought in floating point, rounded to decimals, and its inequalities are then decided
as the checker decides them.  That is a candidate: only the checker's verdict on the file counts.

In the loop xi' = A xi + B w, z = C xi + D w, w_i^2 <= z_i^2, with Q = P^-1 and S = diag(1/tau),

    [ A Q + Q A' + 2 alpha Q + B S B'    Q C' + B S D' ]
    [ (the same)'                        D S D' - S    ] < 0           for each piece
    h'Q h <= side^2                                                    for each side of the box

are the claim's inequalities after a congruence; they are affine in Q and S.  The objective is the
trace of Q in units of the box, plus a multiple of its least eigenvalue, so that no half width
becomes very small.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
import scipy.sparse as sp

from takagi.certificates.checker.kernel.obligation import first_failure
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.rotor import Plant
from takagi.certificates.checker.turbine.running_loop.cell import Cell, cut, factors
from takagi.certificates.checker.turbine.running_loop.equations import (
    Rows,
    Signal,
    Signals,
    equations,
    rows,
    states,
)
from takagi.certificates.checker.turbine.running_loop.inputs import STATED, Machine, Sides, Span
from takagi.certificates.checker.turbine.running_loop.limits import limits
from takagi.certificates.checker.turbine.running_loop.running_claim import (
    StatedCell,
    cell_obligations,
)
from takagi.certificates.checker.turbine.turbine_claim import refusal_fails
from takagi.certificates.claims.turbine.published import merged
from takagi.certificates.document.model_data import as_read
from takagi.lmi.cone.cone_program import Cone, ConeProgram, pack
from takagi.lmi.solver.solve import Session
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

# The largest box to try for 5 MW, and fractions of it, the largest first.
LARGEST = Sides(
    speed=Fraction("0.04"),
    measured=Fraction("0.04"),
    pitch=Fraction("0.03"),
    signal=Fraction("0.04"),
    effort=Fraction("0.03"),
    schedule=Fraction("0.5"),
    estimate=Fraction("0.5"),
    integral=Fraction("0.06"),
    measured_rate=Fraction("0.1"),
)
SIZES = tuple(map(Fraction, ("1 0.7 0.5 0.35 0.25 0.18 0.12 0.08 0.05 0.03 0.02 0.01".split())))
# Of another turbine they are scaled by its rated speed [rad/s] and by the law's overlap [rad/s^2].
RATED_SPEED, OVERLAP = Fraction("1.2671"), Fraction("0.01")
SPEEDS = ("speed", "measured", "signal", "integral")
EFFORTS = ("pitch", "effort", "measured_rate")
# How often the side "schedule" is halved where the box of the usual shape is narrower than the
# ranges that it has to hold: at a corner of the reference speed, omega*' times that side.
HALVINGS = 2
# A wider range of the pitch share is divided into pieces, each with its own multipliers.
WIDEST_SHARE, DIGITS = Fraction(1, 5), 8
# Margins with which the inequalities are posed, so that they hold after rounding: a rate that is
# larger by a twentieth, smaller multipliers and boxes.  Then the factor of the least eigenvalue.
RATE_FACTOR, MARGIN, LEAST_WEIGHT = 1.05, 1e-3, 2.0
Loop = tuple[Floats, Floats]


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """Turbine, law and machine, as the checker reads them; the decay rate that is sought [1/s]."""

    plant: Plant
    law: Law
    machine: Machine
    decay: Fraction


def running_candidate(
    subject: Subject, winds: Span, *, sizes: Sequence[Fraction] = SIZES
) -> tuple[StatedCell | None, str]:
    """Return the cell with the largest box, or None and the reason of the last failure."""
    why = "no size was tried"
    for size in sizes:
        stated, why = _of_size(subject, winds, size)
        if stated is not None:
            return stated, ""
    return None, why


# A size is tried for half of a cell, and again where the cell is halved.
@lru_cache(maxsize=16)
def _of_size(subject: Subject, winds: Span, size: Fraction) -> tuple[StatedCell | None, str]:
    """Return the cell with a box of this size, or None and the reason."""
    try:
        cell = _cell(subject, winds, box_of_size(subject, size))
        why = first_failure(limits(cell))
    except Refused as reason:
        why = str(reason)
    if why:
        return None, why
    function = _solved(cell, subject.decay)
    if function is None:
        return None, "no quadratic function was found"
    stated = StatedCell(winds, cell.sides, *function)
    required = cell_obligations(subject.plant, subject.law, subject.machine, stated, subject.decay)
    why = first_failure(refusal_fails(required))
    return (None, why) if why else (stated, "")


def _cell(subject: Subject, winds: Span, sides: Sides) -> Cell:
    """Return the cell with this box, or with a shorter side "schedule" that leaves room in it.

    Signal and effort lose what the ranges add, in proportion to this side (``rows``).  Without room
    there is no function, so such a box is refused.
    """
    for _ in range(HALVINGS + 1):
        cell = Cell(subject.plant, subject.law, subject.machine, winds, sides)
        if all(bound > 0 for _, bound in rows(cell, factors(cell)).values()):
            return cell
        sides = replace(sides, schedule=sides.schedule / 2)
    raise Refused("the ranges are wider than the box")


def box_of_size(subject: Subject, size: Fraction) -> Sides:
    """Return the largest box times a factor."""
    ratios = subject.plant.rated_speed / RATED_SPEED, subject.law.overlap / OVERLAP
    speed, effort = (Fraction(f"{float(ratio):.2g}") for ratio in ratios)
    factors = dict.fromkeys(SPEEDS, speed) | dict.fromkeys(EFFORTS, effort)
    return Sides(**{
        side.name: size * factors.get(side.name, Fraction(1)) * getattr(LARGEST, side.name)
        for side in fields(Sides)
    })  # fmt: skip


def _solved(cell: Cell, decay: Fraction) -> tuple[Rows, list[dict[str, Fraction]]] | None:
    """Return P and multipliers found by a solver, in decimals."""
    span, unit, order = factors(cell), _units(cell), states(cell.machine)
    boxes = []
    for h, bound in rows(cell, span).values():
        boxes.append(np.array(h, dtype=np.float64) * unit / float(bound))
    low, high = cell.ramp_share
    # At every instant the pitch share lies in one of the pieces.
    pieces = cut(cell.ramp_share, 1 if high - low < WIDEST_SHARE else 2)
    posed = [equations(cell, span, share_range) for share_range in pieces]
    loops = [_scaled(*equations_of_piece, unit) for equations_of_piece in posed]
    largest_set = _largest_set([(F, Z) for F, Z, _ in loops], np.array(boxes), float(decay))
    if largest_set is None:
        return None
    P = largest_set[0] / np.outer(unit, unit)
    exact = [[_decimal((P[i, j] + P[j, i]) / 2) for j in range(order)] for i in range(order)]
    multipliers = [
        dict(zip(signals.names, map(_decimal, tau / scale**2), strict=True))
        for tau, (signals, _), (_, _, scale) in zip(largest_set[1], posed, loops, strict=True)
    ]
    return exact, multipliers


def _units(cell: Cell) -> Floats:
    """Return the units of the states for a solver: about what each moves by in the box."""
    sides = cell.sides
    named = (
        *(sides.speed, sides.pitch, sides.integral, sides.schedule),
        *(sides.measured, sides.measured, sides.estimate, sides.pitch),
        *(sides.measured, sides.measured),
    )
    return np.array([float(side) for side in named[: states(cell.machine)]])


def _scaled(signals: Signals, rates: list[Signal], unit: Floats) -> tuple[Floats, Floats, Floats]:
    """Return rates and outer signals in units of the box, and the units of the w."""
    F = np.array([signals.row(rate) for rate in rates], dtype=np.float64)
    Z = np.array([signals.row(signal) for signal in signals.outer], dtype=np.float64)
    scale, order = np.zeros(len(Z)), len(unit)
    for i, row in enumerate(np.abs(Z)):
        scale[i] = max(float((row[:order] * unit).max()), 1e-9)
        scale[i] = max(scale[i], float((row[order:] * scale).max()))
    units = np.concatenate([unit, scale])
    return F * units / unit[:, None], Z * units / scale[:, None], scale


def _decimal(value: float) -> Fraction:
    return Fraction(f"{value:.{DIGITS}g}")


def _largest_set(
    loops: Sequence[Loop], boxes: Floats, decay: float
) -> tuple[Floats, list[Floats]] | None:
    """Return P and the multipliers of each piece, or None where the solver finds none.

    A piece's loop: the rates (n, n + k) and the outer signals (k, n + k), over (xi, w).  The boxes
    are rows h over their bounds; |h xi| <= 1 is needed.
    """
    n = boxes.shape[1]
    pairs = [(i, j) for j in range(n) for i in range(j + 1)]
    basis = np.zeros((len(pairs), n, n))
    for E, (i, j) in zip(basis, pairs, strict=True):
        E[i, j] = E[j, i] = 1.0
    ends = np.cumsum([len(pairs), *(len(outer) for _, outer in loops)])

    def split(y: Floats) -> tuple[Floats, list[Floats]]:
        """Return Q and the 1/tau of each piece; the last unknown is Q's least eigenvalue."""
        Q, *S, _ = np.split(y, ends)
        return np.tensordot(Q, basis, axes=1), S

    def sides(y: Floats) -> list[Floats]:
        Q, S = split(y)
        inequalities = [_piece(*loop, Q, s, decay) for loop, s in zip(loops, S, strict=True)]
        return [*inequalities, y[-1] * np.eye(n) - Q]

    unknowns = np.eye(int(ends[-1]) + 1)
    rows = [np.einsum("ri,ij,rj->r", boxes, split(y)[0], boxes) for y in unknowns]
    columns = [
        np.concatenate([row, *map(pack, sides(y))]) for row, y in zip(rows, unknowns, strict=True)
    ]
    orders = [*map(len, sides(unknowns[0]))]
    offsets = np.cumsum([0, *(m * (m + 1) // 2 for m in orders)]).tolist()
    cones = tuple(Cone(m, 1, at) for m, at in zip(orders, offsets, strict=False))
    A = np.column_stack(columns)
    b = np.zeros(len(A))
    b[: len(boxes)] = 1 - MARGIN
    q = -np.array([float(i == j) for i, j in pairs] + [0.0] * (len(unknowns) - len(pairs)))
    q[-1] = -LEAST_WEIGHT * n
    raw = Session().solve(ConeProgram(q, sp.csc_array(A), b, len(boxes), cones))
    if "Solved" not in raw.status or not np.all(np.isfinite(raw.y)):
        return None
    Q, S = split(np.asarray(raw.y))
    if np.linalg.eigvalsh(Q).min() <= 0 or min(float(s.min(initial=1)) for s in S) <= 0:
        return None
    return np.asarray(np.linalg.inv(Q), dtype=np.float64), [1 / s for s in S]


def _piece(rates: Floats, outer: Floats, Q: Floats, s: Floats, decay: float) -> Floats:
    """Return the inequality of one piece, as the module states it, with both margins."""
    n, k = len(rates), len(outer)
    AQ, QC = rates[:, :n] @ Q, Q @ outer[:, :n].T
    along = np.vstack([rates[:, n:], outer[:, n:]])
    M = np.block([[AQ + AQ.T + 2 * RATE_FACTOR * decay * Q, QC], [QC.T, np.zeros((k, k))]])
    M += along * s @ along.T
    M[n:, n:] -= (1 - MARGIN) * np.diag(s)
    return np.asarray(M)


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
    nodes = subject.law.wind
    return {
        "name": f"running loop, {float(nodes[0]):g} to {float(nodes[-1]):g} m/s",
        **head,
        "winds": [[*map(float, pair)] for pair in merged([cell.winds for cell in cells])],
        "cells": [_data(cell) for cell in cells],
    }


def _stated_controller(
    controller: Mapping[str, Any], gains: Mapping[str, Any]
) -> dict[str, dict[str, Any]]:
    """Return the numbers of observer and filters that a claim repeats from the gain file."""
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
    data = as_read({"model": model, "gains": gains, "claim": claim})
    machine = Machine.read(data["claim"], data["model"], data["gains"], "claim")
    plant, law = Plant.read(data["model"]), Law.read(data["gains"])
    return Subject(plant, law, machine, Fraction(str(claim["decay_rate"])))


def cells_over_winds(
    subject: Subject, intervals: Iterable[Span] | None = None, hint: int = 0
) -> Iterator[StatedCell]:
    """Yield the cells, in the order of their winds.

    ``intervals`` : None takes those of the law's tables;  ``hint`` : the place of the last cell's
    size.
    """
    for low, high in pairwise(subject.law.wind) if intervals is None else intervals:
        middle = Fraction(round((low + high) / 2 * WIND_DENOMINATOR), WIND_DENOMINATOR)
        halves = ((low, middle), (middle, high))
        largest, cells = _largest(subject, (low, high), hint), iter(list[StatedCell]())
        if largest is not None and not _is_small(subject, largest, halves):
            cells = iter([largest])
        elif high - low >= 2 * LEAST_WIDTH:
            cells = cells_over_winds(subject, halves, hint)
        for cell in cells:
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
    return SIZES.index(cell.sides.estimate / LARGEST.estimate)


def _data(cell: StatedCell) -> dict[str, Any]:
    """Return a cell as plain data, with floats that print as the short decimals of the cell."""
    return {
        "wind": [*map(float, cell.winds)],
        "sides": {side.name: float(getattr(cell.sides, side.name)) for side in fields(Sides)},
        "P": [[*map(float, row)] for row in cell.P],
        "multipliers": [{name: float(x) for name, x in tau.items()} for tau in cell.multipliers],
    }
