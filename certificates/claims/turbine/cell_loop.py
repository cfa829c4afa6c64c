"""One wind cell of the effort-sharing loop, with the coefficients that the checker encloses.

The checker's own functions compute every range and size here, so a claim states what the checker
will find, rounded outward to the decimals of a file.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from math import ceil, floor
from typing import Any

from takagi.certificates.checker.arithmetic.effort_ramp import psi
from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Box, Law, Subject, Uncertainty
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop
from takagi.certificates.checker.turbine.effort_sharing.wind_cell import NIL
from takagi.certificates.checker.turbine.rotor import Plant
from takagi.certificates.document.certificate_file import (
    as_read,
    effort_sharing_law_data,
    turbine_data,
)
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, Number, exact
from takagi.models.laws.effort_sharing.law import (
    EffortGains,
    EffortSharingLaw,
    LoopBox,
    LoopCell,
    LoopUncertainty,
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
        self._at_rest: LoopCell | None = None
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
        # Most of the enclosure does not depend on the rate; it is computed once.
        if self._at_rest is None:
            self._at_rest = self._resting()
        disturbance = _bound(self._moving(speed).lag_disturbance())
        return replace(self._at_rest, wind_rate=speed, lag_disturbance=disturbance)

    @property
    def reference_slope(self) -> Fraction:
        """Return |omega*'| [rad/s per m/s]."""
        return abs(self._moving(NIL).slope(self._subject.law.speed))

    def _moving(self, rate: Fraction) -> Loop:
        return Loop(self._subject, self._k, rate)

    def _resting(self) -> LoopCell:
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
