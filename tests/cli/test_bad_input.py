"""Bad input through the real command line: one message, the right status, nothing half-written."""

from __future__ import annotations

import errno
import json
import os
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from takagi.cli.main import main
from takagi.models.files.library import data_folder

Capture = pytest.CaptureFixture[str]


def told(capsys: Capture) -> str:
    captured = capsys.readouterr()
    assert captured.out == "" and "Traceback" not in captured.err
    assert captured.err.startswith(("Error: ", "Not proved, nothing written: "))
    return captured.err


@pytest.fixture
def never(monkeypatch: pytest.MonkeyPatch) -> None:
    def design_turbine(*_: Any, **__: Any) -> None:
        raise AssertionError("the long work began")

    monkeypatch.setattr("takagi.certificates.design.turbine.design.design_turbine", design_turbine)


@pytest.mark.parametrize(
    ("old", "new", "field", "expected"),
    [
        ('unit = "rpm"', 'unit = "rp"', "rotor.rated_speed", "this field accepts"),
        ('unit = "rpm"', 'unit = "kg"', "rotor.rated_speed", "does not fit"),
        ("\nradius", "\nradios", "rotor.radios", "did you mean 'radius'"),
        ("\nradius", "\n# radius", "rotor.radius", "is missing; add\n[rotor]\nradius ="),
        ('power = "nrel5mw_cp.csv"', 'power = "no.csv"', "coefficients.power", "no such file"),
        ('kind = "turbine"', 'kind = "boat"', "kind", 'a turbine: write kind = "turbine"'),
        ("[rotor]", "[rotor", "", "not valid TOML: "),
    ],
)
def test_a_wrong_field_is_named_with_file_and_line(
    never: None, tmp_path: Path, capsys: Capture, old: str, new: str, field: str, expected: str
) -> None:
    """Unit, name, missing figure, missing table, kind, a bracket that is not closed."""
    folder = tmp_path / "mine"
    shutil.copytree(data_folder(), folder, ignore=shutil.ignore_patterns("*.py", "__pycache__"))
    path = folder / "nrel5mw.toml"
    text = path.read_text(encoding="utf-8")
    path.write_text(text.replace(old, new, 1), encoding="utf-8")

    assert main(["design", str(path), "--out", str(tmp_path / "out")]) == 2

    message = told(capsys)
    line = text[: text.index(old)].count("\n") + 1
    assert f"{path}:{line}:" in message if not field else str(path) in message
    assert (not field or repr(field) in message) and expected in message
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_a_requirement_that_cannot_be_met_is_an_answer(tmp_path: Path, capsys: Capture) -> None:
    """A set-point so low that pitch cannot hold it: status 1, the step, and what to relax."""
    options = ["--speed-setpoint", "9.6rpm"]

    assert main(["design", "nrel5mw", "--out", str(tmp_path / "out"), *options]) == 1

    message = told(capsys)
    assert "leaves the table" in message and "raise the speed set-point" in message
    assert "--speed-setpoint 9.6rpm; relax that" in message
    assert not (tmp_path / "out").exists()


