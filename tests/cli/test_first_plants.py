"""docs/first-plants.md, followed to the letter: three files, the commands, what they answer."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from takagi.certificates.checker import Verdict, check
from takagi.cli.main import main

Capture = pytest.CaptureFixture[str]
ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs/first-plants.md").read_text(encoding="utf-8")


@pytest.fixture(autouse=True)
def files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The three plants of the page in a folder of their own; reports are tested elsewhere."""
    from takagi.reports.html.page import ReportFiles
    from takagi.reports.plant import page

    for name, text in re.findall(r"`(\w+\.toml)`:\n\n```toml\n(.*?)```", PAGE, flags=re.DOTALL):
        (tmp_path / name).write_text(text, encoding="utf-8")
    drawn = ReportFiles("<!doctype html><title>report</title>", {})
    monkeypatch.setattr(page, "plant_report_files", lambda *_, **__: drawn)
    monkeypatch.chdir(tmp_path)
    return tmp_path


def commands() -> list[list[str]]:
    """Return the commands of the page, in order."""
    lines = re.findall(r"^    takagi (.*)$", PAGE, flags=re.MULTILINE)
    return [shlex.split(line) for line in lines]


def test_the_page_s_commands_do_what_it_says(files: Path) -> None:
    """All are proved but the last, which has no answer and writes nothing."""
    assert sorted(path.name for path in files.glob("*.toml")) == [
        "cruise.toml",
        "pendulum.toml",
        "stock.toml",
    ]
    *proved, hopeless = commands()
    for command in proved:
        assert main(command) == 0, command
    assert main(hopeless) == 1
    assert not (files / "build/no").exists()


def test_the_checker_proves_every_plant_of_the_page(files: Path) -> None:
    """With its gain file and its plant file."""
    for name in ("pendulum", "cruise", "stock"):
        out = files / "build" / name
        assert main(["design", f"{name}.toml", "--out", str(out)]) == 0
        found = check(
            out / "certificate.json", gains=out / "gains.json", model=files / f"{name}.toml"
        )
        assert found.verdict is Verdict.PROVED
        assert "Takagi-Sugeno model" in found.claims[0].name


def test_the_page_s_error_is_what_is_said(files: Path, capsys: Capture) -> None:
    """The unit that is not known, with file, line and field."""
    shown = next(line for line in PAGE.splitlines() if line.startswith("    Error: "))
    path = files / "cruise.toml"
    path.write_text(path.read_text(encoding="utf-8").replace('"N"', '"Newton"'), encoding="utf-8")

    assert main(["design", "cruise.toml", "--out", "build"]) == 2
    assert capsys.readouterr().err.startswith(shown.strip().removesuffix("..."))
