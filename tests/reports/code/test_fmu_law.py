"""The law as an FMU: FMPy has nothing to complain of, and runs it to the Python law's commands."""

from __future__ import annotations

import io
import re
import shutil
import subprocess
import zipfile
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import numpy as np
import pytest

from takagi.certificates import TurbineDesign
from takagi.cli.main import main
from takagi.reports.code.fmu.target import base_units
from takagi.reports.code.run import ProgramRun
from tests.reports.code.fmu_files import exported, fmpy, simulated, sources_alone
from tests.reports.test_gain_file_alone import plant_file, plant_law, turbine_file

EXACT = 1e-9
SAMPLES = 60


def compared(gains: Path, time: float, random: Random) -> int:
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
    own = plant_law(name)[1].model.sample_time

    assert compared(plant_file(name, tmp_path), float(own or 0.05), Random(3)) >= 2 * SAMPLES


def test_a_turbine_s_law(turbine_design: TurbineDesign, tmp_path: Path) -> None:
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


STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")
SANITIZED = ("-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def names(content: bytes | str) -> list[str]:
    assert isinstance(content, bytes)
    return zipfile.ZipFile(io.BytesIO(content)).namelist()


@pytest.mark.parametrize(
    ("unit", "exponents"),
    [
        ("rad/s", {"s": -1, "rad": 1}),
        ("N m", {"kg": 1, "m": 2, "s": -2}),
        ("N m s^2/rad^2", {"kg": 1, "m": 2, "rad": -2}),
        ("Pa/s", {"kg": 1, "m": -1, "s": -3}),
        ("kN", None),
        ("apples", None),
    ],
)
def test_base_units(unit: str, exponents: dict[str, int] | None) -> None:
    assert base_units(unit) == exponents


@pytest.mark.slow
def test_equal_files_for_equal_gains(tmp_path: Path) -> None:
    gains = plant_file("tora", tmp_path)

    assert exported(gains, anew=True)[1].files == exported(gains, anew=True)[1].files


def test_sources_alone_where_there_is_no_compiler(tmp_path: Path) -> None:
    _, made = sources_alone(plant_file("tora", tmp_path))

    assert names(made.files["tora.fmu"]) == [
        "modelDescription.xml",
        "sources/buildDescription.xml",
        "documentation/index.html",
        "sources/tora.c",
        "sources/fmi3.c",
        "sources/tora.h",
        "sources/runner.h",
        "sources/model.h",
    ]
    assert "no C compiler was found" in made.use["tora.fmu"]


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    gains = plant_file("tora", tmp_path)
    out = tmp_path / "out"

    assert main(["export", str(gains), "--to", "fmu", "--out", str(out)]) == 0
    assert sorted(one.name for one in out.iterdir()) == ["tora.fmu", "tora_fmi2.fmu"]
    assert "FMI 3.0 co-simulation: the law" in capsys.readouterr().out


DRIVER = """
#include "fmi3.c"

static void log_message(Environment e, Status status, const char *category, const char *message)
{
    (void)e;
    (void)category;
    printf("%d %s\\n", status, message);
}

int main(void)
{
    const double bad[] = { 0.0, 1e308, -1e308, 1e-308, NAN, INFINITY, -INFINITY, 0.3 };
    unsigned seed = 7u;
    int round;
    for (round = 0; round < 200; round++) {
        void *one = fmi3InstantiateCoSimulation("one", MODEL_TOKEN, "", false, false, false, false,
                                                NULL, 0, NULL, log_message, NULL);
        double at = 0.0;
        int k;
        void *state = NULL;
        uint8_t bytes[STORED_SIZE];
        for (k = 0; k < 60; k++) {
            Reference place;
            double value;
            uint32_t status;
            seed = seed * 1103515245u + 12345u;
            place = (seed >> 16) % (MODEL_REALS + 3u);
            value = bad[(seed >> 8) % 8u];
            (void)fmi3SetFloat64(one, &place, 1, &value, 1);
            (void)fmi3GetFloat64(one, &place, 1, &value, 1);
            (void)fmi3GetUInt32(one, &place, 1, &status, 1);
            if (k == 5) {
                (void)fmi3EnterInitializationMode(one, false, 0.0, 0.0, false, 0.0);
            }
            if (k == 9) {
                (void)fmi3ExitInitializationMode(one);
            }
            if (fmi3DoStep(one, at, 0.001 * (seed >> 24), true, NULL, NULL, NULL, NULL) < 2) {
                at += 0.001 * (seed >> 24);
            }
            if (k % 20 == 19) {
                (void)fmi3GetFMUState(one, &state);
                (void)fmi3SerializeFMUState(one, state, bytes, sizeof bytes);
                bytes[seed % sizeof bytes] ^= (uint8_t)(seed >> 12);
                if (fmi3DeserializeFMUState(one, bytes, sizeof bytes, &state) == 0 && k == 59) {
                    (void)fmi3SetFMUState(one, state);
                    (void)fmi3DoStep(one, at, 0.01, true, NULL, NULL, NULL, NULL);
                }
                (void)fmi3FreeFMUState(one, &state);
            }
        }
        fmi3FreeInstance(one);
    }
    return 0;
}
"""


def test_bad_calls_under_sanitizers(tmp_path: Path) -> None:
    if shutil.which("cc") is None:
        pytest.skip("no cc on this machine")
    _, made = sources_alone(plant_file("split_range", tmp_path))
    content = made.files["split_range.fmu"]
    assert isinstance(content, bytes)
    zipfile.ZipFile(io.BytesIO(content)).extractall(tmp_path)
    sources = tmp_path / "sources"
    (sources / "driver.c").write_text(DRIVER, encoding="utf-8")
    law = next(one.name for one in sources.glob("split*.c"))
    build = ["cc", *STRICT, *SANITIZED, "driver.c", law, "-o", "driver", "-lm"]
    done = subprocess.run(build, cwd=sources, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr[-3000:]
    ran = subprocess.run(
        ["./driver"], cwd=sources, capture_output=True, text=True, check=False, timeout=300
    )
    assert ran.returncode == 0, ran.stderr[-3000:]


def test_fmi_2_compiles_without_a_warning(tmp_path: Path) -> None:
    if shutil.which("cc") is None:
        pytest.skip("no cc on this machine")
    _, made = sources_alone(plant_file("tora", tmp_path))
    content = made.files["tora_fmi2.fmu"]
    assert isinstance(content, bytes)
    zipfile.ZipFile(io.BytesIO(content)).extractall(tmp_path)
    done = subprocess.run(
        ["cc", *STRICT, "-c", "fmi2.c"], cwd=tmp_path / "sources",
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-3000:]


TIME = 0.01


class Slave:
    """A law as an instance that is called function by function; ``said`` are its messages."""

    def __init__(self, file: Path, folder: Path, token: str | None = None) -> None:
        fmpy()
        from fmpy import extract, read_model_description
        from fmpy.fmi3 import FMU3Slave

        about = read_model_description(str(file))
        self.said: list[tuple[int, str]] = []
        self.places = {one.name: one.valueReference for one in about.modelVariables}
        self.fmu: Any = FMU3Slave(
            guid=token or about.guid,
            modelIdentifier=about.coSimulation.modelIdentifier,
            unzipDirectory=extract(str(file), str(folder)),
            instanceName="one",
        )
        self.fmu.instantiate(
            logMessage=lambda _, status, category, text: self.said.append((status, text.decode()))
        )

    def start(self, at: float = 0.0, **values: float) -> Slave:
        self.set(**values)
        self.fmu.enterInitializationMode(startTime=at)
        self.fmu.exitInitializationMode()
        return self

    def set(self, **values: float) -> None:
        for name, value in values.items():
            self.fmu.setFloat64([self.places[name]], [value])

    def get(self, name: str) -> float:
        return float(self.fmu.getFloat64([self.places[name]])[0])

    def step(self, at: float, time: float) -> None:
        self.fmu.doStep(at, time)

    def refused(self, at: float, time: float) -> str:
        from fmpy.fmi1 import FMICallException

        before = self.get("force"), self.get("time")
        with pytest.raises(FMICallException):
            self.step(at, time)
        assert (self.get("force"), self.get("time")) == before
        status, text = self.said.pop()
        assert status == 3
        return text


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("cart_pole")
    for name in ("cart_pole", "split_range"):
        exported(plant_file(name, folder), sample_time=TIME)
    return folder


@pytest.fixture
def law(files: Path, tmp_path: Path) -> Iterator[Slave]:
    one = Slave(files / "cart_pole_16_rules.fmu", tmp_path)
    yield one
    one.fmu.freeInstance()


@pytest.fixture
def blend(files: Path, tmp_path: Path) -> Iterator[Slave]:
    """A law that keeps its effort from one sample to the next."""
    one = Slave(files / "split_range.fmu", tmp_path)
    yield one
    one.fmu.freeInstance()


def test_a_command_is_held_between_samples(law: Slave) -> None:
    law.start(angle=0.1)
    sent = []
    for k in range(8):
        law.set(angle=0.1 + 0.01 * k)
        law.step(k * TIME / 4, TIME / 4)
        sent.append(law.get("force"))

    assert len(set(sent[:4])) == len(set(sent[4:])) == 1
    assert sent[0] != sent[4]


def test_before_the_first_step_the_command_follows_the_inputs(law: Slave) -> None:
    law.fmu.enterInitializationMode()
    law.set(angle=0.1)
    first = law.get("force")
    law.set(angle=0.2)
    second = law.get("force")
    law.fmu.exitInitializationMode()
    law.step(0.0, TIME)

    assert first != second == law.get("force")


@pytest.mark.parametrize("parts", [[1.0] * 8, [0.25] * 32, [0.7, 2.3, 0.1, 3.9, 1.0]])
def test_the_law_does_not_depend_on_how_time_is_cut(blend: Slave, parts: list[float]) -> None:
    """The effort that a law keeps sums up its samples: each runs once, however steps end."""
    blend.start(at=5.0, T=351.0)
    first = blend.get("effort")
    blend.step(5.0, 8 * TIME)
    whole = blend.get("effort")
    blend.fmu.reset()
    blend.start(at=5.0, T=351.0)
    at = 5.0
    for part in parts:
        blend.step(at, part * TIME)
        at += part * TIME

    assert first != whole == blend.get("effort")
    assert blend.get("time") == pytest.approx(5.08)


def test_steps_that_make_no_sense_are_refused_and_change_nothing(law: Slave) -> None:
    law.start(angle=0.1)
    law.step(0.0, TIME)

    assert "above 0" in law.refused(TIME, 0.0)
    assert "above 0" in law.refused(TIME, -TIME)
    assert "finite" in law.refused(TIME, float("nan"))
    assert "finite" in law.refused(TIME, float("inf"))
    assert re.search("backwards or jumps", law.refused(0.0, TIME))
    assert re.search("starts at 5 s.*ended at 0.01 s", law.refused(5.0, TIME))
    assert "cannot be cut" in law.refused(TIME, 1e9)
    law.step(TIME, TIME)


def test_calls_out_of_order_are_refused(law: Slave) -> None:
    assert "before initialization" in law.refused(0.0, TIME)
    law.start()
    law.step(0.0, TIME)
    law.fmu.terminate()
    assert "after the end" in law.refused(TIME, TIME)
    law.fmu.reset()
    law.start(angle=0.1).step(0.0, TIME)


def test_an_input_that_is_no_number_is_said_once(law: Slave) -> None:
    law.start(angle=0.1)
    law.step(0.0, TIME)
    good = law.get("force")
    for k in range(1, 4):
        law.set(angle=float("nan"), rate=float("inf"))
        law.step(k * TIME, TIME)

    assert law.get("force") == good
    assert law.said == [(1, "an input was not finite; the last good one stood in")]


def test_a_parameter_is_fixed_after_the_start(law: Slave) -> None:
    from fmpy.fmi1 import FMICallException

    law.start()

    for name in ("sample_time", "force"):
        with pytest.raises(FMICallException):
            law.set(**{name: 0.5})


@pytest.mark.parametrize("value", [0.0, -1.0, float("nan"), 1e-300])
def test_a_sample_time_that_cannot_be_is_refused(law: Slave, value: float) -> None:
    from fmpy.fmi1 import FMICallException

    with pytest.raises(FMICallException):
        law.start(at=1.0, sample_time=value)
    assert "sample" in law.said[-1][1]


def test_a_state_is_taken_back_and_stored_as_bytes(blend: Slave) -> None:
    from fmpy.fmi1 import FMICallException

    blend.start(T=351.0)
    blend.step(0.0, 3 * TIME)
    kept = blend.fmu.getFMUState()
    stored = blend.fmu.serializeFMUState(kept)

    def run() -> float:
        for k in range(3, 9):
            blend.step(k * TIME, TIME)
        return blend.get("effort")

    first = run()
    blend.fmu.setFMUState(kept)
    assert run() == first
    blend.fmu.freeFMUState(kept)
    again = blend.fmu.deserializeFMUState(stored)
    blend.fmu.setFMUState(again)
    assert run() == first
    blend.fmu.freeFMUState(again)
    for damaged in (b"x" + stored[1:], stored[:-1]):
        with pytest.raises(FMICallException):
            blend.fmu.deserializeFMUState(damaged)


def test_the_token_is_that_of_these_sources(files: Path, tmp_path: Path) -> None:
    with pytest.raises(Exception, match="instantiate"):
        Slave(files / "cart_pole_16_rules.fmu", tmp_path, token="{another}")
