"""Enclosures of the loop's coefficients in one wind cell, from the law's tables and the surface.

The derivation of each coefficient is in ``coherent``; here it is only bounded.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.interval import (
    ONE,
    Interval,
    add,
    div,
    enclose,
    hull,
    magnitude,
    mul,
    point,
    square,
    sub,
    within,
)
from takagi.certificates.checker.turbine.coherent_inputs import Box, Law, Plant, Uncertainty
from takagi.certificates.checker.turbine.coherent_moving import Moving
from takagi.certificates.checker.turbine.coherent_residual import residual

__all__ = ["Loop"]

PIECES = 8
Range = tuple[Fraction, Fraction]


class Loop:
    """One cell: schedule winds from node k to node k + 1 that move at up to ``rate``."""

    def __init__(
        self,
        plant: Plant,
        law: Law,
        box: Box,
        uncertainty: Uncertainty,
        k: int,
        rate: Fraction,
    ) -> None:
        self.plant, self.law, self.box, self.k = plant, law, box, k
        self.frozen, self.kappa = uncertainty.frozen_wake, uncertainty.kappa
        self.power = uncertainty.power
        self.wind = enclose(law.wind[k], law.wind[k + 1])
        self.c = point(plant.torque_per_inertia)
        self.b = self._range(law.effectiveness)
        gammas, efforts = law.gamma[k : k + 2], law.effort[k : k + 2]
        # The efforts that the set can demand: q* + gamma (e - x).
        self.low = min(q - g * box.speed_signal for q in efforts for g in gammas)
        self.high = max(q + g * box.speed_signal for q in efforts for g in gammas)
        # b (beta - beta_min) = psi(U) - zeta, and pitch never goes below its lower limit.
        owed = max(self._psi(self.low) - box.effort_lag, Fraction(0))
        self.owed = enclose(owed, self._psi(self.high) + box.effort_lag)
        self.pitch = add(div(self.owed, self.b), point(law.pitch_min))
        self.moving = Moving(plant, law, box, self.kappa, (self.low, self.high), k, rate)

    def range_failure(self, stated: dict[str, list[Fraction]]) -> str:
        """Return the name of a coefficient that leaves its stated range, or nothing."""
        for name, (low, high) in self._rational_ranges().items():
            if not stated[name][0] <= low <= high <= stated[name][1]:
                return name
        for name, found in self._enclosed_ranges().items():
            if not within(found, *stated[name]):
                return name
        return ""

    def size_failure(self, stated: dict[str, Fraction]) -> str:
        """Return the name of a coefficient that exceeds its stated size, or nothing."""
        moving = self.moving
        for name, size in (
            ("inertia_gain", self.kappa[1]),
            ("effectiveness_slope", moving.effectiveness_slope()),
            ("reference_slope", moving.reference_slope()),
            ("lag_disturbance", moving.lag_disturbance()),
        ):
            if size > stated[name]:
                return name
        for name, found in self._magnitudes():
            if found * stated[name].denominator > stated[name].numerator * ONE:
                return name
        return ""

    def limits_failure(self) -> str:
        """Return why the set may demand what the actuators cannot deliver, or nothing."""
        if self.moving.least_torque() < 0:
            return "negative torque may be demanded"
        most = self.law.pitch_max
        if self.pitch[1] > most * ONE or self.moving.largest_pitch() > most:
            return "pitch beyond its limit may be demanded"
        if self.moving.lag_rates() is None:
            return "the pitch lead exceeds the pitch rate limit"
        return ""

    def _psi(self, s: Fraction) -> Fraction:
        return psi(s, self.law.overlap)

    def _share(self, low: Fraction, high: Fraction) -> Range:
        return share(low, self.law.overlap), share(high, self.law.overlap)

    def _range(self, column: list[Fraction]) -> Interval:
        a, b = column[self.k], column[self.k + 1]
        return enclose(min(a, b), max(a, b))

    def _tip_speed(self, speed_error: Fraction, wind_error: Fraction) -> Interval:
        """Return the range of R (omega* + e) / (v_s + dv): monotone in each, so at corners."""
        corners = [
            self.plant.radius * (self.law.speed[i] + e) / (self.law.wind[i] + dv)
            for i in (self.k, self.k + 1)
            for e in {-speed_error, speed_error}
            for dv in {-wind_error, wind_error}
        ]
        return enclose(min(corners), max(corners))

    def _rational_ranges(self) -> dict[str, Range]:
        """Return the coefficients that need no enclosure."""
        gammas = self.law.gamma[self.k : self.k + 2]
        low, high = self._share(self.low, self.high)
        # A lead beyond the rate limit is refused by limits_failure; here it leaves no secant.
        return {
            "share_gain": (low * min(gammas), high * max(gammas)),
            "lag_rate": self.moving.lag_rates() or (-1 / self.plant.lag, 1 / self.plant.lag),
        }

    def _enclosed_ranges(self) -> dict[str, Interval]:
        """Return the coefficients that come from the surface."""
        kappa, gamma = enclose(*self.kappa), self._range(self.law.gamma)
        power = enclose(*self.power)
        ratio = self._tip_speed(self.box.speed_error, Fraction(0))
        at_trim = self._tip_speed(Fraction(0), Fraction(0))
        steep = mul(self.plant.surface.bounds(ratio, self.pitch, 1, 0), self.wind)
        return {
            "stiffness": mul(mul(kappa, power), mul(steep, mul(self.c, point(self.plant.radius)))),
            "loop_gain": mul(mul(kappa, gamma), self._curve_gain(at_trim)),
            "lag_gain": mul(kappa, self._sigma(at_trim, self.pitch)),
        }

    def _magnitudes(self) -> Iterator[tuple[str, int]]:
        """Yield the coefficients that enter by their size, over 10^36."""
        yield "residual", residual(self.plant, self.law, self.k, self.power)
        yield "wind_gain", magnitude(mul(enclose(*self.power), self._wind_gain()))

    def _wind_gain(self) -> Interval:
        """Return dT_r/dv / J = c v (2 c_Q - lambda c_Q,lambda)."""
        error = self.box.wind_share * self.law.wind[self.k]
        ratio = self._tip_speed(self.box.speed_error, error)
        bounds = self.plant.surface.bounds
        value = bounds(ratio, self.pitch)
        inner = sub(add(value, value), mul(ratio, bounds(ratio, self.pitch, 1, 0)))
        wind = enclose(self.law.wind[self.k] - error, self.law.wind[self.k + 1] + error)
        return mul(mul(inner, wind), self.c)

    def _sigma(self, ratio: Interval, pitch: Interval) -> Interval:
        """Return -s dT_r/dbeta / (J b), up to the frozen wake's where that is asked."""
        slope_ = mul(mul(self.plant.surface.bounds(ratio, pitch, 0, 1), square(self.wind)), self.c)
        sigma = mul(enclose(*self.power), div((-slope_[1], -slope_[0]), self.b))
        if not self.frozen:
            return sigma
        return sigma[0], max(sigma[1], div(self._range(self.law.limit), self.b)[1])

    def _curve_gain(self, ratio: Interval) -> Interval:
        """Return m - F (m - sigma) along beta = beta_min + psi(s) / b, piece by piece."""
        m = point(self.law.effort_torque * self.plant.gear_per_inertia)
        found = []
        for low, high in self._pieces():
            held = enclose(*self._share(low, high))
            if held[1] <= 0:
                found.append(m)
                continue
            shed = enclose(self._psi(low), self._psi(high))
            pitch = add(div(shed, self.b), point(self.law.pitch_min))
            found.append(sub(m, mul(held, sub(m, self._sigma(ratio, pitch)))))
        return hull(*found)

    def _pieces(self) -> list[Range]:
        """Return the efforts the set can demand, cut finely where the ramp bends."""
        eps, cuts = self.law.overlap, {self.low, self.high}
        start, stop = max(self.low, -eps), min(self.high, eps)
        if start < stop:
            cuts |= {start + (stop - start) * i / PIECES for i in range(PIECES + 1)}
        ordered = sorted(cuts)
        return list(zip(ordered, ordered[1:], strict=False))
