"""The candidate of a claim of kind ``set-points``: boxes of winds and set-points, each with a P.

Each interval of the law's tables, with all set-points, is one box.  Where no quadratic function is
found, the box is halved along the side that is widest for its kind, down to a least width.  A box
without a function is left out, and the checker says which winds are then not covered.  Nothing is
proved here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, SetpointRange
from takagi.certificates.checker.turbine.effort_sharing.set_points import NAME, Box, Cell, CellLoop
from takagi.certificates.checker.turbine.rotor import Plant, Span
from takagi.certificates.document.model_data import as_read, floats
from takagi.lmi.analysis.common_quadratic import common_lyapunov
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import exact
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.effort_sharing.schedule import effort_at_rest
from takagi.models.turbine.data import Turbine

# The set's bounds: speed error and e - x over rated speed [-], and pitch [rad].
SPEED_ERROR, SPEED_SIGNAL, PITCH = 0.016, 0.024, 0.015
# Widths at which the three sides of a box count the same: wind [m/s], speed and torque over the
# rated ones [-]; and the share of them down to which a box is halved.
WIDTHS, LEAST_WIDTH = (0.5, 0.08, 0.1), 0.05
# Shares of the slowest corner's decay rate that are tried, and of the rate that is stated.
RATES, RESERVE = (0.8, 0.5, 0.2, 0.05), 0.97
# A box that decays more slowly than this [1/s] is halved as well, where it can be.
ENOUGH = 0.004
# How far beyond those at the box's corners an equilibrium is looked for [rad/s^2], and by
# what this grows, so often.
FIRST_PAD, PAD_GROWTH, PADS = 0.002, 1.5, 12
# Of the set's bounds that are tried, until torque does not reach zero.
SHARES = tuple(Fraction(1, 2**k) for k in range(4))
DIGITS = 9
# Boxes in one interval of the law's tables.
MOST_BESIDE = 24


def set_points_claim(
    turbine: Turbine, law: EffortSharingLaw, model: Mapping[str, Any], gains: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the claim as plain data.

    ``model``, ``gains`` : turbine and law as the certificate states them.
    """
    search = _Search(turbine, law, model, gains)
    cells = [cell for k in range(len(search.law.wind) - 1) for cell in search.cells(k)]
    state = ["speed error [rad/s]", "pitch [rad]", *law.state_names[:1]]
    return {"name": NAME, "kind": "set-points", "state": state, "cells": cells}


