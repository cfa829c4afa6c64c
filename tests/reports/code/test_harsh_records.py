"""One law in all its forms, fed with the same records of a machine in trouble."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest

from takagi.certificates import TurbineDesign
from takagi.models import Floats
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.trim import trim
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.run import ProgramRun
from tests.reports.code.bladed import GEAR_RATIO, Simulator, built, input_file
from tests.reports.code.compiled import Compiled
from tests.reports.code.design_program import program_of
from tests.reports.code.fmu_files import exported, fmpy, simulated
from tests.reports.python_law import PythonLaw
from tests.reports.test_gain_file_alone import turbine_file

T, SAMPLES = 0.02, 1000
# Of rated torque, and rad: sums in another order, over twenty seconds.
ROUNDING = 1e-9


class Record(NamedTuple):
    """What is read at each sample: rotor speed [rad/s], pitch [rad], and the wind guess [m/s]."""

    speed: Floats
    pitch: Floats
    guess: float


def swaying(turbine: Turbine, wind: float) -> Record:
    """Around the trim at a wind, or at the end of the table: speed sways by 3 %, pitch by 1 deg."""
    time = T * np.arange(SAMPLES)
    at = trim(turbine, min(max(wind, turbine.cut_in), turbine.cut_out))
    speed = at.rotor_speed * (1 + 0.03 * np.sin(0.4 * time))
    pitch = np.maximum(at.pitch + 0.0175 * np.sin(0.7 * time), turbine.pitch_min)
    return Record(speed, pitch, wind)


def at_wind(wind: float) -> Callable[[Turbine], Record]:
    return lambda turbine: swaying(turbine, wind)


def stuck_speed(turbine: Turbine) -> Record:
    """The sensor shows 3 % above rated for ever."""
    record = swaying(turbine, 14.0)
    return record._replace(speed=np.full(SAMPLES, 1.03 * turbine.rated_rotor_speed))


def stuck_pitch(turbine: Turbine) -> Record:
    return swaying(turbine, 16.0)._replace(pitch=np.full(SAMPLES, 0.05))


def hair_below(turbine: Turbine) -> Record:
    """Pitch at its lower stop, where a sensor shows a little less, and sometimes almost nothing."""
    record = swaying(turbine, 8.0)
    pitch = np.full(SAMPLES, turbine.pitch_min - 1e-7)
    pitch[::3] = turbine.pitch_min - 1.4e-45
    return record._replace(pitch=pitch)


def standstill(turbine: Turbine) -> Record:
    """Six seconds at rest, then to rated speed; pitch from 80 degrees to its lower stop."""
    time = T * np.arange(SAMPLES)
    share = np.clip((time - 6) / 12, 0, 1)
    return Record(turbine.rated_rotor_speed * share, 1.4 * (1 - share), 6.0)


def stalled(turbine: Turbine) -> Record:
    """A fifth of rated speed, where the tip-speed ratio is below the table of c_Q."""
    return Record(np.full(SAMPLES, 0.2 * turbine.rated_rotor_speed), np.zeros(SAMPLES), 20.0)


RECORDS: dict[str, Callable[[Turbine], Record]] = {
    **{f"{wind:g} m/s": at_wind(wind) for wind in (2.0, 3.0, 11.4, 25.0, 30.0)},
    "stuck speed": stuck_speed,
    "stuck pitch": stuck_pitch,
    "pitch a hair below": hair_below,
    "standstill": standstill,
    "stalled": stalled,
}


def as_read(record: Record) -> Record:
    """Return the numbers that single precision carries to the Bladed-style library."""
    speed = np.float32(record.speed * GEAR_RATIO).astype(float) / GEAR_RATIO
    return Record(speed, np.float32(record.pitch).astype(float), float(np.float32(record.guess)))


@pytest.fixture(scope="module")
def program(turbine_design: TurbineDesign) -> ControllerProgram:
    return program_of(turbine_design)


@pytest.fixture(scope="module")
def law(program: ControllerProgram, tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    return Compiled(program, tmp_path_factory.mktemp("c"))


@pytest.fixture(scope="module")
def library(program: ControllerProgram, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(program, tmp_path_factory.mktemp("discon"))


@pytest.fixture(scope="module")
def units(turbine_design: TurbineDesign, tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    folder = tmp_path_factory.mktemp("fmu")
    made = exported(turbine_file(turbine_design, turbine_design.law, folder), sample_time=T)[1]
    return [folder / name for name in made.files]


def inputs(record: Record, k: int) -> dict[str, float]:
    return {
        "measured_speed": float(record.speed[k]),
        "pitch": float(record.pitch[k]),
        "wind_guess": record.guess,
    }


def by_program(program: ControllerProgram, record: Record) -> Floats:
    run = ProgramRun(program)
    sent = (run.sample(T, inputs(record, k)) for k in range(len(record.speed)))
    return np.array([(one["torque_sent"], one["pitch_sent"]) for one in sent])


def by_c(law: Compiled, record: Record) -> Floats:
    assert law.init(T) == 0
    sent = (law.step(inputs(record, k)) for k in range(len(record.speed)))
    return np.array([(one["torque_sent"], one["pitch_sent"]) for one in sent])


def by_library(library: Path, record: Record) -> Iterator[tuple[float, float]]:
    run = Simulator(library, input_file(library), step=T)
    run.records({27: record.guess})
    run.pitch(float(record.pitch[0]))
    assert run.call(0, 0.0).fail == 0
    for k in range(len(record.speed)):
        run.records({20: float(record.speed[k]) * GEAR_RATIO, 21: float(record.speed[k])})
        run.pitch(float(record.pitch[k]))
        answer = run.call(1, k * T)
        assert answer.fail >= 0, answer.message
        yield answer.torque, answer.pitch
    assert run.call(-1, len(record.speed) * T).fail == 0


def by_unit(file: Path, record: Record) -> Floats:
    table = {name: [inputs(record, k)[name] for k in range(SAMPLES)] for name in inputs(record, 0)}
    for values in table.values():
        values.append(values[-1])
    found = simulated(file, T * np.arange(SAMPLES + 1), table)
    return np.array([found["torque_sent"][1:], found["pitch_sent"][1:]]).T


def agree(found: Floats, wanted: Floats, turbine: Turbine, within: float) -> None:
    """Compare torque over rated torque, and pitch in rad; both are finite and within the limits."""
    assert np.isfinite(found).all()
    assert found[:, 0].min() >= 0 and found[:, 0].max() <= turbine.rated_torque * (1 + 1e-6)
    assert found[:, 1].min() >= turbine.pitch_min - 1e-6
    assert found[:, 1].max() <= turbine.pitch_max + 1e-6
    assert np.abs(found - wanted)[:, 0].max() / turbine.rated_torque <= within
    assert np.abs(found - wanted)[:, 1].max() <= within


# What is ordinary operation is left to the slow tests.
ORDINARY = ("3 m/s", "11.4 m/s", "25 m/s", "stuck pitch")


@pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.slow) if n in ORDINARY else n for n in RECORDS],
)
def test_the_forms_agree(
    name: str,
    turbine_design: TurbineDesign,
    program: ControllerProgram,
    law: Compiled,
    library: Path,
) -> None:
    turbine = turbine_design.turbine
    record = as_read(RECORDS[name](turbine))
    wanted = by_program(program, record)

    agree(wanted, wanted, turbine, 0.0)
    agree(by_c(law, record), wanted, turbine, ROUNDING)
    # Its outputs are numbers of single precision.
    agree(np.array(list(by_library(library, record))), wanted, turbine, 1.2e-7)
    python = PythonLaw(turbine_design, T)
    commands = [
        python.sample(float(record.speed[k]), float(record.pitch[k]), record.guess)
        for k in range(SAMPLES)
    ]
    agree(np.array(commands), wanted, turbine, ROUNDING)


@pytest.mark.parametrize("name", ["30 m/s", "pitch a hair below", "standstill"])
def test_the_units_agree(
    name: str, turbine_design: TurbineDesign, program: ControllerProgram, units: list[Path]
) -> None:
    fmpy()
    record = as_read(RECORDS[name](turbine_design.turbine))
    wanted = by_program(program, record)

    for file in units:
        agree(by_unit(file, record), wanted, turbine_design.turbine, ROUNDING)


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_what_is_no_number_is_the_last_good_one(
    bad: float,
    turbine_design: TurbineDesign,
    program: ControllerProgram,
    law: Compiled,
    library: Path,
) -> None:
    """One reading, for a sample or five seconds; FMPy alone spreads it to samples beside."""
    turbine = turbine_design.turbine
    good = as_read(swaying(turbine, 14.0))
    given = Record(good.speed.copy(), good.pitch.copy(), good.guess)
    seen = Record(good.speed.copy(), good.pitch.copy(), good.guess)
    for begin, end in ((100, 101), (300, 550)):
        given.speed[begin:end] = bad
        seen.speed[begin:end] = good.speed[begin - 1]
    for begin, end in ((200, 201), (700, 950)):
        given.pitch[begin:end] = bad
        seen.pitch[begin:end] = good.pitch[begin - 1]
    wanted = by_program(program, seen)

    agree(by_c(law, given), wanted, turbine, ROUNDING)
    agree(np.array(list(by_library(library, given))), wanted, turbine, 1.2e-7)
