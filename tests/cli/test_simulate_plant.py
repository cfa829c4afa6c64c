"""`takagi simulate` for plants: cut inputs, disturbances, noise, samples, and what is refused."""

from __future__ import annotations

import csv
import io
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.cli.main import main
from takagi.models.turbine.data import rotor_torque
from takagi.models.turbine.loader import nrel5mw
from tests.reports.code.design_program import recorded_file

Capture = pytest.CaptureFixture[str]
pytestmark = pytest.mark.usefixtures("proved_once")

# x' = x + u + w, |u| <= 2: from |x| > 2 no input within its range holds it.
CART = """
format = 1
kind = "plant"
name = "unstable cart"

[states]
x = { unit = "cm", range = [-300, 300] }

[inputs]
u = { unit = "m/s", range = [-2, 2] }

[disturbances]
w = { unit = "mm/s", range = [-200, 200] }

[scheduling]
a = { unit = "1/s", range = [0.9, 1.1], rest = 1 }

[equations]
x = "a*x + u + w"
"""


@pytest.fixture(scope="module")
def cart(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("cart") / "cart.toml"
    path.write_text(CART, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def gains(cart: Path) -> Path:
    """u = -3 x, held within the range of the input."""
    from takagi.certificates.design.plant.design import design_plant
    from takagi.certificates.design.plant.result import PlantDesign
    from takagi.models.plant_files.loader import PlantFile, load_plant
    from takagi.reports.gains_file.envelope import dump_gains, plant_gain_file

    found = design_plant(load_plant(cart), files=PlantFile.of(cart).files)
    assert isinstance(found, PlantDesign)
    content = plant_gain_file(found)
    content["law"] |= {"K": [[[3.0]]] * len(content["law"]["K"])}
    path = cart.with_name("gains.json")
    path.write_text(dump_gains(content), encoding="utf-8")
    return path


def simulated(cart: Path, gains: Path, capsys: Capture, *options: str) -> dict[str, Any]:
    capsys.readouterr()
    assert main(["simulate", str(cart), "--gains", str(gains), "--json", *options]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def test_an_input_is_cut_at_its_range_and_it_is_said(
    cart: Path, gains: Path, capsys: Capture
) -> None:
    """From x = 1 m: u = -3 x is beyond -2 until x = 2/3, x' = x - 2: t = log(4/3).

    From x = 0.6 m the command is 1.8 at most.
    """
    found = simulated(cart, gains, capsys, "--start", "x=1m", "--start", "x=60")
    run, within = found["runs"]
    assert within["cut"] == {"u": {"seconds": 0, "spans": []}}

    assert run["largest_input"]["u"] == 2.0 and run["wanted_input"]["u"] == pytest.approx(3.0)
    (span,) = run["cut"]["u"]["spans"]
    assert span["from"] == 0.0 and span["end"] == "lower"
    assert span["to"] == pytest.approx(np.log(4 / 3), abs=1e-4)
    assert run["cut"]["u"]["seconds"] == pytest.approx(np.log(4 / 3), abs=1e-4)
    assert any("u was cut at its range [-2, 2] m/s" in note for note in found["notes"])


def test_what_the_actuator_cannot_hold_diverges(cart: Path, gains: Path, capsys: Capture) -> None:
    """From x = 2.1 m, x' = x - 2 > 0: with the command as wanted it would have settled."""
    asked = ["simulate", str(cart), "--gains", str(gains)]

    assert main([*asked, "--start", "x=2.1m", "--duration", "9"]) == 1
    said = capsys.readouterr().out
    assert "x 210 cm" in said and "diverged" in said and "Outside the proved set: x 210 cm" in said


def test_a_step_of_the_disturbance_ends_at_the_rest_of_the_closed_form(
    cart: Path, gains: Path, capsys: Capture
) -> None:
    """x' = -2 x + w: 100 mm/s from 1 s on end at 0.05 m; two on one name are added."""
    one = simulated(cart, gains, capsys, "--disturbance", "w=step 100 at 1s")
    two = simulated(
        cart, gains, capsys,
        "--disturbance", "w=step 0.05 m/s at 1 s", "--disturbance", "w=step 50 at 0s",
    )  # fmt: skip

    assert one["runs"][0]["end"]["x"] == pytest.approx(0.05, abs=1e-4)
    assert two["runs"][0]["end"]["x"] == pytest.approx(0.05, abs=1e-4)
    assert "From outside: w: a step of 100 mm/s at 1 s." in one["notes"]
    assert not any("Not covered" in note for note in one["notes"])

    beyond = simulated(cart, gains, capsys, "--disturbance", "w=step 300 at 1s")
    (note,) = (note for note in beyond["notes"] if "Not covered" in note)
    assert "w from 0 to 300 mm/s, outside its range [-200, 200]" in note


def test_a_scheduling_signal_moves_the_plant(cart: Path, gains: Path, capsys: Capture) -> None:
    """x' = (a - 3) x: with a = 1.1 from the start it decays at 1.9 in place of 2."""
    options = ("--start", "x=10", "--duration", "2")
    still = simulated(cart, gains, capsys, *options)
    moved = simulated(cart, gains, capsys, *options, "--disturbance", "a=constant 0.1")

    assert still["runs"][0]["end"]["x"] == pytest.approx(0.1 * np.exp(-4), rel=1e-4)
    assert moved["runs"][0]["end"]["x"] == pytest.approx(0.1 * np.exp(-3.8), rel=1e-4)


def test_the_sampled_law_is_the_gain_file_s_program(
    cart: Path, gains: Path, capsys: Capture
) -> None:
    """x(t + T) = e^T x - (e^T - 1) 3 x with T = 0.2 s, ten samples."""
    options = ("--start", "x=10", "--duration", "2", "--sample-time", "200ms")
    found = simulated(cart, gains, capsys, *options)
    factor = 3 - 2 * np.exp(0.2)

    assert found["runs"][0]["end"]["x"] == pytest.approx(0.1 * factor**10, rel=1e-4)
    assert any("it runs every 0.2 s" in note for note in found["notes"])
    assert any("a law in samples of 0.2 s" in note for note in found["notes"])


def test_noise_has_a_seed(cart: Path, gains: Path, capsys: Capture) -> None:
    """The same seed gives the same run, another one another."""
    options = ("--noise", "x=1 mm", "--sample-time", "0.1", "--duration", "2")
    first, again, other = (
        simulated(cart, gains, capsys, *options, "--seed", seed)["runs"][0]["end"]["x"]
        for seed in ("3", "3", "4")
    )

    assert first == again != other
    assert abs(first) < 0.05


def test_the_files_are_in_the_units_of_the_plant_s_file(
    cart: Path, gains: Path, tmp_path: Path, capsys: Capture
) -> None:
    """cm for x, mm/s for w; the command before and after the cut; a jump has two rows."""
    out = tmp_path / "out"
    options = ("--start", "x=1m", "--disturbance", "w=step 0.1 m/s at 1s", "--out", str(out))
    simulated(cart, gains, capsys, *options)
    text = (out / "responses.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(io.StringIO(text)))

    assert float(rows[0]["x [cm]"]) == 100.0
    assert float(rows[0]["u [m/s]"]) == -2.0 and float(rows[0]["u wanted [m/s]"]) == -3.0
    jump = [float(row["w [mm/s]"]) for row in rows if float(row["time [s]"]) == 1.0]
    assert jump == [0.0, 100.0]
    assert (out / "figures" / "responses.svg").read_text(encoding="utf-8").startswith("<svg")
    summary = (out / "summary.md").read_text(encoding="utf-8")
    assert "u was cut at its range" in summary and "| x 100 cm |" in summary


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--disturbance", "v=step 1 at 1s"], "there is no disturbance v; the plant has w, a"),
        (["--disturbance", "w"], "NAME=... is needed"),
        (["--disturbance", "w=stepp 1 at 1s"], "did you mean 'step'?"),
        (["--disturbance", "w=step 1 K at 1s"], "its size is in mm/s, which 'K' does not fit"),
        (
            ["--disturbance", "w=step 1 at 5s", "--duration", "2"],
            "begins at 5 s, but the run ends at 2 s",
        ),
        (["--noise", "y=1"], "there is no state y; the plant has x"),
        (["--sample-time", "0"], "a time above 0 is needed"),
        (["--sample-time", "1m"], "'m' is no unit of time"),
        (["--sample-time", "5s", "--duration", "2"], "5 s is longer than the run of 2 s"),
        (["--sample-time", "1us", "--duration", "2"], "2000000 samples and jumps"),
        (["--seed", "-1"], "option --seed: -1 was given; 0 or more is needed"),
        (["--start", "x=1K"], "option --start x=1K: x is in cm"),
    ],
)
def test_misuse_has_place_reason_and_cure(
    cart: Path, gains: Path, capsys: Capture, options: list[str], message: str
) -> None:
    """Status 2, one message, no traceback."""
    assert main(["simulate", str(cart), "--gains", str(gains), *options]) == 2

    said = capsys.readouterr().err
    assert said.startswith("Error: ") and message in said and "Traceback" not in said


@pytest.fixture(scope="module")
def turbine_gains(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("setpoints") / "gains.json"
    path.write_text(recorded_file(setpoints=True), encoding="utf-8")
    return path


def run(turbine_gains: Path, *more: str) -> int:
    return main(["simulate", "nrel5mw", "--law-from", str(turbine_gains), "--wind", "15", *more])


def test_speed_and_power_come_to_rest_at_the_set_points(
    turbine_gains: Path, tmp_path: Path, capsys: Capture
) -> None:
    """In a wind far above rated; the pitch there is the one at which the torques balance."""
    given = ("--setpoint", "speed=1.1rad/s", "--setpoint", "power=4.2MW")
    assert run(turbine_gains, *given, "--duration", "200", "--out", str(tmp_path)) == 0
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


def test_rated_set_points_are_none_at_all(turbine_gains: Path, capsys: Capture) -> None:
    """5 MW is rated power, which the tables have as 4999999.8 W; 12.1 rpm is rated speed."""
    rows = []
    for more in ((), ("--setpoint", "power=5MW"), ("--setpoint", "speed=12.1rpm")):
        assert run(turbine_gains, *more, "--duration", "4", "--json") == 0
        rows.append(json.loads(capsys.readouterr().out)["rows"])
    assert rows[0] == rows[1]
    assert rows[0][0]["energy"] == pytest.approx(rows[2][0]["energy"], rel=1e-9)


def test_torque_below_rated_is_no_fight_of_the_actuators(
    turbine_gains: Path, capsys: Capture
) -> None:
    """The lowest torque is 90 %, and pitch sheds the rest."""
    assert run(turbine_gains, "--setpoint", "power=3.8MW", "--duration", "10", "--json") == 0
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
    given: list[str], words: str, turbine_gains: Path, capsys: Capture
) -> None:
    assert run(turbine_gains, *(word for text in given for word in ("--setpoint", text))) == 2
    assert words in " ".join(capsys.readouterr().err.split())


def test_a_law_that_takes_none_is_refused(
    tmp_path: Path, turbine_gains: Path, capsys: Capture
) -> None:
    """With the cure; a new design has no set-points, and the reference controller takes none."""
    plain = tmp_path / "gains.json"
    plain.write_text(recorded_file(), encoding="utf-8")
    asked = ("--setpoint", "power=4MW")
    for more in (["--law-from", str(plain)], []):
        assert main(["simulate", "nrel5mw", *more, *asked]) == 2
        assert "--lowest-speed-setpoint SPEED" in capsys.readouterr().err
    assert run(turbine_gains, *asked, "--law", "reference") == 2
    assert "leave --law reference out" in " ".join(capsys.readouterr().err.split())
