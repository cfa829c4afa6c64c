"""Set-points of speed and power as inputs of exported code, of a recorded NREL 5-MW design."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from takagi.certificates import law_from_gains
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.laws.protocol import Measurement, sampled
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.run import ProgramRun
from takagi.reports.code.structured_text.block import function_block
from takagi.reports.code.targets import ExportSettings, exported
from tests.reports.code.bladed import GEAR_RATIO, Simulator, built, edited, input_file
from tests.reports.code.compiled import STRICT, Compiled
from tests.reports.code.design_program import recorded_file, recorded_program
from tests.reports.code.fmu_files import exported as exported_fmu
from tests.reports.code.fmu_files import simulated
from tests.reports.code.structured_text import FunctionBlock
from tests.reports.code.test_matlab import octave

T, RATED, RATED_POWER = 0.02, 1.267109037, 5e6
LOWEST, LOWEST_POWER = 1.05, 0.944 * 97 * 1.05 * 38784.195
# Rated, inside the range, and beyond each of its ends.
SETPOINTS = (
    (RATED, RATED_POWER),
    (1.1, 4.2e6),
    (RATED, 3.9e6),
    (0.7, 9e6),
    (2.0, 1e6),
    (1.15, math.pi * 1.5e6),
)
Given = dict[str, float]


@pytest.fixture(scope="module")
def program() -> ControllerProgram:
    return recorded_program(setpoints=True)


def waves(samples: int) -> Iterator[tuple[float, float, float, float, float]]:
    for k in range(samples):
        t = T * k
        speed, power = SETPOINTS[k * len(SETPOINTS) // samples]
        wave = 1.15 + 0.15 * math.sin(0.7 * t)
        yield wave, 0.05 + 0.05 * math.sin(t), 12 + 6 * math.sin(0.4 * t), speed, power


def rows(program: ControllerProgram, samples: int) -> Iterator[Given]:
    for speed, pitch, wind, slowest, power in waves(samples):
        inputs_of_sample = {"measured_speed": speed, "pitch": pitch, "wind_guess": wind}
        yield inputs_of_sample | {"speed_setpoint": slowest, "power_setpoint": power}


@pytest.mark.parametrize("precision", ["double", "float"])
def test_commands_of_c_are_those_of_the_law_in_python(precision: str, tmp_path: Path) -> None:
    """The program reads set-points at every sample; in Python each pair makes a law of its own."""
    path = tmp_path / "gains.json"
    path.write_text(recorded_file(setpoints=True), encoding="utf-8")
    law = law_from_gains(path)
    assert isinstance(law, EffortSharingLaw)
    without = ("speed filter", "observer", "rate limits")
    compiled = Compiled(
        recorded_program(without=without, setpoints=True), tmp_path,
        precision="float" if precision == "float" else "double", flags=STRICT,
    )  # fmt: skip
    within, state, outside = 1e-12 if precision == "double" else 2e-4, None, set()
    compiled.init(T)
    for speed, pitch, wind, slowest, power in waves(1200):
        state = law.initial_state(wind) if state is None else state
        asked = law.at_setpoints(speed=slowest, power=power)
        expected, state = sampled(asked, state, Measurement(speed, pitch, wind), T)
        sent = compiled.step({"speed": speed, "wind_estimate": wind,
                              "speed_setpoint": slowest, "power_setpoint": power})  # fmt: skip
        assert sent["torque"] == pytest.approx(expected.torque, abs=within * law.rated_torque)
        assert sent["pitch_reference"] == pytest.approx(expected.pitch, abs=within)
        outside.add((slowest, power, compiled.bit("INPUT_OUTSIDE")))
    assert [told for *_, told in sorted(outside)] == [
        not (LOWEST <= slowest <= RATED and power <= RATED_POWER)
        for slowest, power in sorted(SETPOINTS)
    ]


def test_at_rated_set_points_it_is_the_law_without(program: ControllerProgram) -> None:
    rest = {s.name: float(s.rest or 0) for s in program.inputs if s.optional}
    assert rest == pytest.approx({"speed_setpoint": RATED, "power_setpoint": RATED_POWER}, 1e-6)
    ours, theirs = ProgramRun(program), ProgramRun(recorded_program())
    for inputs_of_sample in rows(program, 100):
        without = {name: value for name, value in inputs_of_sample.items() if name not in rest}
        assert ours.sample(T, inputs_of_sample | rest) == theirs.sample(T, without)


def test_an_fmu_starts_at_rated_set_points(tmp_path: Path) -> None:
    gains = tmp_path / "gains.json"
    gains.write_text(recorded_file(setpoints=True), encoding="utf-8")
    program, made = exported_fmu(gains, sample_time=T)
    series = list(rows(program, 60))
    run, rated = ProgramRun(program), ProgramRun(recorded_program())
    connected = [run.sample(T, inputs_of_sample)["torque_sent"] for inputs_of_sample in series]
    names = [name for name in series[0] if not name.endswith("_setpoint")]
    free = [
        rated.sample(T, {n: inputs_of_sample[n] for n in names})["torque_sent"]
        for inputs_of_sample in series
    ]
    assert connected != free
    times = T * np.arange(61)
    for file in made.files:
        for expected, inputs_of_sample in ((connected, list(series[0])), (free, names)):
            inputs = {
                name: [row[name] for row in (*series, series[-1])] for name in inputs_of_sample
            }
            found = simulated(tmp_path / file, times, inputs)["torque_sent"]
            np.testing.assert_allclose(found[1:], expected, rtol=1e-9)
        with zipfile.ZipFile(tmp_path / file) as archive:
            described = archive.read("modelDescription.xml").decode()
        (line,) = (x for x in described.splitlines() if 'name="power_setpoint"' in x)
        assert f"[{LOWEST_POWER:.0f}"[:6] in line and 'causality="input"' in line


def test_a_function_block_starts_at_rated_set_points(program: ControllerProgram) -> None:
    for named in (True, False):
        block = FunctionBlock(function_block(program, ExportSettings()))
        run = ProgramRun(program if named else recorded_program())
        for inputs_of_sample in rows(program, 60):
            if not named:
                del inputs_of_sample["speed_setpoint"], inputs_of_sample["power_setpoint"]
            sent, expected = (
                block.call(sample_time=T, **inputs_of_sample),
                run.sample(T, inputs_of_sample),
            )
            assert sent["TORQUE_SENT"] == pytest.approx(expected["torque_sent"], rel=1e-12)
            assert sent["PITCH_SENT"] == pytest.approx(expected["pitch_sent"], abs=1e-12)


def test_a_function_of_matlab_reads_them(program: ControllerProgram, tmp_path: Path) -> None:
    run, series = ProgramRun(program), list(rows(program, 60))
    found = octave(program, series, T, tmp_path)
    for sent, inputs_of_sample in zip(found, series, strict=True):
        expected = list(run.sample(T, inputs_of_sample).values())
        assert sent[:-1] == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("to", ["c", "mat", "st"])
def test_unit_and_range_stand_in_the_page(to: str, program: ControllerProgram) -> None:
    page = str(exported(to, program, ExportSettings()).files["README.md"])
    for name, unit, least in (("speed_setpoint", "rad/s", "1.05"), ("power_setpoint", "W", "3728")):
        (row,) = (x for x in page.splitlines() if x.startswith("| `") and f"{name}`" in x)
        assert f" {unit} |" in row and least in row and " to " in row


# ------------------------------------------------------------------ the Bladed-style library


@pytest.fixture(scope="module")
def library(program: ControllerProgram, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(program, tmp_path_factory.mktemp("discon"))


def powers(library: Path, file: Path, records: list[float]) -> tuple[list[float], list[str]]:
    """Return torque and pitch of each call, one after the other, and the messages that came."""
    run = Simulator(library, file, str(file), T)
    run.records({20: 1.3 * GEAR_RATIO, 27: 15.0, 23: 4.3e4})
    run.pitch(0.2)
    assert run.call(0, 0.0)[2:] == (0, "")
    sent: list[float] = []
    told: list[str] = []
    for k, record in enumerate(records):
        run.records({13: record})
        answer = run.call(1, T * (k + 1))
        sent += answer[:2]
        if answer.fail:
            told.append(answer.message)
    assert run.call(-1, T * len(records)).fail == 0
    return sent, told


def test_the_input_file_has_the_set_points(
    library: Path, program: ControllerProgram, tmp_path: Path
) -> None:
    plain = built(recorded_program(), tmp_path / "plain")
    as_written = powers(library, input_file(library), [0.0] * 60)
    assert as_written == powers(plain, input_file(plain), [0.0] * 60)
    file = edited(input_file(library), tmp_path / "i", speed_setpoint=1.1,
                  power_setpoint="4.2e6")  # fmt: skip
    sent, told = powers(library, file, [0.0] * 60)
    run, step = ProgramRun(program), float(np.float32(T))
    inputs_of_sample = {"measured_speed": float(np.float32(1.3 * GEAR_RATIO)) / GEAR_RATIO,
             "pitch": float(np.float32(0.2)), "wind_guess": 15.0,
             "speed_setpoint": 1.1, "power_setpoint": 4.2e6}  # fmt: skip
    expected = [run.sample(step, inputs_of_sample) for _ in sent[::2]]
    assert not told
    assert sent[::2] == pytest.approx([row["torque_sent"] for row in expected], rel=1e-6)
    assert sent[1::2] == pytest.approx([row["pitch_sent"] for row in expected], rel=1e-6)


def test_record_13_is_the_power_and_the_last_one_holds(library: Path, tmp_path: Path) -> None:
    """Zero, negative and not finite are no power: at first the rated one is there."""
    file = edited(input_file(library), tmp_path / "a", power_setpoint="record13")
    rated = powers(library, input_file(library), [0.0] * 100)[0]
    none, told = powers(library, file, [0.0, math.nan, -4e6, math.inf] * 25)
    assert none == rated
    assert len(told) == 1 and "record 13 is no power" in told[0]
    lower = edited(input_file(library), tmp_path / "b", power_setpoint=4.75e6)
    number, silent = powers(library, lower, [0.0] * 100)
    record, told = powers(library, file, [4.75e6] * 50 + [0.0] * 50)
    assert record == number != rated and not silent
    assert len(told) == 1 and "4.75e+06 W holds" in told[0]


def test_a_power_beyond_the_range_is_limited_and_told_once(library: Path, tmp_path: Path) -> None:
    file = edited(input_file(library), tmp_path / "a", power_setpoint="record13")
    least = edited(input_file(library), tmp_path / "b", power_setpoint=LOWEST_POWER)
    expected, _ = powers(library, least, [0.0] * 50)
    sent, told = powers(library, file, [1e6] * 50)
    assert sent == pytest.approx(expected, rel=1e-6)
    assert len(told) == 1 and "outside the range" in told[0] and "power 1e+06 W" in told[0]


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("speed_setpoint", "1.0", "a number from 1.05 to 1.26711"),
        ("speed_setpoint", "record13", "a number from"),
        ("power_setpoint", "6e6", "a number from 3.72895e+06 to 5.00001e+06"),
        ("power_setpoint", "record14", "a number from"),
    ],
)
def test_other_set_points_are_refused(
    key: str, value: str, words: str, library: Path, tmp_path: Path
) -> None:
    file = edited(input_file(library), tmp_path / "i", **{key: value})
    answer = Simulator(library, file, f"{key} {value}").call(0, 0.0)
    assert answer.fail == -1 and words in answer.message and key in answer.message
