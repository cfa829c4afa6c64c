"""One wind cell of the effort-sharing loop, with the coefficients that the checker encloses.

The checker's own functions compute every range and size here, so a claim states what the checker
will find, rounded outward to the decimals of a file.

The wind class of every cell: the rate to try, and the largest wind error with one function.

The result is a floating-point candidate, which the checker proves or refuses.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import ceil, floor
from typing import Any

import numpy as np

from takagi.certificates.checker.arithmetic.effort_ramp import psi
from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Box, Law, Subject, Uncertainty
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop
from takagi.certificates.checker.turbine.effort_sharing.wind_cell import NIL
from takagi.certificates.checker.turbine.rotor import Plant
from takagi.certificates.document.certificate_file import effort_sharing_law_data, turbine_data
from takagi.certificates.document.model_data import as_read
from takagi.lmi.analysis.decay_rate import fast_decay
from takagi.lmi.analysis.invariant_ellipsoid import decay_rates, largest_scale
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, Number, exact
from takagi.models.laws.effort_sharing.law import (
    EffortGains,
    EffortSharingLaw,
    LoopBox,
    LoopCell,
    LoopUncertainty,
    LoopVertices,
    loop_vertices,
)
from takagi.models.turbine.data import Turbine

# Decimals of the intervals that a certificate states; rounded outward.
EMITTED_DIGITS = 7
# An end that is a short decimal is bracketed by far less than this.
END_TOLERANCE = Fraction(1, 10**30)


class CellLoop:
    """One cell of the loop, which can be enclosed again for another wind rate at little cost.

    Attributes
    ----------
    wind : schedule winds of the cell [m/s];  gamma : range of the proportional gain [1/s].
    widest_error : the largest |v - v_s| that is enclosed [m/s].

    Parameters
    ----------
    subject : turbine, law, box and uncertainty, as the checker reads them.
    k : the cell lies between the nodes k and k + 1 of the law's schedule.
    residual : as stated of the same cell with other gains, which do not change it; None computes
        it.
    """

    def __init__(self, subject: Subject, k: int, residual: Fraction | None = None) -> None:
        self._subject, self._k, self._residual = subject, k, residual
        resting = self._moving(NIL)
        self.wind = Interval(*resting.winds)
        self.gamma = Interval(*resting.over(subject.law.gamma))
        self.widest_error = subject.box.wind_share * self.wind.lower

    def enclosed(self, rate: Number) -> LoopCell:
        """Return the enclosure for |v_s'| <= rate [m/s^2].

        Raises
        ------
        ModelError : the box leaves the coefficient table, asks for negative torque, or for pitch or
            a pitch rate beyond its limit; the message names the cell and what to reduce.
        """
        speed = exact(rate)
        if speed < 0:
            raise ModelError(f"wind rate {float(speed):g} m/s^2 was given; it must not be negative")
        disturbance = _bound(self._moving(speed).lag_disturbance())
        return replace(self._at_rest, wind_rate=speed, lag_disturbance=disturbance)

    @property
    def reference_slope(self) -> Fraction:
        """Return |omega*'| [rad/s per m/s]."""
        return abs(self._moving(NIL).slope(self._subject.law.speed))

    def _moving(self, rate: Fraction) -> Loop:
        return Loop(self._subject, self._k, rate)

    # Most of the enclosure does not depend on the rate; it is computed once.
    @cached_property
    def _at_rest(self) -> LoopCell:
        loop, law = self._within_limits(), self._subject.law
        try:
            members: dict[str, Any] = {}
            for name, enclosure in loop.ranges():
                exact_range = Interval(Fraction(enclosure.low, ONE), Fraction(enclosure.high, ONE))
                scheduled = name in ("share_gain", "lag_rate")
                members[name] = (
                    exact_range.outward(EMITTED_DIGITS) if scheduled else _stated(exact_range)
                )
            for name, size in loop.sizes(self._residual):
                as_is = name in ("inertia_gain", "effectiveness_slope")
                members[name] = (
                    Interval(NIL, size).outward(EMITTED_DIGITS).upper if as_is else _bound(size)
                )
        except Refused as error:
            box = loop.box
            raise ModelError(
                f"wind cell {self.wind} m/s: {error}. The box is the speed error of "
                f"{float(box.speed_error):.4g} rad/s and the wind share of "
                f"{float(box.wind_share):.4g} about the trim: extend the c_P and c_T tables, "
                "leave these winds out by cut_in and cut_out of the turbine's file, or, from "
                "Python, reduce the speed error or the wind share"
            ) from error
        if self._residual:
            members["residual"] = self._residual
        nu = law.nu[self._k]
        return LoopCell(
            wind=self.wind,
            wind_rate=NIL,
            integral_rate=Interval(nu, nu),
            effectiveness_limit=Interval(*loop.over(law.limit)),
            **members,
        )

    def _within_limits(self) -> Loop:
        """Return the loop; refuses a set that asks for negative torque or too much pitch."""
        loop = self._moving(NIL)
        law = loop.law
        if loop.least_torque() < 0:
            reserve = psi(-loop.efforts[0], law.overlap)
            raise ModelError(
                f"wind cell {self.wind} m/s: the set may demand {float(reserve):.4g} rad/s^2 below "
                "rated effort, but torque reaches "
                f"zero at {float(law.rated_torque / law.effort_torque):.4g}; lower the "
                f"proportional gain there ({float(self.gamma.upper):.4g} 1/s) or the box's speed "
                f"signal ({float(loop.box.speed_signal):.4g} rad/s)"
            )
        largest_pitch = Fraction(loop.reached.high, ONE)
        if largest_pitch > law.pitch_max:
            raise ModelError(
                f"wind cell {self.wind} m/s: the set reaches pitch {float(largest_pitch):.4g} rad, "
                f"beyond the limit {float(law.pitch_max):.4g} rad; reduce the box"
            )
        return loop


