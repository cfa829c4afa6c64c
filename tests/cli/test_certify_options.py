"""`takagi certify` with --noise or --sample-time: proved, too much of it, misuse."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker import check
from takagi.cli.main import main
from tests.undrawn import undrawn

Capture = pytest.CaptureFixture[str]
NOISY_ROD = """
format = 1
kind = "plant"

[states]
x = { unit = "m", range = [-1, 1] }

[inputs]
u = { unit = "m/s" }

[disturbances]
gust = { unit = "cm/s" }
flow = { unit = "m/s", range = [-0.05, 0.05] }

[parameters]
a = { value = 1.0, unit = "1/s", source = "chosen" }
b = { value = 1.0, unit = "1/(m^2 s)", source = "chosen" }

[equations]
x = "a*x - b*x^3 + u + gust + flow"
"""


@pytest.fixture
def noisy_rod(tmp_path: Path) -> Path:
    path = tmp_path / "rod.toml"
    path.write_text(NOISY_ROD, encoding="utf-8")
    return path


def noisy(out: Path) -> list[dict[str, Any]]:
    claims = json.loads(out.read_text(encoding="utf-8"))["claims"]
    return [claim for claim in claims if claim["kind"] == "exit-probability"]


def test_noise_by_option_and_by_file(noisy_rod: Path, tmp_path: Path, capsys: Capture) -> None:
    """20 cm/s sqrt(s) is 0.2 m/s sqrt(s); flow counts with its whole range; both checkers agree."""
    out = tmp_path / "c.json"
    asked = ["--noise", "gust=20", "--horizon", "1min"]

    assert main(["certify", str(noisy_rod), "--out", str(out), *asked]) == 0
    (claim,) = noisy(out)
    assert claim["noise"] == [0.2, 0.0] and claim["disturbance_bounds"] == [0.0, 0.05]
    assert claim["horizon"] == 60 and claim["probability"] < 0.1
    assert "reaches 1 within 60 s is at most" in capsys.readouterr().out
    assert main(["check", str(out), "--model", str(noisy_rod), "--cross"]) == 0
    assert "they agree" in capsys.readouterr().out

    wanted = "\n[design]\nnoise = { gust = 20 }\nhorizon = 60\n"
    noisy_rod.write_text(NOISY_ROD + wanted, encoding="utf-8")
    build = tmp_path / "build"
    with undrawn():
        assert main(["design", str(noisy_rod), "--out", str(build)]) == 0
    assert noisy(build / "certificate.json")[0]["noise"] == [0.2, 0.0]


def test_noise_that_is_too_much(noisy_rod: Path, tmp_path: Path, capsys: Capture) -> None:
    out = tmp_path / "c.json"

    asked = ["--noise", "gust=5m/s", "--horizon", "600"]
    assert main(["certify", str(noisy_rod), "--out", str(out), *asked]) == 1

    assert "UNDECIDED" in capsys.readouterr().out
    assert [c.verdict.name for c in check(out).claims][-1] != "DISPROVED"
    (claim,) = noisy(out)
    assert "disturbance_bounds" not in claim


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--noise", "gust=1"], "horizon is missing"),
        (["--horizon", "10s"], "noise is missing"),
        (["--noise", "dust=1", "--horizon", "10s"], "there is no dust"),
        (["--noise", "gust=-1", "--horizon", "10s"], "positive"),
        (["--noise", "gust=1", "--horizon", "10m"], "no unit of time"),
        (["--noise", "flow=1", "--horizon", "10s"], "has a range"),
    ],
)
def test_misuse_of_noise(
    noisy_rod: Path, tmp_path: Path, capsys: Capture, options: list[str], words: str
) -> None:
    out = tmp_path / "c.json"
    assert main(["certify", str(noisy_rod), "--out", str(out), *options]) == 2
    assert words in capsys.readouterr().err
    assert not out.exists()


ROD = """
format = 1
kind = "plant"
units = "unchecked"

[states]
x = { range = [-1, 1] }

[inputs]
u = { range = [-4, 4] }

[equations]
x = "x - x^3 + u"
"""


@pytest.fixture
def rod(tmp_path: Path) -> Path:
    path = tmp_path / "rod.toml"
    path.write_text(ROD, encoding="utf-8")
    return path


def sampled(out: Path) -> list[dict[str, Any]]:
    claims = json.loads(out.read_text(encoding="utf-8"))["claims"]
    return [claim for claim in claims if claim["kind"] == "sampled-loop"]


def test_a_sample_time_that_is_proved(rod: Path, tmp_path: Path, capsys: Capture) -> None:
    """By the option, in ms; and by the file, of gains that are designed and then given."""
    out = tmp_path / "c.json"

    assert main(["certify", str(rod), "--out", str(out), "--sample-time", "10ms"]) == 0
    assert [claim["sample_time"] for claim in sampled(out)] == [0.01]
    assert "with a sample every 0.01 s" in capsys.readouterr().out
    assert main(["check", str(out), "--cross"]) == 0
    assert "they agree" in capsys.readouterr().out

    rod.write_text(ROD + "\n[design]\nsample_time = 0.02\n", encoding="utf-8")
    build = tmp_path / "build"
    with undrawn():
        assert main(["design", str(rod), "--out", str(build)]) == 0
    assert [claim["sample_time"] for claim in sampled(build / "certificate.json")] == [0.02]
    gains = ["--gains", str(build / "gains.json")]
    assert main(["certify", str(rod), *gains, "--out", str(out), "--sample-time", "0.03"]) == 0
    assert [claim["sample_time"] for claim in sampled(out)] == [0.03]


def test_a_sample_time_that_is_too_large(rod: Path, tmp_path: Path, capsys: Capture) -> None:
    """UNDECIDED, status 1, with the largest time that was found, which is proved."""
    out = tmp_path / "c.json"

    assert main(["certify", str(rod), "--out", str(out), "--sample-time", "20s"]) == 1

    told = capsys.readouterr().out
    asked, largest = sampled(out)
    assert asked["sample_time"] == 20 and 0.05 < largest["sample_time"] < 20
    assert "the largest time found" in told
    verdicts = {claim.name: claim.verdict.name for claim in check(out).claims}
    assert verdicts[asked["name"]] == "UNDECIDED" and verdicts[largest["name"]] == "PROVED"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["--sample-time", "soon"], "a time such as 10ms is needed"),
        (["--sample-time", "3kg"], "is no unit of time"),
        (["--sample-time", "-1ms"], "a positive number is needed"),
    ],
)
def test_misuse_of_a_sample_time(
    rod: Path, tmp_path: Path, capsys: Capture, arguments: list[str], told: str
) -> None:
    out = tmp_path / "c.json"

    assert main(["certify", str(rod), "--out", str(out), *arguments]) == 2
    assert told in capsys.readouterr().err and not out.exists()


def test_it_is_about_plants(tmp_path: Path, capsys: Capture) -> None:
    out = str(tmp_path / "c.json")

    assert main(["certify", "nrel5mw", "--out", out, "--sample-time", "10ms"]) == 2
    assert "--sample-time is about a plant" in capsys.readouterr().err
