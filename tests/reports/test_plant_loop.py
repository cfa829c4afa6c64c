"""The numbers behind a plant's report: ellipsoid, memberships, linear loops, computed two ways."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from takagi.certificates.checker.replay.certificate import concluded
from takagi.models import ModelError
from takagi.reports.figures.plant.proved_set import ellipse, planes
from takagi.reports.loops.plant_local import local_loops
from takagi.reports.loops.plant_loop import largest_commands, plant_loop
from takagi.reports.sections.plant.gains import gain_columns
from tests.plant_rates import plant_rate
from tests.reports.plant_designs import design_of

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
