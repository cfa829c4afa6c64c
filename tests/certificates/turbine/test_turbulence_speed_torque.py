"""``turbulence-speed``: the rotor's greatest torque where a table is greatest at one corner.

The knots of both axes are met four times at their ends, so the coefficient at a corner of the table
is the value of the surface there.  With all others at zero or below, the greatest torque is known.
"""

from __future__ import annotations

import json
from copy import deepcopy
from fractions import Fraction
from typing import Any

import pytest
from flint import fmpq

from takagi.certificates.checker import check_document, read_text
from takagi.certificates.checker.turbine.effort_sharing.inputs import Plant
from takagi.certificates.checker.turbine.overspeed import rotor_torque
from takagi.certificates.cross_check import loads
from takagi.certificates.cross_check.turbine import numbers
from takagi.certificates.cross_check.turbine.overspeed import driven
from tests.certificates.recorded.answers import recorded
from tests.certificates.turbine.running_documents import sealed, verdicts

F = Fraction
TOP = F("8.7")
PEAK = 0.05
ENDS = (0, -1)


@pytest.fixture(scope="module")
def stored() -> dict[str, Any]:
    return dict(json.loads(next(recorded("turbulence-speed"))[1]))


def with_corner(stored: dict[str, Any], ratio: int, pitch: int, rest: float) -> dict[str, Any]:
    """Return the document with a table that is at its peak in one corner."""
    found = deepcopy(stored)
    table = found["model"]["torque_surface"]
    rows = [[rest] * len(row) for row in table["coefficients"]]
    rows[ratio][pitch] = PEAK
    table["coefficients"] = rows
    return found


def first_pitch(stored: dict[str, Any]) -> Fraction:
    """Return the first pitch of the table [rad]."""
    return F(str(stored["model"]["torque_surface"]["pitch_knots"][0]))


class Driving:
    """The bounds of both checkers [rad/s^2], as fractions."""

    def __init__(self, document: dict[str, Any], pitch_min: Fraction) -> None:
        for part in ("model", "gains"):
            document[part]["pitch_min"] = float(pitch_min)
        self.plant = Plant.read(read_text(json.dumps(document), "document")["model"])
        read = loads(json.dumps(document))
        self.rotor = numbers.Rotor(read["model"], read["gains"])
        self.breaks = self.plant.surface.x.breaks

    def at(self, slow: Fraction, fast: Fraction) -> tuple[Fraction, Fraction]:
        first = rotor_torque.greatest(self.plant, (slow, fast), TOP)
        return first, back(driven.driven(self.rotor, there(slow), there(fast), there(TOP)))

    def anywhere(self) -> tuple[Fraction, Fraction]:
        first = rotor_torque.greatest_at_any_speed(self.plant, TOP)
        return first, back(driven.driven_at_all(self.rotor, there(TOP)))

    def torque(self, wind: Fraction) -> Fraction:
        """Return T_r/J at the peak."""
        return self.plant.torque_per_inertia * wind**2 * F(str(PEAK))

    def speed(self, ratio: Fraction, wind: Fraction) -> Fraction:
        return ratio * wind / self.plant.radius


def there(value: Fraction) -> fmpq:
    return fmpq(value.numerator, value.denominator)


def back(value: fmpq) -> Fraction:
    return F(int(value.p), int(value.q))


def shows(found: tuple[Fraction, Fraction], true: Fraction) -> bool:
    """Whether both bounds are at or above the torque, and by 2 % at most."""
    # The first checker rounds the knots' shares, outward.
    return all(true <= bound <= true * F(102, 100) for bound in found)


@pytest.mark.parametrize("ratio", ENDS)
@pytest.mark.parametrize("pitch", ENDS)
def test_a_peak_in_any_corner_of_the_table_is_seen(
    stored: dict[str, Any], ratio: int, pitch: int
) -> None:
    """At all speeds, and beside the speed that has the corner's tip-speed ratio in the top wind."""
    driving = Driving(with_corner(stored, ratio, pitch, 0.0), first_pitch(stored))
    true = driving.torque(TOP)
    assert shows(driving.anywhere(), true)
    X = driving.speed(driving.breaks[ratio], TOP)
    # Beyond the table's first ratio or its last one the coefficient is that of the end.
    beyond = X / 2 if ratio == 0 else 2 * X
    assert shows(driving.at(beyond, beyond), true)
    assert shows(driving.at(X / 2, 2 * X), true)


@pytest.mark.parametrize("part", [F(1, 2), F(1), F(24)])
def test_a_peak_that_only_slow_winds_have_is_seen(stored: dict[str, Any], part: Fraction) -> None:
    """Winds up to a few forty-eighths of the top: at faster ones the ratio is below the last."""
    driving = Driving(with_corner(stored, -1, 0, 0.0), first_pitch(stored))
    wind = TOP * part / 48
    X = driving.speed(driving.breaks[-1], wind)
    assert all(bound >= driving.torque(wind) for bound in driving.at(X, X))


def test_the_least_pitch_is_held_within_the_table(stored: dict[str, Any]) -> None:
    """Pitch from the last knot on has the last coefficient, and none of the first one."""
    last = F(str(stored["model"]["torque_surface"]["pitch_knots"][-1]))
    for pitch, least, seen in (
        (-1, last, True),
        (0, last, False),
        (0, first_pitch(stored) - 1, True),
    ):
        driving = Driving(with_corner(stored, 0, pitch, 0.0), least)
        for bound in driving.anywhere():
            assert seen == (bound >= driving.torque(TOP))


def test_a_rotor_that_nothing_drives_is_told_as_undecided(stored: dict[str, Any]) -> None:
    """The theorem divides by the rate at which the rotor may speed up; an excess gives it one."""
    document = with_corner(stored, 0, 0, -0.01)
    document["model"]["torque_surface"]["coefficients"][0][0] = -0.01
    assert Driving(deepcopy(document), F(0)).anywhere() == (F(0), F(0))
    for excess, answer in ((0.0, "UNDECIDED"), (1e-4, "PROVED")):
        document["claims"][0]["uncertainty"]["torque_excess"] = excess
        assert verdicts(document) == (answer, answer)
    document["claims"][0]["uncertainty"]["torque_excess"] = 0.0
    said = check_document(sealed(document)).claims[0].text
    assert "the rotor's torque may be above the generator's" in said
