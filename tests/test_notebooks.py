"""docs/notebooks: each runs from top to bottom, is stored without output, and is listed."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

from tests.docs_pages import DOCS
from tests.takagi_tool import path_with_takagi

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
