"""`takagi design` for plants: from a TOML file to gains, certificate and report, checked again."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from takagi.certificates.checker import Verdict, check
from takagi.cli.main import main
from takagi.models.files.library import data_folder
from tests.undrawn import blank_figures, undrawn

Capture = pytest.CaptureFixture[str]

PENDULUM = """
format = 1
kind = "plant"
name = "Pendulum with a motor"

[states]
theta = { unit = "deg", range = [-60, 60], description = "angle from upright" }
omega = { unit = "rad/s", range = [-4, 4], description = "its rate" }

[inputs]
tau = { unit = "N m", description = "torque of the motor" }

[parameters]
m = { value = 2.0, unit = "kg" }
l = { value = 500, unit = "mm" }
g = { value = 9.81, unit = "m/s^2" }

[equations]
theta = "omega"
omega = "(m*g*l*sin(theta) + tau) / (m*l^2)"
"""
VALVE = Path(__file__).parents[1] / "certificates" / "many_rules" / "tank_with_valve.toml"
TRAILER = (data_folder() / "truck_trailer.toml").read_text(encoding="utf-8")
OSCILLATOR = """
format = 1
kind = "plant"
units = "unchecked"

[states]
x = { range = [-1, 1] }
v = {}

[equations]
x = "v"
v = "-x - x^3 - v"
"""


@pytest.fixture
def pendulum(tmp_path: Path) -> Path:
    path = tmp_path / "pendulum.toml"
    path.write_text(PENDULUM, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("pendulum")
    (place / "pendulum.toml").write_text(PENDULUM, encoding="utf-8")
    with undrawn():
        assert main(["design", str(place / "pendulum.toml"), "--out", str(place / "out")]) == 0
    return place


@pytest.fixture
def drawn() -> None:
    pass


@pytest.fixture(autouse=True)
def mostly_undrawn(request: pytest.FixtureRequest) -> Iterator[None]:
    with nullcontext() if "drawn" in request.fixturenames else undrawn():
        yield


def read(path: Path) -> Any:
    return json.loads(path.read_text(encoding="utf-8"))


def test_a_plant_file_becomes_a_folder_that_the_checker_proves(
    drawn: None, pendulum: Path, tmp_path: Path, capsys: Capture
) -> None:
    """Gains, certificate, report, figures; with both companions the checker has no reservation."""
    out = tmp_path / "out"

    with blank_figures():
        assert main(["design", str(pendulum), "--out", str(out)]) == 0

    printed = capsys.readouterr().out
    answer = printed.split("\n\n", 1)[0].splitlines()
    assert answer[0].startswith("PROVED  Pendulum with a motor") and len(answer) <= 14
    assert max(map(len, answer)) <= 100 and "\x1b" not in printed
    gains = next(line for line in answer if line.split()[0] == "gains")
    assert "N m/rad theta" in gains and "N m s/rad omega" in gains
    names = {"gains.json", "certificate.json", "report.html", "figures", "design.json", "model"}
    assert {path.name for path in out.iterdir()} == names
    checked = check(out / "certificate.json", gains=out / "gains.json", model=pendulum)
    assert checked.verdict is Verdict.PROVED
    assert [claim.verdict for claim in checked.claims] == [Verdict.PROVED] * len(checked.claims)


def test_the_certificate_is_about_the_plant_s_own_equations(finished: Path) -> None:
    """The first claim ties vertices to equations; the file's hash and parameters are recorded."""
    document = read(finished / "out" / "certificate.json")

    assert document["claims"][0]["kind"] == "sector-embedding"
    assert document["model"]["parameters"]["g"] == 9.81
    # What is emitted is what is proved, so it is rounded first: to four digits here.
    gains = np.ravel(document["gains"]["K"])
    assert all(len(repr(float(gain)).replace(".", "").strip("-0")) <= 4 for gain in gains)
    assert document["model"]["model_file"]["parameters"]["g"] == {"value": "9.81", "unit": "m/s^2"}
    assert list(document["provenance"]["files_sha256"]) == ["pendulum.toml"]


@pytest.mark.slow
def test_discrete_time(tmp_path: Path, capsys: Capture) -> None:
    """The truck with a trailer moves in steps of 2 s, and the law says so."""
    path = tmp_path / "trailer.toml"
    path.write_text(TRAILER, encoding="utf-8")

    assert main(["design", str(path), "--out", str(tmp_path / "out"), "--all"]) == 0

    assert "discrete time, T = 2 s" in capsys.readouterr().out
    assert read(tmp_path / "out" / "gains.json")["law"]["sample_time"] == 2.0


def test_a_plant_without_inputs_is_analysed(tmp_path: Path, capsys: Capture) -> None:
    """There are no gains to write; a certificate says that it decays."""
    path = tmp_path / "oscillator.toml"
    path.write_text(OSCILLATOR, encoding="utf-8")

    assert main(["design", str(path), "--out", str(tmp_path / "out")]) == 0

    assert "no inputs: an analysis" in capsys.readouterr().out
    assert not (tmp_path / "out" / "gains.json").exists()
    assert check(tmp_path / "out" / "certificate.json").verdict is Verdict.PROVED


