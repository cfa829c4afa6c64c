"""The law as an FMU: FMPy has nothing to complain of, and runs it to the Python law's commands."""

from __future__ import annotations

from pathlib import Path
from random import Random

import numpy as np
import pytest

from takagi.certificates import TurbineDesign
from takagi.reports.code.run import ProgramRun
from tests.reports.code.fmu_files import exported, fmpy, simulated, sources_alone
from tests.reports.test_gain_file_alone import plant_file, plant_law, turbine_file

EXACT = 1e-9
SAMPLES = 60


def compared(gains: Path, time: float, random: Random) -> int:
    """Compare both FMUs with the law in Python at random inputs; return how many values."""
    program, made = exported(gains, sample_time=time)
    times = time * np.arange(SAMPLES + 1)
    inputs = {}
    for one in program.inputs:
        low, high = map(float, one.range or (-1, 1))
        inputs[one.name] = [random.uniform(low, high) for _ in times]
    run, count = ProgramRun(program), 0
    wanted = [
        run.sample(time, {name: values[k] for name, values in inputs.items()})
        for k in range(SAMPLES)
    ]
    for name in made.files:
        found = simulated(gains.parent / name, times, inputs)
        for signal in wanted[0]:
            ours = np.array([row[signal] for row in wanted])
            # What is computed from the inputs at t is there at the end of the step, t + T.
            np.testing.assert_allclose(found[signal][1:], ours, rtol=EXACT, atol=1e-300)
            assert found[signal][0] == pytest.approx(ours[0], rel=EXACT)
            count += len(ours)
    return count


@pytest.mark.parametrize(
    "name",
    [
        "split_range",
        *(pytest.param(name, marks=pytest.mark.slow) for name in ("cart_pole", "truck_trailer")),
    ],
)
def test_a_plant_s_law(name: str, tmp_path: Path) -> None:
    """Rules, a blend with its kept effort, and a law in discrete time."""
    own = plant_law(name)[1].model.sample_time

    assert compared(plant_file(name, tmp_path), float(own or 0.05), Random(3)) >= 2 * SAMPLES


def test_a_turbine_s_law(turbine_design: TurbineDesign, tmp_path: Path) -> None:
    """Low-pass, observer, law and rate limits: eleven kept values."""
    gains = turbine_file(turbine_design, turbine_design.law, tmp_path)

    assert compared(gains, 0.02, Random(4)) == 2 * 6 * SAMPLES


@pytest.mark.parametrize(
    "name",
    [
        "split_range",
        *(
            pytest.param(name, marks=pytest.mark.slow)
            for name in ("cart_pole", "truck_trailer", "tora")
        ),
    ],
)
def test_every_file_is_valid(name: str, tmp_path: Path) -> None:
    fmpy()
    from fmpy.validation import validate_fmu

    _, made = exported(plant_file(name, tmp_path))

    assert len(made.files) == 2
    for file in made.files:
        assert validate_fmu(str(tmp_path / file)) == []


def test_variables_say_what_they_are(tmp_path: Path) -> None:
    fmpy()
    from fmpy import read_model_description

    sources_alone(plant_file("cart_pole", tmp_path), sample_time=0.004)
    found = read_model_description(str(tmp_path / "cart_pole_16_rules.fmu"))
    variables = {one.name: one for one in found.modelVariables}
    units = {one.name: one.baseUnit for one in found.unitDefinitions}

    assert found.coSimulation.modelIdentifier == "cart_pole_16_rules"
    assert found.coSimulation.canHandleVariableCommunicationStepSize
    assert variables["angle"].causality == "input"
    assert variables["angle"].unit == "rad"
    assert variables["angle"].description == (
        "measured; of the pendulum from upright; the model holds in [-1.5, 1.5]"
    )
    assert variables["force"].causality == "output"
    assert float(variables["sample_time"].start) == 0.004
    assert variables["status"].type == "UInt32"
    force = units["N"]
    assert (force.kg, force.m, force.s, force.rad) == (1, 1, -2, 0)
