"""Cells of a ``schedule-rate`` candidate in the units of a solver.

A solver sees states of size one: each is measured in the side of its box, and what follows another
state from that state.  Boxes are rounded here as a certificate writes them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.running_loop.cell import down
from takagi.certificates.checker.turbine.running_loop.equations import states
from takagi.certificates.checker.turbine.running_loop.inputs import Span
from takagi.certificates.checker.turbine.scheduled_loop.schedule_cell import ScheduleCell
from takagi.certificates.checker.turbine.scheduled_loop.schedule_claim import lead_of
from takagi.certificates.checker.turbine.scheduled_loop.schedule_inputs import ScheduleSides
from takagi.certificates.checker.turbine.scheduled_loop.schedule_loop import (
    ETA,
    FIRST,
    LAG,
    SECOND,
    SEEN,
    E,
    M,
    P,
    Q,
    X,
    schedule_equations,
    schedule_factors,
    schedule_rows,
)
from takagi.certificates.claims.turbine.running_loop.candidate import Subject
from takagi.certificates.claims.turbine.scheduled_loop.schedule_program import ScheduleLoop
from takagi.models.arrays import Floats

# Sides that no factor depends on, in the order of the rows: they are what the limits allow.
LIMITED = ("integral", "measured_rate", "innovation", "drive")
# The share of the pitch rate's limit that the rate of the filtered speed may take.
SENT = Fraction(23, 25)


@dataclass(frozen=True, slots=True, eq=False)
class PosedCells:
    """Cells in units of the solver; ``unit`` are the columns of the states in these units."""

    cells: list[ScheduleCell]
    loops: list[ScheduleLoop]
    names: list[list[str]]
    factors: list[list[str]]
    lead: Span
    unit: Floats


def rounded_box(subject: Subject, gain: Fraction, sides: Mapping[str, float]) -> ScheduleSides:
    """Return a box with four digits; the sides that no factor depends on are what limits allow.

    Parameters
    ----------
    gain : the largest pitch per signal: most of the rate of the pitch that is sent is this times
        the rate of the filtered speed.
    """
    plant = subject.plant
    limited = {
        "drive": plant.rate_limit * plant.lag,
        "innovation": plant.rate_limit / 2,
        "measured_rate": plant.rate_limit * SENT / gain,
    }
    rounded = {name: Fraction(f"{value:.4g}") for name, value in sides.items()}
    short = {name: down(value) for name, value in limited.items()}
    return ScheduleSides(**rounded, **short)


def posed_cells(
    subject: Subject, winds: Sequence[Span], boxes: Sequence[ScheduleSides], rate: float
) -> PosedCells:
    """Return the cells for a solver; refuses boxes that no claim allows."""
    cells = [
        ScheduleCell(subject.plant, subject.law, subject.machine, *one)
        for one in zip(winds, boxes, strict=True)
    ]
    lead, unit = lead_of(cells), _unit(cells)
    loops, names, factors = [], [], []
    for cell in cells:
        span = schedule_factors(cell, lead)
        signals, rates = schedule_equations(cell, span)
        F = np.array([signals.row(one) for one in rates], dtype=np.float64)
        Z = np.array([signals.row(one) for one in signals.outer], dtype=np.float64)
        rows = schedule_rows(cell, span)
        if min(bound for _, bound in rows.values()) <= 0:
            raise Refused("the ranges are wider than the box")
        scaled = {
            name: np.array(h, dtype=np.float64) @ unit / float(bound)
            for name, (h, bound) in rows.items()
        }
        loops.append(_in_units(F, Z, unit, rate, scaled, float(cell.schedule_rate)))
        names.append([name for name in rows if name not in LIMITED])
        factors.append(signals.names)
    return PosedCells(cells, loops, names, factors, lead, unit)


def _unit(cells: Sequence[ScheduleCell]) -> Floats:
    """Return the solver's states as columns: what follows another state is measured from it."""
    sides, n = cells[len(cells) // 2].sides, states(cells[0].machine)
    follow = ((M, E), (SEEN, E), (Q, LAG), (FIRST, E), (SECOND, E))
    unit, size = np.eye(n), np.zeros(n)
    for i, j in follow:
        if i < n:
            unit[i, j] = 1
    speed, pitch, signal, wind = (
        float(getattr(sides, name)) for name in ("speed", "pitch", "signal", "wind")
    )
    named = {
        E: speed, P: pitch, X: signal, LAG: wind, M: speed / 5, SEEN: speed / 5, Q: wind * 2 / 5,
        ETA: pitch, FIRST: speed / 8, SECOND: speed / 4,
    }  # fmt: skip
    for i in range(n):
        size[i] = named[i]
    return unit * size


def _in_units(
    F: Floats, Z: Floats, unit: Floats, rate: float, rows: Mapping[str, Floats], moved: float
) -> ScheduleLoop:
    n, k = len(unit), len(Z)
    whole = np.eye(n + 2 + k)
    whole[:n, :n], whole[n, n] = unit, rate
    outer, scale = Z @ whole, np.ones(k)
    for i, row in enumerate(np.abs(outer)):
        scale[i] = max(float(row[: n + 2].max()), float((row[n + 2 :] * scale).max()), 1e-9)
    whole[n + 2 :, n + 2 :] = np.diag(scale)
    return ScheduleLoop(
        rates=np.asarray(np.linalg.solve(unit, F @ whole), dtype=np.float64),
        outer=Z @ whole / scale[:, None],
        scale=scale,
        rows=np.array([row for name, row in rows.items() if name not in LIMITED]),
        limits=np.array([rows[name] for name in LIMITED]),
        moved=moved,
    )
