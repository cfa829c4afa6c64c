"""A turbine's wind cells on the page of `takagi explore`: the certificate's and law's numbers."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest

from takagi.certificates import TurbineDesign, Verdict
from takagi.certificates.design.turbine.result import claim_summary
from takagi.models.errors import ModelError
from takagi.reports.explore.books import Book
from takagi.reports.explore.turbine_cells import turbine_book
from takagi.reports.simulation.measured_loop import NOTHING

FOLDER = Path("build/nrel5mw")


@pytest.fixture
def book(turbine_design: TurbineDesign) -> Book:
    return turbine_book(replace(turbine_design, measured=NOTHING), FOLDER)


def test_each_cell_states_no_more_than_the_certificate(
    book: Book, turbine_design: TurbineDesign
) -> None:
    """The wind limits, rounded so that they claim no more; the law's shares sum to one."""
    summary, law = claim_summary(turbine_design), turbine_design.effort_sharing_law
    assert summary is not None and law is not None
    assert len(book.cells) == len(summary.winds) == len(book.axes[0].words)

    for (k,), cell in book.cells.items():
        assert cell["proved"]
        error, rate = [
            float(text) for text in re.findall(r"\d+\.?\d*(?:e-\d+)?", cell["sentence"])
        ][:2]
        assert 0.99 * summary.wind_error[k] <= error <= summary.wind_error[k]
        assert 0.99 * summary.wind_rate[k] <= rate <= summary.wind_rate[k]
        pitch, torque, proportional = ([float(v) for v in row] for row in cell["gains"]["rows"][:3])
        assert [a + b for a, b in zip(pitch, torque, strict=True)] == pytest.approx(
            [1, 1], abs=1e-4
        )
        assert proportional == pytest.approx(law.gains.proportional[k : k + 2], rel=1e-4)


def test_what_is_not_proved_is_not_shown_as_proved(turbine_design: TurbineDesign) -> None:
    """Without the folder's margins there are none; an open claim makes no green badge."""
    first, *others = turbine_design.checked.claims
    claims = [replace(first, verdict=Verdict.UNDECIDED), *others]
    checked = replace(turbine_design.checked, verdict=Verdict.UNDECIDED, claims=claims)
    book = turbine_book(replace(turbine_design, measured=NOTHING, checked=checked), FOLDER)

    assert "Proved wind limit" not in [panel["title"] for panel in book.panels]
    for cell in book.cells.values():
        assert not cell["proved"]
        assert cell["verdict"].startswith("UNDECIDED")
        assert "not proved" in cell["sentence"]
        assert "wind limits" not in [row["name"] for row in cell["rows"]]
        margins = [row for row in cell["rows"] if row["name"] == "margins"]
        assert [row["basis"] for row in margins] == ["linear loop that runs, not proved"]


def test_the_page_of_a_turbine_copies_its_check(book: Book) -> None:
    answer = book.nearest((3,))

    assert (answer["exact"], answer["command"]) == (True, "takagi check build/nrel5mw")
    assert book.progress() == (70, 70)


def test_a_law_without_cells_is_refused(turbine_design: TurbineDesign) -> None:
    document = {**turbine_design.document, "claims": []}
    checked = replace(turbine_design.checked, claims=[])
    with pytest.raises(ModelError, match="no wind cells to turn"):
        turbine_book(replace(turbine_design, document=document, checked=checked), FOLDER)
