"""A law with measured outputs is simulated as it runs: disturbances, noise, samples, and limits.

The comparison is an integration of its own, written from the law's matrices.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from takagi.certificates.design.plant.design import design_plant
from takagi.certificates.design.plant.result import PlantDesign
from takagi.models import ModelError
from takagi.models.plant_files.loader import load_plant
from takagi.models.plant_simulation.signals import Noise, Step
from takagi.reports.simulation.plant import simulate_plant
from takagi.reports.simulation.plant_scenario import PlantScenario

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
        file = Path(folder) / "pendulum.toml"
        file.write_text(FILE, encoding="utf-8")
        found = design_plant(load_plant(file))
    assert isinstance(found, PlantDesign) and found.output_law is not None
    return found


def integrated(start: tuple[float, float], load: float, end: float) -> Any:
    """Return times and (x, v, estimate) from scipy alone, the load a step at 0.5 s."""
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
    """The motion ends where an integration of its own does, with an offset by the load."""
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
    """One step of Euler's method a sample: the distance falls like the sample time."""
    start = {"x": 0.05, "v": 0.0}
    smooth = simulate_plant(pendulum(), starts=[start], duration=1.0).motions[0]
    off = []
    for step in (0.004, 0.001):
        scenario = PlantScenario(sample_time=step)
        (motion,) = simulate_plant(
            pendulum(), starts=[start], duration=1.0, scenario=scenario
        ).motions
        last = [float(np.interp(t, motion.time, motion.state[:, 0])) for t in smooth.time]
        off.append(np.abs(np.array(last) - smooth.state[:, 0]).max())

    assert off[1] < 0.4 * off[0]
    assert off[1] < 1e-3


def test_noise_is_put_on_what_is_measured_alone() -> None:
    noise = PlantScenario(noise=(("x", Noise(0.001, every=0.01, seed=(1,))),))
    (motion,) = simulate_plant(pendulum(), starts=[{}], duration=1.0, scenario=noise).motions
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
