r"""Enclosures of the loop's coefficients in one wind cell with a moving schedule wind.

``loop_claim`` derives each coefficient; this module computes its bounds.  For |v_s'| <= rho, with
N = F(U) (q*' + gamma' (e - x)) - psi(U) b' / b, the law's feed-forward leaves:

    drive     h_min = min(1, (limit - lead rho |N / b|) / y_max) with lead = tau_lead / tau: the
              least secant of the pitch rate limit from the lead's own rate
    torque    |omega*' - kappa m mu f| for mu from min(1, g / |f| rho, psi(-U_high) / |f| rho) to 1:
              the part of f v_s', limited to +-g, that reaches the generator below rated torque
    lag       |w_zeta| <= max(|1 - lead| rho |N|, rho |N| - psi(U) / tau): the lead cancels v_s' N
              except where the lower pitch limit is active
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import cached_property

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.interval import ONE, Interval, enclose, point
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative, positive
from takagi.certificates.checker.turbine.effort_sharing.corners import Stated
from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
from takagi.certificates.checker.turbine.effort_sharing.wind_cell import FULL, NIL, WindCell

PIECES = 8


class Loop(WindCell):
    """One cell: schedule winds from node k to node k + 1 that move at up to ``rate``.

    Its set can demand the efforts q* + gamma (e - x), from ``efforts[0]`` to ``efforts[1]``.
    """

    def __init__(self, subject: Subject, k: int, rate: Fraction) -> None:
        law, self.box, self.rate = subject.law, subject.box, rate
        self.uncertainty = subject.uncertainty
        super().__init__(subject.plant, law, (law.wind[k], law.wind[k + 1]))
        (least, most), steep = self.over(law.effort), self.over(law.gamma)[1]
        away = steep * self.box.speed_signal
        self.efforts = least - away, most + away
        self.least_b = self.over(law.effectiveness)[0]
        self.lead = law.lead / self.plant.lag
        self.power = enclose(*self.uncertainty.power)

    @cached_property
    def reached(self) -> Interval:
        """The pitch range: b (beta - beta_min) = psi(U) - zeta, and not below its lower limit."""
        lag, (low, high) = self.box.effort_lag, (psi(U, self.law.overlap) for U in self.efforts)
        return self.pitch(enclose(max(low - lag, NIL), high + lag))

    def enclosed(self, stated: Stated) -> Obligations:
        """Yield that each coefficient lies in its stated range, or is at most its stated size.

        Raises
        ------
        Refused : an enclosure that is refused.
        """
        for name, enclosure in self.ranges():
            (low, high), failure = stated.ranges[name], f"the loop's {name} leaves the stated range"
            yield nonnegative(Fraction(enclosure.low, ONE) - low, failure)
            yield nonnegative(high - Fraction(enclosure.high, ONE), failure)
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
        (least, most), eps = self.over(self.law.gamma), self.law.overlap
        low, high = share(self.efforts[0], eps) * least, share(self.efforts[1], eps) * most
        yield "share_gain", enclose(low, high)
        # A lead beyond the rate limit fails in ``limits``; here no secant exists then.
        yield "lag_rate", enclose(*self.lag_rates() or (-1 / self.plant.lag, 1 / self.plant.lag))
        kappa, trim = enclose(*self.uncertainty.kappa), self.tip_speed()
        ratio = self.tip_speed(self.box.speed_error)
        steep = self.plant.torque_by_speed(ratio, self.reached, self.wind)
        yield "stiffness", kappa * self.power * steep
        along = self.effort_gain(self._cuts(), lambda pitch: self._sigma(trim, pitch))
        yield "loop_gain", kappa * enclose(least, most) * along
        yield "lag_gain", kappa * self._sigma(trim, self.reached)

    def sizes(self, residual: Fraction | None = None) -> Iterator[tuple[str, Fraction]]:
        """Yield the coefficients that enter by their size; ``residual`` if it is known."""
        yield "inertia_gain", self.uncertainty.kappa[1]
        yield "effectiveness_slope", self.effectiveness_slope()
        yield "reference_slope", self.reference_slope()
        yield "lag_disturbance", self.lag_disturbance()
        if residual is None:
            residual = Fraction(self.residual(self.uncertainty.power), ONE)
        yield "residual", residual
        (low, high), error = self.winds, self.box.wind_share * self.winds[0]
        ratio = self.tip_speed(self.box.speed_error, error)
        steep = self.plant.torque_by_wind(ratio, self.reached, enclose(low - error, high + error))
        yield "wind_gain", Fraction((self.power * steep).magnitude(), ONE)

    def _sigma(self, ratio: Interval, pitch: Interval) -> Interval:
        """Return -s dT_r/dbeta / (J b), up to the frozen wake's value if that is requested."""
        sigma = self.power * (-self.plant.torque_by_pitch(ratio, pitch, self.wind) / self.b)
        if not self.uncertainty.frozen_wake:
            return sigma
        limit = enclose(*self.over(self.law.limit)) / self.b
        return Interval(sigma.low, max(sigma.high, limit.high))

    def _cuts(self) -> set[Fraction]:
        """Return the ends of the efforts, and finer cuts where the ramp is curved."""
        cuts = set(self.efforts)
        if (ramp := self.on_ramp(self.efforts)) is not None:
            cuts |= {ramp[0] + (ramp[1] - ramp[0]) * i / PIECES for i in range(PIECES + 1)}
        return cuts

    # The effect of the moving schedule wind; all values are rational, except |N|.

    @cached_property
    def asked(self) -> tuple[Fraction, Fraction]:
        """Bounds of |N| and of |N / b|."""
        law, signal = self.law, enclose(-self.box.speed_signal, self.box.speed_signal)
        moved = signal * point(self.slope(law.gamma)) + point(self.slope(law.effort))
        relative = point(self.slope(law.effectiveness)) / self.b
        N = self.share(self.efforts) * moved - self.psi(self.efforts) * relative
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
            least = min(FULL, g / reach, psi(-self.efforts[1], self.law.overlap) / reach)
        ends = (self.uncertainty.kappa[0] * least, self.uncertainty.kappa[1])
        speed = self.slope(self.law.speed)
        return max(abs(speed - self.effort_unit * f * part) for part in ends)

    def lag_disturbance(self) -> Fraction:
        """Return a bound of |w_zeta|."""
        remaining = abs(1 - self.lead) * self.asked[0] * self.rate
        return max(remaining, self._cut()) if self.lead > 0 else remaining

    def _cut(self) -> Fraction:
        """Return sup of rho |N| - psi / tau, at least 0, from |N| <= A F + |b'/b| psi.

        On the ramp psi = eps F^2, beyond it F = 1 and psi >= eps: below A F - c eps F^2 all along.
        """
        law, eps, (low, high) = self.law, self.law.overlap, self.efforts
        A = abs(self.slope(law.effort)) + abs(self.slope(law.gamma)) * self.box.speed_signal
        A *= self.rate
        c = 1 / self.plant.lag - self.rate * self.effectiveness_slope()
        least, most = share(low, eps), share(high, eps)
        if c <= 0:
            return max(NIL, A * most - c * psi(high, eps))
        if low >= eps:
            return max(NIL, A - c * low)
        F = min(max(A / (2 * c * eps), least), most)
        return max(NIL, A * F - c * eps * F * F)

    def least_torque(self) -> Fraction:
        """Return the least torque that the law may command, before its limits."""
        law = self.law
        ahead = min(abs(law.inertia[self.k]) * self.rate, law.inertia_limit[self.k])
        return law.rated_torque - law.effort_torque * (psi(-self.efforts[0], law.overlap) + ahead)

    def largest_pitch(self) -> Fraction:
        """Return the largest pitch that the law may command, before its limits."""
        asked = self.law.pitch_min + psi(self.efforts[1], self.law.overlap) / self.least_b
        return asked + self.plant.lag * self.led()
