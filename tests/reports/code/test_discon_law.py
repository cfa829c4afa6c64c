"""The Bladed-style library sends what the law in Python sends, fed with the same records."""

from __future__ import annotations

import math
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from takagi.certificates import TurbineDesign
from takagi.models import ModelError
from takagi.models.laws.protocol import SampledLaw
from takagi.models.simulation.closed_loop import simulate
from takagi.models.simulation.turbine_plant import validation_plant
from takagi.models.simulation.wind import WindSeries
from takagi.models.turbine.loader import load_turbine
from takagi.reports.code.baseline import baseline_program
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.discon.library import export
from takagi.reports.code.program_reading import controller_program, read_controller
from takagi.reports.code.run import ProgramRun
from takagi.reports.code.targets import ExportSettings
from tests.reports.code.bladed import (
    GEAR_RATIO,
    Answer,
    Simulator,
    built,
    edited,
    input_file,
)
from tests.reports.code.design_program import program_of
from tests.reports.python_law import PythonLaw
from tests.reports.test_gain_file_alone import plant_file

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
    return WindSeries(np.append(wind.time[:-1], 70.0), wind.speed, wind.name)


def sent(library: Path, file: Path, rows: list[Row]) -> Iterator[tuple[float, float]]:
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
    """A rotor that stops has a tip-speed ratio below the table's; that is no message."""
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


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(baseline_program(load_turbine("nrel5mw")), tmp_path_factory.mktemp("discon"))


@pytest.fixture
def copied(made: Path, tmp_path: Path) -> Path:
    """A copy for each test: a library keeps the simulations that had no last call."""
    return Path(shutil.copy(made, tmp_path / "library.so"))


@pytest.fixture
def file(made: Path) -> Path:
    return input_file(made)


def started(copied: Path, file: Path, name: str, *, calls: int = 5) -> Simulator:
    run = Simulator(copied, file, name, T)
    run.pitch(0.1)
    assert run.call(0, 0.0).fail == 0
    for k in range(calls):
        assert run.call(1, T * (k + 1)).fail == 0
    return run


def sane(answer: Answer) -> bool:
    return 0 <= answer.torque <= 47402.92 and 0 <= answer.pitch <= math.pi / 2 + 1e-6


# ------------------------------------------------------------------ order and time


def test_the_first_call_sends_what_is_measured(copied: Path, file: Path) -> None:
    run = Simulator(copied, file, "first", T)
    run.records({23: 1.25e4})
    run.pitch(0.25)
    assert run.call(0, 0.0) == (1.25e4, 0.25, 0, "")
    assert run.call(-1, 0.0).fail == 0


@pytest.mark.parametrize("status", [1, -8, 7])
def test_no_first_call(status: int, copied: Path, file: Path) -> None:
    answer = Simulator(copied, file, f"none {status}").call(status, 0.0)
    assert answer.fail == -1 and sane(answer)
    assert answer.message == (
        f"nrel_5_mw: a call with status {status} came before the first call, status 0"
    )


def test_a_last_call_alone_is_nothing(copied: Path, file: Path) -> None:
    """A simulator makes it after a first call that failed."""
    answer = Simulator(copied, file, "last").call(-1, 0.0)
    assert answer.fail == 0 and answer.message == "" and sane(answer)


def test_after_the_last_call_there_is_none(copied: Path, file: Path) -> None:
    run = started(copied, file, "ended")
    assert run.call(-1, 5 * T).fail == 0
    assert run.call(1, 6 * T).fail == -1


def test_the_same_time_twice_moves_nothing(copied: Path, file: Path) -> None:
    """As in a corrector step; what is read then does not count."""
    run, other = started(copied, file, "one"), started(copied, file, "two")
    for k in range(6, 60):
        run.records({20: (1.2 + 0.002 * k) * GEAR_RATIO})
        first = run.call(1, T * k)
        speed = run.swap[19]
        for again in (T * k, T * k + 0.3 * T, T * k - 0.3 * T):
            run.records({20: 150.0})
            assert run.call(1, again) == first
        other.records({20: speed})
        assert other.call(1, T * k) == first