@pytest.mark.slow
def test_the_file_s_own_wishes_and_those_of_the_command_line(
    pendulum: Path, tmp_path: Path
) -> None:
    """[design] asks for 1 1/s; --decay-rate takes its place; each is proved of V' <= -2 alpha V."""
    pendulum.write_text(PENDULUM + "[design]\ndecay_rate = 1\n", encoding="utf-8")
    rates = []
    for name, options in (("file", []), ("line", ["--decay-rate", "3"])):
        out = tmp_path / name
        assert main(["design", str(pendulum), "--out", str(out), *options]) == 0
        document = read(out / "certificate.json")
        (claim,) = (c for c in document["claims"] if c["kind"] == "decay")
        rates.append((document["provenance"]["configuration"]["decay_rate"], claim["decay_rate"]))

    assert [asked for asked, _ in rates] == [1.0, 3.0]
    assert rates[0][1] >= 1.0 and rates[1][1] >= 3.0


def test_limits_of_inputs_are_proved_where_they_are_asked_for(
    pendulum: Path, tmp_path: Path
) -> None:
    """A range of the input, or --input-limit in a unit of one's own: |tau| <= 15 N m is claimed."""
    ranged = PENDULUM.replace('tau = { unit = "N m",', 'tau = { unit = "N m", range = [-15, 15],')
    other = tmp_path / "ranged.toml"
    other.write_text(ranged, encoding="utf-8")
    asked = {str(other): [], str(pendulum): ["--input-limit", "tau=0.015kN m"]}

    for number, (path, options) in enumerate(asked.items()):
        out = tmp_path / f"out{number}"
        assert main(["design", path, "--out", str(out), *options]) == 0
        claims = read(out / "certificate.json")["claims"]
        (limits,) = (c["input_limits"] for c in claims if c["kind"] == "input-limits")
        assert limits == [15.0]


def test_what_no_gains_can_do_is_an_answer(pendulum: Path, tmp_path: Path, capsys: Capture) -> None:
    """2 N m cannot hold 2 kg on 0.5 m from 30 deg: status 1, nothing written, what to relax."""
    options = ["--input-limit", "tau=2", "--initial", "theta=30deg,omega=0.1"]

    assert main(["design", str(pendulum), "--out", str(tmp_path / "out"), *options]) == 1

    message = capsys.readouterr().err
    assert message.startswith("Not proved, nothing written: ")
    assert "--input-limit tau=2" in message and "relax that first" in message
    assert not (tmp_path / "out").exists()


def test_the_answer_for_machines(pendulum: Path, tmp_path: Path, capsys: Capture) -> None:
    """--json: verdict, claims, gains and the files that were written."""
    out = tmp_path / "out"

    assert main(["design", str(pendulum), "--out", str(out), "--json"]) == 0

    answer = json.loads(capsys.readouterr().out)
    assert answer["verdict"] == "PROVED" and answer["rules"] == 2
    assert answer["gains"] == read(out / "gains.json")["law"]["K"]
    assert all(Path(file).is_file() for file in answer["files"])
    rows = {row["name"]: row for row in answer["summary"]}
    theta, omega = rows["safe start"]["numbers"]
    assert (theta["unit"], omega["unit"]) == ("deg", "rad/s")
    assert theta["share"] == pytest.approx(theta["value"] / 60)
    assert theta["value"] == pytest.approx(np.degrees(answer["starts_alone"]["theta [rad]"]))
    assert rows["input"]["proved"] and not rows["margins"]["proved"]


@pytest.mark.slow
def test_the_announcement_goes_to_standard_error(tmp_path: Path, capsys: Capture) -> None:
    """The answer alone is on standard output."""
    asked = ["certify", str(VALVE), "--out", str(tmp_path / "c.json"), "--time", "10s"]
    assert main(asked) == 0
    captured = capsys.readouterr()
    assert captured.err.startswith("takagi: 32 rules by 5 premises")
    assert "Chosen: one gain for all rules" in captured.err
    assert "Chosen" not in captured.out


CUBIC = """
format = 1
kind = "plant"
units = "unchecked"
name = "Cubic"

[states]
x = { range = [-2, 2] }

[inputs]
u = { range = [-1.5, 1.5] }

[equations]
x = "x^3 - x + 2*u"
"""


@pytest.mark.slow
def test_a_polynomial_set_is_larger_than_the_ellipsoid(tmp_path: Path, capsys: Capture) -> None:
    """--safe-start polynomial: its own row, in JSON too; and the file may ask for it instead."""
    file, out = tmp_path / "cubic.toml", tmp_path / "out"
    file.write_text(CUBIC + '\n[design]\nsafe_start = "polynomial"\n', encoding="utf-8")

    with undrawn():
        assert main(["design", str(file), "--out", str(out), "--json"]) == 0

    answer = json.loads(capsys.readouterr().out)
    rows = {row["name"]: row["numbers"][0]["value"] for row in answer["summary"] if row["numbers"]}
    assert rows["polynomial"] > 1.2 * rows["safe start"]
    assert main(["check", str(out), "--cross", "--json"]) == 0
    kinds = [claim["kind"] for claim in read(out / "certificate.json")["claims"]]
    assert kinds.count("attraction-region") == 1


@pytest.mark.parametrize(
    ("text", "options", "words"),
    [
        (PENDULUM, ["--safe-start", "polynomial"], "no polynomial in the states"),
        (TRAILER, ["--safe-start", "polynomial"], "a plant in continuous time"),
        (CUBIC, ["--safe-start", "polynomal"], "did you mean 'polynomial'?"),
    ],
)
def test_a_polynomial_set_that_makes_no_sense(
    text: str, options: list[str], words: str, tmp_path: Path, capsys: Capture
) -> None:
    file = tmp_path / "plant.toml"
    file.write_text(text, encoding="utf-8")

    assert main(["design", str(file), "--out", str(tmp_path / "out"), *options]) == 2

    assert words in capsys.readouterr().err
