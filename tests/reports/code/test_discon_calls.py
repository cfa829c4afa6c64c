"""Calls out of order and bad input of the Bladed-style library, on the baseline law's program."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import numpy as np
import pytest

from takagi.models import ModelError
from takagi.models.turbine.loader import load_turbine
from takagi.reports.code.baseline import baseline_program
from takagi.reports.code.discon.library import export
from takagi.reports.code.program_reading import controller_program, read_controller
from takagi.reports.code.targets import ExportSettings
from tests.reports.code.bladed import GEAR_RATIO, Answer, Simulator, built, edited, input_file
from tests.reports.test_gain_file_alone import plant_file

T = 0.02


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return built(baseline_program(load_turbine("nrel5mw")), tmp_path_factory.mktemp("discon"))


@pytest.fixture
def library(made: Path, tmp_path: Path) -> Path:
    """A copy for each test: a library keeps the simulations that had no last call."""
    return Path(shutil.copy(made, tmp_path / "library.so"))


@pytest.fixture
def file(made: Path) -> Path:
    return input_file(made)


def started(library: Path, file: Path, name: str, *, calls: int = 5) -> Simulator:
    """Return a simulation after its first call and some running ones, 1.2 rad/s and 0.1 rad."""
    run = Simulator(library, file, name, T)
    run.pitch(0.1)
    assert run.call(0, 0.0).fail == 0
    for k in range(calls):
        assert run.call(1, T * (k + 1)).fail == 0
    return run


def sane(answer: Answer) -> bool:
    """Return whether what is sent is within the actuators' limits."""
    return 0 <= answer.torque <= 47402.92 and 0 <= answer.pitch <= math.pi / 2 + 1e-6


# ------------------------------------------------------------------ order and time


def test_the_first_call_sends_what_is_measured(library: Path, file: Path) -> None:
    run = Simulator(library, file, "first", T)
    run.records({23: 1.25e4})
    run.pitch(0.25)
    assert run.call(0, 0.0) == (1.25e4, 0.25, 0, "")
    assert run.call(-1, 0.0).fail == 0


@pytest.mark.parametrize("status", [1, -8, 7])
def test_no_first_call(status: int, library: Path, file: Path) -> None:
    answer = Simulator(library, file, f"none {status}").call(status, 0.0)
    assert answer.fail == -1 and sane(answer)
    assert answer.message == (
        f"nrel_5_mw: a call with status {status} came before the first call, status 0"
    )


def test_a_last_call_alone_is_nothing(library: Path, file: Path) -> None:
    """A simulator makes it after a first call that failed."""
    answer = Simulator(library, file, "last").call(-1, 0.0)
    assert answer.fail == 0 and answer.message == "" and sane(answer)


def test_after_the_last_call_there_is_none(library: Path, file: Path) -> None:
    run = started(library, file, "ended")
    assert run.call(-1, 5 * T).fail == 0
    assert run.call(1, 6 * T).fail == -1


def test_the_same_time_twice_moves_nothing(library: Path, file: Path) -> None:
    """As in a corrector step; what is read then does not count."""
    run, other = started(library, file, "one"), started(library, file, "two")
    for k in range(6, 60):
        run.records({20: (1.2 + 0.002 * k) * GEAR_RATIO})
        first = run.call(1, T * k)
        speed = run.swap[19]
        for again in (T * k, T * k + 0.3 * T, T * k - 0.3 * T):
            run.records({20: 150.0})
            assert run.call(1, again) == first
        other.records({20: speed})
        assert other.call(1, T * k) == first


def test_time_that_goes_back_or_jumps_is_told_once(library: Path, file: Path) -> None:
    run = started(library, file, "times")
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


def test_a_time_of_too_few_digits(library: Path, file: Path) -> None:
    """At 10^6 s float32 knows sixteenths of a second: every call counts."""
    run = started(library, file, "long")
    run.call(1, 1e6)
    run.records({20: 1.35 * GEAR_RATIO})
    answers = [run.call(1, 1e6) for _ in range(40)]
    assert len({one.torque for one in answers} | {one.pitch for one in answers}) > 20


def test_another_step(library: Path, file: Path) -> None:
    run = started(library, file, "step")
    run.records({3: 0.01})
    told = run.call(1, 6 * T)
    assert told.fail == 1 and "the step, record 3, went from 0.02 to 0.01 s" in told.message
    torque = told.torque
    run.records({20: 0.8 * GEAR_RATIO})
    after = run.call(1, 6 * T + 0.01)
    assert after.fail == 0 and abs(after.torque - torque) <= 15000 * 0.01 * (1 + 1e-4)


@pytest.mark.parametrize("step", [0.0, -1.0, math.nan, math.inf])
def test_a_step_that_is_none(step: float, library: Path, file: Path) -> None:
    run = Simulator(library, file, "no step", step)
    told = run.call(0, 0.0)
    assert told.fail == 1 and "record 3 is no step; 0.01 s stands in" in told.message
    assert all(run.call(1, 0.01 * k).fail == 0 for k in range(1, 5))


