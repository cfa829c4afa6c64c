r"""The effect of a varying schedule wind on the loop, after the law's feed-forward.

With |v_s'| <= rho, N = F(U) (q*' + gamma' (e - x)) - psi(U) b' / b and the law's feed-forward
a_f = f v_s' held within +-g, beta_f = tau_lead v_s' N / b:

torque   a_f = mu f v_s' reaches the generator, mu in [mu_min, 1]: less than all only where g or
         rated torque cuts it, and mu_min = min(1, g / |f| rho, psi(-U_high) / |f| rho).  Of the
         moving reference there is left (omega*' - kappa m mu f) v_s'.
drive    sat(y + y0) - y0 = h y for |y0| <= rate limit, with y = zeta / (b tau) and y0 the lead's
         share of the demanded rate; h in [h_min, 1], h_min = min(1, (limit - |y0|) / y_max).
lead     where neither limit acts it cancels v_s' N but for the share 1 - tau_lead / tau.  The lower
         pitch limit cuts a lead that would ask for less than beta_min, and what is then left is at
         most rho |N| - psi(U) / tau.
"""

from __future__ import annotations

from fractions import Fraction

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, exact
from takagi.models.loops.effort_sharing.law_interval import LawInterval
from takagi.models.loops.effort_sharing.loop_cell import LoopBox
from takagi.models.turbine.data import Turbine


class MovingSchedule:
    """The parts of one cell's enclosure that depend on the schedule wind's rate.

    Attributes
    ----------
    torque_share : m = n_g E / J;  kappa : nominal over true inertia.
    asked : range of N [rad/s^2 per m/s];  turn : largest |N / b| [rad/s per m/s^2 of rate].
    """

    def __init__(
        self,
        turbine: Turbine,
        interval: LawInterval,
        box: LoopBox,
        torque_share: Fraction,
        kappa: Interval,
    ) -> None:
        self.law, self.box, self.torque_share, self.kappa = interval, box, torque_share, kappa
        self.lag_time = exact(turbine.pitch_time_constant)
        self.rate_limit = exact(turbine.pitch_rate_limit)
        self.relative = interval.slope("effectiveness") / interval.effectiveness
        moved = interval.signal * interval.slope("gamma") + interval.slope("effort")
        shed = interval.ramp(interval.demand)
        self.asked = interval.share(interval.demand) * moved - shed * self.relative
        self.turn = (self.asked / interval.effectiveness).magnitude
        self.lead = interval.pitch_lead / self.lag_time

    def own_rate(self) -> Fraction:
        """Return the largest pitch rate that the lag asks for, zeta / (b tau) [rad/s]."""
        return self.box.effort_lag / (self.law.effectiveness.lower * self.lag_time)

    def drive_room(self, rate: Fraction) -> Fraction:
        """Return the part of the lag's pitch rate that the limit leaves: h_min, or below 0."""
        return (self.rate_limit - self.lead * rate * self.turn) / self.own_rate()

    def lag_rate(self, rate: Fraction) -> Interval:
        """Return T = h / tau [1/s]; refuses a lead that asks for more than the rate limit."""
        room = self.drive_room(rate)
        if room <= 0:
            raise ModelError(
                f"wind cell {self.law.wind} m/s: a schedule wind that moves at {float(rate):.4g} "
                f"m/s^2 asks for a pitch rate of {float(rate * self.turn):.4g} rad/s by itself, "
                f"and the limit is {float(self.rate_limit):.4g}; lower the wind rate there"
            )
        return Interval(min(Fraction(1), room) / self.lag_time, 1 / self.lag_time)

    def reference_slope(self, rate: Fraction) -> Fraction:
        """Return |omega*' - kappa m mu f| [rad/s per m/s]."""
        law, reach = self.law, abs(self.law.inertia) * rate
        reached = Fraction(1)
        if reach > 0:
            rest = law.psi(-law.demand.upper)
            reached = min(reached, law.effort_limit / reach, rest / reach)
        least, most = self.kappa.lower * reached, self.kappa.upper
        forward = self.torque_share * law.inertia
        return max(abs(law.slope("speed") - forward * part) for part in (least, most))

    def lag_disturbance(self, rate: Fraction) -> Fraction:
        """Return a bound of |w_zeta| [rad/s^3]."""
        left = abs(1 - self.lead) * self.asked.magnitude * rate
        return max(left, self._cut(rate)) if self.lead > 0 else left

    def _cut(self, rate: Fraction) -> Fraction:
        """Return sup of rate |N| - psi / tau over the demanded efforts, at least 0.

        rate |N| <= A F + B psi with A = rate (|q*'| + |gamma'| |e - x|), B = rate |b'/b|, and
        psi >= eps F^2 (equal on the ramp): a quadratic in F, or a line where F = 1.
        """
        law = self.law
        moved = abs(law.slope("gamma")) * law.signal.upper + abs(law.slope("effort"))
        A, k = rate * moved, 1 / self.lag_time - rate * self.relative.magnitude
        low, high = law.demand.lower, law.demand.upper
        share = law.share(law.demand)
        if k <= 0:
            worst = A * share.upper - k * law.psi(high)
        elif low >= law.overlap:
            worst = A - k * low
        else:
            F = min(max(A / (2 * k * law.overlap), share.lower), share.upper)
            worst = A * F - k * law.overlap * F**2
        return max(worst, Fraction(0))

    def torque(self, rate: Fraction) -> Interval:
        """Return the reachable T_rated - E (psi(-U) + a_f); refuses negative torque."""
        law = self.law
        ahead = min(abs(law.inertia) * rate, law.effort_limit)
        reserve = law.ramp(-law.demand)
        least = law.rated_torque - law.effort_torque * (reserve.upper + ahead)
        if least < 0:
            raise ModelError(
                f"wind cell {law.wind} m/s: the set may demand {float(reserve.upper):.4g} rad/s^2 "
                f"below rated effort and {float(ahead):.4g} for the moving schedule, but torque "
                f"reaches zero at {float(law.rated_torque / law.effort_torque):.4g}; lower the "
                f"proportional gain there ({float(law.gamma.upper):.4g} 1/s) or the box's speed "
                f"signal ({float(self.box.speed_signal):.4g} rad/s)"
            )
        most = law.rated_torque - law.effort_torque * (reserve.lower - ahead)
        return Interval(least, min(most, law.rated_torque))

    def check_pitch(self, rate: Fraction, pitch: Interval) -> None:
        """Refuse a set that reaches, or a command that asks for, more than the largest pitch."""
        law = self.law
        asked = law.psi(law.demand.upper) / law.effectiveness.lower + law.pitch_min
        asked += law.pitch_lead * rate * self.turn
        most = max(asked, pitch.upper)
        if most > law.pitch_max:
            raise ModelError(
                f"wind cell {law.wind} m/s: the set reaches pitch {float(most):.4g} rad, beyond "
                f"the limit {float(law.pitch_max):.4g} rad; reduce the box"
            )