def test_time_that_goes_back_or_jumps_is_told_once(copied: Path, file: Path) -> None:
    run = started(copied, file, "times")
    before = run.call(1, 6 * T)
    back = run.call(1, 2 * T)
    assert back[:2] == before[:2] and back.fail == 1 and "back from 0.12 to 0.04 s" in back.message
    assert run.call(1, 1 * T).fail == 0
    assert run.call(1, 2 * T).fail == 0
    run.records({20: 1.4 * GEAR_RATIO})
    jump = run.call(1, 50.0)
    assert jump.fail == 1 and "it counts as one step" in jump.message
    assert abs(jump.torque - before.torque) <= 3 * 15000 * T
    assert run.call(1, 100.0).fail == 0


def test_a_time_of_too_few_digits(copied: Path, file: Path) -> None:
    """At 10^6 s float32 knows sixteenths of a second: every call counts."""
    run = started(copied, file, "long")
    run.call(1, 1e6)
    run.records({20: 1.35 * GEAR_RATIO})
    answers = [run.call(1, 1e6) for _ in range(40)]
    assert len({one.torque for one in answers} | {one.pitch for one in answers}) > 20


def test_another_step(copied: Path, file: Path) -> None:
    run = started(copied, file, "step")
    run.records({3: 0.01})
    told = run.call(1, 6 * T)
    assert told.fail == 1 and "the step, record 3, went from 0.02 to 0.01 s" in told.message
    torque = told.torque
    run.records({20: 0.8 * GEAR_RATIO})
    after = run.call(1, 6 * T + 0.01)
    assert after.fail == 0 and abs(after.torque - torque) <= 15000 * 0.01 * (1 + 1e-4)


@pytest.mark.parametrize("step", [0.0, -1.0, math.nan, math.inf])
def test_a_step_that_is_none(step: float, copied: Path, file: Path) -> None:
    run = Simulator(copied, file, "no step", step)
    told = run.call(0, 0.0)
    assert told.fail == 1 and "record 3 is no step; 0.01 s stands in" in told.message
    assert all(run.call(1, 0.01 * k).fail == 0 for k in range(1, 5))


def test_a_sample_time_that_is_no_multiple(copied: Path, file: Path, tmp_path: Path) -> None:
    run = Simulator(copied, edited(file, tmp_path / "i", sample_time=0.05), "multiple", T)
    told = run.call(0, 0.0)
    assert told.fail == -1
    assert "sample_time 0.05 s is not a multiple of the simulator's step 0.02 s" in told.message


def test_an_unknown_status_holds(copied: Path, file: Path) -> None:
    run = started(copied, file, "status")
    before = run.call(1, 6 * T)
    for status in (5, math.nan, 1e30):
        held = run.call(status, 7 * T)  # type: ignore[arg-type]
        assert held[:2] == before[:2] and held.fail >= 0


# ------------------------------------------------------------------ records


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("record", [2, 4, 20, 23, 27, 61])
def test_a_record_that_is_not_finite(value: float, record: int, copied: Path, file: Path) -> None:
    run, whole = started(copied, file, "bad"), started(copied, file, "good")
    last, told = run.call(1, 6 * T), 0
    whole.call(1, 6 * T)
    for k in range(7, 40):
        good = run.swap[record - 1]
        run.swap[record - 1] = value
        answer = run.call(1, value if record == 2 else T * k)
        run.swap[record - 1] = good
        told += answer.fail
        assert sane(answer)
        assert abs(answer.torque - last.torque) <= 15000 * T * (1 + 1e-4)
        assert abs(answer.pitch - last.pitch) <= 0.13962634 * T * (1 + 1e-3)
        last = answer
        whole.call(1, T * k)
    assert told == (1 if record in (2, 4, 20) else 0)
    if record in (23, 27):
        assert run.call(1, 40 * T) == whole.call(1, 40 * T)