def test_a_sample_time_that_is_no_multiple(library: Path, file: Path, tmp_path: Path) -> None:
    run = Simulator(library, edited(file, tmp_path / "i", sample_time=0.05), "multiple", T)
    told = run.call(0, 0.0)
    assert told.fail == -1
    assert "sample_time 0.05 s is not a multiple of the simulator's step 0.02 s" in told.message


def test_an_unknown_status_holds(library: Path, file: Path) -> None:
    run = started(library, file, "status")
    before = run.call(1, 6 * T)
    for status in (5, math.nan, 1e30):
        held = run.call(status, 7 * T)  # type: ignore[arg-type]
        assert held[:2] == before[:2] and held.fail >= 0


# ------------------------------------------------------------------ records


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("record", [2, 4, 20, 23, 27, 61])
def test_a_record_that_is_not_finite(value: float, record: int, library: Path, file: Path) -> None:
    """Told once at most; what is sent stays within limits and rates, and the law recovers."""
    run, whole = started(library, file, "bad"), started(library, file, "good")
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
def test_a_speed_out_of_range(speed: float, library: Path, file: Path) -> None:
    run = started(library, file, "speed")
    last = run.call(1, 6 * T)
    run.records({20: speed})
    for k in range(7, 200):
        answer = run.call(1, T * k)
        assert sane(answer)
        assert abs(answer.pitch - last.pitch) <= 0.13962634 * T * (1 + 1e-3)
        last = answer


def test_nothing_is_ever_finite(library: Path, file: Path) -> None:
    run = Simulator(library, file, "nothing", T)
    run.swap[:] = np.nan
    run.room = 0
    assert sane(run.call(0, math.nan))
    for _ in range(20):
        assert sane(run.call(1, math.nan))


def test_two_blades_and_the_mean(library: Path, file: Path) -> None:
    run = Simulator(library, file, "blades", T)
    run.records({61: 2, 4: 0.1, 33: 0.2, 34: 9.0})
    assert run.call(0, 0.0).pitch == pytest.approx(0.15)
    run.records({61: 3, 34: 0.6})
    again = run.call(0, 0.0)
    assert again.pitch == pytest.approx(0.3)
    assert again.fail == 1 and "a first call came again" in again.message


def test_simulations_do_not_disturb_each_other(library: Path, file: Path) -> None:
    alone = started(library, file, "alone")
    wanted = [alone.call(1, T * k) for k in range(6, 30)]
    first, second = started(library, file, "first of two"), started(library, file, "second of two")
    second.records({20: 1.5 * GEAR_RATIO})
    for k in range(6, 30):
        other = second.call(1, T * k)
        assert first.call(1, T * k) == wanted[k - 6]
    assert other != wanted[-1]


def test_more_simulations_than_places(library: Path, file: Path, tmp_path: Path) -> None:
    copy = tmp_path / "copy.so"
    copy.write_bytes(library.read_bytes())
    for k in range(16):
        started(copy, file, f"number {k}")
    answer = Simulator(copy, file, "one more", T).call(0, 0.0)
    assert answer.fail == -1 and "16 simulations run in this process" in answer.message


@pytest.mark.parametrize("room", [0, 1, 12, 512])
def test_the_message_keeps_its_length(room: int, library: Path, tmp_path: Path) -> None:
    run = Simulator(library, tmp_path / "no such file", f"room {room}")
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
def test_a_damaged_input_file(name: str, library: Path, file: Path, tmp_path: Path) -> None:
    good, bad, wanted = DAMAGES[name]
    text = file.read_text(encoding="utf-8")
    assert good in text
    (tmp_path / "i").write_text(text.replace(good, bad), encoding="utf-8")
    answer = Simulator(library, tmp_path / "i", f"damaged {name}").call(0, 0.0)
    assert answer.fail == -1 and wanted in answer.message and sane(answer)


def test_an_input_file_that_ends_early(library: Path, file: Path, tmp_path: Path) -> None:
    data = file.read_bytes()
    for size in range(0, data.rindex(b"log_file"), 97):
        (tmp_path / "i").write_bytes(data[:size])
        assert Simulator(library, tmp_path / "i", "early").call(0, 0.0).fail == -1


def test_a_damaged_checkpoint(library: Path, file: Path, tmp_path: Path) -> None:
    run, at = started(library, file, "checkpoint"), tmp_path / "c.chkp"
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


def test_the_log_has_a_row_for_each_call(library: Path, file: Path, tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    run = started(library, edited(file, tmp_path / "i", log_file=log), "log")
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
    library: Path, file: Path, tmp_path: Path, drive: str, follows: bool, told: bool
) -> None:
    """Blades that stand at once where pitch was sent to have no drive; those that lag have one."""
    run = Simulator(library, edited(file, tmp_path / "i", pitch_drive=drive), "drive", T)
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
