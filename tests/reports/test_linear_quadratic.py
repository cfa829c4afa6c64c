"""The regulator beside a design: closed forms, its set, and where there is none."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from takagi.certificates.design.plant.design import certify_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Interval, Plant, Variable
from takagi.reports.loops.linear_quadratic import regulator
from takagi.reports.loops.plant_loop import plant_loop
from takagi.reports.sections.plant.loops import regulator_section
from tests.reports.plant_designs import U, V, X, two_integrators


def spring(*, room: int | None = 6, step: float | None = None) -> PlantDesign:
    return two_integrators(2, 3, side=2, room=room, step=step)


def test_the_gain_is_the_closed_form_for_two_integrators() -> None:
    """min of x^2/q^2 + v^2/s^2 + u^2/r^2: k1 = r/q, k2 = (2 k1 + r^2/s^2)^(1/2)."""
    found = regulator(spring())
    assert found is not None
    assert np.allclose(found.gain, [[6.0, np.sqrt(12.0 + 9.0)]], rtol=1e-3)
    assert np.allclose(found.own_gain, [[2.0, 3.0]])
    assert np.allclose(np.sort(found.own_poles.real), [-2.0, -1.0])
    time = found.settling(own=True, step=None)
    assert time is not None and np.isclose(time, np.log(50.0))


def test_its_set_is_inside_the_box_and_keeps_the_input() -> None:
    """From each state alone the regulator's first command is within the range."""
    found = regulator(spring())
    assert found is not None and found.sought and found.starts is not None
    assert np.all(found.starts <= [1.0, 2.0])
    assert np.all(np.abs(found.gain[0]) * found.starts <= 6.0 * (1 + 1e-9))


def test_in_discrete_time_poles_are_inside_the_circle() -> None:
    found = regulator(spring(step=0.1))
    assert found is not None and np.all(np.abs(found.poles) < 1)
    time = found.settling(own=False, step=0.1)
    assert time is not None and time > 0


def test_an_input_without_a_range_takes_its_largest_command_on_the_set() -> None:
    design = spring(room=None)
    found = regulator(design)
    loop = plant_loop(design)
    assert found is not None
    P, level = loop.ellipsoid
    K = np.array([2.0, 3.0])
    assert np.isclose(found.inputs[0], np.sqrt(level * K @ np.linalg.solve(P, K)))


def test_a_plant_that_no_input_stabilises_has_no_regulator() -> None:
    """x' = x beside a stable loop: no solution, and so no section."""
    plant = Plant(
        equations=(X, U),
        states=(Variable(X, "-", Interval.of(-1, 1)), Variable(V, "-", Interval.of(-1, 1))),
        inputs=(Variable(U, "-", Interval.of(-1, 1)),),
    )
    design = certify_plant(plant, np.array([[[0.0, 1.0]]]))
    assert regulator(design) is None
    assert regulator_section(design, plant_loop(design)) is None


@pytest.mark.parametrize("sought", [True, False])
def test_the_section_says_what_is_floating_point_and_what_was_not_sought(sought: bool) -> None:
    from unittest.mock import patch

    from takagi.reports.loops import linear_quadratic

    with patch.object(linear_quadratic, "MOST_RULES", 16 if sought else 0):
        design = spring()
        section = regulator_section(replace(design), plant_loop(design))
    assert section is not None
    rows = {row[0]: row[1:] for row in section.content["table"].rows}
    assert rows["gain, u by x"] == ("(m/s^2)/m", "2.000", "6.000")
    assert section.content["sought"] is sought
    assert (rows["proved start of x alone"][2] != "\N{EN DASH}") == sought or sought
    assert section.content["proved"] is sought
