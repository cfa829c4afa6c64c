"""The regulator beside a design: closed forms, its set, and where there is none."""

from __future__ import annotations

import numpy as np

from takagi.certificates.design.plant.design import certify_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Interval, Plant, Variable
from takagi.reports.loops.linear_quadratic import regulator
from takagi.reports.loops.plant_local import local_loops
from takagi.reports.loops.plant_loop import plant_loop
from takagi.reports.sections.plant.certificate import set_section
from takagi.reports.sections.plant.loops import loops_section
from tests.reports.plant_designs import U, V, X, two_integrators


def spring(*, room: int | None = 6, step: float | None = None) -> PlantDesign:
    return two_integrators(2, 3, side=2, room=room, step=step)


def test_the_gain_is_the_closed_form_for_two_integrators() -> None:
    """min of x^2/q^2 + v^2/s^2 + u^2/r^2: k1 = r/q, k2 = (2 k1 + r^2/s^2)^(1/2)."""
    found = regulator(spring())
    assert found is not None
    assert np.allclose(found.gain, [[6.0, np.sqrt(12.0 + 9.0)]], rtol=1e-3)
    assert np.allclose(np.sort(found.own_poles.real), [-2.0, -1.0])
    time = found.settling(of_design=True, step=None)
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
    time = found.settling(of_design=False, step=0.1)
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
    """x' = x beside a stable loop: no solution."""
    plant = Plant(
        equations=(X, U),
        states=(Variable(X, "-", Interval.of(-1, 1)), Variable(V, "-", Interval.of(-1, 1))),
        inputs=(Variable(U, "-", Interval.of(-1, 1)),),
    )
    design = certify_plant(plant, np.array([[[0.0, 1.0]]]))
    assert regulator(design) is None


def test_the_report_says_where_the_law_is_worse_than_the_regulator() -> None:
    """Linear at rest, by the loops' margins and times; the regulator's own gains are not shown."""
    design = spring()
    loop, beside = plant_loop(design), regulator(design)
    assert beside is not None
    content = loops_section(design, loop, local_loops(loop)).content
    own, other = (beside.settling(of_design=own, step=None) for own in (True, False))
    assert own is not None and other is not None and own > other
    assert f"worse in settling time {own:.2f} against {other:.2f} s" in content["compared"]
    assert [row[0] for row in content["table"].rows[:2]] == ["rest", "rest, LQR"]
    assert len(content["weights"]) == 3


def test_safe_starts_of_both_laws_stand_side_by_side() -> None:
    """Rounded down, as bounds are."""
    design = spring()
    beside, safe = regulator(design), set_section(design, plant_loop(design))
    assert beside is not None and beside.starts is not None and safe is not None
    for row, start in zip(safe.content["table"].rows, beside.starts, strict=True):
        shown = float(row[-1].removeprefix("±"))
        assert shown <= start and np.isclose(shown, start, rtol=1e-2)
