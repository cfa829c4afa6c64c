"""The closed loop as an FMU against the loop in Python: law, plant and Runge-Kutta steps."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from takagi.certificates import TurbineDesign
from takagi.models import Floats, Plant
from takagi.models.laws import SampledLaw
from takagi.models.simulation import SimulatedTurbine, WindSeries, simulate
from takagi.models.simulation.dynamics import dynamics
from takagi.reports.code import ProgramRun
from takagi.reports.code.fmu.model_source import INNER_STEPS
from tests.reports.code.fmu_files import exported, simulated
from tests.reports.test_gain_file_alone import plant_file, plant_law, turbine_file

EXACT = 1e-9

Slope = Callable[[Floats, Floats], Floats]


def moved(
    x: Floats, slope: Slope, u: Floats, time: float, hold: Callable[[Floats], Floats] | None = None
) -> Floats:
    """Return x after a time, by the classical method in as many steps as the FMU takes."""
    step = time / INNER_STEPS
    for _ in range(INNER_STEPS):
        k1 = slope(x, u)
        k2 = slope(x + step / 2 * k1, u)
        k3 = slope(x + step / 2 * k2, u)
        k4 = slope(x + step * k3, u)
        x = x + step / 6 * (k1 + 2 * (k2 + k3) + k4)
        x = x if hold is None else hold(x)
    return x


def plant_slope(plant: Plant, disturbances: dict[str, float]) -> Slope:
    """Return (x, u) -> x' of the plant as it was written, by sympy: no part of the export."""
    import sympy as sp

    values = {s: sp.Rational(*v.as_integer_ratio()) for s, v in plant.values.items()}
    values |= {v.symbol: sp.Float(disturbances[v.name]) for v in plant.disturbances}
    symbols = [v.symbol for v in (*plant.states, *plant.inputs)]
    right = sp.lambdify(symbols, [sp.sympify(row).subs(values) for row in plant.equations])
    mass = None if plant.mass is None else sp.lambdify(symbols, plant.mass.subs(values).tolist())

    def slope(x: Floats, u: Floats) -> Floats:
        found = np.array(right(*x, *u), dtype=float)
        return found if mass is None else np.linalg.solve(np.array(mass(*x, *u), float), found)

    return slope


LOOPS = [
    pytest.param("cart_pole", 0.01, {"angle": 0.2}, marks=pytest.mark.slow),
    ("tora", 0.05, {"x": 0.1, "theta": 0.3}),  # with a mass matrix
    ("truck_trailer", 2.0, {"x1": 0.02, "x3": -0.05}),  # in discrete time
    pytest.param("quarter_car", 0.001, {}, marks=pytest.mark.slow),  # with a disturbance
]


@pytest.mark.parametrize(("name", "time", "start"), LOOPS)
def test_a_plant_with_its_law(
    name: str, time: float, start: dict[str, float], tmp_path: Path
) -> None:
    gains = plant_file(name, tmp_path)
    plant, law = plant_law(name)
    program, made = exported(gains, sample_time=time)
    disturbances = {v.name: float(v.rest) + 0.01 for v in plant.disturbances}
    slope, run = plant_slope(plant, disturbances), ProgramRun(program)
    names = [v.name for v in plant.states]
    x = np.array([start.get(v.name, float(v.rest)) for v in plant.states])
    # Gains of no meaning: in discrete time the loop goes far off, and rounding grows with it.
    count = 10 if law.model.sample_time else 40
    states, commands = [x], []
    for _ in range(count):
        seen = dict(zip(names, map(float, x), strict=True))
        sent = run.sample(time, seen | disturbances)
        u = np.array([sent[v.name] for v in plant.inputs])
        x = slope(x, u) if law.model.sample_time else moved(x, slope, u, time)
        states.append(x)
        commands.append(u)

    assert np.ptp(np.array(states)) > 0.001
    for file in (one for one in made.files if "_loop" in one):
        times = time * np.arange(count + 1)
        inputs = {key: [value] * (count + 1) for key, value in disturbances.items()}
        found = simulated(tmp_path / file, times, inputs, start)
        for k, one in enumerate(plant.states):
            ours = np.array(states)[:, k]
            np.testing.assert_allclose(found[one.name], ours, EXACT, EXACT * np.abs(ours).max())
        for k, one in enumerate(plant.inputs):
            ours = np.array(commands)[:, k]
            np.testing.assert_allclose(found[one.name][1:], ours, EXACT, EXACT * np.abs(ours).max())


TABLES = """format = 1
kind = "plant"
name = "Pendulum with tabulated friction"
units = "unchecked"

[states]
theta = { unit = "rad", range = [-1.2, 1.2] }
omega = { unit = "rad/s", range = [-3, 3] }

[inputs]
tau = { unit = "N m" }

[parameters]
m = { value = 2.0, unit = "kg" }
l = { value = 500, unit = "mm" }
g = { value = 9.81, unit = "m/s^2" }

[tables.friction]
file = "friction.csv"
unit = "N m"
arguments = [{ name = "speed", unit = "rad/s" }]

[equations]
theta = "omega"
omega = "(m*g*l*sin(theta) + tau - friction(omega) + friction(0))/(m*l^2)"
"""


