"""The README and the pages it leads to do what they say."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from takagi.cli.main import VERBS, main
from tests.docs_pages import ROOT, fenced

README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]


def test_the_python_example_runs_as_it_stands(tmp_path: Path) -> None:
    (example,) = fenced(README, "python")
    command = [sys.executable, "-c", example]

    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)

    assert (ran.returncode, ran.stdout, ran.stderr) == (0, "Verdict.PROVED\n", "")


@pytest.mark.slow
def test_the_first_plant_is_proved_as_it_stands(tmp_path: Path) -> None:
    (tmp_path / "pendulum.toml").write_text(fenced(README, "toml")[0], encoding="utf-8")

    assert main(["design", str(tmp_path / "pendulum.toml"), "--out", str(tmp_path / "out")]) == 0
    made = (tmp_path / "out/figures/phase.svg").read_text(encoding="utf-8")
    shown = (ROOT / "docs/figures/pendulum-set.svg").read_text(encoding="utf-8")
    assert made.count("<path") == shown.count("<path")


def test_every_verb_is_in_the_table() -> None:
    named = set(re.findall(r"^\| `takagi (\w+)", README, flags=re.MULTILINE))

    assert named == {verb.name for verb in VERBS}


def test_every_option_in_the_pages_exists() -> None:
    ours = "design|certify|report|check|simulate|appendix|models"
    source = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "cli").rglob("*.py"))
    text = (ROOT / "docs" / "cli.md").read_text(encoding="utf-8")
    lines = [line for line in text.splitlines() if re.search(rf"takagi ({ours})|^\| `--", line)]
    options = {name for line in lines for name in re.findall(r"--([a-z][a-z-]+)", line)}

    missing = {n for n in options if f"--{n}" not in source and n.replace("-", "_") not in source}

    assert options and missing == set()


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_link_leads_somewhere(page: Path) -> None:
    """Pages and figures inside the repository."""
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    targets = re.findall(r"\]\(([^)#\s]+)[^)]*\)", text)

    broken = [t for t in targets if "://" not in t and not (page.parent / t).exists()]

    assert broken == []
