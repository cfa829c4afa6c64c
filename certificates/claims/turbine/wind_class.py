"""The wind class to try in a claim about the effort-sharing loop, cell by cell."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from takagi.certificates.claims.turbine.cell_loop import CellLoop
from takagi.lmi.analysis.invariant_ellipsoid import largest_scale
from takagi.models.arrays import Floats
from takagi.models.laws.effort_sharing.loop_cell import LoopBox, LoopCell, loop_vertices

# The requested rate is lowered if the lag would keep less than this fraction of the pitch drive's
# rate, or if it disturbs the speed by more than this fraction of the control authority.
DRIVE_SHARE = 0.45
ANSWER_SHARE = 0.2
# A cell gets a lower rate if its wind error would be less than these fractions of the requested
# one, and of the one at constant schedule wind.
LEAST_ERROR, LEAST_AT_REST = 0.4, 0.7
LOWER, STEPS = 0.9, 50
# Subtracted from the floating-point result, so that the rounded decimals can still be proved.
RESERVE = 0.985


@dataclass(frozen=True, slots=True)
class WindClass:
    """The requested class of a claim: wind rates, and the proportions of wind errors.

    A rate is lowered where the law's feed-forward or the pitch drive cannot follow it; the errors
    that are stated are the largest that are then found.

    Attributes
    ----------
    wind : nodes [m/s];  error : |v - v_s| [m/s];  rate : |v_s'| [m/s^2], linear between nodes.
    """

    wind: tuple[float, ...] = (3.0, 4.0, 6.0, 10.0, 11.5, 12.0, 12.5, 13.0, 25.0)
    error: tuple[float, ...] = (0.02, 0.04, 0.1, 0.1, 0.08, 0.1, 0.12, 0.15, 0.2)
    rate: tuple[float, ...] = (0.2, 0.2, 0.2, 0.2, 0.3, 0.5, 1.2, 2.0, 2.0)


@dataclass(frozen=True, slots=True, eq=False)
class CellClass:
    """The result of one cell: its enclosure at the rate, multiplier, and wind error [m/s]."""

    cell: LoopCell
    multiplier: float
    wind_error: float


def asked_rates(loops: Sequence[CellLoop], box: LoopBox, shape: WindClass) -> list[Fraction]:
    """Return the wind rate to enclose in each cell [m/s^2], in the decimals that are emitted."""
    rates = []
    for loop in loops:
        wanted = float(np.interp(float(loop.wind.centre), shape.wind, shape.rate))
        rate, answer = _down(wanted), loop.gamma.lower * box.speed_signal
        for _ in range(STEPS):
            if _bearable(loop, rate, answer):
                break
            rate = calmer(rate, LOWER)
        rates.append(rate)
    return rates


def calmer(rate: Fraction, factor: float) -> Fraction:
    """Return a lower rate, in the decimals that are emitted."""
    return _down(factor * float(rate))


def _bearable(loop: CellLoop, rate: Fraction, answer: Fraction) -> bool:
    left = loop.reference_slope(rate) * rate
    room = loop.drive_share(rate) >= min(
        Fraction(str(DRIVE_SHARE)), loop.drive_share(Fraction(0))
    ) * Fraction(9, 10)
    return room and left <= Fraction(str(ANSWER_SHARE)) * answer


def cell_class(P: Floats, loop: CellLoop, rate: Fraction, asked_error: float) -> CellClass:
    """Return the largest wind error of a cell with P, at the rate or a lower one.

    The wind error is 0 if P fails even at constant schedule wind.
    """
    at_rest = _largest_class(P, loop.enclosed(0), loop.widest_error)
    least = min(LEAST_ERROR * asked_error, LEAST_AT_REST * at_rest.wind_error)
    if at_rest.wind_error == 0:
        return at_rest
    for _ in range(STEPS):
        found = _largest_class(P, loop.enclosed(rate), loop.widest_error)
        if found.wind_error >= least:
            return found
        rate = calmer(rate, LOWER)
    return at_rest


def _largest_class(P: Floats, cell: LoopCell, widest: Fraction) -> CellClass:
    v = loop_vertices(cell)
    error, alpha = largest_scale(P, v.A, v.fixed, v.per_wind_error, limit=float(widest))
    # Rounded down: a smaller wind error than the one found is proved by the same numbers.
    allowed = math.floor(RESERVE * error * 1e5) / 1e5
    return CellClass(cell, alpha if allowed else 1.0, allowed)


def _down(value: float) -> Fraction:
    return Fraction(math.floor(value * 1e5), 10**5)
