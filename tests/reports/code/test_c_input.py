"""Bad inputs, times and states of the exported C."""

from __future__ import annotations

import math
import shutil
import subprocess
from decimal import Decimal
from pathlib import Path
from typing import cast

import pytest

from takagi.models import ModelError
from takagi.models.turbine.loader import load_turbine
from takagi.reports.code.baseline import baseline_program
from takagi.reports.code.c.source import c_source
from takagi.reports.code.controller_program import ControllerProgram
from takagi.reports.code.program_reading import controller_program, read_controller
from takagi.reports.code.targets import ExportSettings, Precision
from tests.reports.code.compiled import (
    C99,
    SANITIZED,
    STRICT,
    Compiled,
    compiler,
    only_half,
    run,
    written,
)
from tests.reports.code.design_program import recorded_program
from tests.reports.code.language_document import every_function
from tests.reports.test_gain_file_alone import PLANTS, plant_file

BAD = (math.nan, math.inf, -math.inf)


@pytest.fixture(scope="module")
def program() -> ControllerProgram:
    return baseline_program(load_turbine("nrel5mw"))


@pytest.fixture(scope="module")
def compiled(program: ControllerProgram, tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    """The law, compiled once: all that it remembers is in its state."""
    return Compiled(program, tmp_path_factory.mktemp("law"))


@pytest.fixture
def law(compiled: Compiled) -> Compiled:
    compiled.zeroed()
    compiled.status = 0
    return compiled


# ------------------------------------------------------------------ what comes in


@pytest.mark.parametrize("bad", BAD)
def test_the_last_good_input_stands_in(law: Compiled, bad: float) -> None:
    good = {"speed": 1.1, "pitch": 0.1}
    law.init(0.01)
    law.step(good)
    law.step(good)
    other = law.state.__class__.from_buffer_copy(law.state)
    sent = law.step({"speed": 1.1, "pitch": bad})
    assert law.bit("INPUT_NOT_FINITE")
    law.state = other
    assert law.step(good) == sent
    assert not law.bit("INPUT_NOT_FINITE")


@pytest.mark.parametrize("bad", BAD)
def test_a_bad_first_sample_starts_from_rest(
    law: Compiled, program: ControllerProgram, bad: float
) -> None:
    rest = {one.name: float(one.rest or 0) for one in program.inputs}
    T, limits = 0.01, load_turbine("nrel5mw")
    law.init(T)
    first = law.step(dict.fromkeys(rest, bad))
    assert law.bit("INPUT_NOT_FINITE")
    law.init(T)
    assert law.step(rest) == first
    for _ in range(50):
        then = law.step({"speed": 1.4, "pitch": 0.3})
        assert (
            abs(then["torque_sent"] - first["torque_sent"]) <= T * limits.torque_rate_limit * 1.001
        )
        assert abs(then["pitch_sent"] - first["pitch_sent"]) <= T * limits.pitch_rate_limit * 1.001
        first = then


@pytest.mark.parametrize("pitch", [-1.4e-45, -4.9e-324, -1e-6])
def test_a_pitch_a_hair_below_its_limit_is_not_reported(law: Compiled, pitch: float) -> None:
    """Noise of a measurement, or what a float leaves of 0; the law gets it as it is."""
    law.init(0.01)
    wanted = law.step({"speed": 1.1, "pitch": 0.0})
    law.init(0.01)
    assert law.step({"speed": 1.1, "pitch": pitch}) == pytest.approx(wanted, rel=1e-5)
    assert not law.bit("INPUT_OUTSIDE")


@pytest.mark.parametrize("pitch", [-1e-4, -0.1])
def test_a_pitch_below_that_is_told(law: Compiled, pitch: float) -> None:
    law.init(0.01)
    law.step({"speed": 1.1, "pitch": pitch})
    assert law.bit("INPUT_OUTSIDE")


def test_inputs_out_of_range_and_too_large(law: Compiled) -> None:
    """Used as they are, and told; where a result is not finite what was sent last is kept."""
    law.init(0.01)
    before = law.step({"speed": 1.1, "pitch": 0.1})
    assert law.status & ~law.c.status_bits["AT_LIMIT"] == 0
    law.step({"speed": 50.0, "pitch": 0.1})
    assert law.bit("INPUT_OUTSIDE")
    sent = law.step({"speed": 1.7e308, "pitch": 1.7e308})
    assert law.bit("RESULT_NOT_FINITE")
    assert all(map(math.isfinite, (*sent.values(), *law.kept().values())))
    assert abs(sent["torque_sent"] - before["torque_sent"]) <= 2 * 0.01 * 15001
    law.init(0.01)
    first = law.step({"speed": 1.7e308, "pitch": -1.7e308})
    assert law.bit("RESULT_NOT_FINITE")
    assert all(map(math.isfinite, first.values()))


def test_a_command_at_a_limit_is_told(law: Compiled) -> None:
    law.init(0.01)
    law.step({"speed": 1.0, "pitch": 0.0})
    law.keep({"w_f": 170.0, "x": 1e6, "pitch_before": 0.2, "torque_before": 40000.0})
    law.step({"speed": 1.4, "pitch": 0.3})
    assert law.bit("AT_LIMIT")
    assert law.message(law.status) == "a command is held at a limit"


# ------------------------------------------------------------------ calls and times


def test_a_step_before_init(law: Compiled) -> None:
    given = {"speed": 1.1, "pitch": 0.1}
    law.zeroed()
    sent = law.step(given)
    assert law.bit("NOT_STARTED")
    assert law.state.sample_time == float(law.c.sample_time)
    law.step(given)
    assert not law.bit("NOT_STARTED")
    law.init(float(law.c.sample_time))
    assert law.step(given) == sent


@pytest.mark.parametrize("time", [*BAD, 0.0, -0.01])
def test_a_time_that_is_none_is_refused(law: Compiled, time: float) -> None:
    refused = law.c.status_bits["SAMPLE_TIME_REFUSED"]
    assert law.init(0.02) == 0
    law.step({"speed": 1.1, "pitch": 0.1})
    assert law.set_sample_time(time) == refused
    assert law.state.sample_time == 0.02
    assert law.set_sample_time(0.05) == 0
    assert law.state.sample_time == 0.05
    assert law.init(time) == refused
    assert law.message(refused) == "a sample time was refused; the one before is kept"
    assert all(map(math.isfinite, law.step({"speed": 1.1, "pitch": 0.1}).values()))


def test_a_damaged_state_starts_anew(law: Compiled) -> None:
    given = {"speed": 1.1, "pitch": 0.1}
    for member in ("w_f", "torque_before"):
        law.init(0.01)
        law.step(given)
        setattr(law.state.kept, member, math.nan)
        assert all(map(math.isfinite, law.step(given).values()))
        assert law.bit("NOT_STARTED")
    law.state.sample_time = -1.0
    law.step(given)
    assert law.bit("NOT_STARTED")


def test_a_stored_state_goes_on_where_it_was(law: Compiled) -> None:
    law.init(0.01)
    law.step({"speed": 1.1, "pitch": 0.1})
    stored = bytes(law.state)
    then = law.step({"speed": 1.2, "pitch": 0.12})
    law.state = type(law.state).from_buffer_copy(stored)
    assert law.step({"speed": 1.2, "pitch": 0.12}) == then


def test_a_law_with_a_time_of_its_own_refuses_another(tmp_path: Path) -> None:
    document = every_function()
    document["law"]["sample_time"] = Decimal("0.05")
    law = Compiled(controller_program(document), tmp_path)
    assert law.init(0.05) == 0
    assert law.init(0.01) == law.c.status_bits["SAMPLE_TIME_REFUSED"]
    assert law.state.sample_time == 0.05
    with pytest.raises(ModelError, match=r"the law is one in discrete time with 0\.05 s"):
        c_source(controller_program(document), ExportSettings(sample_time=0.01))


HARNESS = Path(__file__).with_name("fuzz.c")
CALLS = 10_000_000


def build(
    program: ControllerProgram, folder: Path, precision: str, *flags: str, by: str = "cc"
) -> Path:
    word = written(program, folder, ExportSettings(precision=cast(Precision, precision)))
    shutil.copy(HARNESS, folder / "fuzz.c")
    names = f"-DW={word}", f'-DHEADER="{word}.h"'
    run([compiler(by), *C99, *STRICT, "-Wno-missing-prototypes", *flags, *names, f"{word}.c",
         "fuzz.c", "-o", "fuzz", "-lm"], folder)  # fmt: skip
    return folder / "fuzz"


def program_of(name: str, folder: Path) -> ControllerProgram:
    if name == "baseline":
        return baseline_program(load_turbine("nrel5mw"))
    return read_controller(plant_file(name, folder))


@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("name", ["baseline", "split_range", "cart_pole"])
def test_random_bytes_under_the_sanitizers(name: str, precision: str, tmp_path: Path) -> None:
    """50 000 calls under the sanitizers of addresses and of undefined behaviour."""
    fuzz = build(program_of(name, tmp_path), tmp_path / "c", precision, *SANITIZED)

    assert run([str(fuzz), "50000"], tmp_path) == "50000 calls\n"


@pytest.mark.slow
@pytest.mark.parametrize("precision", ["double", "float"])
@pytest.mark.parametrize("name", ["baseline", *PLANTS])
def test_many_random_bytes(name: str, precision: str, tmp_path: Path, reduced: bool) -> None:
    """10^7 calls over all laws and both types: for each its part; reduced, each law in one type."""
    if reduced:
        only_half(["baseline", *PLANTS], name, precision, 0)
    fuzz = build(program_of(name, tmp_path), tmp_path / "c", precision, *SANITIZED)
    calls = CALLS // (2 * (len(PLANTS) + 1)) // (10 if reduced else 1)

    assert run([str(fuzz), str(calls)], tmp_path) == f"{calls} calls\n"


@pytest.mark.slow
def test_a_fuzzer_that_looks_for_paths(tmp_path: Path, reduced: bool) -> None:
    empty = tmp_path / "empty.c"
    empty.write_text("int LLVMFuzzerTestOneInput(const char *b, unsigned long n);\n"
                     "int LLVMFuzzerTestOneInput(const char *b, unsigned long n)\n"
                     "{ return b == 0 && n > 0; }\n", encoding="utf-8")  # fmt: skip
    tried = [compiler("clang"), "-fsanitize=fuzzer,address", str(empty), "-o", "empty"]
    if subprocess.run(tried, cwd=tmp_path, capture_output=True, check=False).returncode:
        pytest.skip("clang is here without its fuzzer")
    program = program_of("split_range", tmp_path)
    flags = ("-g", "-O1", "-DLIBFUZZER", "-fsanitize=fuzzer,address,undefined",
             "-fno-sanitize-recover=all")  # fmt: skip
    fuzz = build(program, tmp_path / "c", "double", *flags, by="clang")

    run([str(fuzz), f"-runs={20_000 if reduced else 1_000_000}", "-seed=1"], tmp_path)


# ------------------------------------------------------------------ the wind estimate

T, RATED = 0.01, 1.267109037  # s, rad/s
HELD = "the wind estimate is held at a limit, or at the end of a table"


@pytest.fixture(scope="module")
def observed(tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    """The default law of the NREL 5-MW turbine, from a recorded certificate."""
    return Compiled(recorded_program(), tmp_path_factory.mktemp("law"))


@pytest.fixture
def estimator(observed: Compiled) -> Compiled:
    observed.zeroed()
    observed.status = 0
    return observed


def held(
    estimator: Compiled, speed: float, pitch: float, guess: float, seconds: float
) -> list[bool]:
    estimator.init(T)
    found = []
    for _ in range(round(seconds / T)):
        sent = estimator.step({"measured_speed": speed, "pitch": pitch, "wind_guess": guess})
        assert all(map(math.isfinite, (*sent.values(), *estimator.kept().values())))
        found.append(estimator.bit("ESTIMATE_HELD"))
    return found


def test_an_estimate_that_is_free_is_not_said_to_be_held(estimator: Compiled) -> None:
    assert not any(held(estimator, RATED, 0.18, 15.0, 20.0))
    assert not estimator.bit("INPUT_OUTSIDE")


def test_a_rotor_that_is_too_fast_drives_it_to_its_upper_limit(estimator: Compiled) -> None:
    """With pitch at 29 degrees the table's torque is small: no wind explains the speed."""
    is_held = held(estimator, 1.4 * RATED, 0.5, 20.0, 40.0)
    assert not is_held[0] and is_held[-1]
    assert estimator.kept()["v_hat"] >= 37.5 - 0.1
    assert estimator.message(estimator.c.status_bits["ESTIMATE_HELD"]) == HELD


def test_beyond_the_winds_of_the_law_it_is_said(estimator: Compiled) -> None:
    """From 25 m/s on the law reads its tables at their end, below the observer's limit."""
    is_held = held(estimator, 1.4 * RATED, 0.5, 20.0, 40.0)
    first = is_held.index(True)
    held(estimator, 1.4 * RATED, 0.5, 20.0, (first + 1) * T)
    assert 25.0 < estimator.state.outputs.wind_estimate < 25.5


@pytest.mark.parametrize("speed", [0.0, -0.1, 0.05])
def test_a_rotor_that_stands_or_stalls_is_told(estimator: Compiled, speed: float) -> None:
    """Its tip-speed ratio lies below the table of the torque."""
    is_held = held(estimator, speed, 0.0, 8.0, 30.0)
    assert all(is_held)


def test_pitch_beyond_the_table_is_told(estimator: Compiled) -> None:
    """The table ends at 30 degrees, the pitch's range at 90."""
    assert held(estimator, RATED, 0.6, 15.0, T)[-1]
    assert not estimator.bit("INPUT_OUTSIDE")
    assert not held(estimator, RATED, 0.5, 15.0, T)[-1]


@pytest.mark.parametrize("pitch", [-1.4e-45, -1e-6])
def test_a_hair_below_the_lowest_pitch_nothing_is_told(estimator: Compiled, pitch: float) -> None:
    held(estimator, 1.0, 0.0, 8.0, 2.0)
    kept, status = estimator.kept(), estimator.status
    assert not any(held(estimator, 1.0, pitch, 8.0, 2.0))
    assert (
        estimator.kept() == pytest.approx(kept, rel=1e-7, abs=1e-7) and estimator.status == status
    )
    assert not estimator.bit("INPUT_OUTSIDE")


def test_as_float_under_all_warnings(tmp_path: Path) -> None:
    law = Compiled(recorded_program(), tmp_path, precision="float", flags=STRICT)
    assert not any(held(law, RATED, 0.18, 15.0, 1.0))
    assert all(held(law, 0.0, 0.0, 8.0, 1.0))
