"""docs/published.md: every number it prints is found again, every test it names exists."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.docs_pages import ROOT, catalogue
from tests.lmi.published.solved import NUMBERS, STATUSES

pytestmark = pytest.mark.numeric

published = catalogue("catalogue.published")
# Found by the tests that are named, from both sides or as a bound, not as one number.
FROM_BOTH_SIDES = {
    "rolmip-massspring-g1-claim",
    "ac15-sof",
    "compleib-sof",
    "dayawansa-martin",
    "dstab-companion",
    "kimlee-3rule-a2",
    "lpj12",
    "tiw-fixedF-basic",
    "truck-trailer",
}


def printed(name: str) -> str:
    (found,) = [problem.found for problem in published.PROBLEMS if problem.name == name]
    return str(found)


@pytest.mark.parametrize("name", NUMBERS)
def test_every_number_is_found_again(name: str) -> None:
    """To a unit of the last digit, or a ten-thousandth; a thousandth is what is promised."""
    texts = re.findall(r"\d+\.\d+", printed(name))
    found = np.atleast_1d(NUMBERS[name]())

    assert len(texts) == len(found)
    for text, value in zip(texts, found, strict=True):
        unit = 10.0 ** -len(text.split(".")[1])
        assert value == pytest.approx(float(text), abs=unit, rel=1e-4)


@pytest.mark.parametrize("name", STATUSES)
def test_every_status_is_found_again(name: str) -> None:
    assert STATUSES[name]() == printed(name)


def test_every_problem_is_held() -> None:
    """By a number, a status or named tests from both sides; or the page says why not."""
    names = {problem.name for problem in published.PROBLEMS}
    untested = {p.name for p in published.PROBLEMS if p.note.startswith("not tested: ")}

    assert len(names) == len(published.PROBLEMS)
    assert names == {*NUMBERS, *STATUSES, *FROM_BOTH_SIDES, *untested}
    assert all(p.found and p.tests for p in published.PROBLEMS if p.name not in untested)


def test_no_row_contradicts_the_whole_collection() -> None:
    """What the paragraph on SDPLIB found by hand is not said to have had no data."""
    said = " ".join(published.COLLECTIONS.split()).split("SDPLIB (Borchers 1999) are solved")[1]
    ranges = re.findall(
        r"(control|hinf)(\d+)(?: to \1(\d+))?", said.split(" the answer is a candidate")[0]
    )
    found = {
        f"sdplib-{name}{k}"
        for name, low, high in ranges
        for k in range(int(low), int(high or low) + 1)
    }
    notes = {p.name: p.note for p in published.PROBLEMS if p.note.startswith("not tested: ")}
    by_hand = {
        name for name, note in notes.items() if "run by hand with the whole collection" in note
    }

    assert {"sdplib-control1", "sdplib-control4", "sdplib-hinf11", "sdplib-hinf14"} <= found
    assert by_hand == notes.keys() & found
    assert by_hand and notes.keys() - by_hand


def test_every_test_that_is_named_exists() -> None:
    sources = [path.read_text(encoding="utf-8") for path in (ROOT / "tests").rglob("test_*.py")]
    there = {name for text in sources for name in re.findall(r"^def (test_\w+)\(", text, re.M)}

    named = {name for problem in published.PROBLEMS for name in problem.tests}

    assert named <= there
