"""The wind estimate in C: it stays finite, and the status says where it is held.

The law is the default one of the NREL 5-MW turbine, from a recorded certificate.
"""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from takagi.reports.code.controller_program import ControllerProgram
from tests.reports.code.compiled import STRICT, Compiled
from tests.reports.code.design_program import recorded_program

T, RATED = 0.01, 1.267109037  # s, rad/s
HELD = "the wind estimate is held at a limit, or at the end of a table"


@pytest.fixture(scope="module")
def program() -> ControllerProgram:
    return recorded_program()


@pytest.fixture(scope="module")
def compiled(program: ControllerProgram, tmp_path_factory: pytest.TempPathFactory) -> Compiled:
    """The law, compiled once: all that it remembers is in its state."""
    return Compiled(program, tmp_path_factory.mktemp("law"))


@pytest.fixture
def law(compiled: Compiled) -> Compiled:
    """The law with a state that was never touched."""
    compiled.zeroed()
    compiled.status = 0
    return compiled


def held(law: Compiled, speed: float, pitch: float, guess: float, seconds: float) -> list[bool]:
    """Run the law at constant inputs; return at which samples the estimate is said to be held."""
    law.init(T)
    found = []
    for _ in range(round(seconds / T)):
        sent = law.step({"measured_speed": speed, "pitch": pitch, "wind_guess": guess})
        assert all(map(math.isfinite, (*sent.values(), *law.kept().values())))
        found.append(law.bit("ESTIMATE_HELD"))
    return found


def test_an_estimate_that_is_free_is_not_said_to_be_held(law: Compiled) -> None:
    assert not any(held(law, RATED, 0.18, 15.0, 20.0))
    assert not law.bit("INPUT_OUTSIDE")


def test_a_rotor_that_is_too_fast_drives_it_to_its_upper_limit(law: Compiled) -> None:
    """With pitch at 29 degrees the table's torque is small: no wind explains the speed."""
    told = held(law, 1.4 * RATED, 0.5, 20.0, 40.0)
    assert not told[0] and told[-1]
    assert law.kept()["v_hat"] >= 37.5 - 0.1
    assert law.message(law.c.status_bits["ESTIMATE_HELD"]) == HELD


def test_beyond_the_winds_of_the_law_it_is_said(law: Compiled) -> None:
    """From 25 m/s on the law reads its tables at their end, below the observer's limit."""
    told = held(law, 1.4 * RATED, 0.5, 20.0, 40.0)
    first = told.index(True)
    held(law, 1.4 * RATED, 0.5, 20.0, (first + 1) * T)
    assert 25.0 < law.state.outputs.wind_estimate < 25.5


@pytest.mark.parametrize("speed", [0.0, -0.1, 0.05])
def test_a_rotor_that_stands_or_stalls_is_told(law: Compiled, speed: float) -> None:
    """Its tip-speed ratio lies below the table of the torque."""
    told = held(law, speed, 0.0, 8.0, 30.0)
    assert all(told)


def test_pitch_beyond_the_table_is_told(law: Compiled) -> None:
    """The table ends at 30 degrees, the pitch's range at 90."""
    assert held(law, RATED, 0.6, 15.0, T)[-1]
    assert not law.bit("INPUT_OUTSIDE")
    assert not held(law, RATED, 0.5, 15.0, T)[-1]


@pytest.mark.parametrize("pitch", [-1.4e-45, -1e-6])
def test_a_hair_below_the_lowest_pitch_nothing_is_told(law: Compiled, pitch: float) -> None:
    held(law, 1.0, 0.0, 8.0, 2.0)
    kept, status = law.kept(), law.status
    assert not any(held(law, 1.0, pitch, 8.0, 2.0))
    assert law.kept() == pytest.approx(kept, rel=1e-7, abs=1e-7) and law.status == status
    assert not law.bit("INPUT_OUTSIDE")


def test_as_float_under_all_warnings(program: ControllerProgram, tmp_path: Path) -> None:
    law = Compiled(program, tmp_path, precision="float", flags=STRICT)
    assert not any(held(law, RATED, 0.18, 15.0, 1.0))
    assert all(held(law, 0.0, 0.0, 8.0, 1.0))