@pytest.mark.parametrize("speed", [0.0, -3.0, 1e30, 3.4e38])
def test_a_speed_out_of_range(speed: float, copied: Path, file: Path) -> None:
    run = started(copied, file, "speed")
    last = run.call(1, 6 * T)
    run.records({20: speed})
    for k in range(7, 200):
        answer = run.call(1, T * k)
        assert sane(answer)
        assert abs(answer.pitch - last.pitch) <= 0.13962634 * T * (1 + 1e-3)
        last = answer


def test_two_blades_and_the_mean(copied: Path, file: Path) -> None:
    run = Simulator(copied, file, "blades", T)
    run.records({61: 2, 4: 0.1, 33: 0.2, 34: 9.0})
    assert run.call(0, 0.0).pitch == pytest.approx(0.15)
    run.records({61: 3, 34: 0.6})
    again = run.call(0, 0.0)
    assert again.pitch == pytest.approx(0.3)
    assert again.fail == 1 and "a first call came again" in again.message


def test_simulations_do_not_disturb_each_other(copied: Path, file: Path) -> None:
    alone = started(copied, file, "alone")
    wanted = [alone.call(1, T * k) for k in range(6, 30)]
    first, second = (started(copied, file, "first of two"), started(copied, file, "second of two"))
    second.records({20: 1.5 * GEAR_RATIO})
    for k in range(6, 30):
        other = second.call(1, T * k)
        assert first.call(1, T * k) == wanted[k - 6]
    assert other != wanted[-1]


