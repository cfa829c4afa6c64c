"""`takagi sweep` through the real command line: status, words, files, and a second run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.sweep import sweep as module
from takagi.cli.main import main
from takagi.reports.study import tuning
from takagi.reports.study.tuning import LEVERS, QUANTITIES, requirements_of
from tests.cli.conftest import contents

Capture = pytest.CaptureFixture[str]
GRID = ("--law", "effort-sharing", "--over", "overlap=0.01,0.02", "--over", "inertia=0.1:0.3:3")


def cheap(source: object, inputs: Mapping[str, Any]) -> dict[str, Any]:
    if inputs["at"]["inertia"] > 0.25:
        return {"verdict": "UNDECIDED", "reason": "too much"}
    return {"verdict": "PROVED", "reason": None, "overspeed [%]": 100 * inputs["at"]["overlap"]}


@pytest.fixture(autouse=True)
def cheap_points(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "point", cheap)


def swept(out: Path, *options: str, model: str = "nrel5mw") -> int:
    return main(["sweep", model, "--out", str(out), "--workers", "1", *options])


def test_a_sweep_and_its_second_run(tmp_path: Path, capsys: Capture) -> None:
    """All points are answered, status 0; the second run computes none, with the same bytes."""
    assert swept(tmp_path, *GRID) == 0
    first = capsys.readouterr()
    assert first.err == ""
    head = "effort-sharing over overlap (2) x inertia (3): 4 PROVED, 2 UNDECIDED"
    assert first.out.splitlines()[0] == head
    before = contents(tmp_path)
    assert len(list((tmp_path / "results").iterdir())) == 6
    assert {"map.md", "points.csv", "figures/map.svg"} <= set(before)

    assert swept(tmp_path, *GRID, "--json") == 0
    data = json.loads(capsys.readouterr().out)
    counted = {"PROVED": 4, "UNDECIDED": 2}
    assert (data["points"], data["resumed"], data["verdicts"]) == (6, 6, counted)
    assert data["axes"][1] == {"name": "inertia", "unit": "-", "values": [0.1, 0.2, 0.3]}
    assert all(Path(name).is_file() for name in data["files"])
    assert contents(tmp_path) == before


def test_an_interrupt_says_how_to_go_on(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C in the middle: status 130, one sentence, and the finished points on disk."""

    def interrupted(source: object, inputs: Mapping[str, Any]) -> dict[str, Any]:
        if inputs["at"]["overlap"] == 0.02:
            raise KeyboardInterrupt
        return cheap(source, inputs)

    monkeypatch.setattr(module, "point", interrupted)
    assert swept(tmp_path, *GRID) == 130
    assert "the same command goes on" in capsys.readouterr().err
    assert len(list((tmp_path / "results").iterdir())) == 3
    monkeypatch.setattr(module, "point", cheap)
    assert swept(tmp_path, *GRID) == 0
    assert "3 of 6 points were computed before" in capsys.readouterr().out


def test_another_model_or_law_computes_its_own_points(tmp_path: Path, capsys: Capture) -> None:
    """Results of a study are never those of another one in the same folder."""
    over = ("--law", "effort-sharing", "--over", "inertia=0.1,0.2", "--over", "overlap=0.01")
    for count, model in ((2, "nrel5mw"), (4, "iea15mw")):
        assert swept(tmp_path, *over, model=model) == 0
        assert "computed before" not in capsys.readouterr().out
        assert len(list((tmp_path / "results").iterdir())) == count


def test_a_point_that_fails_is_status_1(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def faulty(source: object, inputs: Mapping[str, Any]) -> dict[str, Any]:
        return {"verdict": "PROVED", "reason": None, "x": 1 / (inputs["at"]["overlap"] - 0.02)}

    monkeypatch.setattr(module, "point", faulty)
    assert swept(tmp_path, *GRID) == 1
    told = capsys.readouterr().out
    assert "3 FAILED, 3 PROVED" in told
    assert "FAILED at overlap 0.02, inertia 0.1: ZeroDivisionError" in told


def test_a_file_in_the_place_of_the_folder_stays(tmp_path: Path) -> None:
    (tmp_path / "out").write_text("mine")
    assert swept(tmp_path / "out", *GRID) == 2
    assert (tmp_path / "out").read_text() == "mine"


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
def cheap_tuning(monkeypatch: pytest.MonkeyPatch) -> None:
    # The tasks find the functions by these names.
    for name, function in (("behaviour", cheap_behaviour), ("proof", cheap_proof)):
        function.__name__ = name
        monkeypatch.setattr(tuning, name, function)


def tune(out: Path, *options: str, model: str = "nrel5mw") -> int:
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
    monkeypatch.setattr(tuning, "proof", not_proved)
    assert tune(tmp_path) == 1
    assert "a wind is not proved" in capsys.readouterr().out


def test_the_front_has_no_point_that_another_betters(tmp_path: Path) -> None:
    tune(tmp_path, "--require", "recovery 30s, travel 0.7")
    data = json.loads((tmp_path / "tuning.json").read_text())
    rows = [[p["values"][q] for q in ("tower-del", "recovery", "travel")] for p in data["front"]]
    for row in rows:
        for other in rows:
            assert not (all(a <= b for a, b in zip(other, row, strict=True)) and other != row)


def test_what_a_requirement_misses() -> None:
    """By scales of the quantity: 0.1 % of energy, 5 s of recovery."""
    energy, recovery = requirements_of("energy >= -0.2 %, recovery 30s, proved")
    assert energy.missed(-0.2) == 0 and energy.missed(-0.4) == pytest.approx(2.0)
    assert recovery.missed(40) == pytest.approx(2.0) and recovery.missed(30) == 0
    assert recovery.missed(float("nan")) == float("inf")


@pytest.mark.slow
def test_the_real_loop(monkeypatch: pytest.MonkeyPatch) -> None:
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
        tuning.behaviour(turbine, {**inputs, "at": at | {"wind-filter": tau}})["values"]
        for tau in (12.0, 4.0)
    )
    assert fast["recovery"] < slow["recovery"]
    assert set(slow) == {quantity.name for quantity in QUANTITIES}
    assert 100 < slow["peak-power"] < 130 and 0.3 < slow["tower-del"] < 2
