"""A sample time too long for filters (band-stop at 9.3 rad/s) and observer is refused or said."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from takagi.certificates.controller import longest_sample
from takagi.certificates.controller.content import bound, gain_file_of
from takagi.certificates.design.plant.result import PlantDesign
from takagi.cli.main import main
from takagi.models import ModelError, TSModel, nrel5mw, sector_model
from takagi.models.plant.plant import Plant
from takagi.models.simulation import turbine_plant
from takagi.models.simulation.turbine_plant import validation_plant
from takagi.reports.code import targets
from takagi.reports.code.baseline import baseline_program
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import read_controller
from takagi.reports.code.run import ProgramRun
from takagi.reports.code.structured_text import block as block_file
from takagi.reports.code.targets import ExportSettings
from tests.plant_files import designed_in, filed_plant
from tests.reports.code.bladed import Simulator, built, edited, input_file
from tests.reports.code.compiled import STRICT, Compiled
from tests.reports.code.design_program import recorded_program
from tests.reports.code.structured_text import FunctionBlock

LONG = "SAMPLE_TIME_LONG"


@pytest.fixture(scope="module")
def program() -> ControllerProgram:
    return recorded_program()


def test_the_longest_is_by_what_the_program_has(program: ControllerProgram) -> None:
    """2 pi / (6 x 9.3) = 0.1126 s; without the filter half of the observer's 1 / l_1."""
    found = targets.longest_sample(program)
    assert found is not None and found.time == Decimal("0.11")
    assert found.reason == "the band-stop at 9.3 rad/s needs 6 samples a period"

    unfiltered = targets.longest_sample(recorded_program(without=["speed filter"]))
    gain = float(program.document["observer"]["l1"])
    assert unfiltered is not None and "observer" in unfiltered.reason
    assert 0.9 * 0.5 / gain < float(unfiltered.time) <= 0.5 / gain

    assert targets.longest_sample(recorded_program(without=["speed filter", "observer"])) is None


def test_the_longest_of_the_baseline_is_by_its_low_pass() -> None:
    """1 / (2 x 1.570796) = 0.318 s: its Euler step is unstable from 2 / c on."""
    found = targets.longest_sample(baseline_program(nrel5mw()))

    assert found is not None and found.time == Decimal("0.31")
    assert (
        found.reason == "its low-pass at 1.5708 rad/s takes steps of at most half its time constant"
    )
    with pytest.raises(ModelError, match=r"0\.4 s was given; at most 0\.31 s is needed"):
        targets.start_sample_time(baseline_program(nrel5mw()), 0.4)


def test_a_time_to_start_with(program: ControllerProgram) -> None:
    assert targets.start_sample_time(program, None) == Decimal("0.01")
    assert targets.start_sample_time(program, 0.11) == Decimal("0.11")
    with pytest.raises(
        ModelError, match=r"0\.112 s was given; at most 0\.11 s is needed, since the"
    ):
        targets.start_sample_time(program, 0.112)


@pytest.mark.parametrize("target", [one.word for one in targets.TARGETS if one.word != "csv"])
def test_every_target_refuses_it(target: str, program: ControllerProgram) -> None:
    settings = ExportSettings(sample_time=0.5)
    with pytest.raises(ModelError, match=r"0\.5 s was given; at most 0\.11 s is needed"):
        targets.exported(target, program, settings)


def test_c_says_it_at_every_step(program: ControllerProgram, tmp_path: Path) -> None:
    """The time is used all the same: another one would be wrong."""
    law = Compiled(program, tmp_path, flags=("-O1", *STRICT))
    bit = law.c.status_bits[LONG]
    reading = {"measured_speed": 1.2, "pitch": 0.0, "wind_guess": 9.0}

    assert law.init(0.11) == 0 and law.step(reading) and not law.bit(LONG)
    assert law.init(0.5) == bit and law.step(reading) and law.bit(LONG)
    assert law.state.sample_time == 0.5
    assert law.message(bit).startswith("the sample time is longer than 0.11 s: the band-stop")
    assert law.set_sample_time(0.02) == 0 and law.step(reading) and not law.bit(LONG)
    assert law.set_sample_time(0.2) == bit
    assert law.set_sample_time(-1.0) == law.c.status_bits["SAMPLE_TIME_REFUSED"]


