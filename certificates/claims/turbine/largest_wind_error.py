"""The wind class of every cell: the rate to try, and the largest wind error with one function.

The result is a floating-point candidate, which the checker proves or refuses.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from takagi.certificates.claims.turbine.cell_loop import CellLoop
from takagi.lmi.analysis.decay_rate import fast_decay
from takagi.lmi.analysis.invariant_ellipsoid import decay_rates, largest_scale
from takagi.models.arrays import Floats
from takagi.models.laws.effort_sharing.law import (
    LoopBox,
    LoopCell,
    LoopUncertainty,
    LoopVertices,
    loop_vertices,
)

Tell = Callable[[str], None]

# P is increased by this factor, so that the set stays inside the box after rounding.
SHRINK = 1 + 1e-5


@dataclass(frozen=True, slots=True, eq=False)
class EffortSharingCandidate:
    """All data of a claim, in floating point except the enclosures.

    Attributes
    ----------
    cells : the enclosed loops.
    P : (3, 3) in (e, zeta, x), or None where no common P was found.
    multipliers, wind_error, wind_rate, decay_rate : one per cell; a cell without a candidate has
        wind class and decay 0.
    common_rate : the largest decay rate of one quadratic function over all cells [1/s], and
        settling_P : (3, 3) that function; both for constant wind.
    diagnosis : why there is no P, in words.
    words : the solver's.
    """

    box: LoopBox
    uncertainty: LoopUncertainty
    cells: tuple[LoopCell, ...]
    P: Floats | None
    multipliers: Floats
    wind_error: Floats
    wind_rate: Floats
    decay_rate: Floats
    settling_P: Floats
    common_rate: float
    diagnosis: str
    words: str


def largest_wind_errors(
    P: Floats,
    box: LoopBox,
    uncertainty: LoopUncertainty,
    cells: Sequence[CellLoop],
    rates: Sequence[Fraction],
    error: Floats,
    *,
    words: str = "",
    tell: Tell | None = None,
) -> EffortSharingCandidate:
    """Return for every cell the largest wind error with P, and the decay rate at constant wind.

    Parameters
    ----------
    P : (3, 3), its set inside the box; its decimals are those that a claim states.
    cells : one enclosure per wind cell;  rates : |v_s'| to try in each [m/s^2].
    error : (K - 1,) |v - v_s| to compare with [m/s].
    words : the solver's, on P.   tell : called with a word on progress.
    """
    stated = np.round(P * SHRINK, 4)
    classes = [_cell_class(stated, *cell) for cell in zip(cells, rates, error, strict=True)]
    enclosed = tuple(cell for cell, _, _ in classes)
    corners = [loop_vertices(cell) for cell in enclosed]
    if tell is not None:
        tell("the largest common decay rate")
    settling, common = _settling(stated, corners)
    decay = [max(float(decay_rates(stated, v.at_rest).min()), 0.0) for v in corners]
    return EffortSharingCandidate(
        box=box,
        uncertainty=uncertainty,
        cells=enclosed,
        P=stated,
        multipliers=np.array([round(multiplier, 7) for _, multiplier, _ in classes]),
        wind_error=np.array([allowed for _, _, allowed in classes]),
        wind_rate=np.array([float(cell.wind_rate) for cell in enclosed]),
        decay_rate=np.floor(RESERVE * np.array(decay) * 1e5) / 1e5,
        settling_P=settling,
        common_rate=common,
        diagnosis="",
        words=words,
    )


def _settling(P: Floats, corners: list[LoopVertices]) -> tuple[Floats, float]:
    """Return the quadratic function with the largest decay rate over all corners, and the rate.

    The largest rate is a generalised eigenvalue problem; if it fails, P itself is used.
    """
    A = np.concatenate([v.at_rest for v in corners])
    answer = fast_decay(A)
    candidate = P if answer.P is None else np.asarray(answer.P)
    # The smallest eigenvalue becomes 1000, so three decimals leave P definite and accurate.
    rounded = np.round(candidate * (1e3 / np.linalg.eigvalsh(candidate)[0]), 3)
    rate = RESERVE * float(decay_rates(rounded, A).min())
    return rounded, max(math.floor(rate * 1e6) / 1e6, 0.0)


# The requested rate is lowered if it disturbs the speed by more than this fraction of the control
# authority.
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

    A rate is lowered where the loop cannot follow it; the errors that are stated are the largest
    that are then found.

    Attributes
    ----------
    wind : nodes [m/s];  error : |v - v_s| [m/s];  rate : |v_s'| [m/s^2], linear between nodes.
    """

    wind: tuple[float, ...] = (3.0, 4.0, 6.0, 10.0, 11.5, 12.0, 12.5, 13.0, 25.0)
    error: tuple[float, ...] = (0.02, 0.04, 0.1, 0.1, 0.08, 0.1, 0.12, 0.15, 0.2)
    rate: tuple[float, ...] = (0.2, 0.2, 0.2, 0.2, 0.3, 0.5, 1.2, 2.0, 2.0)


# Of one cell: its enclosure at the rate, the multiplier, and the wind error [m/s].
CellClass = tuple[LoopCell, float, float]


def class_rates(
    loops: Sequence[CellLoop], box: LoopBox, shape: WindClass, wind_filter: float
) -> list[Fraction]:
    """Return the wind rate to enclose in each cell [m/s^2], in the decimals that are emitted.

    The law's filter moves no faster than its distance from the estimate over its time constant [s].
    """
    rates = []
    for loop in loops:
        class_rate = float(np.interp(float(loop.wind.centre), shape.wind, shape.rate))
        if wind_filter > 0:
            class_rate = min(class_rate, float(loop.widest_error) / wind_filter)
        rate, answer = _down(class_rate), loop.gamma.lower * box.speed_signal
        for _ in range(STEPS):
            if loop.reference_slope * rate <= Fraction(str(ANSWER_SHARE)) * answer:
                break
            rate = calmer(rate, LOWER)
        rates.append(rate)
    return rates


def calmer(rate: Fraction, factor: float) -> Fraction:
    """Return a lower rate, in the decimals that are emitted."""
    return _down(factor * float(rate))


def _cell_class(P: Floats, loop: CellLoop, rate: Fraction, asked_error: float) -> CellClass:
    """Return the largest wind error of a cell with P, at the rate or a lower one.

    The wind error is 0 if P fails even at constant schedule wind.
    """
    at_rest = _largest_class(P, loop.enclosed(0), loop.widest_error)
    least_error = min(LEAST_ERROR * asked_error, LEAST_AT_REST * at_rest[2])
    for _ in range(STEPS if at_rest[2] else 0):
        at_rate = _largest_class(P, loop.enclosed(rate), loop.widest_error)
        if at_rate[2] >= least_error:
            return at_rate
        rate = calmer(rate, LOWER)
    return at_rest


def _largest_class(P: Floats, cell: LoopCell, widest: Fraction) -> CellClass:
    v = loop_vertices(cell)
    error, alpha = largest_scale(P, v.A, v.fixed, v.per_wind_error, limit=float(widest))
    # Rounded down: a smaller wind error than the one found is proved by the same numbers.
    allowed = math.floor(RESERVE * error * 1e5) / 1e5
    return cell, alpha if allowed else 1.0, allowed


def _down(value: float) -> Fraction:
    return Fraction(math.floor(value * 1e5), 10**5)
