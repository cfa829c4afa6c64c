"""The numbers behind a plant's report: ellipsoid, memberships, linear loops, computed two ways."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from takagi.certificates.checker.replay.certificate import concluded
from takagi.certificates.design.plant.design import certify_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Interval, ModelError, Plant, Variable
from takagi.reports.figures.plant.proved_set import ellipse, planes
from takagi.reports.loops.plant_local import local_loops, regulator
from takagi.reports.loops.plant_loop import largest_commands, plant_loop
from takagi.reports.sections.plant.claims import set_section
from takagi.reports.sections.plant.gains import gain_columns
from takagi.reports.sections.plant.loops import loops_section
from tests.plant_rates import plant_rate
from tests.reports.plant_designs import U, V, X, design_of, two_integrators

PENDULUM, DISCRETE, ANALYSIS = "cart_pole_2rules", "truck_trailer", "dayawansa_martin"


@pytest.mark.slow
def test_the_ellipsoid_is_the_largest_in_the_box() -> None:
    """Its border touches a side of the box, and lies on the level: by points, not by formula."""
    loop = plant_loop(design_of("cart_pole"))
    P, level = loop.ellipsoid
    border = ellipse(P, level, (0, 1), points=20001)
    sides = [float(loop.model.box[label][1]) for label in loop.model.states]
    reach = np.abs(border).max(axis=1) / sides

    assert np.einsum("ik,ij,jk->k", border, P, border) == pytest.approx(level, rel=1e-9)
    assert loop.level_proved or reach.max() == pytest.approx(1, rel=1e-6)
    assert reach.max() <= 1 + 1e-9


def test_a_projection_holds_all_points_of_the_ellipsoid() -> None:
    """Random points of {x'Px = c} in four states, projected, lie inside; some near the border."""
    loop = plant_loop(design_of("flexible_joint"))
    P, level = loop.ellipsoid
    chance = np.random.default_rng(3).normal(size=(4000, 4))
    points = np.linalg.solve(np.linalg.cholesky(P).T, chance.T)
    points *= np.sqrt(level / np.einsum("ik,ij,jk->k", points, P, points))
    for pair in planes(loop):
        border = ellipse(P, level, pair)
        shape = np.linalg.inv(border[:, :-1] @ border[:, :-1].T / (border.shape[1] - 1) * 2)
        flat = points[list(pair)]
        share = np.einsum("ik,ij,jk->k", flat, shape, flat)
        assert 0.9 < share.max() <= 1 + 1e-9


def test_the_largest_command_is_that_of_the_worst_rule_and_state() -> None:
    """sqrt(c K P^-1 K') against the maximum over points of the ellipse, for every rule."""
    loop = plant_loop(design_of(PENDULUM))
    assert loop.gains is not None
    border = ellipse(*loop.ellipsoid, (0, 1), points=20001)
    ((name, most),) = largest_commands(loop)

    assert name == "force [N]"
    assert most == pytest.approx(np.abs(loop.gains[:, 0] @ border).max(), rel=1e-6)


def test_a_claim_that_is_not_proved_gives_no_ellipsoid() -> None:
    """P of an undecided claim is nobody's function."""
    design = design_of(PENDULUM)
    checked = design.certificate.checked
    from takagi.certificates import Claim, Verdict

    doubted = concluded([Claim(c.name, Verdict.UNDECIDED, c.text) for c in checked.claims], [])
    loop = plant_loop(replace(design, certificate=replace(design.certificate, checked=doubted)))

    assert loop.P is None and loop.level is None and loop.decay_rate is None
    assert largest_commands(loop) == []


def test_gains_of_another_model_are_refused() -> None:
    """Named with both shapes."""
    with pytest.raises(ModelError, match=r"2 rules, 1 inputs and 2 states need"):
        plant_loop(replace(design_of(PENDULUM), gains=np.zeros((16, 1, 2))))


@pytest.mark.parametrize(
    "name", ["duffing", pytest.param("tora", marks=pytest.mark.slow), "lorenz"]
)
def test_the_loop_at_rest_is_the_derivative_of_the_plant(name: str) -> None:
    """A - B K against central differences of the plant's own equations under the law."""
    loop = plant_loop(design_of(name))
    rate = plant_rate(loop.plant)
    matrices, K = loop.at_rest()
    assert K is not None
    step = 1e-6
    columns = [
        (rate(loop.state + d, loop.command(d)) - rate(loop.state - d, loop.command(-d))) / 2 / step
        for d in step * np.eye(len(loop.names))
    ]

    assert np.column_stack(columns) == pytest.approx(matrices.A - matrices.B @ K, abs=1e-5)


def test_an_open_loop_on_the_axis_has_margins() -> None:
    """Mass, spring, damper: some vertices have no damping, and a pole on the axis."""
    found = local_loops(plant_loop(design_of("mass_spring_damper")))

    assert len(found) == 5 and all(one.margins.stable for one in found)


def test_gains_have_the_unit_of_input_per_state() -> None:
    """force [N] by rate [rad/s]: N s/rad."""
    assert gain_columns(plant_loop(design_of(PENDULUM)))[-2:] == (
        ("force by angle", "N/rad"),
        ("force by rate", "N s/rad"),
    )


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