class _Search:
    """Turbine and law, in floats and as the checker reads them."""

    def __init__(
        self,
        turbine: Turbine,
        law: EffortSharingLaw,
        model: Mapping[str, Any],
        gains: Mapping[str, Any],
    ) -> None:
        data = as_read({"model": model, "gains": gains})
        self.turbine, self.schedule = turbine, law.schedule
        self.plant, self.law = Plant.read(data["model"]), Law.read(data["gains"])
        if self.law.setpoints is None:
            raise ModelError("a claim about set-points needs a law that takes them")
        self.setpoints: SetpointRange = self.law.setpoints
        self.speed_effort = [float(s) for s in self.setpoints.speed_effort]
        self.effort_torque = law.effort_torque
        rated = turbine.rated_rotor_speed
        sizes = (SPEED_ERROR * rated, SPEED_SIGNAL * rated, PITCH)
        error, signal, pitch = (exact(float(f"{size:.3g}")) for size in sizes)
        self.bounds = error, signal, pitch
        self.widths = [WIDTHS[0], WIDTHS[1] * rated, WIDTHS[2] * turbine.rated_torque]

    def cells(self, k: int) -> Iterator[dict[str, Any]]:
        """Yield the cells of an interval of the law's tables, as plain data."""
        law, setpoints = self.law, self.setpoints
        slowest = min(setpoints.lowest_speed - max(law.speed[k : k + 2]), Fraction(0))
        torque = setpoints.lowest_torque, law.rated_torque
        waiting: list[Box] = [((law.wind[k], law.wind[k + 1]), (slowest, Fraction(0)), torque)]
        count = 0
        while waiting:
            box = waiting.pop()
            cell = self._cell(box)
            shares = [float(high - low) for low, high in box] / np.array(self.widths)
            side = int(shares.argmax())
            undivided = shares[side] < LEAST_WIDTH or len(waiting) + count + 2 > MOST_BESIDE
            if not undivided and (cell is None or cell["decay_rate"] < ENOUGH):
                low, high = box[side]
                middle = exact(round(float(low + high) / 2, DIGITS))
                for half in ((low, middle), (middle, high)):
                    waiting.append((*box[:side], half, *box[side + 1 :]))  # type: ignore[arg-type]
            elif cell is not None:
                count += 1
                yield cell

    def _cell(self, box: Box) -> dict[str, Any] | None:
        try:
            shifts = self._shifts(box)
            if shifts is None:
                return None
            # At low winds torque is small, so that the set must be small, too.
            loops = (self._loop(box, shifts, share) for share in SHARES)
            loop = next((loop for loop in loops if loop.least_torque() >= 0), None)
            if loop is None:
                return None
            corners = [floats(A) for A in loop.corners()]
            room = self.law.integral_limit - loop.integral()
        except (Refused, ModelError):
            # The box leaves the tables, or has no equilibrium somewhere: smaller ones may not.
            return None
        if room <= 0 or (P := _quadratic(np.array(corners))) is None:
            return None
        P, rate = self._scaled(P, loop, corners, float(room))
        if rate <= 0:
            return None
        names = ("wind", "reduction", "torque", "shift", "bounds")
        ranges = zip(names, (*box, shifts, loop.cell.bounds), strict=True)
        stated = {name: [float(number) for number in numbers] for name, numbers in ranges}
        return {**stated, "P": P.tolist(), "decay_rate": rate}

    def _shifts(self, box: Box) -> Span | None:
        """Return w_1 and w_2 between which the checker sees an equilibrium."""
        table = self.schedule
        at_corners = []
        for v, reduction, torque in product(*(map(float, span) for span in box)):
            speed = float(np.interp(v, table.wind, table.rotor_speed)) + reduction
            b = float(np.interp(v, table.wind, table.effectiveness))
            effort = effort_at_rest(self.turbine, v, speed, b, table.overlap, torque)
            s = float(np.interp(v, table.wind, self.speed_effort))
            lowered = (self.turbine.rated_torque - torque) / self.effort_torque
            rest = float(np.interp(v, table.wind, table.trim_effort)) + s * reduction + lowered
            at_corners.append(effort - rest)
        pad = FIRST_PAD
        for _ in range(PADS):
            ends = (round(min(at_corners) - pad, 6), round(max(at_corners) + pad, 6))
            shifts = exact(ends[0]), exact(ends[1])
            loop = self._loop(box, shifts)
            if loop.excess(shifts[0]).low > 0 > loop.excess(shifts[1]).high:
                return shifts
            pad *= PAD_GROWTH
        return None

    def _loop(self, box: Box, shifts: Span, share: Fraction = Fraction(1)) -> CellLoop:
        """Return the checker's loop of a cell, with a share of the usual bounds of its set."""
        error, signal, pitch = self.bounds
        bounds = error * share, signal * share, pitch * share
        cell = Cell(box, shifts, bounds, Matrix.identity(3), Fraction(1))
        return CellLoop(self.plant, self.law, self.setpoints, cell)

    def _scaled(
        self, P: Floats, loop: CellLoop, corners: list[Floats], room: float
    ) -> tuple[Floats, float]:
        """Return P with its set just inside all bounds, and the decay rate to state."""
        error, signal, pitch = map(float, loop.cell.bounds)
        turning = float(self.plant.rate_limit * self.plant.lag)
        rows = [
            np.array([1.0, 0.0, 0.0]) / error,
            np.array([1.0, 0.0, -1.0]) / signal,
            np.array([0.0, 1.0, 0.0]) / pitch,
            np.array([0.0, 0.0, 1.0]) / room,
            *(np.array([float(g), -1.0, -float(g)]) / turning for g in loop.signal_gain),
        ]
        inverse = np.linalg.inv(P)
        P = np.round(P * max(h @ inverse @ h for h in rows) * (1 + 1e-6), 3)
        half = np.linalg.inv(np.linalg.cholesky(P))
        rate = min(
            float(np.linalg.eigvalsh(half @ -(A.T @ P + P @ A) @ half.T)[0]) for A in corners
        )
        return P, float(np.floor(RESERVE * rate / 2 * 1e6) / 1e6)


def _quadratic(corners: Floats) -> Floats | None:
    """Return a P with which all corners decay, at the largest of the rates that are tried."""
    slowest = -max(float(np.linalg.eigvals(A).real.max()) for A in corners)
    if slowest <= 0:
        return None
    for share in RATES:
        answer = common_lyapunov(corners, scales=np.full(3, 0.01), decay_rate=share * slowest)
        if answer.P is not None:
            return np.asarray(answer.P)
    return None
