r"""Enclosures of the loop's coefficients in one wind cell with a moving schedule wind.

``loop_claim`` derives each coefficient; this module computes its bounds.  For |v_s'| <= rho, with
N = F(U) (q*' + gamma' (e - x)) - psi(U) b' / b, the moving schedule wind adds

    speed     |w_e| by |omega*'| rho
    lag       |w_zeta| <= rho |N|
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from functools import cached_property

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.interval import ONE, Interval, enclose, point
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative
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
        yield nonnegative(self.least_torque(), "negative torque may be demanded")
        # What the law asks for lies in the range that pitch reaches.
        room = self.law.pitch_max - Fraction(self.reached.high, ONE)
        yield nonnegative(room, "pitch beyond its limit may be demanded")

    def ranges(self) -> Iterator[tuple[str, Interval]]:
        """Yield the coefficients that enter with their sign."""
        (least, most), eps = self.over(self.law.gamma), self.law.overlap
        low, high = share(self.efforts[0], eps) * least, share(self.efforts[1], eps) * most
        yield "share_gain", enclose(low, high)
        yield "lag_rate", enclose(*self.lag_rates())
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
        yield "reference_slope", abs(self.slope(self.law.speed))
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

    def lag_rates(self) -> tuple[Fraction, Fraction]:
        """Return the ends of h / tau, h the secant of the pitch rate limit."""
        demanded = self.box.effort_lag / (self.least_b * self.plant.lag)
        return min(FULL, self.plant.rate_limit / demanded) / self.plant.lag, 1 / self.plant.lag

    def effectiveness_slope(self) -> Fraction:
        """Return |b' / b|."""
        return abs(self.slope(self.law.effectiveness)) / self.least_b

    def lag_disturbance(self) -> Fraction:
        """Return rho |N|, a bound of |w_zeta|."""
        law, signal = self.law, enclose(-self.box.speed_signal, self.box.speed_signal)
        moved = signal * point(self.slope(law.gamma)) + point(self.slope(law.effort))
        relative = point(self.slope(law.effectiveness)) / self.b
        N = self.share(self.efforts) * moved - self.psi(self.efforts) * relative
        return self.rate * Fraction(N.magnitude(), ONE)

    def least_torque(self) -> Fraction:
        """Return the least torque that the law may command, before its limits."""
        law = self.law
        return law.rated_torque - law.effort_torque * psi(-self.efforts[0], law.overlap)
