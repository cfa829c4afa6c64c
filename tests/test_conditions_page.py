"""docs/conditions.md is what the conditions say: nothing missing, nothing stale, costs counted."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

import takagi.lmi

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE = DOCS / "conditions.md"
SIZES = ((5, 4, 3, 2, 1), (2, 3, 1, 1, 2), (3, 2, 2, 2, 2))


@pytest.fixture(scope="module")
def catalogue() -> Iterator[Any]:
    """The modules that make the page, by name; they lie beside it, not in the package."""
    sys.path.insert(0, str(DOCS))
    try:
        yield lambda name: import_module(f"catalogue.{name}")
    finally:
        sys.path.remove(str(DOCS))


def written(page: str) -> list[str]:
    """The formulas of a page."""
    return re.findall(r"^```math\n(.*?)^```$", page, flags=re.DOTALL | re.MULTILINE)


def test_the_page_is_what_the_generator_gives(catalogue: Any) -> None:
    """Run ``make docs`` when this fails."""
    assert catalogue("page").page() == PAGE.read_text(encoding="utf-8")


def test_every_condition_of_the_layer_has_an_entry(catalogue: Any) -> None:
    """A builder that is added to ``takagi.lmi`` is added to the page."""
    builders = {name for name in dir(takagi.lmi) if name.endswith("_condition")}

    assert {entry.builder for entry in catalogue("page").entries()} >= builders


def test_every_call_of_the_page_exists(catalogue: Any) -> None:
    """What is renamed leaves no trace on the page."""
    text = PAGE.read_text(encoding="utf-8")

    named = set(re.findall(r"`takagi\.lmi\.(\w+)`", text))

    assert named and named <= set(dir(takagi.lmi))


@pytest.mark.parametrize("sizes", SIZES, ids=str)
def test_the_costs_are_those_of_what_is_posed(catalogue: Any, sizes: tuple[int, ...]) -> None:
    """Each expression in r, n, m, p, q, at sizes other than those that are printed."""
    entry_module, counts = catalogue("entry"), catalogue("formula").counts
    given = dict(zip("rnmpq", sizes, strict=True))
    for entry in catalogue("page").entries():
        for case in entry.cases:
            printed = case.sizes != entry_module.GENERAL
            at = case.sizes if printed else entry_module.Sizes(**given)
            letters = {letter: getattr(at, letter) for letter in "rnmpq"}
            lmis, variables = counts(case.pose(at))
            assert eval(case.variables, {}, letters) == variables, (entry.title, case.title)
            if case.lmis:
                assert eval(case.lmis, {}, letters) == lmis, (entry.title, case.title)


def test_a_size_without_a_letter_is_an_error(catalogue: Any) -> None:
    """A number that stands for nothing named would be printed as if it belonged there."""
    entry, formula = catalogue("entry"), catalogue("formula").formula
    condition = takagi.lmi.common_lyapunov_condition(entry.plant(entry.GENERAL))

    with pytest.raises(ValueError, match="13 has no letter"):
        formula(condition, entry.Sizes(r=5, n=4, m=3, p=2, q=1))


@pytest.mark.slow
def test_the_command_notices_a_stale_page(tmp_path: Path) -> None:
    """``--check`` is 0 for the page as it lies there."""
    command = [sys.executable, str(DOCS / "make_pages.py"), "--check"]

    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)

    assert (ran.returncode, ran.stderr) == (0, "")


@pytest.mark.tex
def test_every_formula_compiles_and_fits_a_page(catalogue: Any, tmp_path: Path) -> None:
    """pdflatex on a landscape page: no error, and no line wider than the text."""
    text = catalogue("sheet").sheet(PAGE.read_text(encoding="utf-8"))
    (tmp_path / "sheet.tex").write_text(text, encoding="utf-8")

    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "sheet.tex"]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
    log = ran.stdout.decode(errors="replace")

    assert ran.returncode == 0, log[-2000:]
    assert not re.findall(r"Overfull \\hbox", log)
    assert len(written(PAGE.read_text(encoding="utf-8"))) > 40
