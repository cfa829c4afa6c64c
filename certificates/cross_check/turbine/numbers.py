"""Turbine, law, box and uncertainty of the claim about a turbine's loop, as exact numbers."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

from flint import fmpq

from takagi.certificates.cross_check.kernel.reading import Refusal, entry, line, rational, rationals
from takagi.certificates.cross_check.turbine.surface import CoefficientSurface, NumberRange

CONSTANTS = (
    "torque_constant",
    "rotor_radius",
    "gear_ratio",
    "pitch_time_constant",
    "pitch_rate_limit",
    "rated_rotor_speed",
)
ZERO, FULL = fmpq(0), fmpq(1)


class Rotor:
    """The plant and the law's tables.

    ``c``, ``rated``, ``m`` : torque constant, rated torque on the low-speed side, and n_g E, each
    divided by the nominal inertia J.  The equation of motion then gives an acceleration [rad/s^2].
    """

    def __init__(self, model: Any, gains: Any) -> None:
        if entry(model, "kind") != "turbine":
            raise Refusal("a turbine is needed")
        self._read_plant(model)
        self._read_law(gains)
        for name in ("pitch_min", "pitch_max"):
            if rational(gains, name) != rational(model, name):
                raise Refusal(f"{name}: the law's is not the turbine's")
        self.pitch_min, self.pitch_max = (rational(gains, f"pitch_{end}") for end in ("min", "max"))
        if self.pitch_min > self.pitch_max:
            raise Refusal("pitch_min: above pitch_max")
        self.integral_limit = rational(gains, "integral_limit")

    def _read_plant(self, model: Any) -> None:
        values = {name: rational(model, name) for name in CONSTANTS}
        n = values["gear_ratio"]
        J = rational(model, "rotor_inertia") + n**2 * rational(model, "generator_inertia")
        if J <= 0 or min(values.values()) <= 0:
            raise Refusal("model: inertia and constants must be positive")
        self.c, self.n_over_J = values["torque_constant"] / J, n / J
        self.radius, self.drive = values["rotor_radius"], values["pitch_time_constant"]
        self.rate_limit = values["pitch_rate_limit"]
        self.surface = CoefficientSurface(entry(model, "torque_surface"))

    def _read_law(self, gains: Any) -> None:
        # A gain file of another name has another program.
        if line(gains, "name") != "coherent":
            raise Refusal("gains: the claim is about the law named coherent")
        self.wind = rationals(gains, "wind")
        n = len(self.wind)
        # A program computes with floats, in which two winds must not be one.
        if n < 2 or any(b - a <= max(abs(a), abs(b)) / 2**50 for a, b in pairwise(self.wind)):
            raise Refusal("wind: two winds or more that increase, also as floats, are needed")
        self.speed = rationals(gains, "rotor_speed", n)
        self.effort = rationals(gains, "trim_effort", n)
        self.effectiveness = rationals(gains, "effectiveness", n)
        self.limit = rationals(gains, "effectiveness_limit", n)
        self.proportional = rationals(gains, "proportional", n)
        self.integral_rates = rates = rationals(gains, "integral_rate", n - 1)
        self.ahead = rationals(gains, "inertia_feedforward", n - 1)
        self.ahead_limit = rationals(gains, "feedforward_limit", n - 1)
        self.lead, self.overlap = rational(gains, "pitch_lead"), rational(gains, "overlap")
        self.torque, self.per_effort = (
            rational(gains, "rated_torque"),
            rational(gains, "effort_torque"),
        )
        tables = (*self.speed, *self.effectiveness, *self.proportional, *rates)
        numbers = (self.wind[0], self.overlap, self.torque, self.per_effort)
        if min(*tables, *numbers, rational(gains, "integral_limit")) <= 0:
            raise Refusal("gains: winds, speeds, gains, effectiveness and limits must be positive")
        if min(self.lead, *self.ahead_limit) < 0:
            raise Refusal("gains: pitch_lead and feedforward_limit must not be negative")
        fed = self.lead != 0 or any(f != 0 for f in self.ahead)
        if fed and rational(gains, "wind_filter") <= 0:
            raise Refusal("wind_filter: what feeds a wind's rate forward needs a filter")
        self.m, self.rated = self.n_over_J * self.per_effort, self.n_over_J * self.torque


class TurbineNumbers(Rotor):
    """Plant and law, with the box and the uncertainty of a claim about the loop."""

    def __init__(self, claim: Any, model: Any, gains: Any) -> None:
        super().__init__(model, gains)
        box = entry(claim, "box")
        names = ("speed_error", "effort_lag", "speed_signal", "wind_share")
        sides = [rational(box, name) for name in names]
        self.speed_error, self.effort_lag, self.speed_signal, self.wind_share = sides
        if min(sides) <= 0 or self.wind_share >= 1:
            raise Refusal("box: sides must be positive, and wind_share below 1")
        uncertainty = entry(claim, "uncertainty")
        light, heavy = rationals(uncertainty, "inertia", 2)
        if light <= 0 or heavy < light:
            raise Refusal("inertia: 0 < low <= high is needed")
        self.kappa = NumberRange(1 / heavy, 1 / light)
        self.frozen = entry(uncertainty, "frozen_wake")
        if type(self.frozen) is not bool:
            raise Refusal("frozen_wake: true or false is needed")
        said = "power_coefficient" in uncertainty
        worst, best = rationals(uncertainty, "power_coefficient", 2) if said else (FULL, FULL)
        if worst <= 0 or worst > 1 or best < 1:
            raise Refusal("power_coefficient: 0 < low <= 1 <= high is needed")
        self.power = NumberRange(worst, best)

    def cell(self, k: int) -> WindCell:
        """Return the cell between winds k and k + 1."""
        return WindCell(self, k)


class WindCell:
    """Schedule winds from node k to node k + 1, and the ranges of the law's tables over them.

    ``shed`` is psi(U) and ``share`` F(U) over the efforts U; ``owed`` is b times pitch above its
    minimum, within the effort lag; ``band`` is the range of pitch.
    """

    def __init__(self, turbine: TurbineNumbers, k: int) -> None:
        self.turbine, self.k = turbine, k
        self.wind = NumberRange(turbine.wind[k], turbine.wind[k + 1])
        self.b, self.frozen = self._over(turbine.effectiveness), self._over(turbine.limit)
        self.gamma, self.effort = self._over(turbine.proportional), self._over(turbine.effort)
        self.kappa, eps = turbine.kappa, turbine.overlap
        signal = NumberRange(-turbine.speed_signal, turbine.speed_signal)
        self.efforts = self.effort + self.gamma * signal
        self.shed = NumberRange(ramp(self.efforts.low, eps), ramp(self.efforts.high, eps))
        self.share = NumberRange(
            ramp_slope(self.efforts.low, eps), ramp_slope(self.efforts.high, eps)
        )
        zeta = turbine.effort_lag
        self.owed = NumberRange(max(self.shed.low - zeta, ZERO), self.shed.high + zeta)
        self.band = self.owed / self.b + NumberRange(turbine.pitch_min, turbine.pitch_min)

    def _over(self, column: list[fmpq]) -> NumberRange:
        return NumberRange.of(column[self.k], column[self.k + 1])

    def slope(self, column: list[fmpq]) -> fmpq:
        """Return the slope of a table over wind, one number in the cell."""
        return (column[self.k + 1] - column[self.k]) / (self.wind.high - self.wind.low)

    def ratio(self, error: fmpq, away: fmpq) -> NumberRange:
        """Return R (omega* + e) / (v_s + d), |e| <= error, |d| <= away.

        Numerator and denominator are affine in v_s, hence the quotient is monotone in each of v_s,
        e and d: its ends are at the corners.
        """
        ends = []
        for i in (self.k, self.k + 1):
            for e in (-error, error):
                for d in (-away, away):
                    wind = self.turbine.wind[i] + d
                    ends.append(self.turbine.radius * (self.turbine.speed[i] + e) / wind)
        return NumberRange.of(*ends)


def ramp(s: fmpq, eps: fmpq) -> fmpq:
    """Return psi: 0 for s <= -eps, (s + eps)^2 / (4 eps) between, s for s >= eps."""
    if -eps < s < eps:
        return (s + eps) ** 2 / (4 * eps)
    return max(s, ZERO)


def ramp_slope(s: fmpq, eps: fmpq) -> fmpq:
    """Return F = psi', which is in [0, 1] and does not decrease."""
    return max(ZERO, min(FULL, (s / eps + 1) / 2))


def ramp_secant(s: fmpq, rest: fmpq, eps: fmpq) -> fmpq:
    """Return the secant slope of psi from ``rest`` to s; where they are equal, F."""
    return ramp_slope(s, eps) if s == rest else (ramp(s, eps) - ramp(rest, eps)) / (s - rest)
