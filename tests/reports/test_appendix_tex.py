"""The LaTeX appendix compiles with a stock TeX distribution, and fits its pages."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import pytest

from takagi.certificates import Claim, Verdict
from takagi.certificates.checker.replay.certificate import concluded
from takagi.models.laws.published.regional_schedule import Variant
from takagi.reports.appendix.turbine import appendix_files
from tests.reports.published_designs import with_published_law
from tests.reports.tex_runs import PAPERS, compiled, sound
from tests.undrawn import few_margins

if TYPE_CHECKING:
    from takagi.certificates import TurbineDesign

pytestmark = pytest.mark.tex

HOSTILE = r"50 % of a_1 & b^2 {x} \input{y} #3 $z$ ~ <|> K\"uhn Kühn"


@pytest.fixture(scope="module")
def design(turbine_design: TurbineDesign) -> TurbineDesign:
    return turbine_design


def paper_design(design: TurbineDesign, variant: Variant) -> TurbineDesign:
    """The same turbine with a published law and a claim of another kind, in hostile words."""
    wide = [[1234567.8901234 + 10 * i + j for j in range(7)] for i in range(7)]
    claim = {"name": HOSTILE, "kind": "other", "P": wide, "words": HOSTILE, "rate": 1e-9}
    checked = concluded([Claim(HOSTILE, Verdict.UNDECIDED, HOSTILE)], [HOSTILE])
    return with_published_law(design, variant, document={"claims": [claim]}, checked=checked)


@pytest.fixture(scope="module", autouse=True)
def _few_margins() -> Iterator[None]:
    """Margins at two winds: the search over all of them takes a minute."""
    with pytest.MonkeyPatch.context() as patch:
        few_margins(patch)
        yield


@pytest.fixture(scope="module")
def files(design: TurbineDesign) -> dict[str, bytes | str]:
    return appendix_files(design)


@pytest.mark.parametrize("paper", PAPERS)
def test_the_default_appendix_compiles(
    files: dict[str, bytes | str], tmp_path: Path, paper: str
) -> None:
    sound(compiled(tmp_path, files, paper))


@pytest.mark.parametrize("variant", ["sector", "saturated"])
def test_the_published_law_compiles(
    design: TurbineDesign, tmp_path: Path, variant: Variant
) -> None:
    sound(compiled(tmp_path, appendix_files(paper_design(design, variant))))


def test_an_open_certificate_compiles(design: TurbineDesign, tmp_path: Path) -> None:
    claims = [
        Claim(one.name, Verdict.UNDECIDED, "wind 3 to 4 m/s: a reason")
        for one in design.checked.claims
    ]
    sound(compiled(tmp_path, appendix_files(replace(design, checked=concluded(claims, [])))))
