r"""The closed loop with the coherent law as an interval family, one per wind cell.

Coordinates (e, zeta, x): e = omega - omega*(v_s), zeta = psi(U) - b (beta - beta_min) the effort
that pitch still owes, x the law's speed integral; v_s is the schedule wind.  With the plant

    (J / kappa) omega' = T_r(omega, beta, v) - n_g T,     beta' = sat((beta_ref - beta) / tau)

the loop is, exactly and without linearisation,

    e'    = (a - Gamma) e + S zeta + Gamma x                       + w_e
    zeta' = Phi (a - Gamma + nu) e + (Phi S - T) zeta + Phi Gamma x + Phi w_e + w_zeta
    x'    = -nu e

    w_e    = kappa (r + d (v - v_s)) - omega*' v_s'
    w_zeta = v_s' (F (q*' + gamma' (e - x)) - b' (beta - beta_min))

where every letter is a mean value of a partial derivative, so it lies in that derivative's range:

    a     kappa dT_r/domega / J                     over the band in omega and beta, at v_s
    Gamma kappa gamma (m - F (m - sigma))           along the curve beta = beta_min + psi(s) / b
    S     kappa sigma, sigma = -dT_r/dbeta / (J b)  over the pitch band at omega*, v_s
    Phi   F gamma, F = psi'                         over the efforts the set can demand
    T     1/tau, less where the pitch rate limit bites: secant of the saturation
    d     dT_r/dv / J                               over the whole band
    r     torque left over by the emitted tables at the trim

m = n_g E / J is one but for the rounding of the emitted effort torque E.  Keeping F (m - sigma)
along the curve is what ties large pitch shares to the pitch angles at which
pitch works; taken apart, the product admits a loop without any gain near rated wind.

Pitch effectiveness is uncertain upwards: sigma reaches the frozen-wake value of the schedule's
``effectiveness_limit``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from takagi.models.embedding.jet import Jet
from takagi.models.enclosure.interval import Interval, exact
from takagi.models.errors import ModelError
from takagi.models.law.coherent import CoherentLaw
from takagi.models.turbine.data import Turbine

__all__ = ["LoopBox", "LoopCell", "Uncertainty", "coherent_cells"]

DIGITS = 14
# Decimals of the intervals that a certificate states; rounded outward.
EMITTED_DIGITS = 7
CURVE_PIECES = 8


@dataclass(frozen=True, slots=True)
class LoopBox:
    """The region on which the family is valid, around the trim at the schedule wind.

    Attributes
    ----------
    speed_error : bound on |e| [rad/s].
    effort_lag : bound on |zeta| [rad/s^2].
    speed_signal : bound on |e - x| [rad/s]; the demanded effort is gamma times this.
    wind_share : bound on |v - v_s| over the cell's lower wind [-], up to which d is enclosed.
    """

    speed_error: Fraction
    effort_lag: Fraction
    speed_signal: Fraction
    wind_share: Fraction


@dataclass(frozen=True, slots=True)
class Uncertainty:
    """What the family covers beside the nominal model.

    Attributes
    ----------
    inertia : the true inertia over the nominal one, e.g. [0.9, 1.1].
    frozen_wake : whether pitch effectiveness may reach the frozen-wake value.
    """

    inertia: Interval
    frozen_wake: bool


@dataclass(frozen=True, slots=True)
class LoopCell:
    """Enclosures of the loop's coefficients for schedule winds in one cell.

    Attributes
    ----------
    wind : schedule winds [m/s].
    stiffness : a [1/s];  loop_gain : Gamma [1/s];  lag_gain : S [-];  share_gain : Phi [1/s].
    lag_rate : T [1/s];  integral_rate : nu [1/s], a point.
    residual : |r| [rad/s^2];  wind_gain : |d| [rad/s per m];  inertia_gain : largest kappa [-].
    reference_slope : |omega*'| [rad/s per m/s].
    lag_slope : |F (q*' + gamma'(e - x)) - b'(beta - beta_min)| [rad/s^2 per m/s].
    speed : omega* [rad/s];  torque : reachable command [N m];  pitch : reachable angle [rad].
    pitch_rate : largest demanded rate (beta_ref - beta)/tau [rad/s], before the limit.
    """

    wind: Interval
    stiffness: Interval
    loop_gain: Interval
    lag_gain: Interval
    share_gain: Interval
    lag_rate: Interval
    integral_rate: Interval
    residual: Fraction
    wind_gain: Fraction
    inertia_gain: Fraction
    reference_slope: Fraction
    lag_slope: Fraction
    speed: Interval
    torque: Interval
    pitch: Interval
    pitch_rate: Fraction


def coherent_cells(
    turbine: Turbine, law: CoherentLaw, box: LoopBox, uncertainty: Uncertainty
) -> Iterator[LoopCell]:
    """Yield the enclosed loop for every interval between the nodes of the law's schedule.

    Raises
    ------
    ModelError : the box leaves the coefficient table, asks for negative torque, or for pitch
        beyond its limit in some cell; the message names the cell and what to reduce.
    """
    for k in range(len(law.schedule.wind) - 1):
        yield _Cell(turbine, law, box, uncertainty, k).enclosed()


@dataclass(frozen=True, slots=True)
class _Constants:
    """The plant's numbers as rationals: torque is c v^2 c_Q, everything else over J."""

    torque_per_inertia: Fraction
    radius: Fraction


