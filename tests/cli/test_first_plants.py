"""docs/first-plants.md, followed to the letter: the files, the commands, what they answer."""

from __future__ import annotations

import json
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
    """The plants of the page in a folder of their own; reports are tested elsewhere."""
    from takagi.reports.page.assembly import ReportFiles
    from takagi.reports.sections.plant import page

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


@pytest.mark.slow
def test_the_page_s_commands_do_what_it_says(files: Path, capsys: Capture) -> None:
    """All are proved but the last, which has no answer and writes nothing.

    The summary of the first is the page's, the checker proves every folder again, with its gain
    file and its plant file.
    """
    names = ["cruise", "magnet", "pendulum", "reactor", "stock"]
    assert sorted(path.stem for path in files.glob("*.toml")) == names
    first, *proved, hopeless = commands()
    assert main(first) == 0
    assert re.match(summary(), capsys.readouterr().out)
    for command in proved:
        assert main(command) == 0, command
    assert main(hopeless) == 1
    assert not (files / "build/no").exists()
    for name in names:
        out = files / "build" / name
        found = check(
            out / "certificate.json", gains=out / "gains.json", model=files / f"{name}.toml"
        )
        assert found.verdict is Verdict.PROVED
        assert "Takagi-Sugeno model" in found.claims[0].name


def summary() -> str:
    """Return the page's summary as a pattern; three dots stand for anything."""
    shown = re.search(r"```text\n(.*?)```", PAGE, flags=re.DOTALL)
    assert shown is not None
    return re.escape(shown[1].strip()).replace(r"\.\.\.", "(?s:.*?)")


@pytest.mark.slow
def test_a_large_box_leaves_little_of_it_and_the_summary_says_so(
    files: Path, capsys: Capture
) -> None:
    """The magnet's first try, from 5 to 15 mm; the page's box is not called little."""
    text = (files / "magnet.toml").read_text(encoding="utf-8")
    for small, large in (
        ("[8, 12]", "[5, 15]"),
        ("[0.6, 1.4]", "[0.2, 2.5]"),
        ("0.2, 0.2", "0.5, 0.5"),
    ):
        assert small in text
        text = text.replace(small, large)
    (files / "large.toml").write_text(text, encoding="utf-8")

    told = {}
    for name in ("magnet", "large"):
        assert main(["design", f"{name}.toml", "--out", f"build/{name}", "--json"]) == 0
        told[name] = json.loads(capsys.readouterr().out)["starts_alone"]["delta_z [m]"]
    assert main(["design", "large.toml", "--out", "build/again"]) == 0

    assert "little of the ranges" in " ".join(capsys.readouterr().out.split())
    assert told["large"] < 3e-5 < 3e-4 < told["magnet"] < 2e-3


def test_a_reactor_that_does_not_rest_exactly_is_told_how_to_write_it(
    files: Path, capsys: Capture
) -> None:
    """k0 exp(-E/T) for k exp(E/T0 - E/T): a residual with its unit, and the cure."""
    text = (files / "reactor.toml").read_text(encoding="utf-8")
    plain = text.replace("k*exp(E/T0 - E/T)", "k*exp(-E/T)").replace(
        'value = 1, unit = "1/min", source = "chosen: rate',
        'value = 7.2e10, unit = "1/min", source = "chosen: rate',
    )
    assert plain.count("7.2e10") == 1
    (files / "reactor.toml").write_text(plain, encoding="utf-8")

    assert main(["design", "reactor.toml", "--out", "build"]) == 2
    told = capsys.readouterr().err
    assert "mol/m^3 per second, not 0" in told
    assert "k*exp(b/T0 - b/T)" in told


def test_the_page_s_error_is_what_is_said(files: Path, capsys: Capture) -> None:
    """The unit that is not known, with file, line and field."""
    shown = next(line for line in PAGE.splitlines() if line.startswith("    Error: "))
    path = files / "cruise.toml"
    path.write_text(path.read_text(encoding="utf-8").replace('"N"', '"Newton"'), encoding="utf-8")

    assert main(["design", "cruise.toml", "--out", "build"]) == 2
    assert capsys.readouterr().err.startswith(shown.strip().removesuffix("..."))
