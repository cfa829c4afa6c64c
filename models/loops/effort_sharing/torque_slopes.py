"""Ranges of the aerodynamic torque's slopes on one wind cell, from the surface's Bernstein form.

The true torque is s T_r with s, the true over the tabulated power coefficient, in a range.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from takagi.models.errors import ModelError
from takagi.models.intervals.interval import Interval, exact
from takagi.models.intervals.jet import Jet
from takagi.models.loops.effort_sharing.law_interval import LawInterval, hull
from takagi.models.loops.effort_sharing.loop_cell import LoopBox, LoopUncertainty
from takagi.models.turbine.data import Turbine

DIGITS = 14
# The range of a derivative (dx, dy) of the torque coefficient over a rectangle.
Ranges = Callable[[Interval, Interval, int, int], Interval]


class LoopTorque:
    """s T_r / J, T_r / J = c v^2 c_Q(omega R / v, beta), around one interval's trim, as rationals.

    Attributes
    ----------
    inertia : J [kg m^2];  share : m = n_g E / J [-];  power : s [-].
    """

    def __init__(
        self,
        turbine: Turbine,
        interval: LawInterval,
        box: LoopBox,
        uncertainty: LoopUncertainty,
        ranges: Ranges | None = None,
    ) -> None:
        self.law, self.box, self._ranges = interval, box, ranges or turbine.torque.bounds
        self.frozen_wake, self.power = uncertainty.frozen_wake, uncertainty.power_coefficient
        gear = exact(turbine.gear_ratio)
        self.inertia = exact(turbine.rotor_inertia) + gear**2 * exact(turbine.generator_inertia)
        self.constant = exact(turbine.torque_constant) / self.inertia
        self.radius = exact(turbine.rotor_radius)
        self.share = interval.effort_torque * gear / self.inertia
        self.rated_effort = interval.rated_torque * gear / self.inertia

    def _ratio(self, speed_error: Fraction, wind_error: Fraction) -> Interval:
        """Return the range of omega R / v; a ratio of lines is monotone, so the ends decide.

        Over the cell at fixed deviations (R (omega* + e) / (v_s + dv)) it is monotone in v_s, and
        monotone in e and dv: the hull of all corners is the range.
        """
        ratios = [
            self.radius * (speed + e) / (wind + dv)
            for speed, wind in zip(self.law.ends["speed"], self.law.ends["wind"], strict=True)
            for e in (-speed_error, speed_error)
            for dv in (-wind_error, wind_error)
        ]
        return Interval(min(ratios), max(ratios)).outward(DIGITS)

    def _surface(self, ratio: Interval, pitch: Interval, dx: int = 0, dy: int = 0) -> Interval:
        try:
            return self._ranges(ratio, pitch, dx, dy).outward(DIGITS)
        except ModelError as error:
            raise ModelError(
                f"wind cell {self.law.wind} m/s: {error}. The box is the speed error of "
                f"{float(self.box.speed_error):.4g} rad/s and the wind share of "
                f"{float(self.box.wind_share):.4g} about the trim: extend the c_P and c_T tables, "
                "leave these winds out by cut_in and cut_out of the turbine's file, or, from "
                "Python, reduce the speed error or the wind share"
            ) from error

    def speed_slope(self, pitch: Interval) -> Interval:
        """Return s dT_r/domega / J = s c R v c_Q,lambda."""
        ratio = self._ratio(self.box.speed_error, Fraction(0))
        slope = self._surface(ratio, pitch, 1, 0) * self.law.wind * (self.constant * self.radius)
        return self.power * slope

    def wind_slope(self, pitch: Interval) -> Interval:
        """Return s dT_r/dv / J = s c v (2 c_Q - lambda c_Q,lambda)."""
        error = self.box.wind_share * self.law.wind.lower
        ratio = self._ratio(self.box.speed_error, error)
        wind = Interval(self.law.wind.lower - error, self.law.wind.upper + error)
        inner = self._surface(ratio, pitch) * 2 - ratio * self._surface(ratio, pitch, 1, 0)
        return self.power * (inner * wind * self.constant)

    def sigma(self, pitch: Interval) -> Interval:
        """Return -s dT_r/dbeta / (J b) at omega* over a pitch range, frozen wake included."""
        ratio = self._ratio(Fraction(0), Fraction(0))
        slope = self._surface(ratio, pitch, 0, 1) * self.law.wind**2 * self.constant
        sigma = self.power * (-slope / self.law.effectiveness)
        if not self.frozen_wake:
            return sigma.outward(DIGITS)
        frozen = hull(self.law.ends["limit"]) / self.law.effectiveness
        return Interval(sigma.lower, max(sigma.upper, frozen.upper)).outward(DIGITS)

    def curve_gain(self) -> Interval:
        """Return the range of m - F (m - sigma) along beta = beta_min + psi(s) / b."""
        gains = []
        for piece in self.law.pieces():
            share = self.law.share(piece)
            if share.upper == 0:
                gains.append(Interval(self.share, self.share))
                continue
            pitch = self.law.ramp(piece) / self.law.effectiveness + self.law.pitch_min
            sigma = self.sigma(pitch.outward(DIGITS))
            gains.append(self.share - share * (self.share - sigma))
        found = gains[0]
        for gain in gains[1:]:
            found = found.hull(gain)
        return found

    def residual(self) -> Fraction:
        """Return a bound of |r + (s - 1) T_r* / J| over the cell, T_r* the trim's torque.

        |r(v)| <= max(|r(v_1)|, |r(v_2)|) + (width^2 / 8) sup |r''|, the error of linear
        interpolation of a C^1 function whose slope is Lipschitz; and T_r* / J is r +
        n_g T_rated / J - m psi(-q*), the last two of which lie between their values at the ends.
        """
        ends = [self._residual_at(i).magnitude for i in (0, 1)]
        tables = max(ends) + self.law.width**2 / 8 * self._residual_curvature().magnitude
        wrong = (self.power - 1).magnitude
        efforts = self.law.ends["effort"]
        trim = max(abs(self.rated_effort - self.share * self.law.psi(-q)) for q in efforts)
        return (1 + wrong) * tables + wrong * trim

    def _residual_at(self, i: int) -> Interval:
        law, wind, q = self.law, self.law.ends["wind"][i], self.law.ends["effort"][i]
        ratio = Interval.of(self.radius * law.ends["speed"][i] / wind).outward(DIGITS)
        pitch = law.pitch_min + law.psi(q) / law.ends["effectiveness"][i]
        coefficient = self._surface(ratio, Interval.of(pitch).outward(DIGITS))
        torque = coefficient * (self.constant * wind**2)
        return torque - self.rated_effort + law.psi(-q) * self.share

    def _residual_curvature(self) -> Interval:
        """Return r'' = (c v^2 c_Q(lambda(v), beta(v)))'' + m (psi(-q*(v)))'' over the cell."""
        law, width = self.law, self.law.width
        wind = Jet.linear(law.wind.lower, law.wind.upper, width)
        speed = Jet.linear(*law.ends["speed"], width).scaled(self.radius)
        ratio = (speed / wind).rounded(DIGITS)
        effort = Jet.linear(*law.ends["effort"], width)
        shed = law.ramp_jet(effort)
        pitch = (shed / Jet.linear(*law.ends["effectiveness"], width)).rounded(DIGITS)
        angle = pitch.value + law.pitch_min
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
        torque = (wind * wind * coefficient).scaled(self.constant)
        reserve = law.ramp_jet(effort.scaled(Fraction(-1))).scaled(self.share)
        return torque.curvature + reserve.curvature