def test_a_bladed_simulation_does_not_begin(program: ControllerProgram, tmp_path: Path) -> None:
    library = built(program, tmp_path / "library")
    file = input_file(library)

    refused = Simulator(library, file, "slow", step=0.5).call(0, 0.0)
    assert refused.fail == -1
    assert "a sample every 0.5 s: the sample time is longer than 0.11 s" in refused.message
    assert "set a shorter sample_time or step of the simulator" in refused.message
    other = edited(file, tmp_path / "OTHER.IN", sample_time=0.2)
    assert Simulator(library, other, "asked", step=0.02).call(0, 0.0).fail == -1

    run = Simulator(library, file, "grows", step=0.02)
    run.pitch(0.1)
    assert run.call(0, 0.0).fail == 0 and run.call(1, 0.02).fail == 0
    run.records({3: 0.2})
    told = run.call(1, 0.22)
    assert told.fail == 1 and "the sample time is longer than 0.11 s" in told.message


def test_the_function_block_says_it(program: ControllerProgram) -> None:
    text = block_file.function_block(program, ExportSettings())
    assert "128  the sample time is longer than 0.11 s: the band-stop" in text
    block = FunctionBlock(text)
    reading = {"measured_speed": 1.2, "pitch": 0.0, "wind_guess": 9.0}
    for time, status in ((0.11, 0), (0.12, 128), (0.5, 128)):
        found = block.call(sample_time=time, **reading)
        assert int(found["STATUS"]) & 128 == status


