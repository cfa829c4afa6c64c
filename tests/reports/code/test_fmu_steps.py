"""Steps of an FMU that fit the samples or not, and calls that make no sense."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.reports.code.fmu_files import exported, fmpy
from tests.reports.test_gain_file_alone import plant_file

TIME = 0.01


class Slave:
    """A law as an instance that is called function by function.

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
