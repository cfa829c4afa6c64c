"""docs/conditions.md is what the conditions say: nothing missing, nothing stale, costs counted."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import pytest

import takagi.lmi
from tests.docs_pages import catalogue, text_of

PAGE = text_of("conditions.md")
SIZES = ((5, 4, 3, 2, 1), (2, 3, 1, 1, 2), (3, 2, 2, 2, 2))


def written(page: str) -> list[str]:
    return re.findall(r"^```math\n(.*?)^```$", page, flags=re.DOTALL | re.MULTILINE)


def test_every_condition_of_the_layer_has_an_entry() -> None:
    """A builder that is added to ``takagi.lmi`` is added to the page."""
    builders = {name for name in dir(takagi.lmi) if name.endswith("_condition")}

    assert {entry.builder for entry in catalogue("catalogue.page").entries()} >= builders


def test_every_call_of_the_page_exists() -> None:
    text = PAGE

    named = set(re.findall(r"`takagi\.lmi\.(\w+)`", text))

    assert named and named <= set(dir(takagi.lmi))


@pytest.mark.parametrize("sizes", SIZES, ids=str)
def test_the_costs_are_those_of_what_is_posed(sizes: tuple[int, ...]) -> None:
    entry_module, counts = catalogue("catalogue.entry"), catalogue("catalogue.formula").counts
    given = dict(zip("rnmpq", sizes, strict=True))
    for entry in catalogue("catalogue.page").entries():
        for case in entry.cases:
            printed = case.sizes != entry_module.GENERAL
            at = case.sizes if printed else entry_module.Sizes(**given)
            letters = {letter: getattr(at, letter) for letter in "rnmpq"}
            lmis, variables = counts(case.pose(at))
            assert eval(case.variables, {}, letters) == variables, (entry.title, case.title)
            if case.lmis:
                assert eval(case.lmis, {}, letters) == lmis, (entry.title, case.title)


def test_a_size_without_a_letter_is_an_error() -> None:
    """A number that stands for nothing named would be printed as if it belonged there."""
    entry, formula = catalogue("catalogue.entry"), catalogue("catalogue.formula").formula
    condition = takagi.lmi.common_lyapunov_condition(entry.plant(entry.GENERAL))

    with pytest.raises(ValueError, match="13 has no letter"):
        formula(condition, entry.Sizes(r=5, n=4, m=3, p=2, q=1))


@pytest.mark.tex
def test_every_formula_compiles_and_fits_a_page(tmp_path: Path) -> None:
    text = catalogue("catalogue.sheet").sheet(PAGE)
    (tmp_path / "sheet.tex").write_text(text, encoding="utf-8")

    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "sheet.tex"]
    ran = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
    log = ran.stdout.decode(errors="replace")

    assert ran.returncode == 0, log[-2000:]
    assert not re.findall(r"Overfull \\hbox", log)
    assert len(written(PAGE)) > 20
