"""docs/tutorial.md and docs/notebooks do what they say, in their order, in an empty folder."""

from __future__ import annotations

import math
import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

from tests.docs_pages import DOCS, fenced, text_of
from tests.takagi_tool import path_with_takagi

PAGE = text_of("tutorial.md")
PART = re.compile(r"```(sh|text|toml)\n(.*?)```", re.DOTALL)
NUMBER = re.compile(r"\d+\.?\d*")
# Of a number whose last digits depend on the processor.
NEAR = 0.05


def ran(command: str, folder: Path) -> str:
    """Return what a line of the shell prints, with the checkout's ``takagi``."""
    tools = folder / "tools"
    tools.mkdir(exist_ok=True)
    script = tools / "takagi"
    script.write_text(
        f'#!/bin/sh\nexec "{sys.executable}" -c '
        '"import sys; from takagi.cli.main import main; sys.exit(main(sys.argv[1:]))" "$@"\n',
        encoding="utf-8",
    )
    script.chmod(0o755)
    env = {**os.environ, "PATH": f"{tools}{os.pathsep}{os.environ['PATH']}", "COLUMNS": "100"}
    done = subprocess.run(
        ["bash", "-c", command],
        cwd=folder,
        env=env,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    return done.stdout


def assert_shows(shown: str, printed: str) -> None:
    """The shown words stand in what is printed, in one piece, and numbers are near."""
    wanted, words = shown.split(), printed.split()
    masked = [NUMBER.sub("#", word) for word in words]
    pattern = [NUMBER.sub("#", word) for word in wanted]
    places = range(len(words) - len(wanted) + 1)
    at = next((k for k in places if masked[k : k + len(wanted)] == pattern), None)
    assert at is not None, printed
    for one, other in zip(wanted, words[at:], strict=False):
        for a, b in zip(NUMBER.findall(one), NUMBER.findall(other), strict=True):
            assert math.isclose(float(a), float(b), rel_tol=NEAR), f"{one} is {other}"


@pytest.mark.slow
def test_every_command_works_and_prints_what_is_shown(tmp_path: Path) -> None:
    printed, counted = "", 0
    for kind, text in PART.findall(PAGE):
        if kind == "sh":
            printed = "".join(ran(line, tmp_path) for line in text.splitlines())
            counted += 1
        elif kind == "text":
            assert_shows(text, printed)

    assert counted == len(fenced(PAGE, "sh")) >= 7


def test_the_file_that_is_shown_is_the_template(tmp_path: Path) -> None:
    ran(fenced(PAGE, "sh")[0], tmp_path)
    written = tomllib.loads((tmp_path / "pendulum.toml").read_text(encoding="utf-8"))

    (shown,) = fenced(PAGE, "toml")
    assert tomllib.loads(shown).items() <= written.items()


FOLDER = DOCS / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))
# What stands in the output of a notebook that has done what its text says.
SHOWN = {
    "own-plant": ("PROVED  Pendulum", "better  faster", "status 1", "pendulum_with_a_motor.c"),
    "wind-turbine": ("PROVED  NREL 5-MW", "rated", "reference"),
    "lmi": ("PROVED PROVED", "infeasible True"),
    "ci-gate": ("takagi.yml: written", "m.value is 2.5 there, 2 in", "WORSE"),
    "appendix": ("appendix.tex: PROVED", "takagitheorem", "report.html: PROVED"),
}


def content_of(notebook: Path) -> Any:
    # The library has no types for this function.
    read: Any = nbformat.read
    return read(notebook, as_version=4)


def test_five_notebooks_are_listed() -> None:
    index = (FOLDER / "index.md").read_text(encoding="utf-8")

    assert sorted(re.findall(r"\(([a-z-]+)\.ipynb\)", index)) == [n.stem for n in NOTEBOOKS]
    assert set(SHOWN) == {notebook.stem for notebook in NOTEBOOKS}


@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_stored_without_output(notebook: Path) -> None:
    content = content_of(notebook)
    nbformat.validate(content)

    for cell in content.cells:
        if cell.cell_type == "code":
            assert cell.outputs == [] and cell.execution_count is None
        else:
            places = re.findall(r"\]\(([^)#]+)", cell.source)
            assert all((FOLDER / place).is_file() for place in places)


@pytest.mark.slow
@pytest.mark.parametrize("notebook", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_runs(notebook: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", path_with_takagi(tmp_path / "tools"))
    monkeypatch.setenv("MPLBACKEND", "agg")
    content = content_of(notebook)
    place = {"metadata": {"path": str(tmp_path)}}

    NotebookClient(content, timeout=1800, kernel_name="python3", resources=place).execute()

    outputs = [output for cell in content.cells for output in cell.get("outputs", [])]
    text = "".join(output.get("text", "") for output in outputs)
    assert [words for words in SHOWN[notebook.stem] if words not in text] == []
