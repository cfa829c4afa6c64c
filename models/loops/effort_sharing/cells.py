r"""The closed loop with the effort-sharing law as an interval family, one for each wind cell.

Coordinates (e, zeta, x): e = omega - omega*(v_s), zeta = psi(U) - b (beta - beta_min) the effort
that pitch has not delivered yet, x the law's speed integral; v_s is the schedule wind.  With the
plant

    (J / kappa) omega' = s T_r(omega, beta, v) - n_g T,   beta' = sat((beta_ref - beta) / tau)

the loop is, exactly and without linearisation,

    e'    = (a - Gamma) e + S zeta + Gamma x                            + w_e
    zeta' = Phi (a - Gamma + nu) e + (Phi S - T + (b'/b) v_s') zeta + Phi Gamma x + Phi w_e + w_zeta
    x'    = -nu e

    w_e    = kappa (r + d (v - v_s)) - (omega*' - kappa m mu f) v_s'
    w_zeta = (1 - mu_beta tau_lead / tau) v_s' N,   N = F (q*' + gamma' (e - x)) - psi(U) b' / b

where every letter is a mean value of a partial derivative, so it lies in that derivative's range:

    a     kappa dT_r/domega / J                     over the band in omega and beta, at v_s
    Gamma kappa gamma (m - F (m - sigma))           along the curve beta = beta_min + psi(s) / b
    S     kappa sigma, sigma = -dT_r/dbeta / (J b)  over the pitch band at omega*, v_s
    Phi   F gamma, F = psi'                         over the efforts the set can demand
    T     1/tau, less where the pitch rate limit bites: secant of the saturation
    d     dT_r/dv / J                               over the whole band
    r residual torque of the emitted tables at the trim

and mu, mu_beta in [0, 1] say how much of the law's feed-forward passes the limits of torque and
pitch (``moving_schedule``).  m = n_g E / J differs from 1 only by the rounding of the emitted
effort torque E. The product F (m - sigma) is enclosed along the curve as a whole, because large
shares F occur only at pitch angles where pitch is effective. Separate ranges of F and sigma would
admit a loop without any gain near rated wind.

Pitch effectiveness is uncertain upwards: sigma reaches the frozen-wake value of the schedule's
``effectiveness_limit``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, Number, exact
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.loops.effort_sharing.law_interval import LawInterval, hull
from takagi.models.loops.effort_sharing.loop_cell import LoopBox, LoopCell, LoopUncertainty
from takagi.models.loops.effort_sharing.moving_schedule import MovingSchedule
from takagi.models.loops.effort_sharing.torque_slopes import DIGITS, LoopTorque
from takagi.models.splines.approximate_ranges import quick_ranges
from takagi.models.turbine.data import Turbine

# Decimals of the intervals that a certificate states; rounded outward.
EMITTED_DIGITS = 7


def effort_sharing_cells(
    turbine: Turbine,
    law: EffortSharingLaw,
    box: LoopBox,
    uncertainty: LoopUncertainty,
    rates: Sequence[Number],
) -> Iterator[LoopCell]:
    """Yield the enclosed loop for every interval between the nodes of the law's schedule.

    Parameters
    ----------
    rates : |v_s'| that each cell encloses [m/s^2].

    Raises
    ------
    ModelError : the box leaves the coefficient table, asks for negative torque, or for pitch or a
        pitch rate beyond its limit in some cell; the message names the cell and what to reduce.
    """
    intervals = len(law.schedule.wind) - 1
    if len(rates) != intervals:
        raise ModelError(f"{len(rates)} wind rates for {intervals} wind cells; one each")
    for k, rate in enumerate(rates):
        yield CellLoop(turbine, law, box, uncertainty, k).enclosed(rate)


class CellLoop:
    """One cell of the loop, which can be enclosed again for another wind rate at little cost.

    Attributes
    ----------
    law : the tables on this interval;  moving : what depends on the wind rate.
    widest_error : the largest |v - v_s| that is enclosed [m/s].

    Parameters
    ----------
    searching : compute the torque's ranges in floating point, which is quick and proves nothing.
    residual : that of the same cell with other gains, which do not move it; None computes it.
    """

    def __init__(
        self,
        turbine: Turbine,
        law: EffortSharingLaw,
        box: LoopBox,
        uncertainty: LoopUncertainty,
        k: int,
        *,
        searching: bool = False,
        residual: Fraction | None = None,
    ) -> None:
        # kappa multiplies torques: it is the nominal inertia over the true one.
        self._kappa = 1 / uncertainty.inertia
        self.law = LawInterval(law, box, k)
        ranges = quick_ranges(turbine.torque) if searching else None
        self._torque = LoopTorque(turbine, self.law, box, uncertainty, ranges)
        self.moving = MovingSchedule(turbine, self.law, box, self._torque.share, self._kappa)
        self.widest_error = box.wind_share * self.law.wind.lower
        self._at_rest: LoopCell | None = None
        self._residual = residual

    @property
    def residual(self) -> Fraction:
        """Return a bound of the tables' residual torque, which does not depend on the gains."""
        if self._residual is None:
            self._residual = self._torque.residual()
        return self._residual

    def enclosed(self, rate: Number) -> LoopCell:
        """Return the enclosure for |v_s'| <= rate [m/s^2].

        Raises
        ------
        ModelError : as ``effort_sharing_cells`` says.
        """
        # Most of the enclosure does not depend on the rate; it is computed once and kept for other
        # rates.
        if self._at_rest is None:
            self._at_rest = self._resting()
        speed, moving, pitch = exact(rate), self.moving, self._at_rest.pitch
        if speed < 0:
            raise ModelError(f"wind rate {float(speed):g} m/s^2 was given; it must not be negative")
        moving.check_pitch(speed, pitch)
        return replace(
            self._at_rest,
            wind_rate=speed,
            lag_rate=moving.lag_rate(speed).outward(EMITTED_DIGITS),
            reference_slope=_bound(moving.reference_slope(speed)),
            lag_disturbance=_bound(moving.lag_disturbance(speed)),
            torque=moving.torque(speed).outward(0),
            pitch_rate=_up(moving.own_rate() + moving.lead * speed * moving.turn),
        )

    def _resting(self) -> LoopCell:
        law, torque, moving = self.law, self._torque, self.moving
        pitch = (law.owed / law.effectiveness + law.pitch_min).outward(DIGITS)
        still = Fraction(0)
        return LoopCell(
            wind=law.wind,
            wind_rate=still,
            stiffness=_stated(self._kappa * torque.speed_slope(pitch)),
            loop_gain=_stated(self._kappa * law.gamma * torque.curve_gain()),
            lag_gain=_stated(self._kappa * torque.sigma(pitch)),
            share_gain=(law.share(law.demand) * law.gamma).outward(EMITTED_DIGITS),
            lag_rate=moving.lag_rate(still).outward(EMITTED_DIGITS),
            integral_rate=Interval(law.nu, law.nu),
            effectiveness_limit=hull(law.ends["limit"]),
            residual=_stated(Interval.of(self.residual)).upper,
            wind_gain=_stated(Interval.of(torque.wind_slope(pitch).magnitude)).upper,
            inertia_gain=_up(self._kappa.upper),
            effectiveness_slope=_up(moving.relative.magnitude),
            reference_slope=still,
            lag_disturbance=still,
            speed=hull(law.ends["speed"]),
            torque=moving.torque(still).outward(0),
            pitch=pitch.outward(EMITTED_DIGITS),
            pitch_rate=still,
        )


def _stated(found: Interval) -> Interval:
    """Return the emitted range: one unit of its last decimal wider than the enclosure.

    Then the checker's own enclosure, from coarser arithmetic, still lies inside.
    """
    unit = Fraction(1, 10**EMITTED_DIGITS)
    rounded = found.outward(EMITTED_DIGITS)
    return Interval(rounded.lower - unit, rounded.upper + unit)


def _bound(value: Fraction) -> Fraction:
    """Return a bound as it is emitted: one unit larger, except if it is exactly zero."""
    return _stated(Interval.of(value)).upper if value else value


def _up(value: Fraction) -> Fraction:
    return Interval(Fraction(0), value).outward(EMITTED_DIGITS).upper