def test_more_simulations_than_places(copied: Path, file: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy.so"
    copy.write_bytes(copied.read_bytes())
    for k in range(16):
        started(copy, file, f"number {k}")
    answer = Simulator(copy, file, "one more", T).call(0, 0.0)
    assert answer.fail == -1 and "16 simulations run in this process" in answer.message


@pytest.mark.parametrize("room", [0, 1, 12, 512])
def test_the_message_keeps_its_length(room: int, copied: Path, tmp_path: Path) -> None:
    run = Simulator(copied, tmp_path / "no such file", f"room {room}")
    run.room = room
    answer = run.call(0, 0.0)
    assert answer.fail == -1
    assert len(answer.message) <= max(room - 1, 0)
    assert "nrel_5_mw: input file".startswith(answer.message) or room == 512


# ------------------------------------------------------------------ files

DAMAGES = {
    "unknown key": ("speed_filter = 0", "speed_fitler = 0", "line 17: key 'speed_fitler'"),
    "twice": ("speed_filter = 0", "speed_filter = 0\nspeed_filter = 1", "line 18: key speed_filter "
              "stands there twice"),
    "missing": ("speed_filter = 0", "", "key speed_filter is missing"),
    "no number": ("speed_filter = 0", "speed_filter = 0x", "speed_filter = 0x, but it is a number"),
    "not finite": ("speed_filter = 0", "speed_filter = nan", "but it is a number from 0 to 10000"),
    "negative": ("speed_filter = 0", "speed_filter = -1", "but it is a number from 0 to 10000"),
    "no word": ("pitch_drive = off", "pitch_drive = on", "is one of off|first_order|second_order"),
    "shaving": ("peak_shaving = off", "peak_shaving = 0.8", "peak_shaving = 0.8, but it is one of"),
    "no sign": ("speed_filter = 0", "speed_filter 0", "a line is key = value"),
    "long": ("speed_filter = 0", "speed_filter = 0 #" + "x" * 4000, "too long, or no text"),
    "binary": ("speed_filter = 0", "speed_filter = \0\n", "line 17: "),
    "version": ("gains_version = 3", "gains_version = 2", "from a gain file of version 3"),
    "gains": ("gains_sha256 = none", "gains_sha256 = 12ab", "the library holds the gains none"),
}  # fmt: skip


@pytest.mark.parametrize("name", DAMAGES)
def test_a_damaged_input_file(name: str, copied: Path, file: Path, tmp_path: Path) -> None:
    good, bad, wanted = DAMAGES[name]
    text = file.read_text(encoding="utf-8")
    assert good in text
    (tmp_path / "i").write_text(text.replace(good, bad), encoding="utf-8")
    answer = Simulator(copied, tmp_path / "i", f"damaged {name}").call(0, 0.0)
    assert answer.fail == -1 and wanted in answer.message and sane(answer)


def test_an_input_file_that_ends_early(copied: Path, file: Path, tmp_path: Path) -> None:
    data = file.read_bytes()
    for size in range(0, data.rindex(b"log_file"), 97):
        (tmp_path / "i").write_bytes(data[:size])
        assert Simulator(copied, tmp_path / "i", "early").call(0, 0.0).fail == -1


def test_a_damaged_checkpoint(copied: Path, file: Path, tmp_path: Path) -> None:
    run, at = started(copied, file, "checkpoint"), tmp_path / "c.chkp"
    assert run.call(-8, 5 * T, str(at).encode()).fail == 0
    data = at.read_bytes()
    assert run.call(-9, 5 * T, str(at).encode()).fail == 0
    for bad, why in (
        (data[:-1], "is damaged"),
        (data + b"0", "is damaged"),
        (data[:500] + bytes([data[500] ^ 1]) + data[501:], "is damaged"),
        (data[:16] + b"\x07" + data[17:], "is not one of this library"),
        (b"", "is damaged"),
    ):
        at.write_bytes(bad)
        answer = run.call(-9, 5 * T, str(at).encode())
        assert answer.fail == -1 and why in answer.message
    assert run.call(-9, 5 * T, str(tmp_path / "none").encode()).fail == -1
    assert run.call(-8, 5 * T, str(tmp_path / "no" / "folder").encode()).fail == 1
    assert run.call(1, 6 * T).fail == 0


def test_the_log_has_a_row_for_each_call(copied: Path, file: Path, tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    run = started(copied, edited(file, tmp_path / "i", log_file=log), "log")
    run.call(1, 5 * T)
    run.call(-1, 5 * T)
    head, *rows = log.read_text(encoding="utf-8").splitlines()
    assert head.startswith("status [-],time [s]") and len(rows) == 7
    assert [row.split(",")[3] for row in rows] == ["1"] * 5 + ["0"] * 2
    assert head.endswith(",status bits of the law [-]")
    assert {row.split(",")[-1] for row in rows} == {"0"}


# ------------------------------------------------------------------ what cannot be exported


def test_a_plant_is_refused(tmp_path: Path) -> None:
    program = read_controller(plant_file("cart_pole", tmp_path))
    with pytest.raises(ModelError, match="is no turbine.*take --to c or --to fmu"):
        export(program, ExportSettings())


def test_without_rate_limits_it_is_refused() -> None:
    program = baseline_program(load_turbine("nrel5mw"))
    bare = controller_program(program.document, without=["rate limits"])
    with pytest.raises(ModelError, match="needs the program 'rate limits'"):
        export(bare, ExportSettings())


@pytest.mark.parametrize(("drive", "follows", "told"), [
    ("off", True, True), ("off", False, False), ("first_order", True, False),
])  # fmt: skip
def test_a_simulator_without_a_pitch_drive_is_told(
    copied: Path, file: Path, tmp_path: Path, drive: str, follows: bool, told: bool
) -> None:
    """Blades that stand at once where pitch was sent to have no drive; those that lag have one."""
    run = Simulator(copied, edited(file, tmp_path / "i", pitch_drive=drive), "drive", T)
    pitch, messages = 0.1, []
    run.pitch(pitch)
    run.call(0, 0.0)
    for k in range(1, 400):
        # Above rated speed, and faster and faster: pitch moves at every sample.
        run.records({20: (1.27 + 1e-4 * k) * GEAR_RATIO})
        run.pitch(pitch)
        answer = run.call(1, k * T)
        messages += [answer.message] if "pitch drive" in answer.message else []
        pitch = answer.pitch if follows else pitch + 0.1 * (answer.pitch - pitch)
    assert len(messages) == int(told)
    assert all("first_order" in message for message in messages)
