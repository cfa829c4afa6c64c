"""Cells of the loop in moving wind: the box that fits a rate of the wind, and functions at winds.

All is found in floating point, rounded to decimals, and decided as the checker decides it.  That is
a candidate: only the checker's verdict on the file counts.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.running_loop.cell import Cell
from takagi.certificates.checker.turbine.running_loop.equations import ETA, P, rows, states
from takagi.certificates.checker.turbine.running_loop.inputs import Sides, Span
from takagi.certificates.checker.turbine.running_loop.limits import limit_failure
from takagi.certificates.checker.turbine.running_loop.moving import (
    in_units,
    moving_equations,
    moving_factors,
)
from takagi.certificates.checker.turbine.running_loop.moving_claim import MovingCell, examined
from takagi.certificates.checker.turbine.running_loop.signals import Rows
from takagi.certificates.claims.turbine.running_loop.candidate import (
    Subject,
    box_of_size,
    decimal,
    pieces,
    units,
)
from takagi.certificates.claims.turbine.running_loop.moving_program import (
    MovingLoop,
    least_set,
    multipliers_of,
)
from takagi.models.arrays import Floats

# By how much a side of the box moves while torque or pitch lag behind the law (``entered_cells``).
Moves = dict[str, float]
# Where the side "schedule" is divided, as shares of it from -1 to 1.
Cuts = Sequence[float]
# A box is this much wider than the set in it, and is accepted below this share.
WIDER, FILLED = 1.15, 0.95
# The least half width in pitch and in the wake's pitch of a set between cells, in the box's units.
THINNEST = 0.15
# How much wider a box is made than the sets at the ends of its cell, the least of that, and by how
# much the room for moves is larger than the moves.
CLOSE, LEAST_ROOM, MORE = 1.06, 1.01, 1.03
# Repetitions until a box fits its set, and by how much a box may grow in one.
REPETITIONS, GROWTH = 5, 2.0
# A side is at least this share of a side of the usual shape, which has the same schedule wind.
FLATTEST = 0.1


class Pace(NamedTuple):
    """How fast motions must settle [1/s].

    Attributes
    ----------
    decay : alpha.
    faster : what remains of the decay for the change of P with the wind.
    """

    decay: float
    faster: float


# The second is asked for where the first is not found.
USUAL, SLOW = Pace(0.012, 0.008), Pace(0.008, 0.004)


@dataclass(frozen=True, slots=True)
class Fitted:
    """A cell with a rate of the wind and a box in which the set of this rate fits."""

    winds: Span
    rate: float
    sides: Sides
    cuts: Cuts = ()
    pace: Pace = USUAL


def as_fitted(cell: MovingCell) -> Fitted:
    """Return a stated cell as one with a rate and a box."""
    cuts = tuple(float(cut / cell.sides.schedule) for cut in cell.cuts)
    return Fitted(cell.winds, float(cell.wind_rate), cell.sides, cuts)


def fitted(
    subject: Subject,
    winds: Span,
    rate: float,
    sides: Sides,
    cuts: Cuts = (),
    pace: Pace = USUAL,
) -> tuple[Fitted | None, str]:
    """Return the cell with a box that fits, from a first box, or None and the reason.

    Parameters
    ----------
    cuts : where the side "schedule" is divided, as shares of it.
    """
    why = "no box fits"
    for _ in range(REPETITIONS):
        posed, why = pose(subject, winds, sides, rate, cuts=cuts)
        if posed is None:
            return None, why
        Q = least_set(posed.loops, posed.rows, *pace)
        if Q is None:
            return None, "no quadratic function was found"
        filled = np.sqrt(np.einsum("ri,ij,rj->r", posed.rows, Q, posed.rows))
        if filled.max() <= FILLED:
            # A smaller box has narrower ranges, so the set fits it, too.
            tight = np.minimum(filled * WIDER, 1)
            fit = resized(subject, sides, posed.by_side(tight))
            return Fitted(winds, rate, fit, cuts, pace), ""
        if filled.max() > 40:
            break
        wider = np.clip(filled * WIDER, 1 / GROWTH, GROWTH)
        sides = resized(subject, sides, posed.by_side(wider))
        why = "no box fits"
    return None, why


def resized(subject: Subject, sides: Sides, factors: Mapping[str, float]) -> Sides:
    """Return the box with each side times its factor.

    A side that has next to nothing to hold, as pitch at low winds, keeps a share of what it has in
    a box of the usual shape: a solver cannot use a box that is flat.
    """
    usual = box_of_size(subject, Fraction(1))
    new = {name: float(getattr(sides, name)) * factor for name, factor in factors.items()}
    least = FLATTEST * new["schedule"] / float(usual.schedule)
    return Sides(**{
        name: Fraction(f"{max(side, least * float(getattr(usual, name))):.4g}")
        for name, side in new.items()
    })  # fmt: skip


def enlarged(subject: Subject, sides: Sides, factor: float) -> Sides:
    """Return the box with every side times a factor."""
    return resized(subject, sides, {one.name: factor for one in fields(Sides)})


@dataclass(frozen=True, slots=True, eq=False)
class CellInUnits:
    """A cell in units of the solver: its pieces, its box by rows, and units with pitch in rad.

    ``names`` are the sides of the rows; each piece of the schedule wind has a row of each.
    ``bounds`` are those that the rows are divided by.
    """

    loops: list[MovingLoop]
    rows: Floats
    names: list[str]
    bounds: Floats
    factors: list[list[str]]
    unit: Floats

    def by_side(self, values: Floats) -> dict[str, float]:
        """Return the largest of the values of each side's rows."""
        found: dict[str, float] = {}
        for name, value in zip(self.names, values, strict=True):
            found[name] = max(found.get(name, 0.0), float(value))
        return found


