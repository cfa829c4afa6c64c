"""A quadratic function for the running loop at the winds of one cell.

The function is sought in floating point, rounded to decimals, and its inequalities are then decided
as the checker decides them.  That is a candidate: only the checker's verdict on the file counts.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from math import floor, log10

import numpy as np

from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.running_loop.cell import Cell
from takagi.certificates.checker.turbine.running_loop.equations import equations, rows, states
from takagi.certificates.checker.turbine.running_loop.factors import cut, factors
from takagi.certificates.checker.turbine.running_loop.inputs import Machine, Sides, Span
from takagi.certificates.checker.turbine.running_loop.limits import limit_failure
from takagi.certificates.checker.turbine.running_loop.running_claim import StatedCell, cell_failure
from takagi.certificates.checker.turbine.running_loop.signals import Rows, Signal, Signals
from takagi.certificates.claims.turbine.running_loop.cell_program import largest_set
from takagi.models.arrays import Floats

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
    innovation=Fraction("0.04"),
)
SIZES = tuple(map(Fraction, ("1 0.7 0.5 0.35 0.25 0.18 0.12 0.08 0.05 0.03 0.02 0.01".split())))
# Of another turbine they are scaled by its rated speed [rad/s] and by the law's overlap [rad/s^2].
RATED_SPEED, OVERLAP = Fraction("1.2671"), Fraction("0.01")
SPEEDS = ("speed", "measured", "signal", "integral", "innovation")
EFFORTS = ("pitch", "effort", "measured_rate")
# How often the side "schedule" is halved where the box of the usual shape is narrower than the
# ranges that it has to hold: at a corner of the reference speed, omega*' times that side.
HALVINGS = 2
# A wider range of the pitch share is divided into pieces, each with its own multipliers.
WIDEST_SHARE, DIGITS = Fraction(1, 5), 8


@dataclass(frozen=True, slots=True)
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
        try:
            cell = _cell(subject, winds, box_of_size(subject, size))
            why = limit_failure(cell)
        except Refused as reason:
            why = str(reason)
        if why:
            continue
        found = _solved(cell, subject.decay)
        if found is None:
            why = "no quadratic function was found"
            continue
        stated = StatedCell(winds, cell.sides, *found)
        why = cell_failure(subject.plant, subject.law, subject.machine, stated, subject.decay)
        if not why:
            return stated, ""
    return None, why


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
    speed = _two_digits(subject.plant.rated_speed / RATED_SPEED)
    effort = _two_digits(subject.law.overlap / OVERLAP)
    factors = dict.fromkeys(SPEEDS, speed) | dict.fromkeys(EFFORTS, effort)
    return Sides(**{
        one.name: size * factors.get(one.name, Fraction(1)) * getattr(LARGEST, one.name)
        for one in fields(Sides)
    })  # fmt: skip


def size_of_box(sides: Sides) -> Fraction:
    """Return a box's size as a fraction of the largest."""
    return sides.estimate / LARGEST.estimate


def _two_digits(value: Fraction) -> Fraction:
    return Fraction(f"{float(value):.2g}")


def pieces(cell: Cell) -> list[Span]:
    """Return the pieces of the pitch share: at every instant it lies in one of them."""
    return cut(cell.share, 1 if cell.share[1] - cell.share[0] < WIDEST_SHARE else 2)


def _solved(cell: Cell, decay: Fraction) -> tuple[Rows, list[dict[str, Fraction]]] | None:
    """Return P and multipliers found by a solver, in decimals."""
    span, unit, order = factors(cell), units(cell), states(cell.machine)
    boxes = []
    for h, bound in rows(cell, span).values():
        boxes.append(np.array(h, dtype=np.float64) * unit / float(bound))
    posed = [equations(cell, span, held) for held in pieces(cell)]
    loops = [scaled(*one, unit) for one in posed]
    found = largest_set([(F, Z) for F, Z, _ in loops], np.array(boxes), float(decay))
    if found is None:
        return None
    P = found[0] / np.outer(unit, unit)
    exact = [[decimal((P[i, j] + P[j, i]) / 2) for j in range(order)] for i in range(order)]
    multipliers = [
        dict(zip(signals.names, map(decimal, tau / scale**2), strict=True))
        for tau, (signals, _), (_, _, scale) in zip(found[1], posed, loops, strict=True)
    ]
    return exact, multipliers


def units(cell: Cell) -> Floats:
    """Return the units of the states for a solver: about what each moves by in the box."""
    sides = cell.sides
    named = (
        *(sides.speed, sides.pitch, sides.integral, sides.schedule),
        *(sides.measured, sides.measured, sides.estimate, sides.pitch),
        *(sides.measured, sides.measured),
    )
    return np.array([float(side) for side in named[: states(cell.machine)]])


def scaled(signals: Signals, rates: list[Signal], unit: Floats) -> tuple[Floats, Floats, Floats]:
    """Return rates and outer signals in units of the box, and the units of the w."""
    F = np.array([signals.row(rate) for rate in rates], dtype=np.float64)
    Z = np.array([signals.row(one) for one in signals.outer], dtype=np.float64)
    scale, order = np.zeros(len(Z)), len(unit)
    for i, row in enumerate(np.abs(Z)):
        scale[i] = max(float((row[:order] * unit).max()), 1e-9)
        scale[i] = max(scale[i], float((row[order:] * scale).max()))
    whole = np.concatenate([unit, scale])
    return F * whole / unit[:, None], Z * whole / scale[:, None], scale


def decimal(value: float) -> Fraction:
    """Return the number with eight digits."""
    if value == 0:
        return Fraction(0)
    places = DIGITS - 1 - floor(log10(abs(value)))
    ten = Fraction(10) ** places
    return round(Fraction(value) * ten) / ten
