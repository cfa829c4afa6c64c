"""The LaTeX appendix compiles with a stock TeX distribution, and fits its pages."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from takagi.certificates import Claim, Verdict
from takagi.certificates.checker.replay.certificate import concluded
from takagi.models.laws.published.law import PublishedLawName
from takagi.reports.appendix.design_files import appendix_files
from tests.reports.published_designs import with_published_law
from tests.reports.tex_runs import compiled, sound

if TYPE_CHECKING:
    from takagi.certificates import TurbineDesign

pytestmark = pytest.mark.tex

HOSTILE = r"50 % of a_1 & b^2 {x} \input{y} #3 $z$ ~ <|> K\"uhn Kühn"


@pytest.fixture(scope="module")
def design(turbine_design: TurbineDesign) -> TurbineDesign:
    """The default design of the NREL 5-MW turbine."""
    return turbine_design


def paper_design(design: TurbineDesign, name: PublishedLawName) -> TurbineDesign:
    """The same turbine with a published law and a claim of another kind, in hostile words."""
    wide = [[1234567.8901234 + 10 * i + j for j in range(7)] for i in range(7)]
    claim = {"name": HOSTILE, "kind": "other", "P": wide, "words": HOSTILE, "rate": 1e-9}
    checked = concluded([Claim(HOSTILE, Verdict.UNDECIDED, HOSTILE)], [HOSTILE])
    return with_published_law(design, name, document={"claims": [claim]}, checked=checked)


def test_the_default_appendix_compiles(design: TurbineDesign, tmp_path: Path) -> None:
    """The effort-sharing law, with theorem and all tables."""
    sound(compiled(tmp_path, appendix_files(design)))


@pytest.mark.parametrize("law", ["paper", "paper-two-integrators"])
def test_the_published_laws_compile(
    design: TurbineDesign, tmp_path: Path, law: PublishedLawName
) -> None:
    """Other claims, a wide matrix and words full of LaTeX's own characters do no harm."""
    sound(compiled(tmp_path, appendix_files(paper_design(design, law))))


def test_an_open_certificate_compiles(design: TurbineDesign, tmp_path: Path) -> None:
    """Without a proof there is a figure and a paragraph less."""
    claim = Claim("effort-sharing loop", Verdict.UNDECIDED, "wind 3 to 4 m/s: a reason")
    sound(compiled(tmp_path, appendix_files(replace(design, checked=concluded([claim], [])))))


def test_the_body_compiles_inside_a_paper(design: TurbineDesign, tmp_path: Path) -> None:
    """The packages that its first lines name are enough, without hyperref."""
    files = appendix_files(design)
    preamble = (
        r"\documentclass{article}\usepackage{amsmath,amssymb,booktabs,longtable,array,graphicx}"
    )
    files["appendix.tex"] = preamble + (
        "\n\\usepackage[margin=25mm]{geometry}\\begin{document}\\appendix\n"
        "\\input{appendix-body}\n\\end{document}\n"
    )
    sound(compiled(tmp_path, files))
