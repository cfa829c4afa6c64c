"""A true power coefficient beside the table's: the loop lies in the family that says so."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from takagi.certificates import Verdict
from takagi.certificates.checker import check_document
from takagi.models import Turbine
from takagi.models.laws.effort_sharing.law import EffortSharingLaw, LoopCell
from tests.certificates.kinds.claims import resealed
from tests.certificates.loop_cells.loop_points import (
    BOX,
    ROUNDING,
    WIDER,
    WRONG,
    campaign,
    derivative,
    distance,
    effort_sharing_cells,
    points,
    rates_of,
)


@pytest.fixture(scope="module")
def wider(turbine: Turbine, law: EffortSharingLaw) -> list[LoopCell]:
    """Return the family with a wrong power coefficient in it."""
    return effort_sharing_cells(turbine, law, BOX, WIDER, rates_of(law))


def test_the_loop_with_another_power_coefficient_lies_in_its_family(
    turbine: Turbine, law: EffortSharingLaw, wider: list[LoopCell]
) -> None:
    """A true c_P of 0.98 to 1.02 times the table's, with all that is uncertain beside it."""
    drawn = points(law, BOX, 500, seed=11, wrong=WRONG)

    assert max(d for _, d in campaign(turbine, law, wider, drawn)) < ROUNDING


@pytest.mark.parametrize(("power", "inside"), [(0.98, True), (1.02, True), (0.975, False)])
def test_a_rotor_outside_the_stated_power_coefficients_leaves_the_family(
    power: float, inside: bool, turbine: Turbine, law: EffortSharingLaw, wider: list[LoopCell]
) -> None:
    """At rest in the trim all there is to see is the torque that the table has wrong."""
    trims = [
        replace(p, e=0.0, zeta=0.0, x=0.0, wind=p.schedule_wind, schedule_rate=0.0, power=power)
        for p in points(law, BOX, 300, seed=13)
    ]
    away = [distance(wider[p.k], p, derivative(turbine, law, p)) for p in trims]
    assert (max(away) < ROUNDING) is inside


FAR_TOO_WIDE = {
    "stiffness": "leaves the stated range",
    "loop_gain": "leaves the stated range",
    "lag_gain": "leaves the stated range",
    "residual": "exceeds the stated bound",
    "wind_gain": "exceeds the stated bound",
}


LESS, MORE = [0.9, 1.0], [1.0, 1.1]


# A better coefficient moves no pitch further than the frozen wake does, a worse one no wind.
@pytest.mark.parametrize(
    ("name", "power"),
    [
        ("stiffness", LESS),
        ("stiffness", MORE),
        ("loop_gain", LESS),
        ("lag_gain", LESS),
        ("residual", LESS),
        ("residual", MORE),
        ("wind_gain", MORE),
    ],
)
def test_each_coefficient_needs_its_share(
    short: dict[str, Any], name: str, power: list[float]
) -> None:
    """All others are stated far too wide: what is left to fail is the one of the table alone."""
    claim = short["claims"][0]
    claim["uncertainty"]["power_coefficient"] = power
    for cell in claim["cells"]:
        for other in FAR_TOO_WIDE.keys() - {name}:
            ranged = isinstance(cell[other], list)
            cell[other] = [-1000.0, 1000.0] if ranged else 1000.0

    checked = check_document(resealed(short))

    assert checked.verdict is Verdict.UNDECIDED
    assert f"the loop's {name} {FAR_TOO_WIDE[name]}" in checked.claims[0].text


def test_the_residual_has_the_trim_torque_and_its_own_share(short: dict[str, Any]) -> None:
    """(1 + p) r + p T, where T is the larger demanded torque of both nodes over the inertia."""
    from fractions import Fraction

    from takagi.certificates.checker import read_text
    from takagi.certificates.checker.arithmetic.interval import ONE
    from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
    from takagi.certificates.checker.turbine.effort_sharing.loop import Loop
    from takagi.certificates.document.certificate_file import dumps

    read = read_text(dumps(short), "certificate")
    subject = Subject.read(read["claims"][0], read["model"], read["gains"], "claim")
    plant, law = subject.plant, subject.law
    one, p = Fraction(1), Fraction(3, 100)
    for k in range(len(law.wind) - 1):
        alone = Loop(subject, k, Fraction(0)).residual((one, one))
        asked = []
        for q in law.effort[k : k + 2]:
            reserve = max(-q, Fraction(0))
            if abs(q) < law.overlap:
                reserve = (law.overlap - q) ** 2 / (4 * law.overlap)
            asked.append((law.rated_torque - law.effort_torque * reserve) * plant.gear_per_inertia)
        needed = (1 + p) * Fraction(alone, ONE) + p * max(asked)

        for power in ((1 - p, one), (one, 1 + p), (1 - p, 1 + p / 2)):
            assert abs(
                Fraction(Loop(subject, k, Fraction(0)).residual(power), ONE) - needed
            ) < Fraction(1, 10**20)