class _Cell:
    """One cell's quantities as exact intervals; computed once, read by the parts below."""

    def __init__(
        self,
        turbine: Turbine,
        law: CoherentLaw,
        box: LoopBox,
        uncertainty: Uncertainty,
        k: int,
    ) -> None:
        self.turbine, self.law, self.box, self.k = turbine, law, box, k
        inertia = exact(turbine.rotor_inertia) + exact(turbine.gear_ratio) ** 2 * exact(
            turbine.generator_inertia
        )
        self.plant = _Constants(
            exact(turbine.torque_constant) / inertia,
            exact(turbine.rotor_radius),
        )
        self.rated_effort = exact(law.rated_torque) * exact(turbine.gear_ratio) / inertia
        self.effort_torque = exact(law.effort_torque)
        self.torque_share = self.effort_torque * exact(turbine.gear_ratio) / inertia
        table, gains = law.schedule, law.gains
        self.overlap = exact(table.overlap)
        self.wind = self._column(table.wind)
        self.width = self.wind.width
        self.ends = {
            name: (exact(float(column[k])), exact(float(column[k + 1])))
            for name, column in (
                ("speed", table.rotor_speed),
                ("effort", table.trim_effort),
                ("effectiveness", table.effectiveness),
                ("limit", table.effectiveness_limit),
                ("gamma", gains.proportional),
            )
        }
        self.nu = exact(float(gains.integral_rate[k]))
        self.effectiveness = _hull(self.ends["effectiveness"])
        self.gamma = _hull(self.ends["gamma"])
        # kappa multiplies torques: it is the nominal inertia over the true one.
        self.kappa = 1 / uncertainty.inertia
        self.frozen_wake = uncertainty.frozen_wake
        self.signal = Interval(-box.speed_signal, box.speed_signal)
        self.demand = _hull(self.ends["effort"]) + self.gamma * self.signal

    def _column(self, column: object) -> Interval:
        values = column  # a (K,) array; the cell's two ends
        return Interval(exact(float(values[self.k])), exact(float(values[self.k + 1])))  # type: ignore[index]

    def enclosed(self) -> LoopCell:
        ramp = self._ramp(self.demand)
        lag = Interval(-self.box.effort_lag, self.box.effort_lag)
        owed = ramp + lag
        shed = Interval(max(owed.lower, Fraction(0)), owed.upper)
        pitch = (shed / self.effectiveness + exact(self.law.pitch_min)).outward(DIGITS)
        share = self._share(self.demand)
        torque = self._torque()
        self._check_pitch(pitch)
        lag_time = exact(self.turbine.pitch_time_constant)
        rate = self.box.effort_lag / (self.effectiveness.lower * lag_time)
        return LoopCell(
            wind=self.wind,
            stiffness=_stated(self.kappa * self._speed_slope(pitch)),
            loop_gain=_stated(self.kappa * self.gamma * self._curve_gain()),
            lag_gain=_stated(self.kappa * self._sigma(pitch)),
            share_gain=(share * self.gamma).outward(EMITTED_DIGITS),
            lag_rate=self._lag_rate(rate).outward(EMITTED_DIGITS),
            integral_rate=Interval(self.nu, self.nu),
            residual=_stated(Interval.of(self._residual())).upper,
            wind_gain=_stated(Interval.of(self._wind_slope(pitch).magnitude)).upper,
            inertia_gain=_up(self.kappa.upper),
            reference_slope=_up(abs(self._slope("speed"))),
            lag_slope=_stated(Interval.of(self._lag_slope(share, shed).magnitude)).upper,
            speed=_hull(self.ends["speed"]),
            torque=torque.outward(0),
            pitch=pitch.outward(EMITTED_DIGITS),
            pitch_rate=_up(rate),
        )

    # ------------------------------------------------------------------ the law's functions
    def _ramp(self, effort: Interval) -> Interval:
        """Return the range of psi, which is monotone."""
        return Interval(self._psi(effort.lower), self._psi(effort.upper))

    def _psi(self, s: Fraction) -> Fraction:
        if s <= -self.overlap:
            return Fraction(0)
        return s if s >= self.overlap else (s + self.overlap) ** 2 / (4 * self.overlap)

    def _share(self, effort: Interval) -> Interval:
        """Return the range of F = psi', which is monotone."""
        return Interval(self._slope_of_ramp(effort.lower), self._slope_of_ramp(effort.upper))

    def _slope_of_ramp(self, s: Fraction) -> Fraction:
        return min(max((s + self.overlap) / (2 * self.overlap), Fraction(0)), Fraction(1))

    def _slope(self, name: str) -> Fraction:
        first, last = self.ends[name]
        return (last - first) / self.width

    # ------------------------------------------------------------------ the surface's slopes
    def _ratio(self, speed_error: Fraction, wind_error: Fraction) -> Interval:
        """Return the range of omega R / v; a ratio of lines is monotone, so the ends decide.

        Over the cell at fixed deviations (R (omega* + e) / (v_s + dv)) it is monotone in v_s, and
        monotone in e and dv: the hull of all corners is the range.
        """
        winds = (self.wind.lower, self.wind.upper)
        ratios = [
            self.plant.radius * (speed + e) / (wind + dv)
            for speed, wind in zip(self.ends["speed"], winds, strict=True)
            for e in (-speed_error, speed_error)
            for dv in (-wind_error, wind_error)
        ]
        return Interval(min(ratios), max(ratios)).outward(DIGITS)

    def _surface(self, ratio: Interval, pitch: Interval, dx: int = 0, dy: int = 0) -> Interval:
        try:
            return self.turbine.torque.bounds(ratio, pitch, dx, dy).outward(DIGITS)
        except ModelError as error:
            raise ModelError(
                f"wind cell {self.wind} m/s: {error}; reduce the speed error "
                f"{float(self.box.speed_error):.4g} rad/s or the wind share "
                f"{float(self.box.wind_share):.4g} of the box"
            ) from error

    def _speed_slope(self, pitch: Interval) -> Interval:
        """Return dT_r/domega / J = c R v c_Q,lambda."""
        ratio = self._ratio(self.box.speed_error, Fraction(0))
        scale = self.plant.torque_per_inertia * self.plant.radius
        return self._surface(ratio, pitch, 1, 0) * self.wind * scale

    def _wind_slope(self, pitch: Interval) -> Interval:
        """Return dT_r/dv / J = c v (2 c_Q - lambda c_Q,lambda)."""
        error = self.box.wind_share * self.wind.lower
        ratio = self._ratio(self.box.speed_error, error)
        wind = Interval(self.wind.lower - error, self.wind.upper + error)
        inner = self._surface(ratio, pitch) * 2 - ratio * self._surface(ratio, pitch, 1, 0)
        return inner * wind * self.plant.torque_per_inertia

    def _sigma(self, pitch: Interval) -> Interval:
        """Return -dT_r/dbeta / (J b) at omega* over a pitch range, frozen wake included."""
        ratio = self._ratio(Fraction(0), Fraction(0))
        slope = self._surface(ratio, pitch, 0, 1) * self.wind**2 * self.plant.torque_per_inertia
        sigma = -slope / self.effectiveness
        if not self.frozen_wake:
            return sigma.outward(DIGITS)
        frozen = _hull(self.ends["limit"]) / self.effectiveness
        return Interval(sigma.lower, max(sigma.upper, frozen.upper)).outward(DIGITS)

    def _curve_gain(self) -> Interval:
        """Return the range of m - F (m - sigma) along beta = beta_min + psi(s) / b."""
        gains = []
        for piece in self._pieces():
            share = self._share(piece)
            if share.upper == 0:
                gains.append(Interval(self.torque_share, self.torque_share))
                continue
            pitch = self._ramp(piece) / self.effectiveness + exact(self.law.pitch_min)
            sigma = self._sigma(pitch.outward(DIGITS))
            gains.append(self.torque_share - share * (self.torque_share - sigma))
        hull = gains[0]
        for gain in gains[1:]:
            hull = hull.hull(gain)
        return hull

    def _pieces(self) -> list[Interval]:
        """Return the efforts the set can demand, cut finely where the ramp bends."""
        low, high, eps = self.demand.lower, self.demand.upper, self.overlap
        cuts = {low, high}
        start, stop = max(low, -eps), min(high, eps)
        if start < stop:
            step = (stop - start) / CURVE_PIECES
            cuts.update(start + step * i for i in range(CURVE_PIECES + 1))
        ordered = sorted(cuts)
        return [Interval(a, b) for a, b in zip(ordered, ordered[1:], strict=False)]

    # ------------------------------------------------------------------ limits
    def _torque(self) -> Interval:
        """Return T_rated - (J / n_g) psi(-U) over the demanded efforts; refuses negative torque."""
        reserve = self._ramp(-self.demand)
        torque = exact(self.law.rated_torque) - self.effort_torque * reserve
        if torque.lower < 0:
            raise ModelError(
                f"wind cell {self.wind} m/s: the set may demand {float(reserve.upper):.4g} rad/s^2 "
                f"below rated effort, but torque reaches zero at "
                f"{float(self.rated_effort):.4g}; lower the proportional gain there "
                f"({float(self.gamma.upper):.4g} 1/s) or the box's speed signal "
                f"({float(self.box.speed_signal):.4g} rad/s)"
            )
        return torque

    def _check_pitch(self, pitch: Interval) -> None:
        if pitch.upper > exact(self.law.pitch_max):
            raise ModelError(
                f"wind cell {self.wind} m/s: the set reaches pitch {float(pitch.upper):.4g} rad, "
                f"beyond the limit {self.law.pitch_max:.4g} rad; reduce the box"
            )

    def _lag_rate(self, rate: Fraction) -> Interval:
        """Return the secants of sat((beta_ref - beta)/tau) per unit of lag: [s_min, 1] / tau."""
        limit = exact(self.turbine.pitch_rate_limit)
        fastest = 1 / exact(self.turbine.pitch_time_constant)
        return Interval(fastest * min(Fraction(1), limit / rate), fastest)

    def _lag_slope(self, share: Interval, shed: Interval) -> Interval:
        """Return F (q*' + gamma' (e - x)) - b' (beta - beta_min), per unit of wind rate."""
        feedforward = self.signal * self._slope("gamma") + self._slope("effort")
        relative = self._slope("effectiveness") / self.effectiveness
        return share * feedforward - shed * relative

    # ------------------------------------------------------------------ the tables' residual
    def _residual(self) -> Fraction:
        """Return a bound of |r| over the cell.

        |r(v)| <= max(|r(v_1)|, |r(v_2)|) + (width^2 / 8) sup |r''|, the error of linear
        interpolation of a C^1 function whose slope is Lipschitz.
        """
        ends = [self._residual_at(i).magnitude for i in (0, 1)]
        return max(ends) + self.width**2 / 8 * self._residual_curvature().magnitude

    def _residual_at(self, i: int) -> Interval:
        wind = (self.wind.lower, self.wind.upper)[i]
        q = self.ends["effort"][i]
        ratio = Interval.of(self.plant.radius * self.ends["speed"][i] / wind).outward(DIGITS)
        pitch = exact(self.law.pitch_min) + self._psi(q) / self.ends["effectiveness"][i]
        coefficient = self._surface(ratio, Interval.of(pitch).outward(DIGITS))
        torque = coefficient * (self.plant.torque_per_inertia * wind**2)
        return torque - self.rated_effort + self._psi(-q) * self.torque_share

    def _residual_curvature(self) -> Interval:
        """Return r'' = (c v^2 c_Q(lambda(v), beta(v)))'' + (psi(-q*(v)))'' over the cell."""
        wind = Jet.linear(self.wind.lower, self.wind.upper, self.width)
        speed = Jet.linear(*self.ends["speed"], self.width).scaled(self.plant.radius)
        ratio = (speed / wind).rounded(DIGITS)
        effort = Jet.linear(*self.ends["effort"], self.width)
        shed = self._ramp_jet(effort)
        pitch = (shed / Jet.linear(*self.ends["effectiveness"], self.width)).rounded(DIGITS)
        angle = pitch.value + exact(self.law.pitch_min)
        exact_ratio = self._ratio(Fraction(0), Fraction(0))
        c = {
            (i, j): self._surface(exact_ratio, angle.outward(DIGITS), i, j)
            for i, j in ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
        }
        coefficient = Jet(
            c[0, 0],
            c[1, 0] * ratio.slope + c[0, 1] * pitch.slope,
            c[2, 0] * ratio.slope**2
            + c[1, 1] * ratio.slope * pitch.slope * 2
            + c[0, 2] * pitch.slope**2
            + c[1, 0] * ratio.curvature
            + c[0, 1] * pitch.curvature,
        ).rounded(DIGITS)
        torque = (wind * wind * coefficient).scaled(self.plant.torque_per_inertia)
        reserve = self._ramp_jet(effort.scaled(Fraction(-1))).scaled(self.torque_share)
        return torque.curvature + reserve.curvature

    def _ramp_jet(self, effort: Jet) -> Jet:
        """Return the jet of psi(s(v)) for a line s: psi'' is 1 / (2 eps) in the ramp, else 0."""
        share = self._share(effort.value)
        bent = Interval(Fraction(0), 1 / (2 * self.overlap))
        if effort.value.upper <= -self.overlap or effort.value.lower >= self.overlap:
            bent = Interval(Fraction(0), Fraction(0))
        return Jet(self._ramp(effort.value), share * effort.slope, bent * effort.slope**2)


def _hull(ends: tuple[Fraction, Fraction]) -> Interval:
    return Interval(min(ends), max(ends))


def _stated(found: Interval) -> Interval:
    """Return the emitted range: one unit of its last decimal wider than the enclosure.

    A checker with coarser arithmetic then still finds its own enclosure inside.
    """
    unit = Fraction(1, 10**EMITTED_DIGITS)
    rounded = found.outward(EMITTED_DIGITS)
    return Interval(rounded.lower - unit, rounded.upper + unit)


def _up(value: Fraction) -> Fraction:
    return Interval(Fraction(0), value).outward(EMITTED_DIGITS).upper