@pytest.mark.slow
@pytest.mark.parametrize(("time", "swings"), [(0.1, False), (0.3, True), (0.5, True)])
def test_why_it_is_refused(program: ControllerProgram, time: float, swings: bool) -> None:
    """Torque at a steady 8 m/s on the validation plant, which does not filter the speed itself."""
    plant, wind, step = validation_plant(nrel5mw()), 8.0, 0.01
    state, at = plant.initial_state(wind)
    law, inner = ProgramRun(program), round(time / 0.01)
    place, before, sent = plant.index("generator speed"), np.array([at.torque, at.pitch]), []
    assert place is not None
    for _ in range(round(100 / time)):
        reading = {"measured_speed": state[place], "pitch": state[1], "wind_guess": wind}
        given = law.sample(time, {name: float(value) for name, value in reading.items()})
        now = np.array([given["torque_sent"], given["pitch_sent"]])
        winds = np.full(2 * inner + 1, wind)
        state = turbine_plant.advance(plant, state, np.concatenate([before, now]), 0, winds, step)
        before = now
        sent.append(given["torque_sent"])
    deviation = float(np.std(sent[len(sent) // 2 :]))
    assert math.isfinite(deviation)
    assert deviation > 1000 if swings else deviation < 10


# ------------------------------------------------------------------ plants

TANKS = """
format = 1
kind = "plant"
name = "Two tanks"
units = "unchecked"
measured = ["h2"]
[parameters]
c = { value = 0.1, unit = "m^2" }
[states]
h1 = { unit = "m", range = [0.5, 1.5], rest = 1 }
h2 = { unit = "m", range = [0.5, 1.5], rest = 1 }
[inputs]
q = { unit = "m^3/s", range = [0, 0.3], rest = 0.1 }
[equations]
h1 = "q - c*sqrt(h1)"
h2 = "c*sqrt(h1) - c*sqrt(h2)"
"""
LINEAR = """
format = 1
kind = "plant"
name = "one state"
units = "unchecked"
[states]
x = { range = [-1, 1] }
[inputs]
u = { }
[equations]
x = "x + u"
[outputs]
y = { expression = "x" }
"""


def linear_plant(folder: Path) -> tuple[Plant, TSModel]:
    plant = filed_plant(folder, LINEAR)
    return plant, sector_model(plant)


def test_the_longest_of_a_plant_halves_the_decay(tmp_path: Path) -> None:
    """x' = x + u, u = -2 x: 2 - e^T from sample to sample, e^-T in continuous time."""
    plant, model = linear_plant(tmp_path)
    right = brentq(lambda T: math.exp(T) - 2 - math.exp(-T / 2), 0.1, 2)

    found = longest_sample.longest_of_plant(plant, model, {"K": [[[2.0]]]})

    assert found is not None and float(found.time) == pytest.approx(right - 0.005, abs=0.0051)
    proved = longest_sample.longest_of_plant(plant, model, {"K": [[[2.0]]]}, 1.5)
    assert proved is not None and proved.time == Decimal("1.5") and "proved" in proved.reason
    assert longest_sample.longest_of_plant(plant, model, {"K": [[[0.5]]]}) is None


def test_the_longest_with_an_observer_is_shorter(tmp_path: Path) -> None:
    """Its Euler step of the error is 1 - 50 T: no T above 2/50 can do."""
    plant, model = linear_plant(tmp_path)
    observer = {"measured": ["y"], "L": [[[51.0]]]}
    law = {"K": [[[2.0]]], "observer": observer}

    found = longest_sample.longest_of_plant(plant, model, law)

    assert found is not None and 0.02 < float(found.time) < 0.04


@pytest.fixture(scope="module")
def tanks(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, PlantDesign]:
    folder = tmp_path_factory.mktemp("tanks")
    return folder, designed_in(folder, TANKS)


def test_a_plant_s_file_states_it_and_exports_refuse_more(
    tanks: tuple[Path, PlantDesign], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder, _ = tanks
    gains = folder / "gains.json"
    stated = json.loads(gains.read_text("utf-8"))["sampling"]["longest"]
    program = read_controller(gains)
    for one in targets.TARGETS:
        if one.word not in ("csv", "discon"):
            with pytest.raises(ModelError, match=f"at most {stated} s is needed"):
                targets.exported(one.word, program, ExportSettings(sample_time=1.01 * stated))
    law = Compiled(program, tmp_path, flags=("-O1", *STRICT))
    assert law.init(stated) == 0 and law.init(2 * stated) == law.c.status_bits[LONG]
    asked = ["simulate", str(folder / "plant.toml"), "--gains", str(gains)]
    assert main([*asked, "--sample-time", str(3 * stated), "--start", "h1=1.4,h2=0.6"]) == 0
    said = capsys.readouterr().out
    assert f"the longest sample time of the law, {stated:g} s" in " ".join(said.split())


@pytest.mark.parametrize("level", [-0.5, 0.0, 0.6, 3.0])
def test_estimates_stay_where_the_premises_have_values(
    level: float, tanks: tuple[Path, PlantDesign]
) -> None:
    run = ProgramRun(read_controller(tanks[0] / "gains.json"))
    for _ in range(40):
        sent = run.sample(60.0, {"h2_measured": level})
        assert 0 <= sent["q"] <= 0.3
        assert all(0.5 <= value <= 1.5 for value in run.kept.values())


@pytest.mark.parametrize("stated", ["soon", {"longest": 0}, {"longest": "1"}, [1]])
def test_a_damaged_longest_is_refused(stated: Any, tanks: tuple[Path, PlantDesign]) -> None:
    content = json.loads((tanks[0] / "gains.json").read_text("utf-8"), parse_int=Decimal)
    program = replace(read_controller(tanks[0] / "gains.json"), document=content)
    content["sampling"] = stated
    with pytest.raises(ModelError, match=r"sampling\.longest"):
        targets.longest_sample(program)


def test_a_file_from_before_is_compared_as_it_was(tanks: tuple[Path, PlantDesign]) -> None:
    """Without ``sampling`` its program holds no estimate: so did those that exist."""
    document = tanks[1].document
    own = {key: value for key, value in document["controller"].items() if key != "sampling"}

    old = gain_file_of(bound(document, own))

    kept = [one["next"] for one in old["programs"][0]["keep"]]
    assert "sampling" not in old and not any(one.startswith("limit(") for one in kept)
