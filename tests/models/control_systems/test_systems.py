"""python-control's simulations and linear systems against our own equations and laws."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from takagi.models import (
    ModelError,
    TSModel,
    law_system,
    nonlinear_system,
    sector_model,
    statespace,
)
from takagi.models.laws.pdc import PdcLaw
from takagi.models.laws.protocol import Measurement, SampledLaw
from takagi.models.plant_files.loader import load_plant
from takagi.models.simulation.baseline import BaselineLaw
from takagi.models.simulation.turbine_plant import plant_rate as turbine_rate
from takagi.models.simulation.turbine_plant import validation_plant
from takagi.models.turbine.data import rotor_torque_gradient
from takagi.models.turbine.loader import load_turbine
from takagi.models.turbine.trim import trim
from tests.plant_rates import plant_rate

PAGE = Path(__file__).parents[3] / "docs" / "models.md"
EXACT: Any = {"rtol": 1e-11, "atol": 1e-13}


def small_law(name: str, gain: float = 1.0) -> Any:
    plant = load_plant(name)
    model = sector_model(plant)
    r, n, m = model.B.shape
    rng = np.random.default_rng(2)
    return plant, PdcLaw(
        model,
        gain * rng.uniform(0.5, 1.5, (r, m, n)),
        np.array([float(one.rest) for one in plant.states]),
        np.array([float(one.rest) for one in plant.inputs]),
    )


def states_by_control(plant: Any, law: PdcLaw, start: Any, time: Any) -> Any:
    states = [one.name for one in plant.states]
    loop = control.interconnect(
        [nonlinear_system(plant), law_system(law)],
        inputs=[one.name for one in plant.disturbances],
        outputs=states,
        check_unused=False,
    )
    rest = [float(one.rest) for one in plant.disturbances]
    held = np.outer(rest, np.ones(len(time))) if rest else 0
    options = {} if law.sample_time else {"solve_ivp_kwargs": EXACT}
    found = control.input_output_response(loop, time, held, start, **options)
    return np.atleast_2d(found.outputs)


@pytest.mark.parametrize(
    "name", ["duffing", pytest.param("mass_spring_damper", marks=pytest.mark.slow), "tora"]
)
def test_plant_and_law_move_as_in_our_simulation(name: str) -> None:
    """Without and with a mass matrix; both integrate with a relative tolerance of 1e-11."""
    plant, law = small_law(name)
    start = law.state_rest + 0.1
    time = np.linspace(0, 2, 21)
    rate = plant_rate(plant)
    ours = solve_ivp(
        lambda t, x: rate(x, law.sent(x)), (0, 2), start, t_eval=time, method="DOP853", **EXACT
    )
    found = states_by_control(plant, law, start, time)
    np.testing.assert_allclose(found, ours.y, rtol=1e-8, atol=1e-9)


def test_a_plant_in_discrete_time() -> None:
    plant, law = small_law("truck_trailer", 0.1)
    x, steps = law.state_rest + 0.1, [law.state_rest + 0.1]
    rate = plant_rate(plant)
    for _ in range(10):
        x = rate(x, law.sent(x))
        steps.append(x)
    time = 2.0 * np.arange(11)
    found = states_by_control(plant, law, steps[0], time)
    np.testing.assert_allclose(found, np.array(steps).T, rtol=1e-12, atol=1e-12)
    assert nonlinear_system(plant).dt == law_system(law).dt == 2.0


@pytest.mark.parametrize("name", ["duffing", "tora", "cart_pole", "truck_trailer", "quarter_car"])
def test_the_linearisation_is_the_slope_of_the_equations(name: str) -> None:
    plant = load_plant(name)
    rate, states = plant_rate(plant), [one.name for one in plant.states]
    x = np.array([float(one.rest) for one in plant.states]) + 0.1
    u = np.array([float(one.rest) for one in plant.inputs]) + 0.2
    names = [*states, *(one.name for one in plant.inputs)]
    found = statespace(plant, at=dict(zip(names, [*x, *u], strict=True)))
    n, m, h = len(x), len(u), 1e-6
    both = np.concatenate([x, u])
    for k in range(n + m):
        step = h * np.eye(n + m)[k]
        up, down = both + step, both - step
        slope = (rate(up[:n], up[n:]) - rate(down[:n], down[n:])) / (2 * h)
        column = found.A[:, k] if k < n else found.B[:, k - n]
        np.testing.assert_allclose(column, slope, rtol=2e-6, atol=2e-6 * (1 + abs(slope).max()))
    assert found.state_labels == states
    assert found.dt == (plant.sample_time or 0)


def test_a_model_at_rest_is_the_plant_at_rest() -> None:
    """At the point that it is written around, the blend of the vertices is the linearisation."""
    plant = load_plant("duffing")
    blended, own = statespace(sector_model(plant)), statespace(plant)
    np.testing.assert_allclose(blended.A, own.A, atol=1e-6)
    np.testing.assert_allclose(blended.B, own.B, atol=1e-6)
    corner = statespace(sector_model(plant), at={"x": 5.0})
    # x^3 = x^2 x: the premise is x^2, at its upper end where x = 5.
    assert corner.A[1, 0] == pytest.approx(-25.0, abs=1e-5)


def test_a_turbine_s_law_keeps_its_states() -> None:
    law = BaselineLaw(load_turbine("nrel5mw"))
    system = law_system(law)
    state, seen = law.initial_state(15.0), Measurement(1.3, 0.2, 15.0)
    np.testing.assert_array_equal(system.output(0, state, list(seen)), law.command(state, seen))
    np.testing.assert_array_equal(
        system.dynamics(0, state, list(seen)), law.state_rate(state, seen)
    )
    assert system.output_labels == ["torque", "pitch_reference"]
    assert system.state_labels[0] == "filtered_generator_speed"


def test_a_sampled_law_is_a_system_in_discrete_time() -> None:
    law = SampledLaw(BaselineLaw(load_turbine("nrel5mw")), 0.02, 0.0, 15000.0, 0.14)
    system, rng = law_system(law), np.random.default_rng(4)
    seen = np.array([[1.25 + 0.05 * k, 0.2, 15.0] for k in rng.uniform(-1, 1, 50)])
    first = law.law.command(law.law.initial_state(15.0), Measurement(1.26, 0.2, 15.0))
    within = law.start(15.0, first)
    wanted = []
    start = np.concatenate([within.law_state, within.sent])
    for row in seen:
        sent, within = law.step(within, Measurement(*row))
        wanted.append(sent)
    found = control.input_output_response(system, 0.02 * np.arange(50), seen.T, start)
    np.testing.assert_allclose(found.outputs.T, wanted, rtol=1e-12)
    assert system.dt == 0.02


def test_a_turbine_and_its_law_move_as_in_our_simulation() -> None:
    turbine = load_turbine("nrel5mw")
    plant, law = validation_plant(turbine), BaselineLaw(turbine)
    start, point = plant.initial_state(15.0)
    inner = law.initial_state(15.0)
    n = len(start)

    def rate(t: float, z: Any) -> Any:
        seen = Measurement(z[0], z[1], 16.0)
        sent = law.command(z[n:], seen)
        moved = turbine_rate(plant)(z[:n], sent.torque, sent.pitch, 16.0)
        return np.concatenate([moved, law.state_rate(z[n:], seen)])

    time = np.linspace(0, 0.2, 3)
    both = np.concatenate([start, inner])
    ours = solve_ivp(rate, (0, 0.2), both, t_eval=time, method="DOP853", rtol=1e-9, atol=1e-11)
    loop = control.interconnect(
        [nonlinear_system(plant), law_system(law)],
        connections=[
            ["turbine.torque", "law.torque"],
            ["turbine.pitch_reference", "law.pitch_reference"],
            ["law.rotor_speed", "turbine.rotor_speed"],
            ["law.pitch", "turbine.pitch"],
        ],
        inplist=[["turbine.wind", "law.wind_estimate"]],
        inputs=["wind"],
        outlist=["turbine.rotor_speed", "turbine.pitch"],
        check_unused=False,
    )
    options = {"rtol": 1e-9, "atol": 1e-11}
    found = control.input_output_response(loop, time, 16.0, both, solve_ivp_kwargs=options)
    np.testing.assert_allclose(found.outputs[0], ours.y[0], rtol=1e-6)
    np.testing.assert_allclose(found.outputs[1], ours.y[1], atol=1e-6)


@pytest.mark.parametrize("wind", [8.0, 11.4, 18.0])
def test_a_turbine_s_slopes_are_those_of_its_tables(wind: float) -> None:
    turbine = load_turbine("nrel5mw")
    linear = statespace(turbine, at={"wind": wind})
    point = trim(turbine, wind)
    slopes = rotor_torque_gradient(turbine, point.rotor_speed, point.pitch, wind)
    by_speed, by_pitch, by_wind = (float(one) / turbine.inertia for one in slopes)
    assert linear.A[0, 0] == pytest.approx(by_speed, rel=1e-5, abs=1e-7)
    assert linear.A[0, 1] == pytest.approx(by_pitch, rel=1e-4)
    assert linear.B[0, 2] == pytest.approx(by_wind, rel=1e-5)
    assert linear.B[0, 0] == pytest.approx(-turbine.gear_ratio / turbine.inertia, rel=1e-6)
    assert linear.B[1, 1] == pytest.approx(1 / turbine.pitch_time_constant, rel=1e-6)
    with pytest.raises(ModelError, match="a turbine needs its wind alone"):
        statespace(turbine)
    with pytest.raises(ModelError, match="wind = 40"):
        statespace(turbine, at={"wind": 40.0})


def test_misuse_is_told() -> None:
    plant = load_plant("duffing")
    with pytest.raises(ModelError, match="at: 'y' was given; the model has x, v, u, w"):
        statespace(plant, at={"y": 1.0})
    with pytest.raises(ModelError, match="a finite value is needed"):
        statespace(sector_model(plant), at={"x": np.nan})
    with pytest.raises(ModelError, match="behind a blend"):
        nonlinear_system(load_plant("boost_throttle"))
    with pytest.raises(ModelError, match="have no premises"):
        statespace(TSModel(np.zeros((2, 1, 1)), np.ones((1, 1))))


def test_the_page_runs(capsys: pytest.CaptureFixture[str]) -> None:
    found = re.search(
        r"<!-- a test runs .*?```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL
    )
    assert found is not None
    exec(found[1], {})
    assert float(capsys.readouterr().out) < 0.4
