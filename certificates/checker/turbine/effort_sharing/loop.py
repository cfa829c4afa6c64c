r"""Enclosures of the loop's coefficients in one wind cell with a moving schedule wind.

``loop_claim`` says what follows from the coefficients; this module computes their bounds.  Symbols
are those of docs/effort-sharing-loop.md.  Nothing is linearised: a mean value of a function g that
is continuously differentiable is a g'(s) with g(p) - g(q) = g'(s) (p - q), s between p and q.  Such
factors change with time in an unknown way; only their ranges are used.

Assumed is that xi = (e, zeta, x) lies in the box |e| <= e_bar, |zeta| <= zeta_bar,
|e - x| <= s_bar.  Then U is in q* + gamma [-s_bar, s_bar], the demanded efforts, and
b (beta - beta_min) = psi(U) - zeta gives the pitch band [max(psi_low - zeta_bar, 0),
psi_high + zeta_bar] / b above beta_min; its lower end may be cut at 0, because
beta_ref >= beta_min keeps beta at or above beta_min.

Speed.  With the true torque T = s_P T_r + J Delta (T_r stands for s_P T_r below)

    e' = (kappa / J) (T(t, omega, beta, v) - n_g T_rated + n_g E psi(-U)) - omega*' v_s' .       (1)

With beta_U = beta_min + psi(U) / b(v_s), the pitch that the law asks for, the torque is taken apart
along a path from (omega, beta, v) to (omega*, beta_U, v_s):

    T(omega, beta, v) = [T_r(omega, beta, v) - T_r(omega, beta, v_s)]       = J d (v - v_s)
                      + [T_r(omega, beta, v_s) - T_r(omega*, beta, v_s)]    = (J / kappa) a e
                      + [T(omega*, beta, v_s) - T(omega*, beta_U, v_s)]     = J sigma zeta
                      + T(omega*, beta_U, v_s)                                                   (2)

- d is a mean value of dT_r/dv / J over winds between v and v_s; a of kappa dT_r/domega / J over
  speeds between omega and omega*.  Delta cancels in both.
- beta - beta_U = -zeta / b, and sigma is a mean value of -dT/dbeta / (J b) over the pitch band,
  which contains beta and beta_U.

The other terms of (1) depend on U alone.  With m = n_g E / J let, at fixed v_s,

    g(s) = T(omega*, beta_min + psi(s) / b, v_s) / J + m psi(-s) .

Because F(s) + F(-s) = 1, its derivative -sigma F(s) - m F(-s) is -(m - F (m - sigma)), and

    g(U) = g(q*) - (m - F (m - sigma)) gamma (e - x)                                             (3)

with F and sigma at one and the same point s of the curve beta = beta_min + psi(s) / b.  This
matters near rated wind: a large share F occurs, and a small sigma occurs, but where F is large the
curve has left the small angles at which pitch has no effect.

At s = q* the tables leave a residual r(v_s) = g(q*) - n_g T_rated / J (``wind_cell``); Delta is
zero there.  With S = kappa sigma and Gamma = kappa gamma (m - F (m - sigma))

    e' = (a - Gamma) e + S zeta + Gamma x + w_e ,                                                (4)
    w_e = kappa (r + d (v - v_s)) - omega*' v_s' .

Lag.  zeta' = F(U) U' - b' v_s' (beta - beta_min) - b beta', where x' = -nu e,
U' = q*' v_s' + gamma' v_s' (e - x) + gamma (e' - x') and b (beta - beta_min) = psi(U) - zeta.  So
with Phi = F(U) gamma and N = F(U) (q*' + gamma' (e - x)) - psi(U) b' / b

    zeta' = Phi (e' + nu e) + v_s' N + (b' / b) v_s' zeta - b beta' .

The pitch drive sees (beta_ref - beta) / tau = y = zeta / (b tau).  For |y| <= y_max =
zeta_bar / (b tau) it moves at sat(y) = h y with h from h_min = min(1, rate limit / y_max) to 1, so
b beta' = T zeta with T = h / tau, and

    zeta' = Phi (e' + nu e) - (T - (b' / b) v_s') zeta + w_zeta ,  w_zeta = v_s' N .             (5)

With (4) in (5), Gamma, S and a those of (4) at the same time:

    zeta' = Phi (a - Gamma + nu) e + (Phi S - T + (b' / b) v_s') zeta + Phi Gamma x
            + Phi w_e + w_zeta .                                                                 (6)
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
