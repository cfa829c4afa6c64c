"""The Bladed-style library sends what the law in Python sends, fed with the same records."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from takagi.certificates import TurbineDesign
from takagi.models.laws.protocol import SampledLaw
from takagi.models.simulation.closed_loop import simulate
from takagi.models.simulation.turbine_plant import validation_plant
from takagi.models.simulation.wind import WindSeries
from takagi.reports.code.baseline import baseline_program
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import controller_program
from takagi.reports.code.run import ProgramRun
from tests.reports.code.bladed import GEAR_RATIO, PythonLaw, Simulator, built, edited, input_file
from tests.reports.code.design_program import program_of

EXACT = 1e-6
T = 0.02


@pytest.fixture(scope="module")
def program(turbine_design: TurbineDesign) -> ControllerProgram:
    return program_of(turbine_design)


@pytest.fixture(scope="module")
def library(program: ControllerProgram, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(program, tmp_path_factory.mktemp("discon"))


Row = tuple[float, float, float, float]


@pytest.fixture(scope="module")
def rows(turbine_design: TurbineDesign) -> list[Row]:
    """Time, rotor speed, pitch and wind of a run over wind steps, as float32 holds them."""
    design = turbine_design
    steps = [8.0, 11.0, 13.0, 18.0, 24.0, 12.0, 9.0]
    time = np.array([t for k in range(len(steps)) for t in (10.0 * k, 10.0 * k + 9.999)])
    wind = WindSeries(time, np.repeat(steps, 2), "steps")
    limits = design.turbine.torque_rate_limit, design.turbine.pitch_rate_limit
    plant = validation_plant(design.turbine, torsion=True)
    law = SampledLaw(design.law, T, 0.0, *limits)
    wind = WindSeries(wind.time, wind.speed, wind.name)
    found = simulate(plant, law, _whole(wind), observer=design.observer.observer)
    series = zip(found.time, found.generator_speed, found.pitch, found.wind, strict=True)
    return [tuple(float(np.float32(one)) for one in row) for row in series]  # type: ignore[misc]


def _whole(wind: WindSeries) -> WindSeries:
    """Return the wind over a whole number of samples."""
    return WindSeries(np.append(wind.time[:-1], 70.0), wind.speed, wind.name)


def sent(library: Path, file: Path, rows: list[Row]) -> Iterator[tuple[float, float]]:
    """Yield torque and pitch demand for each row; first and last call around them."""
    run = Simulator(library, file, step=T)
    run.pitch(rows[0][2])
    assert run.call(0, 0.0)[2:] == (0, "")
    for time, speed, pitch, wind in rows:
        run.records({20: speed * GEAR_RATIO, 21: speed, 27: wind})
        run.pitch(pitch)
        answer = run.call(1, time)
        assert answer.fail == 0, answer.message
        yield answer.torque, answer.pitch
    assert run.call(-1, rows[-1][0]).fail == 0


def seen_speed(speed: float) -> float:
    """Return the rotor speed that the library reads from record 20."""
    return float(np.float32(speed * GEAR_RATIO)) / GEAR_RATIO


def test_a_run_of_wind_steps(library: Path, rows: list[Row], turbine_design: TurbineDesign) -> None:
    law, top = PythonLaw(turbine_design, T), turbine_design.turbine.rated_torque
    pitches = []
    for row, (torque, pitch) in zip(rows, sent(library, input_file(library), rows), strict=True):
        wanted = law.sample(seen_speed(row[1]), row[2], row[3])
        assert torque == pytest.approx(wanted.torque, abs=EXACT * top)
        assert pitch == pytest.approx(wanted.pitch, abs=EXACT)
        pitches.append(pitch)
    assert max(pitches) > 0.2 and min(pitches) == 0


def test_the_log_says_where_the_estimate_is_held(library: Path, tmp_path: Path) -> None:
    """A rotor that stops: behind the filter its tip-speed ratio falls below the table's.

    It is no message: in a gust above 25 m/s the estimate is held as well, beyond the law's tables.
    """
    log = tmp_path / "log.csv"
    run = Simulator(library, edited(input_file(library), tmp_path / "i", log_file=log),
                    "held", T)  # fmt: skip
    run.pitch(0.1)
    run.records({20: 1.2 * GEAR_RATIO, 21: 1.2, 27: 12.0})
    told = [run.call(0, 0.0).message, *(run.call(1, k * T).message for k in range(1, 6))]
    run.records({20: 0.0, 21: 0.0})
    told += [run.call(1, k * T).message for k in range(6, 600)]
    run.call(-1, 600 * T)
    assert not any(told)
    rows = log.read_text(encoding="utf-8").splitlines()[1:]
    held = [int(row.split(",")[-1]) & 64 != 0 for row in rows]
    assert not any(held[:10]) and all(held[300:])


def test_the_wind_of_record_27(
    library: Path, program: ControllerProgram, rows: list[Row], tmp_path: Path
) -> None:
    file = edited(input_file(library), tmp_path / "i", wind_source="record27",
                  speed_source="record21")  # fmt: skip
    run = ProgramRun(controller_program(program.document, without=["observer"]))
    for row, (torque, pitch) in zip(rows, sent(library, file, rows), strict=True):
        step = float(np.float32(T))
        given = {"measured_speed": row[1], "pitch": row[2], "wind_estimate": row[3]}
        wanted = run.sample(step, {s.name: given[s.name] for s in run.program.inputs})
        assert torque == pytest.approx(wanted["torque_sent"], rel=EXACT)
        assert pitch == pytest.approx(wanted["pitch_sent"], abs=EXACT)


@pytest.mark.parametrize("drive", ["first_order", "second_order"])
def test_filter_sample_time_and_drive(
    drive: str, library: Path, rows: list[Row], turbine_design: TurbineDesign, tmp_path: Path
) -> None:
    """The law every third step, of a filtered speed, before a drive at its rate limit."""
    file = edited(
        input_file(library), tmp_path / "i", speed_filter=1.5, sample_time=3 * T,
        pitch_drive=drive, pitch_drive_rate=0.05,
    )  # fmt: skip
    step = float(np.float32(T))
    law, top = PythonLaw(turbine_design, 3 * step), turbine_design.turbine.rated_torque
    low = seen_speed(rows[0][1])
    blade, rate, most = rows[0][2], 0.0, 0.0
    for k, (row, (torque, pitch)) in enumerate(zip(rows, sent(library, file, rows), strict=True)):
        low += (seen_speed(row[1]) - low) * (1 - math.exp(-1.5 * step)) if k else 0.0
        if k % 3 == 0:
            wanted = law.sample(low, row[2], row[3])
        blade, rate = moved(drive, blade, rate, wanted.pitch, step)
        assert torque == pytest.approx(wanted.torque, abs=EXACT * top)
        assert pitch == pytest.approx(blade, abs=EXACT)
        most = max(most, rate)
    assert most == 0.05


def moved(drive: str, x: float, r: float, asked: float, h: float) -> tuple[float, float]:
    """Return pitch and rate of the drive after a step: tau 0.2 s, or 2 pi rad/s with 0.7."""
    if drive == "first_order":
        r = (asked - x) * (1 - math.exp(-h / 0.2)) / h
        r = min(max(r, -0.05), 0.05)
        return max(x + h * r, 0.0), r
    w, z = 6.283185307, 0.7
    # The trapezoidal rule for x' = r, r' = w^2 (asked - x) - 2 z w r, as a system of equations.
    A = np.array([[1, -h / 2], [w * w * h / 2, 1 + z * w * h]])
    b = np.array([x + h / 2 * r, r + h * (w * w * (asked - x / 2) - z * w * r)])
    new = float(np.linalg.solve(A, b)[1])
    new = min(max(new, -0.05), 0.05)
    return max(x + h / 2 * (r + new), 0.0), new


def test_the_baseline_law(turbine_design: TurbineDesign, rows: list[Row], tmp_path: Path) -> None:
    program = baseline_program(turbine_design.turbine)
    library = built(program, tmp_path)
    run, step = ProgramRun(program), float(np.float32(T))
    for row, (torque, pitch) in zip(
        rows[:600], sent(library, input_file(library), rows[:600]), strict=True
    ):
        wanted = run.sample(step, {"speed": seen_speed(row[1]), "pitch": row[2]})
        assert torque == pytest.approx(wanted["torque_sent"], rel=EXACT)
        assert pitch == pytest.approx(wanted["pitch_sent"], abs=EXACT)


def test_a_checkpoint_goes_on_where_it_was(library: Path, rows: list[Row], tmp_path: Path) -> None:
    """Bit by bit, read by a copy of the library that saw no first call."""
    file = edited(
        input_file(library), tmp_path / "i", pitch_drive="second_order",
        speed_filter=2.0, sample_time=2 * T, log_file=tmp_path / "log.csv",
    )  # fmt: skip
    whole = list(sent(library, file, rows[:1500]))
    copy, stored = tmp_path / "copy.so", str(tmp_path / "kept.dll.chkp").encode()
    copy.write_bytes(library.read_bytes())
    run = Simulator(library, file, step=T)
    for k, (time, speed, pitch, wind) in enumerate(rows[:1500]):
        if k == 0:
            run.pitch(pitch)
            run.call(0, 0.0)
        if k == 701:
            assert run.call(-8, rows[k - 1][0], stored)[2:] == (0, "")
            swap = run.swap
            run = Simulator(copy, tmp_path / "no file", step=T)
            run.swap = swap
            assert run.call(-9, rows[k - 1][0], stored)[2:] == (0, "")
        run.records({20: speed * GEAR_RATIO, 21: speed, 27: wind})
        run.pitch(pitch)
        answer = run.call(1, time)
        assert (answer.torque, answer.pitch) == whole[k]
    assert len((tmp_path / "log.csv").read_text().splitlines()) > 700
