"""A true power coefficient beside the table's: the loop lies in the family that says so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from takagi.models import Turbine
from takagi.models.laws.effort_sharing.law import EffortSharingLaw, LoopCell
from takagi.models.turbine.data import rotor_torque
from tests.certificates.loop_cells.loop_points import (
    BOX,
    ROUNDING,
    WIDER,
    WRONG,
    campaign,
    column,
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


@pytest.mark.slow
@pytest.mark.parametrize("power", [0.98, 1.0, 1.02])
def test_residual_between_nodes_is_inside_its_bound(
    power: float,
    turbine: Turbine,
    law: EffortSharingLaw,
    cells: list[LoopCell],
    wider: list[LoopCell],
) -> None:
    """width^2/8 times the enclosed curvature holds at forty winds of every cell, without waste.

    A power coefficient that is wrong leaves its share of the trim's torque as well.
    """
    table, ratio = law.schedule, []
    for k, cell in enumerate(cells if power == 1.0 else wider):
        winds = np.linspace(table.wind[k], table.wind[k + 1], 40)
        left = []
        for v in winds:
            omega = column(law, "rotor_speed", v)
            driving = power * float(rotor_torque(turbine, omega, table.pitch(v, turbine), v))
            held = turbine.gear_ratio * table.torque(v, turbine)
            left.append(abs(driving - held) / turbine.inertia)
        assert max(left) <= float(cell.residual)
        ratio.append(max(left) / float(cell.residual))
    assert max(ratio) > 0.3