def loop_subject(
    turbine: Turbine, law: EffortSharingLaw, box: LoopBox, uncertainty: LoopUncertainty
) -> Subject:
    """Return turbine, law, box and uncertainty as the checker reads them from a file."""
    inertia, power = uncertainty.inertia, uncertainty.power_coefficient
    return Subject(
        Plant.read(as_read(turbine_data(turbine, []))),
        Law.read(as_read(effort_sharing_law_data(law))),
        Box(box.speed_error, box.effort_lag, box.speed_signal, box.wind_share),
        Uncertainty(
            (inertia.lower, inertia.upper), uncertainty.frozen_wake, (power.lower, power.upper)
        ),
    )


def cell_loops(
    turbine: Turbine, law: EffortSharingLaw, box: LoopBox, uncertainty: LoopUncertainty
) -> list[CellLoop]:
    """Return the cells between the nodes of the law's schedule."""
    subject = loop_subject(turbine, law, box, uncertainty)
    return [CellLoop(subject, k) for k in range(len(subject.law.wind) - 1)]


def enclosures_of_gains(
    turbine: Turbine,
    law: EffortSharingLaw,
    box: LoopBox,
    uncertainty: LoopUncertainty,
    rates: Sequence[Number],
) -> Callable[[EffortGains, int], LoopCell]:
    """Return a function of gains and a cell's number: the cell of ``law`` with these gains.

    ``rates`` : |v_s'| of each cell [m/s^2].
    """
    subject = loop_subject(turbine, law, box, uncertainty)
    residuals: dict[int, Fraction] = {}

    def enclosed(gains: EffortGains, k: int) -> LoopCell:
        gamma, nu = (
            [exact(gain) for gain in column.tolist()]
            for column in (gains.proportional, gains.integral_rate)
        )
        subject_of_gains = replace(subject, law=replace(subject.law, gamma=gamma, nu=nu))
        cell = CellLoop(subject_of_gains, k, residuals.get(k)).enclosed(rates[k])
        residuals[k] = cell.residual
        return cell

    return enclosed


def _stated(enclosure: Interval) -> Interval:
    """Return the emitted range: one unit of its last decimal wider than the enclosure."""
    scale = 10**EMITTED_DIGITS
    # Two units stay between the ends even where the tolerance is more than the width.
    low = floor((enclosure.lower + END_TOLERANCE) * scale) - 1
    high = ceil((enclosure.upper - END_TOLERANCE) * scale) + 1
    return Interval(Fraction(low, scale), Fraction(high, scale))


def _bound(value: Fraction) -> Fraction:
    """Return a bound as it is emitted: one unit larger, except if it is exactly zero."""
    return _stated(Interval(value, value)).upper if value else value


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
