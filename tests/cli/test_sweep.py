"""`takagi sweep` through the real command line: status, words, files, and a second run."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.sweep import sweep as module
from takagi.cli.main import main
from tests.cli.conftest import contents

Capture = pytest.CaptureFixture[str]
GRID = ("--law", "effort-sharing", "--over", "overlap=0.01,0.02", "--over", "inertia=0.1:0.3:3")


def cheap(source: object, inputs: Mapping[str, Any]) -> dict[str, Any]:
    """A point that costs nothing: more inertia is not proved."""
    if inputs["at"]["inertia"] > 0.25:
        return {"verdict": "UNDECIDED", "reason": "too much"}
    return {"verdict": "PROVED", "reason": None, "overspeed [%]": 100 * inputs["at"]["overlap"]}


@pytest.fixture(autouse=True)
def cheap_points(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "point", cheap)


def swept(out: Path, *options: str, model: str = "nrel5mw") -> int:
    """Run the verb in one process."""
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


@pytest.mark.parametrize(
    ("options", "parts"),
    [
        (("--law", "papr", *GRID[2:]), ["--law papr", "effort-sharing, schulte"]),
        (("--law", "effort-sharing"), ["no axis was given: add --over", "overlap, bandwidth"]),
        (("--law", "effort-sharing", "--over", "inertia=0.1,0.95"), ["at most 0.9"]),
        (("--over", "z=1"), ["'z' cannot be swept", "speed-overlap [rad/s]", "wind [m/s]"]),
        (("--over", "wind=2,8"), ["2 m/s was given", "from 3 to 24.996 m/s"]),
        ((*GRID, "--workers", "0"), ["at least 1"]),
    ],
)
def test_misuse(
    tmp_path: Path, capsys: Capture, options: tuple[str, ...], parts: list[str]
) -> None:
    """One message, status 2, and no folder."""
    assert swept(tmp_path / "out", *options) == 2
    told = capsys.readouterr()
    assert told.out == "" and told.err.startswith("Error: ")
    for part in parts:
        assert part in told.err
    assert not (tmp_path / "out").exists()


def test_what_is_no_turbine_or_no_folder(tmp_path: Path, capsys: Capture) -> None:
    """The refusal is about the model, and a file in the way stays."""
    assert swept(tmp_path / "out", *GRID, model="cart_pole") == 2
    assert "model cart_pole is a plant" in capsys.readouterr().err
    (tmp_path / "out").write_text("mine")
    assert swept(tmp_path / "out", *GRID) == 2
    assert (tmp_path / "out").read_text() == "mine"