def cut_winds(sides: Sides, cuts: Cuts) -> list[Fraction]:
    """Return the cuts in m/s, as the claim states them: four digits."""
    return [Fraction(f"{float(sides.schedule) * cut:.4g}") for cut in cuts]


def pose(
    subject: Subject,
    winds: Span,
    sides: Sides,
    rate: float,
    unit: Floats | None = None,
    cuts: Cuts = (),
) -> tuple[CellInUnits | None, str]:
    """Return the cell for a solver, or None and why its ranges do not allow a claim.

    Parameters
    ----------
    unit : units of the states with pitch in rad; those of the cell's box where none are given.
    cuts : where the side "schedule" is divided, as shares of it.
    """
    try:
        cell = Cell(subject.plant, subject.law, subject.machine, winds, sides)
        ends = [-sides.schedule, *cut_winds(sides, cuts), sides.schedule]
        parts = [cell.piece(lag) for lag in pairwise(ends)] if cuts else [cell]
        spans = [moving_factors(part) for part in parts]
        if why := limit_failure(cell):
            return None, why
    except Refused as reason:
        return None, str(reason)
    to_cell = np.ones(states(cell.machine))
    to_cell[[P, ETA]] = float(cell.b0)
    unit = units(cell) / to_cell if unit is None else unit
    own = unit * to_cell
    box, names, bounds = [], [], []
    for part, span in zip(parts, spans, strict=True):
        for name, (h, bound) in rows(part, span).items():
            if bound <= 0:
                return None, "the ranges are wider than the box"
            box.append(np.array(h, dtype=np.float64) * own / float(bound))
            names.append(name)
            bounds.append(float(bound))
    loops, factors = [], []
    for part, span in zip(parts, spans, strict=True):
        for held in pieces(part):
            signals, rates = moving_equations(part, span, held)
            F = np.array([signals.row(one) for one in rates], dtype=np.float64)
            Z = np.array([signals.row(one) for one in signals.outer], dtype=np.float64)
            loops.append(_in_units(F, Z, own, rate))
            factors.append(signals.names)
    return CellInUnits(loops, np.array(box), names, np.array(bounds), factors, unit), ""


def _in_units(F: Floats, Z: Floats, unit: Floats, rate: float) -> MovingLoop:
    """Return a piece in units of the box, of the wind's rate, and of each w."""
    known = np.concatenate([unit, [rate, 1.0]])
    scale, first = np.zeros(len(Z)), len(known)
    for i, row in enumerate(np.abs(Z)):
        scale[i] = max(float((row[:first] * known).max()), 1e-9)
        scale[i] = max(scale[i], float((row[first:] * scale).max()))
    whole = np.concatenate([known, scale])
    return MovingLoop(F * whole / unit[:, None], Z * whole / scale[:, None], scale)


