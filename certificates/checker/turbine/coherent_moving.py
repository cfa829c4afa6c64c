r"""What a moving schedule wind does to the loop in one cell, after what the law feeds forward.

For |v_s'| <= rho, with N = F(U) (q*' + gamma' (e - x)) - psi(U) b' / b:

    drive     h_min = min(1, (limit - lead rho |N / b|) / y_max) with lead = tau_lead / tau: the
              least secant of the pitch rate limit from the lead's own rate
    torque    |omega*' - kappa m mu f| for mu from min(1, g / |f| rho, psi(-U_high) / |f| rho) to 1:
              what reaches the generator of f v_s' held within +-g, below rated torque
    lag       |w_zeta| <= max(|1 - lead| rho |N|, rho |N| - psi(U) / tau): the lead cancels
              v_s' N but where the lower pitch limit cuts it

All in rationals but for |N|, which is bracketed.
"""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.interval import (
    ONE,
    add,
    div,
    enclose,
    magnitude,
    mul,
    point,
    sub,
)
from takagi.certificates.checker.turbine.coherent_inputs import Box, Law, Plant
from takagi.certificates.checker.turbine.coherent_residual import slope

__all__ = ["Moving"]

ZERO, FULL = Fraction(0), Fraction(1)


class Moving:
    """One cell at one wind rate: schedule winds from node k to node k + 1."""

    def __init__(
        self,
        plant: Plant,
        law: Law,
        box: Box,
        kappa: tuple[Fraction, Fraction],
        efforts: tuple[Fraction, Fraction],
        k: int,
        rate: Fraction,
    ) -> None:
        self.plant, self.law, self.box, self.kappa = plant, law, box, kappa
        self.low, self.high = efforts
        self.k, self.rate = k, rate
        self.least_b = min(law.effectiveness[k : k + 2])
        self.lead = law.lead / plant.lag
        self.asked, self.turn = self._asked()

    def _slope(self, column: list[Fraction]) -> Fraction:
        return slope(column, self.law.wind, self.k)

    def _asked(self) -> tuple[Fraction, Fraction]:
        """Return bounds of |N| and of |N / b|."""
        law, eps = self.law, self.law.overlap
        b = enclose(self.least_b, max(law.effectiveness[self.k : self.k + 2]))
        signal = enclose(-self.box.speed_signal, self.box.speed_signal)
        moved = add(mul(signal, point(self._slope(law.gamma))), point(self._slope(law.effort)))
        held = enclose(share(self.low, eps), share(self.high, eps))
        shed = enclose(psi(self.low, eps), psi(self.high, eps))
        relative = div(point(self._slope(law.effectiveness)), b)
        N = sub(mul(held, moved), mul(shed, relative))
        return Fraction(magnitude(N), ONE), Fraction(magnitude(div(N, b)), ONE)

    def lag_rates(self) -> tuple[Fraction, Fraction] | None:
        """Return the ends of h / tau, or None where the lead alone exceeds the pitch rate limit."""
        demanded = self.box.effort_lag / (self.least_b * self.plant.lag)
        room = (self.plant.rate_limit - self.lead * self.rate * self.turn) / demanded
        if room <= 0:
            return None
        return min(FULL, room) / self.plant.lag, 1 / self.plant.lag

    def effectiveness_slope(self) -> Fraction:
        """Return |b' / b|."""
        return abs(self._slope(self.law.effectiveness)) / self.least_b

    def reference_slope(self) -> Fraction:
        """Return |omega*' - kappa m mu f|."""
        f, g = self.law.inertia[self.k], self.law.inertia_limit[self.k]
        reach, least = abs(f) * self.rate, FULL
        if reach > 0:
            least = min(FULL, g / reach, psi(-self.high, self.law.overlap) / reach)
        m = self.law.effort_torque * self.plant.gear_per_inertia
        ends = (self.kappa[0] * least, self.kappa[1])
        return max(abs(self._slope(self.law.speed) - m * f * part) for part in ends)

    def lag_disturbance(self) -> Fraction:
        """Return a bound of |w_zeta|."""
        left = abs(1 - self.lead) * self.asked * self.rate
        return max(left, self._cut()) if self.lead > 0 else left

    def _cut(self) -> Fraction:
        """Return sup of rho |N| - psi / tau, at least 0, from |N| <= A F + |b'/b| psi.

        On the ramp psi = eps F^2, beyond it F = 1 and psi >= eps: below A F - c eps F^2 all along.
        """
        law, eps = self.law, self.law.overlap
        A = abs(self._slope(law.effort)) + abs(self._slope(law.gamma)) * self.box.speed_signal
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
        """Return the least torque that the law may ask for, before its limits."""
        law = self.law
        ahead = min(abs(law.inertia[self.k]) * self.rate, law.inertia_limit[self.k])
        return law.rated_torque - law.effort_torque * (psi(-self.low, law.overlap) + ahead)

    def largest_pitch(self) -> Fraction:
        """Return the largest pitch that the law may ask for, before its limits."""
        law = self.law
        asked = law.pitch_min + psi(self.high, law.overlap) / self.least_b
        return asked + law.lead * self.rate * self.turn
