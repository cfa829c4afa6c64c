"""The code blocks of all pages: each command is understood, each block of Python runs in a test.

Commands are parsed by their verbs and not run; what runs them is named by the tests of the pages.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

from takagi.cli import command as cli_command
from takagi.cli.main import main
from takagi.cli.verbs import check as check_verb
from tests.docs_pages import DOCS, ROOT, fenced
from tests.test_pages import CODE

PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted(DOCS.rglob("*.md"))]
# Pages whose Python a test of another file runs, and how many blocks it runs.
ELSEWHERE = {
    "README.md": ("tests/test_readme.py", 1),
    "certificate.md": ("tests/cli/test_certify.py", 1),
    "gain-file.md": ("tests/reports/test_gain_file_alone.py", 2),
    "models.md": ("tests/models/control_systems/test_systems.py", 1),
    "plants.md": ("tests/models/plant/test_plants_page.py", 1),
}


def shell(text: str) -> Iterator[str]:
    """Yield the commands of takagi in blocks of a shell: fenced, or indented by four spaces."""
    indented = re.findall(r"^    (?:\$ )?(takagi .*(?:(?<=\\)\n.*)*)", text, flags=re.MULTILINE)
    for block in [*fenced(text, "sh"), *fenced(text, "bash"), *indented]:
        for line in block.replace("\\\n", " ").splitlines():
            for part in re.split(r"&&|;|\|", line):
                if part.strip().startswith("takagi "):
                    yield part.strip().partition(" < ")[0].partition(" > ")[0]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_command_is_understood(
    page: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cli_command, "guard", lambda work, as_json=False: 0)
    monkeypatch.setattr(check_verb, "_check", lambda options: 0)

    wrong = [
        f"{line}\n{capsys.readouterr().err}"
        for line in shell(page.read_text(encoding="utf-8"))
        if main(shlex.split(line, comments=True)[1:]) != 0
    ]

    assert wrong == []


def test_a_wrong_option_is_noticed(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cli_command, "guard", lambda work, as_json=False: 0)

    assert main(["design", "cart_pole", "--out", "build/x", "--decay-rate", "2"]) == 0
    assert main(["design", "cart_pole", "--out", "build/x", "--decay-speed", "2"]) == 2


def test_every_block_of_python_runs_in_a_test() -> None:
    """A page that gets a block is named here, or in the list of tests/test_pages.py."""
    run = {str(getattr(entry, "values", entry)[0]) for entry in CODE}
    without = []
    for page in PAGES:
        count = len(fenced(page.read_text(encoding="utf-8"), "python"))
        file, blocks = ELSEWHERE.get(page.name, ("", 0))
        if blocks:
            assert page.name in (ROOT / file).read_text(encoding="utf-8")
        if count and page.name not in run and count != blocks:
            without.append(f"{page.name}: {count} blocks, {blocks} of them run")

    assert without == []
