"""`takagi sweep` through the real command line: status, words, files, and a second run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.sweep import Task
from takagi.certificates.sweep.journal import NAME
from takagi.cli.main import main
from takagi.cli.verbs import sweep as verb
from takagi.cli.verbs.sweep_maps import LAWS, SweptLaw
from tests.certificates.sweep.toy import product

Capture = pytest.CaptureFixture[str]

MODULE = "tests.cli.toy_law"
GRID = ("--over", "x=1,2", "--over", "y=0.1:0.3:3", "--workers", "1")


@pytest.fixture(autouse=True)
def toy_laws(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the verb know laws whose maps cost nothing."""
    known = tuple(SweptLaw(name, MODULE, MODULE) for name in ("paper", "troubled"))
    monkeypatch.setattr(verb, "LAWS", known)


def swept(out: Path, *options: str) -> int:
    """Run the verb on the built-in turbine."""
    return main(["sweep", "nrel5mw", "--out", str(out), *options])


def test_a_sweep_and_its_second_run(tmp_path: Path, capsys: Capture) -> None:
    """All points are answered, status 0; the second run makes none again."""
    assert swept(tmp_path, *GRID) == 0
    first = capsys.readouterr()
    assert first.err == ""
    assert first.out.splitlines()[0] == "published over x (2) x y (3): 6 PROVED"
    assert "map.md" in first.out and (tmp_path / "map.md").read_text() == "6 points\n"
    before = (tmp_path / NAME).read_bytes()
    assert swept(tmp_path, *GRID, "--json") == 0
    data = json.loads(capsys.readouterr().out)
    assert (data["points"], data["resumed"], data["verdicts"]) == (6, 6, {"PROVED": 6})
    assert data["axes"][1] == {"name": "y", "unit": "s", "values": [0.1, 0.2, 0.3]}
    assert data["files"] == [str(tmp_path / "map.md")]
    assert (tmp_path / NAME).read_bytes() == before


def test_an_interrupt_says_how_to_go_on(
    tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Ctrl-C in the middle: status 130, one sentence, and the finished points on disk."""

    def interrupted(task: Task) -> dict[str, Any]:
        if task.at["x"] == 2.0:
            raise KeyboardInterrupt
        return product(task)

    monkeypatch.setattr("tests.cli.toy_law.product", interrupted)
    assert swept(tmp_path, *GRID) == 130
    told = capsys.readouterr().err
    assert "the same command goes on" in told and "Interrupted" in told
    monkeypatch.undo()
    assert len((tmp_path / NAME).read_text().splitlines()) == 4


def test_a_point_that_fails(tmp_path: Path, capsys: Capture) -> None:
    """Status 1 and the point's words; what cannot be is an answer and no failure."""
    assert swept(tmp_path, *GRID, "--law", "troubled") == 1
    told = capsys.readouterr().out
    assert "3 PROVED, 1 UNDECIDED, 2 FAILED" in told
    assert "FAILED at x 2, y 0.1: ZeroDivisionError: a fault" in told


@pytest.mark.parametrize(
    ("options", "parts"),
    [
        (("--law", "papr", *GRID), ["--law papr", "did you mean 'paper'", "paper, troubled"]),
        (("--law", "paper", "--trade-off"), ["--trade-off belongs to --law effort-sharing"]),
        (("--over", "z=1"), ["'z' cannot be swept", "x [m], y [s]"]),
        (("--over", "x=2:1:3"), ["does not increase"]),
        (("--over", "x=1kg"), ["'kg' does not fit"]),
        (("--over", "x=1", "--workers", "0"), ["at least 1"]),
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


def test_a_plant_has_no_map(tmp_path: Path, capsys: Capture) -> None:
    """The refusal is about the model, not about a field of its file."""
    assert main(["sweep", "cart_pole", "--out", str(tmp_path / "out"), *GRID]) == 2
    assert "model cart_pole is a plant" in capsys.readouterr().err


def test_a_foreign_journal(tmp_path: Path, capsys: Capture) -> None:
    """Another turbine's journal is refused with what differs."""
    assert swept(tmp_path, *GRID) == 0
    capsys.readouterr()
    assert main(["sweep", "iea15mw", "--out", str(tmp_path), *GRID]) == 2
    told = capsys.readouterr().err
    assert 'settings.model ("NREL 5-MW" there, "IEA 15-MW' in told


def test_a_file_in_the_way(tmp_path: Path, capsys: Capture) -> None:
    """A folder is needed; a file of that name is told."""
    (tmp_path / "out").write_text("mine")
    assert swept(tmp_path / "out", *GRID) == 2
    assert "out" in capsys.readouterr().err
    assert (tmp_path / "out").read_text() == "mine"


def test_every_law_has_its_modules() -> None:
    """What the table names exists: AXES and build of each map, pages of each law."""
    from importlib import import_module

    for law in LAWS:
        maker = import_module(law.map)
        assert maker.AXES and callable(maker.build)
        assert callable(import_module(law.pages).pages)