@pytest.mark.slow
def test_a_plant_with_a_table(tmp_path: Path) -> None:
    """Friction as a spline, which C evaluates by its B-splines."""
    rows = "".join(f"{k / 2},{0.3 * np.tanh(k)}\n" for k in range(-6, 7))
    (tmp_path / "friction.csv").write_text(rows, encoding="utf-8")
    path = tmp_path / "pendulum.toml"
    path.write_text(TABLES, encoding="utf-8")

    test_a_plant_with_its_law(str(path), 0.01, {"theta": 0.3, "omega": -0.5}, tmp_path)


def test_a_blended_plant_is_moved_by_its_two_actuators(tmp_path: Path) -> None:
    """An error of an actuator scales its motion from rest."""
    plant, law = plant_law("split_range")
    assert law.blend is not None
    blending, time = law.blend.blending, 1.0
    program, made = exported(plant_file("split_range", tmp_path), sample_time=time)
    slope, run = plant_slope(blending.plant, {}), ProgramRun(program)
    start = {"T": 352.0, "Tj": 338.0}
    wrong = {"cooling_error": 0.05, "heating_error": -0.08}
    names = [v.name for v in blending.plant.states]
    x = np.array([start.get(v.name, float(v.rest)) for v in blending.plant.states])
    states = [x]
    for _ in range(30):
        sent = run.sample(time, dict(zip(names, map(float, x), strict=True)))
        acting = {
            a.name: float(blending.at_rest(a))
            + (1 + wrong[a.error_name]) * (sent[a.name] - float(blending.at_rest(a)))
            for a in blending.actuators
        }
        u = np.array([acting[v.name] for v in blending.plant.inputs])
        x = moved(x, slope, u, time)
        states.append(x)
    inputs = {name: [value] * 31 for name, value in wrong.items()}
    found = simulated(
        tmp_path / next(one for one in made.files if one.endswith("_loop.fmu")),
        time * np.arange(31), inputs, start,
    )  # fmt: skip

    for k, one in enumerate(names):
        np.testing.assert_allclose(found[one], np.array(states)[:, k], EXACT)
    assert abs(states[-1][1] - 338.0) > 1e-3


@pytest.mark.slow
def test_a_turbine_in_a_wind_that_steps(turbine_design: TurbineDesign, tmp_path: Path) -> None:
    """The rotor and pitch drive of ``takagi simulate``; from 9 to 14 m/s in steps."""
    design, time = turbine_design, 0.02
    turbine = design.turbine
    program, made = exported(turbine_file(design, design.law, tmp_path), sample_time=time)
    plant = dynamics(
        SimulatedTurbine(
            turbine, "first-order", tower=False, pitch_rate_limit=turbine.pitch_rate_limit
        )
    )

    def slope(x: Floats, u: Floats) -> Floats:
        return plant.derivative(x, *map(float, u))

    def hold(x: Floats) -> Floats:
        held = x.copy()
        plant.hold(held)
        return held

    run, x = ProgramRun(program), np.array([1.1, 0.02])
    winds = [9.0 + 0.5 * (k // 40) for k in range(401)]
    states = [x]
    for wind in winds[:-1]:
        sent = run.sample(
            time, {"measured_speed": float(x[0]), "pitch": float(x[1]), "wind_guess": winds[0]}
        )
        x = moved(x, slope, np.array([sent["torque_sent"], sent["pitch_sent"], wind]), time, hold)
        states.append(x)
    found = simulated(
        tmp_path / next(one for one in made.files if one.endswith("_loop.fmu")),
        time * np.arange(401), {"wind_speed": winds}, {"actual_speed": 1.1, "pitch": 0.02},
    )  # fmt: skip

    np.testing.assert_allclose(found["actual_speed"], np.array(states)[:, 0], EXACT)
    np.testing.assert_allclose(found["pitch"], np.array(states)[:, 1], EXACT, EXACT)
    assert np.array(states)[:, 1].max() > 0.05


def test_a_turbine_as_our_own_simulation_runs_it(
    turbine_design: TurbineDesign, tmp_path: Path
) -> None:
    """A wind from 11 to 13 m/s in 20 s.

    The FMU holds the wind for a step, ours is a line: it gets the middle of each step.
    """
    design, time = turbine_design, 0.02
    turbine = design.turbine
    # The simulation's low-pass is continuous.
    gains = turbine_file(design, design.law, tmp_path)
    program, made = exported(gains, ("speed filter",), sample_time=time)
    limits = turbine.torque_rate_limit, turbine.pitch_rate_limit
    plant = SimulatedTurbine(
        turbine, "first-order", tower=False, pitch_rate_limit=limits[1], torque_rate_limit=limits[0]
    )
    times = np.arange(1000 * INNER_STEPS + 1, dtype=np.float64) * (time / INNER_STEPS)
    speeds = 11.0 + 0.1 * times
    ours = simulate(
        plant, SampledLaw(design.law, time, 0.0, *limits), WindSeries(times, speeds, "ramp"),
        observer=design.observer.observer, time_step=time / INNER_STEPS,
    )  # fmt: skip
    start = {"speed": float(ours.rotor_speed[0]), "pitch": float(ours.pitch[0])}
    found = simulated(
        tmp_path / next(one for one in made.files if one.endswith("_loop.fmu")),
        times, {"wind_speed": [11.0, *(speeds[1:] + 0.05 * times[1]).tolist()]}, start,
    )  # fmt: skip

    each = slice(None, None, INNER_STEPS)
    np.testing.assert_allclose(found["speed"][each], ours.rotor_speed, rtol=1e-6)
    np.testing.assert_allclose(found["pitch"][each], ours.pitch, rtol=1e-6, atol=1e-6)
    assert np.ptp(ours.pitch) > 0.05
