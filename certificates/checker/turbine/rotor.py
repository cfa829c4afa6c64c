"""The turbine's numbers as a claim reads them, and the slopes of the rotor's torque."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.arithmetic.interval import Interval, point
from takagi.certificates.checker.arithmetic.spline import Spline
from takagi.certificates.checker.kernel.reader import matrix, member, number, numbers, positive
from takagi.certificates.checker.kernel.refusal import CertificateError

Span = tuple[Fraction, Fraction]


def nominal_inertia(model: Any) -> Fraction:
    """Return J = J_r + n_g^2 J_g [kg m^2]; refuses one that is not positive."""
    inertia = number(model, "rotor_inertia", "model")
    inertia += number(model, "gear_ratio", "model") ** 2 * number(
        model, "generator_inertia", "model"
    )
    if inertia <= 0:
        raise CertificateError("model: rotor and generator need a positive inertia together")
    return inertia


@dataclass(frozen=True)
class Plant:
    """The plant's numbers; torque and gear ratio over the nominal inertia.

    The rotor's torque over J is c v^2 c_Q(lambda, beta), lambda = R omega / v.
    """

    torque_per_inertia: Fraction
    gear_per_inertia: Fraction
    radius: Fraction
    lag: Fraction
    rate_limit: Fraction
    rated_speed: Fraction
    pitch_min: Fraction
    pitch_max: Fraction
    surface: Spline

    @classmethod
    def read(cls, model: Any) -> Plant:
        """Return the plant.

        Refused are another kind, a constant that is not positive, and a least pitch above the
        greatest, which is where the law's program would then hold pitch.
        """
        if member(model, "kind", "model") != "turbine":
            raise CertificateError("model.kind: a turbine is needed")
        gear, inertia = positive(model, "gear_ratio", "model"), nominal_inertia(model)
        least, most = (number(model, f"pitch_{end}", "model") for end in ("min", "max"))
        if least > most:
            raise CertificateError("model: pitch_min <= pitch_max is needed")
        table, where = member(model, "torque_surface", "model"), "model.torque_surface"
        x, y = (numbers(table, f"{axis}_knots", where) for axis in ("tip_speed_ratio", "pitch"))
        return cls(
            torque_per_inertia=positive(model, "torque_constant", "model") / inertia,
            gear_per_inertia=gear / inertia,
            radius=positive(model, "rotor_radius", "model"),
            lag=positive(model, "pitch_time_constant", "model"),
            rate_limit=positive(model, "pitch_rate_limit", "model"),
            rated_speed=positive(model, "rated_rotor_speed", "model"),
            pitch_min=least,
            pitch_max=most,
            surface=Spline(x, y, matrix(table, "coefficients", where)),
        )

    def torque(self, ratio: Interval, pitch: Interval, wind: Interval) -> Interval:
        """Return T_r / J [rad/s^2]."""
        return self.surface.bounds(ratio, pitch) * wind.square() * point(self.torque_per_inertia)

    def torque_by_speed(self, ratio: Interval, pitch: Interval, wind: Interval) -> Interval:
        """Return dT_r/domega / J = c v R c_Q,lambda [1/s]."""
        steep = self.surface.bounds(ratio, pitch, 1, 0) * wind
        return steep * point(self.torque_per_inertia * self.radius)

    def torque_by_pitch(self, ratio: Interval, pitch: Interval, wind: Interval) -> Interval:
        """Return dT_r/dbeta / J = c v^2 c_Q,beta [rad/s^2 per rad]."""
        steep = self.surface.bounds(ratio, pitch, 0, 1) * wind.square()
        return steep * point(self.torque_per_inertia)

    def torque_by_wind(self, ratio: Interval, pitch: Interval, wind: Interval) -> Interval:
        """Return dT_r/dv / J = c v (2 c_Q - lambda c_Q,lambda) [rad/s per m]."""
        value = self.surface.bounds(ratio, pitch)
        inner = value + value - ratio * self.surface.bounds(ratio, pitch, 1, 0)
        return inner * wind * point(self.torque_per_inertia)