def test_an_answer_for_machines_stays_json(
    stable: None, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`--json` prints the reason where it prints the summary."""
    from takagi.models import ModelError

    def design_turbine(*_: Any, tell: Callable[[str], None], **__: Any) -> None:
        tell("gains of the effort-sharing law")
        raise ModelError("no gain at wind 11.4 m/s")

    monkeypatch.setattr("takagi.certificates.design.turbine.design.design_turbine", design_turbine)
    options = ["--out", str(tmp_path / "out"), "--json", "--bandwidth", "4"]

    assert main(["design", "nrel5mw", *options]) == 1

    answer = json.loads(capsys.readouterr().out)
    assert answer["verdict"] == "UNDECIDED" and "wind 11.4 m/s" in answer["reason"]
    assert "--bandwidth 4" in answer["reason"]


@pytest.mark.parametrize(
    ("place", "words"),
    [
        ("gains.json", "a file of this name stands where a folder is needed"),
        # `out/gains.json/` would stop the last step; it stops the first.
        ("", "gains.json: this is a folder"),
    ],
)
def test_a_place_that_is_taken(
    place: str, words: str, never: None, tmp_path: Path, capsys: Capture
) -> None:
    """Told before the long work, and what is there is as it was."""
    taken = tmp_path / "gains.json"
    taken.write_text("mine") if place else taken.mkdir()

    assert main(["design", "nrel5mw", "--out", str(tmp_path / place)]) == 2

    assert words in told(capsys)
    assert taken.read_text() == "mine" if place else taken.is_dir()


@pytest.mark.parametrize(
    ("number", "message"),
    [
        (errno.EROFS, "the file system is read-only; choose another place"),
        (errno.EACCES, "permission denied; check the permissions"),
        (errno.ENOSPC, "the disk is full; free some space"),
    ],
)
def test_a_place_that_refuses_is_told_before_the_long_work(
    never: None,
    tmp_path: Path,
    capsys: Capture,
    monkeypatch: pytest.MonkeyPatch,
    number: int,
    message: str,
) -> None:
    """Read-only, forbidden, full: the folder is named, and nothing is left in it."""

    def refuse(*_: Any, **__: Any) -> None:
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr("takagi.cli.output_place.os.fsync", refuse)

    assert main(["design", "nrel5mw", "--out", str(tmp_path / "out")]) == 2

    written = told(capsys)
    assert message in written and str(tmp_path / "out") in written
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_fills_up_in_the_end_keeps_the_old_files(
    asked: Any, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Full between the first look and the last step: the earlier design is still whole."""
    out = tmp_path / "out"
    out.mkdir()
    (out / "gains.json").write_text("old")

    def refuse(path: Path, content: bytes) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))

    monkeypatch.setattr("takagi.reports.output._write_through", refuse)

    assert main(["design", "nrel5mw", "--out", str(out), "--force"]) == 2

    assert "the disk is full" in told(capsys)
    assert [path.name for path in out.iterdir()] == ["gains.json"]
    assert (out / "gains.json").read_text() == "old"


def test_an_interrupt_leaves_nothing(
    stable: None, tmp_path: Path, capsys: Capture, monkeypatch: pytest.MonkeyPatch
) -> None:
    def design_turbine(*_: Any, **__: Any) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("takagi.certificates.design.turbine.design.design_turbine", design_turbine)

    assert main(["design", "nrel5mw", "--out", str(tmp_path / "out")]) == 130

    assert capsys.readouterr().err == "\nInterrupted.\n"
    assert list(tmp_path.iterdir()) == []


def test_the_installed_command_says_no_more_than_its_message(tmp_path: Path) -> None:
    """A process of its own: the status, one line, no traceback."""
    ran = subprocess.run(
        [sys.executable, "-m", "takagi.cli", "design", "nrel5wm", "--out", "out"],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )

    assert (ran.returncode, ran.stdout, ran.stderr.count("\n")) == (2, "", 1)
    assert ran.stderr.startswith("Error: model 'nrel5wm' is not known")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "arguments",
    [
        ["design", "nrel5wm", "--out", "OUT"],
        ["design", "cart_pole"],
        ["design", "cart_pole", "--out", "OUT", "--bogus"],
        ["check", "OUT"],
        ["check"],
        ["appendix", "OUT", "--out", "OUT"],
    ],
)
def test_errors_for_machines(arguments: list[str], tmp_path: Path, capsys: Capture) -> None:
    """With --json the reason is an object on standard output, also of an option not known."""
    given = [str(tmp_path / "out") if word == "OUT" else word for word in arguments]

    assert main([*given, "--json"]) == 2
    printed = capsys.readouterr()
    answer = json.loads(printed.out)
    assert answer["status"] == 2 and printed.err == f"Error: {answer['error']}\n"
