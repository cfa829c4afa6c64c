"""`takagi tune` through the real command line: front, verdicts, requirements, a second run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from takagi.cli.main import main
from takagi.reports.study import tuning as module
from takagi.reports.study.tuning import LEVERS, QUANTITIES, requirements_of
from tests.cli.conftest import contents

Capture = pytest.CaptureFixture[str]


def cheap_behaviour(source: str, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """Load falls and recovery grows with the wind filter; a larger bandwidth costs travel."""
    tau, bandwidth = inputs["at"]["wind-filter"], inputs["at"]["bandwidth"]
    values = dict.fromkeys((quantity.name for quantity in QUANTITIES), 0.0)
    values |= {"tower-del": 1 - tau / 100, "recovery": 5 * tau, "travel": bandwidth}
    return {"values": values}


def cheap_proof(source: str, inputs: Mapping[str, Any]) -> dict[str, Any]:
    return {"verdict": "PROVED", "reason": ""}


def not_proved(source: str, inputs: Mapping[str, Any]) -> dict[str, Any]:
    return {"verdict": "UNDECIDED", "reason": "a wind is not proved"}


@pytest.fixture(autouse=True)
def cheap(monkeypatch: pytest.MonkeyPatch) -> None:
    # The tasks find the functions by these names.
    for name, function in (("behaviour", cheap_behaviour), ("proof", cheap_proof)):
        function.__name__ = name
        monkeypatch.setattr(module, name, function)


def tune(out: Path, *options: str, model: str = "nrel5mw") -> int:
    """Run the verb in one process."""
    return main(["tune", model, "--out", str(out), "--workers", "1", "--tries", "60", *options])


def test_the_best_point_lies_at_the_requirement(tmp_path: Path, capsys: Capture) -> None:
    """Recovery 5 tau <= 30 s: tau = 6 s has the least load that is allowed."""
    options = ("--require", "recovery 30s", "--json")
    assert tune(tmp_path, *options) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["met"] and answer["tried"] >= 60
    assert 5.0 < answer["best"]["settings"]["wind-filter"] <= 6.0
    first = contents(tmp_path)
    assert tune(tmp_path, *options) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["best"] == answer["best"] and again["resumed"] > answer["resumed"]
    assert contents(tmp_path) == first


def test_a_requirement_that_none_meets(tmp_path: Path, capsys: Capture) -> None:
    """The nearest PROVED point is printed with what it misses, and the status is 1."""
    assert tune(tmp_path, "--require", "recovery 1s") == 1
    out = capsys.readouterr().out
    assert "recovery is" in out and "takagi design nrel5mw --wind-filter" in out


def test_no_point_is_proved(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    not_proved.__name__ = "proof"
    monkeypatch.setattr(module, "proof", not_proved)
    assert tune(tmp_path) == 1
    assert "a wind is not proved" in capsys.readouterr().out


def test_the_front_has_no_point_that_another_betters(tmp_path: Path) -> None:
    tune(tmp_path, "--require", "recovery 30s, travel 0.7")
    data = json.loads((tmp_path / "tuning.json").read_text())
    rows = [[p["values"][q] for q in ("tower-del", "recovery", "travel")] for p in data["front"]]
    for row in rows:
        for other in rows:
            assert not (all(a <= b for a, b in zip(other, row, strict=True)) and other != row)


@pytest.mark.parametrize(
    ("written", "word"),
    [
        ("energy", "limit"),
        ("energy <= 1 %", "energy takes >="),
        ("recovery 30 %", "recovery takes <="),
        ("tower-del 0.9 s", "no unit"),
        ("recovery 30s, recovery 20s", "twice"),
        ("recovry 30s", "recovery"),
    ],
)
def test_a_requirement_that_says_nothing(
    written: str, word: str, tmp_path: Path, capsys: Capture
) -> None:
    assert tune(tmp_path / "out", "--require", written) == 2
    assert word in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("options", "model"),
    [
        (("--tries", "3"), "nrel5mw"),
        (("--minimise", "towerdel"), "nrel5mw"),
        ((), "cart_pole"),
        (("--seeds", "0"), "nrel5mw"),
    ],
)
def test_misuse(options: tuple[str, ...], model: str, tmp_path: Path, capsys: Capture) -> None:
    assert tune(tmp_path / "out", *options, model=model) == 2
    assert "Error" in capsys.readouterr().err


def test_what_a_requirement_misses() -> None:
    """By scales of the quantity: 0.1 % of energy, 5 s of recovery."""
    energy, recovery = requirements_of("energy >= -0.2 %, recovery 30s, proved")
    assert energy.missed(-0.2) == 0 and energy.missed(-0.4) == pytest.approx(2.0)
    assert recovery.missed(40) == pytest.approx(2.0) and recovery.missed(30) == 0
    assert recovery.missed(float("nan")) == float("inf")


@pytest.mark.slow
def test_the_real_loop(monkeypatch: pytest.MonkeyPatch) -> None:
    """The default beside itself: a slower wind filter recovers later from the step."""
    monkeypatch.undo()
    from takagi.certificates.design.turbine.scale import default_settings
    from takagi.certificates.document.certificate_file import files_sha256
    from takagi.models.turbine.loader import load_turbine, model_files

    turbine = load_turbine("nrel5mw")
    settings = default_settings(turbine)
    at = {lever.option: lever.value(settings) for lever in LEVERS}
    inputs = {
        "files": files_sha256(model_files("nrel5mw")),
        "means": [11.0],
        "seeds": 1,
        "duration": 60.0,
    }
    slow, fast = (
        module.behaviour(turbine, {**inputs, "at": at | {"wind-filter": tau}})["values"]
        for tau in (12.0, 4.0)
    )
    assert fast["recovery"] < slow["recovery"]
    assert set(slow) == {quantity.name for quantity in QUANTITIES}
    assert 100 < slow["peak-power"] < 130 and 0.3 < slow["tower-del"] < 2
