"""The README and the pages it leads to do what they say."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

from takagi.cli.main import VERBS

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]


def code(text: str, language: str) -> list[str]:
    """The fenced blocks of a language."""
    return re.findall(rf"```{language}\n(.*?)```", text, flags=re.DOTALL)


@pytest.mark.parametrize(
    ("number", "output"),
    [(0, "Verdict.PROVED\n"), (1, "2.000 1/s\ninfeasible\nTrue\n0.96875\n")],
)
def test_the_python_examples_run_as_they_stand(number: int, output: str, tmp_path: Path) -> None:
    """Pasted into an empty folder, they print what their comments say."""
    examples = code(README, "python")
    command = [sys.executable, "-c", examples[number]]

    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)

    assert (ran.returncode, ran.stdout, ran.stderr) == (0, output, "")
    assert len(examples) == 2


def test_every_verb_is_in_the_table() -> None:
    """And no verb that does not exist."""
    named = set(re.findall(r"^\| `takagi (\w+)", README, flags=re.MULTILINE))

    assert named == {verb.name for verb in VERBS}


def test_every_option_in_the_pages_exists() -> None:
    """An option that was renamed leaves no trace in the documentation."""
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