def function_at(subject: Subject, around: Sequence[Fitted]) -> tuple[Rows | None, str]:
    """Return P at the wind that the given one or two cells have in common, pitch states in rad.

    It is the least set for the smaller of their rates, with the ranges of both; it may leave their
    boxes.
    """
    rate = min(one.rate for one in around)
    loops: list[MovingLoop] = []
    widths: list[Floats] = []
    unit: Floats | None = None
    for one in around:
        posed, why = pose(subject, one.winds, one.sides, rate, unit, one.cuts)
        if posed is None:
            return None, why
        unit = posed.unit
        loops += posed.loops
        widths.append(posed.rows)
    Q = least_set(loops, np.vstack(widths), *min(one.pace for one in around), THINNEST)
    if Q is None or unit is None:
        return None, "no quadratic function was found"
    return in_decimals(np.linalg.inv(Q) / np.outer(unit, unit)), ""


def in_decimals(P: Floats) -> Rows:
    """Return a symmetric matrix in decimals."""
    n = len(P)
    return [[decimal((P[i, j] + P[j, i]) / 2) for j in range(n)] for i in range(n)]


def refitted(subject: Subject, at: Fitted, ends: tuple[Rows, Rows], most: float = np.inf) -> Fitted:
    """Return the cell with a box that holds the sets at both ends, by its present ranges.

    Parameters
    ----------
    most : the largest factor of a side.
    """
    posed, _ = pose(subject, at.winds, at.sides, at.rate, cuts=at.cuts)
    if posed is None:
        return at
    unit = np.outer(posed.unit, posed.unit)
    filled = [
        np.sqrt(np.einsum("ri,ij,rj->r", posed.rows, Q, posed.rows))
        for Q in (np.linalg.inv(np.array(P, dtype=np.float64) * unit) for P in ends)
    ]
    wider = np.minimum(np.maximum(*filled) * CLOSE, most)
    return replace(at, sides=resized(subject, at.sides, posed.by_side(wider)))


def with_moves(
    subject: Subject, winds: Span, sides: Sides, ends: tuple[Rows, Rows], moves: Moves
) -> Sides:
    """Return the box with room for moves beside the sets at both ends, by side.

    Schedule wind, signal and effort: each takes from the bounds of those that come later.

    Raises
    ------
    Refused : the checker refuses a cell with such a box.
    """
    for name in ("schedule", "signal", "effort"):
        cell = Cell(subject.plant, subject.law, subject.machine, winds, sides)
        h, bound = rows(cell, moving_factors(cell))[name]
        row = np.array(h, dtype=np.float64)
        sets = (np.linalg.inv(np.array(in_units(cell, P), dtype=np.float64)) for P in ends)
        reach = max(float(np.sqrt(row @ Q @ row)) for Q in sets)
        more = max(reach * LEAST_ROOM, reach + MORE * moves.get(name, 0.0)) - float(bound)
        if more > 0:
            side = float(getattr(sides, name)) + more
            sides = replace(sides, **{name: Fraction(f"{side:.5g}")})
    return sides


def stated_cell(
    subject: Subject, at: Fitted, ends: tuple[Rows, Rows], rates: Sequence[float]
) -> tuple[MovingCell | None, str]:
    """Return the cell with the largest of some rates for which it holds, or None and the reason."""
    why = "no rate was tried"
    low, high = (float(v) for v in at.winds)
    for rate in rates:
        posed, why = pose(subject, at.winds, at.sides, rate, cuts=at.cuts)
        if posed is None:
            return None, why
        unit = np.outer(posed.unit, posed.unit)
        first, second = (np.array(one, dtype=np.float64) * unit for one in ends)
        found = multipliers_of(posed.loops, (first, second), rate * (second - first) / (high - low))
        if found is None:
            why = "no multipliers were found"
            continue
        tau = [
            {
                name: tuple(map(decimal, pair))
                for name, *pair in zip(names, *(end / loop.scale**2 for end in both), strict=True)
            }
            for names, both, loop in zip(posed.factors, found.multipliers, posed.loops, strict=True)
        ]
        stated = MovingCell(
            winds=at.winds,
            ends=ends,
            wind_rate=Fraction(f"{rate:.3g}"),
            decay=Fraction(f"{found.decay:.5g}"),
            residual_share=Fraction(f"{found.residual_share:.5g}"),
            sides=at.sides,
            multipliers=tau,
            cuts=cut_winds(at.sides, at.cuts),
        )
        kept = examined(subject.plant, subject.law, subject.machine, stated)
        if not isinstance(kept, str):
            return stated, ""
        why = kept
    return None, why
