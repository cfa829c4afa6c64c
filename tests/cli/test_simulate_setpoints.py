"""`takagi simulate --setpoint`: a law at the set-points that it takes at run time."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import pytest

from takagi.cli.main import main
from takagi.models.turbine.data import rotor_torque
from takagi.models.turbine.loader import nrel5mw
from tests.reports.code.design_program import recorded_file

Capture = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def gains(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("setpoints") / "gains.json"
    path.write_text(recorded_file(setpoints=True), encoding="utf-8")
    return path


def run(gains: Path, *more: str) -> int:
    return main(["simulate", "nrel5mw", "--law-from", str(gains), "--wind", "15", *more])


def test_speed_and_power_come_to_rest_at_the_set_points(
    gains: Path, tmp_path: Path, capsys: Capture
) -> None:
    """In a wind far above rated; the pitch there is the one at which the torques balance."""
    given = ("--setpoint", "speed=1.1rad/s", "--setpoint", "power=4.2MW")
    assert run(gains, *given, "--duration", "200", "--out", str(tmp_path)) == 0
    assert "at most 1.1 rad/s and 4200 kW" in capsys.readouterr().out
    answer = json.loads((tmp_path / "simulation.json").read_text(encoding="utf-8"))
    (series,) = (tmp_path / "series").iterdir()
    last = list(csv.DictReader(series.read_text(encoding="utf-8").splitlines()))[-1]
    speed, pitch = float(last["rotor speed [rad/s]"]), float(last["pitch [rad]"])
    assert speed == pytest.approx(1.1, rel=1e-5)
    assert float(last["electrical power [W]"]) == pytest.approx(4.2e6, rel=1e-5)
    turbine = nrel5mw()
    assert float(rotor_torque(turbine, speed, pitch, 15.0)) == pytest.approx(
        4.2e6 / turbine.generator_efficiency / 1.1, rel=1e-4
    )
    assert answer["setpoints"]["coherent"] == pytest.approx(
        {"speed_setpoint": 1.1, "power_setpoint": 4.2e6}
    )


def test_rated_set_points_are_none_at_all(gains: Path, capsys: Capture) -> None:
    """5 MW is rated power, which the tables have as 4999999.8 W; 12.1 rpm is rated speed."""
    rows = []
    for more in ((), ("--setpoint", "power=5MW"), ("--setpoint", "speed=12.1rpm")):
        assert run(gains, *more, "--duration", "4", "--json") == 0
        rows.append(json.loads(capsys.readouterr().out)["rows"])
    assert rows[0] == rows[1]
    assert rows[0][0]["energy"] == pytest.approx(rows[2][0]["energy"], rel=1e-9)


def test_torque_below_rated_is_no_fight_of_the_actuators(gains: Path, capsys: Capture) -> None:
    """The lowest torque is 90 %, and pitch sheds the rest."""
    assert run(gains, "--setpoint", "power=3.8MW", "--duration", "10", "--json") == 0
    (row,) = json.loads(capsys.readouterr().out)["rows"]
    assert row["both_active"] == 0.0


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (["speed=1rad/s"], "speed: 1 rad/s was given; the law takes 1.05 to 1.26711 rad/s"),
        (["power=5.1MW"], "the law takes 3.72896e+06 to 5e+06 W"),
        (["power=4"], "a number with its unit is needed"),
        (["power=4knots"], "unit 'knots' is not known"),
        (["torque=40kNm"], "speed=11.5rpm or power=4MW is needed"),
        (["power=4MW", "power=4.5MW"], "each once"),
    ],
)
def test_other_set_points_are_refused(
    given: list[str], words: str, gains: Path, capsys: Capture
) -> None:
    assert run(gains, *(word for text in given for word in ("--setpoint", text))) == 2
    assert words in " ".join(capsys.readouterr().err.split())


def test_a_law_that_takes_none_is_refused(tmp_path: Path, gains: Path, capsys: Capture) -> None:
    """With the cure; a new design has no set-points, and the reference controller takes none."""
    plain = tmp_path / "gains.json"
    plain.write_text(recorded_file(), encoding="utf-8")
    asked = ("--setpoint", "power=4MW")
    for more in (["--law-from", str(plain)], []):
        assert main(["simulate", "nrel5mw", *more, *asked]) == 2
        assert "--lowest-speed-setpoint SPEED" in capsys.readouterr().err
    assert run(gains, *asked, "--law", "reference") == 2
    assert "leave --law reference out" in " ".join(capsys.readouterr().err.split())
