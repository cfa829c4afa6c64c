"""Enclosures of the loop's coefficients in one wind cell, from the law's tables and the surface.

``loop_claim`` derives each coefficient; this module computes its bounds.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import pairwise

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.interval import ONE, Interval, enclose, hull, point
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative, positive
from takagi.certificates.checker.turbine.effort_sharing.corners import Stated
from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
from takagi.certificates.checker.turbine.effort_sharing.moving_schedule import Moving
from takagi.certificates.checker.turbine.effort_sharing.table_residual import residual

PIECES = 8


class Loop(Moving):
    """One cell: schedule winds from node k to node k + 1 that move at up to ``rate``."""

    def __init__(self, subject: Subject, k: int, rate: Fraction) -> None:
        super().__init__(subject, k, rate)
        # b (beta - beta_min) = psi(U) - zeta, and pitch never goes below its lower limit.
        lag, eps = self.box.effort_lag, self.law.overlap
        owed = max(psi(self.low, eps) - lag, Fraction(0))
        self.reached = self.pitch(enclose(owed, psi(self.high, eps) + lag))

    def enclosed(self, stated: Stated) -> Obligations:
        """Yield that each coefficient lies in its stated range, or is at most its stated size.

        Raises
        ------
        Refused : an enclosure that is refused.
        """
        for name, found in self.ranges():
            (low, high), failure = stated.ranges[name], f"the loop's {name} leaves the stated range"
            yield nonnegative(Fraction(found.low, ONE) - low, failure)
            yield nonnegative(high - Fraction(found.high, ONE), failure)
        for name, size in self.sizes():
            failure = f"the loop's {name} exceeds the stated bound"
            yield nonnegative(stated.sizes[name] - size, failure)

    def limits(self) -> Obligations:
        """Yield that commands in the set do not exceed the actuator limits."""
        most, beyond = self.law.pitch_max, "pitch beyond its limit may be demanded"
        yield nonnegative(self.least_torque(), "negative torque may be demanded")
        yield nonnegative(most - Fraction(self.reached.high, ONE), beyond)
        yield nonnegative(most - self.largest_pitch(), beyond)
        yield positive(self.drive_room(), "the pitch lead exceeds the pitch rate limit")

    def ranges(self) -> Iterator[tuple[str, Interval]]:
        """Yield the coefficients that enter with their sign."""
        (least, most), eps = self.ends(self.law.gamma), self.law.overlap
        low, high = share(self.low, eps) * least, share(self.high, eps) * most
        yield "share_gain", enclose(low, high)
        # A lead beyond the rate limit fails in ``limits``; here no secant exists then.
        yield "lag_rate", enclose(*self.lag_rates() or (-1 / self.plant.lag, 1 / self.plant.lag))
        kappa, power = enclose(*self.uncertainty.kappa), enclose(*self.uncertainty.power)
        ratio = self._tip_speed(self.box.speed_error, Fraction(0))
        steep = self.plant.surface.bounds(ratio, self.reached, 1, 0) * self.wind
        yield "stiffness", kappa * power * (steep * (self.c * self.radius))
        at_trim = self._tip_speed(Fraction(0), Fraction(0))
        yield "loop_gain", kappa * self.range(self.law.gamma) * self._curve_gain(at_trim)
        yield "lag_gain", kappa * self._sigma(at_trim, self.reached)

    def sizes(self) -> Iterator[tuple[str, Fraction]]:
        """Yield the coefficients that enter by their size."""
        yield "inertia_gain", self.uncertainty.kappa[1]
        yield "effectiveness_slope", self.effectiveness_slope()
        yield "reference_slope", self.reference_slope()
        yield "lag_disturbance", self.lag_disturbance()
        yield "residual", Fraction(residual(self, self.uncertainty.power), ONE)
        yield "wind_gain", Fraction(self._wind_gain().magnitude(), ONE)

    def _tip_speed(self, speed_error: Fraction, wind_error: Fraction) -> Interval:
        """Return the range of R (omega* + e) / (v_s + dv): monotone in each, so at corners."""
        corners = [
            self.plant.radius * (self.law.speed[i] + e) / (self.law.wind[i] + dv)
            for i in (self.k, self.k + 1)
            for e in {-speed_error, speed_error}
            for dv in {-wind_error, wind_error}
        ]
        return enclose(min(corners), max(corners))

    def _wind_gain(self) -> Interval:
        """Return s dT_r/dv / J, dT_r/dv = J c v (2 c_Q - lambda c_Q,lambda)."""
        low, high = self.ends(self.law.wind)
        error, bounds = self.box.wind_share * low, self.plant.surface.bounds
        ratio = self._tip_speed(self.box.speed_error, error)
        value = bounds(ratio, self.reached)
        inner = value + value - ratio * bounds(ratio, self.reached, 1, 0)
        wind = enclose(low - error, high + error)
        return enclose(*self.uncertainty.power) * (inner * wind * self.c)

    def _sigma(self, ratio: Interval, pitch: Interval) -> Interval:
        """Return -s dT_r/dbeta / (J b), up to the frozen wake's value if that is requested."""
        steep = self.plant.surface.bounds(ratio, pitch, 0, 1) * self.wind.square() * self.c
        sigma = enclose(*self.uncertainty.power) * (-steep / self.b)
        if not self.uncertainty.frozen_wake:
            return sigma
        return Interval(sigma.low, max(sigma.high, (self.range(self.law.limit) / self.b).high))

    def _curve_gain(self, ratio: Interval) -> Interval:
        """Return m - F (m - sigma) along beta = beta_min + psi(s) / b, piece by piece."""
        m = point(self.law.effort_torque * self.plant.gear_per_inertia)
        found = []
        for low, high in self._pieces():
            held = self.share(low, high)
            if held.high <= 0:
                found.append(m)
                continue
            sigma = self._sigma(ratio, self.pitch(self.psi(low, high)))
            found.append(m - held * (m - sigma))
        return hull(*found)

    def _pieces(self) -> Iterator[tuple[Fraction, Fraction]]:
        """Return the efforts the set can demand, subdivided finely where the ramp is curved."""
        eps, cuts = self.law.overlap, {self.low, self.high}
        start, stop = max(self.low, -eps), min(self.high, eps)
        if start < stop:
            cuts |= {start + (stop - start) * i / PIECES for i in range(PIECES + 1)}
        return pairwise(sorted(cuts))
