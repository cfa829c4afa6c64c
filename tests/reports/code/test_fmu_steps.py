"""Steps of an FMU that fit the samples or not, and calls that make no sense."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.reports.code.fmu_files import exported, fmpy
from tests.reports.test_gain_file_alone import plant_file

TIME = 0.01


class Slave:
    """A cart-pole's loop as an instance that is called function by function.

    Attributes
    ----------
    said : status and text of all messages.
    """

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
    exported(plant_file("cart_pole", folder), sample_time=TIME)
    return folder


@pytest.fixture
def law(files: Path, tmp_path: Path) -> Iterator[Slave]:
    one = Slave(files / "cart_pole_16_rules.fmu", tmp_path)
    yield one
    one.fmu.freeInstance()


@pytest.fixture
def loop(files: Path, tmp_path: Path) -> Iterator[Slave]:
    one = Slave(files / "cart_pole_16_rules_loop.fmu", tmp_path)
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
def test_the_loop_does_not_depend_on_how_time_is_cut(loop: Slave, parts: list[float]) -> None:
    loop.start(at=5.0, angle=0.2)
    loop.step(5.0, 8 * TIME)
    whole = loop.get("angle")
    loop.fmu.reset()
    loop.start(at=5.0, angle=0.2)
    at = 5.0
    for part in parts:
        loop.step(at, part * TIME)
        at += part * TIME

    assert whole != 0.2
    # The plant's steps end at each communication point, so the last digits differ.
    assert loop.get("angle") == pytest.approx(whole, abs=1e-9)
    assert loop.get("time") == pytest.approx(5.08)


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


@pytest.mark.parametrize("start", [{"angle": float("nan")}, {"integration_step": 0.0}])
def test_a_loop_that_cannot_start_is_refused(loop: Slave, start: dict[str, float]) -> None:
    from fmpy.fmi1 import FMICallException

    with pytest.raises(FMICallException):
        loop.start(**start)


def test_a_state_is_taken_back_and_stored_as_bytes(loop: Slave) -> None:
    from fmpy.fmi1 import FMICallException

    loop.start(angle=0.2)
    loop.step(0.0, 3 * TIME)
    kept = loop.fmu.getFMUState()
    stored = loop.fmu.serializeFMUState(kept)

    def run() -> float:
        for k in range(3, 9):
            loop.step(k * TIME, TIME)
        return loop.get("angle")

    first = run()
    loop.fmu.setFMUState(kept)
    assert run() == first
    loop.fmu.freeFMUState(kept)
    again = loop.fmu.deserializeFMUState(stored)
    loop.fmu.setFMUState(again)
    assert run() == first
    loop.fmu.freeFMUState(again)
    for damaged in (b"x" + stored[1:], stored[:-1]):
        with pytest.raises(FMICallException):
            loop.fmu.deserializeFMUState(damaged)


def test_the_token_is_that_of_these_sources(files: Path, tmp_path: Path) -> None:
    with pytest.raises(Exception, match="instantiate"):
        Slave(files / "cart_pole_16_rules.fmu", tmp_path, token="{another}")


def test_a_loop_that_grows_beyond_all_numbers_says_so(files: Path, tmp_path: Path) -> None:
    from fmpy.fmi1 import FMICallException

    one = Slave(files / "cart_pole_16_rules_loop.fmu", tmp_path)
    one.start(rate=1e200)
    with pytest.raises(FMICallException):
        one.step(0.0, TIME)
    assert "beyond all numbers" in one.said[-1][1]
    assert np.isfinite(one.get("force"))
    one.fmu.freeInstance()
