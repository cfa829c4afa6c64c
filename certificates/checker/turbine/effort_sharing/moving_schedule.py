r"""The effect of a moving schedule wind in one cell, after the law's feed-forward.

For |v_s'| <= rho, with N = F(U) (q*' + gamma' (e - x)) - psi(U) b' / b:

    drive     h_min = min(1, (limit - lead rho |N / b|) / y_max) with lead = tau_lead / tau: the
              least secant of the pitch rate limit from the lead's own rate
    torque    |omega*' - kappa m mu f| for mu from min(1, g / |f| rho, psi(-U_high) / |f| rho) to 1:
              the part of f v_s', limited to +-g, that reaches the generator below rated torque
    lag       |w_zeta| <= max(|1 - lead| rho |N|, rho |N| - psi(U) / tau): the lead cancels v_s' N
              except where the lower pitch limit is active

All values are rational, except |N|, which is bracketed.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cached_property

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.interval import ONE, Interval, enclose, point
from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject

ZERO, FULL = Fraction(0), Fraction(1)


class Moving:
    """One cell at one wind rate, and the efforts q* + gamma (e - x) that its set can demand.

    A column of the law is a line between the nodes k and k + 1.
    """

    def __init__(self, subject: Subject, k: int, rate: Fraction) -> None:
        self.plant, self.law, self.box = subject.plant, subject.law, subject.box
        self.k, self.rate, self.uncertainty = k, rate, subject.uncertainty
        self.wind, self.b = self.range(self.law.wind), self.range(self.law.effectiveness)
        self.c, self.radius = point(self.plant.torque_per_inertia), point(self.plant.radius)
        (least, most), steep = self.ends(self.law.effort), self.ends(self.law.gamma)[1]
        self.low = least - steep * self.box.speed_signal
        self.high = most + steep * self.box.speed_signal
        self.least_b = self.ends(self.law.effectiveness)[0]
        self.lead = self.law.lead / self.plant.lag

    def ends(self, column: list[Fraction]) -> list[Fraction]:
        """Return a column's least and greatest value."""
        return sorted(column[self.k : self.k + 2])

    def range(self, column: list[Fraction]) -> Interval:
        return enclose(*self.ends(column))

    def slope(self, column: list[Fraction]) -> Fraction:
        return self.law.slope(column, self.k)

    def psi(self, low: Fraction, high: Fraction) -> Interval:
        """Return the range of the ramp for efforts from low to high."""
        return enclose(psi(low, self.law.overlap), psi(high, self.law.overlap))

    def share(self, low: Fraction, high: Fraction) -> Interval:
        """Return the range of the ramp's slope."""
        return enclose(share(low, self.law.overlap), share(high, self.law.overlap))

    def pitch(self, shed: Interval) -> Interval:
        """Return beta_min + shed / b."""
        return shed / self.b + point(self.law.pitch_min)

    @cached_property
    def asked(self) -> tuple[Fraction, Fraction]:
        """Bounds of |N| and of |N / b|."""
        law, low, high = self.law, self.low, self.high
        signal = enclose(-self.box.speed_signal, self.box.speed_signal)
        moved = signal * point(self.slope(law.gamma)) + point(self.slope(law.effort))
        relative = point(self.slope(law.effectiveness)) / self.b
        N = self.share(low, high) * moved - self.psi(low, high) * relative
        return Fraction(N.magnitude(), ONE), Fraction((N / self.b).magnitude(), ONE)

    def led(self) -> Fraction:
        """Return a bound of the pitch rate that the lead alone commands."""
        return self.lead * self.rate * self.asked[1]

    def drive_room(self) -> Fraction:
        """Return the pitch rate that the lead leaves of the drive's limit."""
        return self.plant.rate_limit - self.led()

    def lag_rates(self) -> tuple[Fraction, Fraction] | None:
        """Return the ends of h / tau, or None where the lead alone exceeds the pitch rate limit."""
        demanded = self.box.effort_lag / (self.least_b * self.plant.lag)
        room = self.drive_room() / demanded
        if room <= 0:
            return None
        return min(FULL, room) / self.plant.lag, 1 / self.plant.lag

    def effectiveness_slope(self) -> Fraction:
        """Return |b' / b|."""
        return abs(self.slope(self.law.effectiveness)) / self.least_b

    def reference_slope(self) -> Fraction:
        """Return |omega*' - kappa m mu f|."""
        f, g = self.law.inertia[self.k], self.law.inertia_limit[self.k]
        reach, least = abs(f) * self.rate, FULL
        if reach > 0:
            least = min(FULL, g / reach, psi(-self.high, self.law.overlap) / reach)
        m = self.law.effort_torque * self.plant.gear_per_inertia
        ends = (self.uncertainty.kappa[0] * least, self.uncertainty.kappa[1])
        return max(abs(self.slope(self.law.speed) - m * f * part) for part in ends)

    def lag_disturbance(self) -> Fraction:
        """Return a bound of |w_zeta|."""
        left = abs(1 - self.lead) * self.asked[0] * self.rate
        return max(left, self._cut()) if self.lead > 0 else left

    def _cut(self) -> Fraction:
        """Return sup of rho |N| - psi / tau, at least 0, from |N| <= A F + |b'/b| psi.

        On the ramp psi = eps F^2, beyond it F = 1 and psi >= eps: below A F - c eps F^2 all along.
        """
        law, eps = self.law, self.law.overlap
        A = abs(self.slope(law.effort)) + abs(self.slope(law.gamma)) * self.box.speed_signal
        A *= self.rate
        c = 1 / self.plant.lag - self.rate * self.effectiveness_slope()
        least, most = share(self.low, eps), share(self.high, eps)
        if c <= 0:
            return max(ZERO, A * most - c * psi(self.high, eps))
        if self.low >= eps:
            return max(ZERO, A - c * self.low)
        F = min(max(A / (2 * c * eps), least), most)
        return max(ZERO, A * F - c * eps * F * F)

    def least_torque(self) -> Fraction:
        """Return the least torque that the law may command, before its limits."""
        law = self.law
        ahead = min(abs(law.inertia[self.k]) * self.rate, law.inertia_limit[self.k])
        return law.rated_torque - law.effort_torque * (psi(-self.low, law.overlap) + ahead)

    def largest_pitch(self) -> Fraction:
        """Return the largest pitch that the law may command, before its limits."""
        asked = self.law.pitch_min + psi(self.high, self.law.overlap) / self.least_b
        return asked + self.plant.lag * self.led()
