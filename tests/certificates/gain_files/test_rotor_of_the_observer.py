"""The rotor that a gain file's observer knows follows from the turbine of the certificate."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.controller.turbine_content import _rotor
from tests.certificates.recorded.inputs import read_law


def test_its_inertia_has_the_generators_share() -> None:
    """J = J_r + n^2 J_g, to the digits that a gain file holds."""
    model = read_law("torque")["model"]
    rotor, gear, generator = (
        Fraction(model[name]) for name in ("rotor_inertia", "gear_ratio", "generator_inertia")
    )

    stated = Fraction(_rotor(model)["inertia"])
    assert abs(stated / (rotor + gear**2 * generator) - 1) < Fraction(1, 10**9)
    assert abs(stated / rotor - 1) > Fraction(1, 100)
