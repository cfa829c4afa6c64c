"""docs/ci.md: its commands run, and fail as it says; workflow files: test_ci_workflows."""

from __future__ import annotations

import json
import re
import shlex
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from takagi.cli.main import main
from tests.undrawn import undrawn

Capture = pytest.CaptureFixture[str]
PAGE = (Path(__file__).parents[1] / "docs" / "ci.md").read_text(encoding="utf-8")
PLANT = """
format = 1
kind = "plant"
name = "cart on a spring"

[parameters]
mass = { value = 1, unit = "kg" }
k = { value = 2, unit = "N/m" }
k3 = { value = 0.5, unit = "N/m^3" }

[states]
x = { unit = "m", range = [-1, 1] }
v = { unit = "m/s", range = [-2, 2] }

[inputs]
F = { unit = "N" }

[equations]
x = "v"
v = "(F - k*x + k3*x^3)/mass"
"""


def commands(language: str) -> list[list[str]]:
    """Return the takagi commands of the page's blocks in a language, as arguments."""
    blocks = re.findall(rf"```{language}\n(.*?)```", PAGE, re.DOTALL)
    lines = [line for block in blocks for line in block.splitlines()]
    found = [re.search(r"(?:^|- (?:run: )?|run: )takagi (.*)$", line) for line in lines]
    return [shlex.split(match[1]) for match in found if match]


def shell() -> list[list[str]]:
    """Return the three commands of the page's block for the shell."""
    return commands("sh")


@pytest.fixture(scope="module")
def repository(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A repository as the page wants it: plant, gains and certificate."""
    folder = tmp_path_factory.mktemp("repository")
    (folder / "plant.toml").write_text(PLANT, encoding="utf-8")
    with pytest.MonkeyPatch.context() as patch, undrawn():
        patch.chdir(folder)
        design = re.search(r"^    takagi (design .*)$", PAGE, re.MULTILINE)
        assert design is not None
        assert main(shlex.split(design[1])) == 0
    return folder


@pytest.fixture
def inside(repository: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(repository)
    return repository


@pytest.mark.slow
def test_the_commands_of_the_page_pass(inside: Path) -> None:
    """Three lines, three times status 0, and the reports are there to be read."""
    (inside / "base.json").write_bytes((inside / "build" / "certificate.json").read_bytes())
    assert [command[0] for command in shell()] == ["check", "certify", "compare"]
    for command in shell():
        assert main(command) == 0, command

    suite = ElementTree.parse(inside / "checks.xml").getroot()[0]
    assert suite.get("failures") == "0" and len(suite.findall("testcase")) > 3
    assert json.loads((inside / "checks.sarif").read_text())["runs"][0]["results"] == []
    assert "PROVED" in (inside / "checks.md").read_text()
    assert "nothing got worse" in (inside / "comparison.md").read_text()


def told(edited: Path, old: str, new: str, command: list[str], capsys: Capture) -> tuple[int, str]:
    """Run a command with one file changed; return its status and all that it prints."""
    before = edited.read_text(encoding="utf-8")
    assert old in before
    edited.write_text(before.replace(old, new, 1), encoding="utf-8")
    try:
        status = main(command)
    finally:
        edited.write_text(before, encoding="utf-8")
    printed = capsys.readouterr()
    return status, printed.out + printed.err


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("mass = { value = 1", "mass = { value = 2", "parameters.mass.value is 2 there, 1 in"),
        ("range = [-1, 1]", "range = [-0.5, 1]", "states.x.range[0] is -0.5 there, -1 in"),
        ("- k*x ", "- 3*k*x ", "equations.v is (F - 3*k*x + k3*x^3)/mass there, (F - k*x +"),
        ('name = "cart', 'name = "Cart', "name is Cart on a spring there, cart on a spring in"),
    ],
)
def test_a_changed_model_is_refused_with_what_changed(
    inside: Path, capsys: Capture, old: str, new: str, what: str
) -> None:
    """Status 1, the field and both values, though every proof in the file is right."""
    status, text = told(inside / "plant.toml", old, new, shell()[0], capsys)

    assert status == 1
    assert "not the certificate's model" in text and what in text


def test_a_changed_gain_is_refused_with_both_numbers(inside: Path, capsys: Capture) -> None:
    gains = inside / "build" / "gains.json"
    law = json.loads(gains.read_text())["law"]
    before = gains.read_text()
    first = law["K"][0][0][0]
    law["K"][0][0][0] = 123.5
    gains.write_text(json.dumps({"law": law}))
    try:
        status = main(shell()[0])
    finally:
        gains.write_text(before)

    assert status == 1
    text = capsys.readouterr().err
    assert f"K[0][0][0] is 123.5 there, {first!r} in the certificate" in text


def test_a_worse_design_fails_against_the_baseline(inside: Path, capsys: Capture) -> None:
    (inside / "base.json").write_bytes((inside / "build" / "certificate.json").read_bytes())
    command = [part for part in shell()[1] if part not in ("--gains", "build/gains.json")]

    assert main([*command, "--decay-rate", "0.05"]) == 1

    text = capsys.readouterr().out
    assert "new.json: PROVED" in text and "WORSE" in text
    assert "configuration: decay_rate: nothing -> 0.05" in text
