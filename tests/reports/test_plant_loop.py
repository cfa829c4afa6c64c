"""The numbers behind a plant's report: ellipsoid, memberships, linear loops, computed two ways."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
import scipy.linalg
import sympy as sp
from scipy.integrate import solve_ivp

from takagi.certificates.checker.replay.certificate import concluded
from takagi.certificates.design.plant.design import certify_plant, design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import Interval, ModelError, Parameter, Plant, Variable, sector_model
from takagi.models.plant_simulation.signals import Noise, Step
from takagi.reports.figures.plant.captioned import Drawn
from takagi.reports.figures.plant.proved_set import ellipse, planes
from takagi.reports.loops.plant_local import local_loops, regulator
from takagi.reports.loops.plant_loop import PlantLoop, largest_commands, plant_loop
from takagi.reports.loops.plant_motion import around, motions, settling_time, starts
from takagi.reports.sections.plant.claims import set_section
from takagi.reports.sections.plant.gains import gain_columns
from takagi.reports.sections.plant.loops import loops_section, motion_section
from takagi.reports.simulation.plant import simulate_plant
from takagi.reports.simulation.plant_words import PlantScenario
from tests.plant_files import filed_plant
from tests.plant_rates import plant_rate
from tests.reports.plant_designs import U, V, X, design_of, two_integrators

PENDULUM, DISCRETE, ANALYSIS = "cart_pole_2rules", "truck_trailer", "dayawansa_martin"


@pytest.mark.slow
def test_the_ellipsoid_is_the_largest_in_the_box() -> None:
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
    design = design_of(PENDULUM)
    checked = design.certificate.checked
    from takagi.certificates import Claim, Verdict

    doubted = concluded([Claim(c.name, Verdict.UNDECIDED, c.text) for c in checked.claims], [])
    loop = plant_loop(replace(design, certificate=replace(design.certificate, checked=doubted)))

    assert loop.P is None and loop.level is None and loop.decay_rate is None
    assert largest_commands(loop) == []


def test_gains_of_another_model_are_refused() -> None:
    with pytest.raises(ModelError, match=r"2 rules, 1 inputs and 2 states need"):
        plant_loop(replace(design_of(PENDULUM), gains=np.zeros((16, 1, 2))))


@pytest.mark.parametrize(
    "name", ["duffing", pytest.param("tora", marks=pytest.mark.slow), "lorenz"]
)
def test_the_loop_at_rest_is_the_derivative_of_the_plant(name: str) -> None:
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
    design = spring()
    beside, safe = regulator(design), set_section(design, plant_loop(design))
    assert beside is not None and beside.starts is not None and safe is not None
    for row, start in zip(safe.content["table"].rows, beside.starts, strict=True):
        shown = float(row[-1].removeprefix("±"))
        assert shown <= start and np.isclose(shown, start, rtol=1e-2)


def linear_loop(step: float | None = None) -> PlantLoop:
    """x1' = x2, x2' = -2 x1 - 3 x2 + u with K = (1, 1), in deviations from x* = (3, 0), u* = 6."""
    x1, x2, u = (sp.Symbol(name, real=True) for name in ("x1", "x2", "u"))
    a = sp.Symbol("a", real=True)
    plant = Plant(
        states=(
            Variable(x1, "m", Interval.of(1, 5), rest=Fraction(3)),
            Variable(x2, "m/s", Interval.of(-4, 4)),
        ),
        inputs=(Variable(u, "N", rest=Fraction(6)),),
        parameters=(Parameter(a, Fraction(2)),),
        equations=(x2, -a * x1 - 3 * x2 + u) if step is None else (x1 + step * x2, x2 / 2 + u - 6),
        sample_time=step,
    )
    model = sector_model(plant)
    return PlantLoop(
        plant, model, np.array([[[1.0, 1.0]]]) * (1.0 if step is None else 0.1),
        np.array([3.0, 0.0]), np.array([6.0]),
    )  # fmt: skip


def test_a_linear_motion_is_the_matrix_exponential() -> None:
    """x' = (A - B K) x about x* = (3, 0), u* = 6."""
    loop = linear_loop()
    x0 = np.array([1.0, -0.5])
    (motion,) = motions(loop, [("given", x0)])
    closed = np.array([[0.0, 1.0], [-3.0, -4.0]])
    exact = np.array([scipy.linalg.expm(closed * t) @ x0 for t in motion.time])

    assert motion.whole and np.abs(motion.state - exact).max() < 1e-6
    assert motion.input[:, 0] == pytest.approx(6 - exact.sum(axis=1), abs=1e-6)
    assert motion.value.size == 0


def test_a_discrete_motion_is_the_power_of_the_matrix() -> None:
    """x+ = (A - B K) x, time in samples."""
    loop = linear_loop(0.25)
    x0 = np.array([1.0, 0.5])
    (motion,) = motions(loop, [("given", x0)])
    closed = np.array([[1.0, 0.25], [-0.1, 0.4]])

    assert motion.state[7] == pytest.approx(np.linalg.matrix_power(closed, 7) @ x0)
    assert motion.time[7] == pytest.approx(1.75)


@pytest.mark.parametrize(
    "name",
    [
        *(PENDULUM, DISCRETE, ANALYSIS),
        *(pytest.param(n, marks=pytest.mark.slow) for n in ("quarter_car", "tora", "lorenz")),
    ],
)
def test_motions_decay_as_fast_as_was_proved(name: str) -> None:
    """V(t) <= e^(-2 alpha t) V(0) along the plant's own equations: proof against simulation."""
    loop = plant_loop(design_of(name))
    assert loop.decay_rate is not None and loop.decay_P is not None
    for motion in motions(loop, starts(loop)):
        V = np.einsum("ki,ij,kj->k", motion.state, loop.decay_P, motion.state)
        allowed = V[0] * np.exp(-2 * loop.decay_rate * motion.time)
        assert motion.whole and np.all(V <= allowed * (1 + 1e-4) + 1e-9 * V[0])


def test_starts_lie_inside_and_are_where_a_state_is_largest() -> None:
    loop = plant_loop(design_of(PENDULUM))
    P, level = loop.ellipsoid
    found = starts(loop)

    assert [name for name, _ in found] == ["angle largest", "rate largest"]
    for _, x in [*found, *around(loop, 12)]:
        assert 0.9 * level < x @ P @ x < level
    for j, (_, x) in enumerate(found):
        assert all(x[j] >= y[j] for _, y in around(loop, 500))


def test_a_wrong_sign_is_seen() -> None:
    design = design_of(PENDULUM)
    right = plant_loop(design)
    assert design.gains is not None
    wrong = plant_loop(replace(design, gains=-design.gains))
    calm, wild = (
        motion_section(loop, motions(loop, starts(right)), Drawn(())).content
        for loop in (right, wrong)
    )

    assert calm["rising"] == [] and calm["lost"] == []
    assert wild["rising"] == ["angle largest", "rate largest"]
    assert "rate largest" in wild["lost"]


def test_settling_is_read_off_a_known_exponential() -> None:
    """e^-t falls below a hundredth at ln 100; what does not settle has no time."""
    loop = linear_loop()
    (motion,) = motions(loop, [("given", np.array([1.0, 0.0]))])
    time = np.linspace(0, 8, 8001)
    falling = replace(motion, time=time, state=np.exp(-time)[:, None])
    staying = replace(motion, time=time, state=np.ones((8001, 1)))

    assert settling_time(falling) == pytest.approx(np.log(100), abs=2e-3)
    assert np.isnan(settling_time(staying))


FILE = """
format = 1
kind = "plant"
units = "unchecked"
measured = ["x"]
[states]
x = { range = [-1, 1] }
v = { range = [-4, 4] }
[inputs]
u = { range = [-15, 15] }
[disturbances]
load = { range = [-3, 3] }
[equations]
x = "v"
v = "20*sin(x) + 2*u + load"
"""


@cache
def pendulum() -> PlantDesign:
    with TemporaryDirectory() as folder:
        found = design_plant(filed_plant(Path(folder), FILE))
    assert isinstance(found, PlantDesign) and found.output_law is not None
    return found


def integrated(start: tuple[float, float], load: float, end: float) -> Any:
    law = pendulum().output_law
    assert law is not None

    def slope(time: float, z: Any) -> Any:
        x, v, s = z[0], z[1], z[2:]
        u = float(np.clip(law.command(s, [x])[0], -15, 15))
        push = load if time >= 0.5 else 0.0
        return [v, 20 * np.sin(x) + 2 * u + push, *law.following(s, [x], [u])]

    first = solve_ivp(slope, (0, 0.5), [*start, start[0], 0.0], rtol=1e-9, atol=1e-11)
    return solve_ivp(slope, (0.5, end), first.y[:, -1], rtol=1e-9, atol=1e-11).y[:, -1]


def test_a_disturbance_moves_plant_and_estimate() -> None:
    scenario = PlantScenario(disturbances=(("load", Step(1.0, 0.5)),))
    found = simulate_plant(
        pendulum(), starts=[{"x": 0.05, "v": 0.0}], duration=3.0, scenario=scenario
    )
    (motion,) = found.motions
    wanted = integrated((0.05, 0.0), 1.0, 3.0)

    assert motion.state[-1] == pytest.approx(wanted[:2], abs=1e-5)
    assert motion.estimate[-1] == pytest.approx(wanted[2:], abs=1e-5)
    assert abs(motion.state[-1, 0]) > 1e-3


def test_the_program_in_samples_comes_near_the_continuous_law() -> None:
    start = {"x": 0.05, "v": 0.0}
    smooth = simulate_plant(pendulum(), starts=[start], duration=0.5).motions[0]
    off = []
    for step in (0.004, 0.001):
        scenario = PlantScenario(sample_time=step)
        (motion,) = simulate_plant(
            pendulum(), starts=[start], duration=0.5, scenario=scenario
        ).motions
        last = [float(np.interp(t, motion.time, motion.state[:, 0])) for t in smooth.time]
        off.append(np.abs(np.array(last) - smooth.state[:, 0]).max())

    assert off[1] < 0.4 * off[0]
    assert off[1] < 1e-3


def test_noise_is_put_on_what_is_measured_alone() -> None:
    noise = PlantScenario(noise=(("x", Noise(0.001, every=0.01, seed=(1,))),))
    (motion,) = simulate_plant(pendulum(), starts=[{}], duration=0.3, scenario=noise).motions
    assert 0 < np.abs(motion.state[:, 0]).max() < 0.05

    with pytest.raises(ModelError, match="v: it is not measured by itself; .*put on x"):
        simulate_plant(
            pendulum(),
            starts=[{}],
            duration=1.0,
            scenario=PlantScenario(noise=(("v", Noise(0.001, every=0.01, seed=(1,))),)),
        )


def test_a_command_beyond_its_range_is_cut_and_told() -> None:
    """From x = 0.9 the law wants more than 15: what acts is 15, and the span is recorded."""
    (motion,) = simulate_plant(pendulum(), starts=[{"x": 0.9, "v": 0.0}], duration=0.5).motions

    assert np.abs(motion.wanted).max() > 15
    assert np.abs(motion.input).max() == 15
    assert motion.cuts and motion.cuts[0].begin == 0.0
