"""What the checker shows of a turbine's claims is compared with what they state, by number."""

from __future__ import annotations

import re
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

campaign: Any = import_module("mutations")
damage: Any = import_module("damage")
judge: Any = import_module("turbine_judge")
Data = dict[str, Any]
LOOP, WIND_RATE, ACTUATORS, RUNNING = range(4)


@pytest.mark.parametrize(
    "shown",
    [
        "overspeed at most 1 %",
        "winds 2 to 25 m/s in 70 cells",
        "inertia 0.8 to 1.1 of nominal",
        "|v - v_s| up to 1 to 2 m/s",
        "settles at no less than 1 1/s in one function, up to 2 1/s by wind cell",
    ],
)
def test_what_is_shown_is_compared(document: Data, shown: str) -> None:
    assert judge.why_shown_false(document, [shown]) != ""


@pytest.mark.slow
def test_the_words_that_are_compared_are_the_checker_s(document: Data, tmp_path: Path) -> None:
    """What the checker shows passes, and does not with one of its numbers changed."""
    path = tmp_path / "certificate.json"
    path.write_text(damage.text_of(document), encoding="utf-8")
    texts = [claim.text for claim in campaign.check(path).claims]

    assert judge.why_shown_false(document, texts) == ""
    for claim, words, number in (
        (LOOP, r"overspeed at most ", "1"),
        (LOOP, r"winds ", "2"),
        (LOOP, r"inertia ", "0.5"),
        (LOOP, r"v_s\| up to ", "9"),
        (LOOP, r"v_s'\| up to ", "9"),
        (LOOP, r"no less than ", "9"),
        (LOOP, r"for all winds, up to ", "9"),
        (WIND_RATE, r"wind filter of ", "0.04"),
        (WIND_RATE, r"overspeed at most ", "1"),
        (WIND_RATE, r"estimate within ", "2.9"),
        (WIND_RATE, r"known to ", "0.05"),
        (WIND_RATE, r"at least ", "0.01"),
        (ACTUATORS, r"pitch moves at most at ", "0.13"),
        (ACTUATORS, r"rad/s, and in ", "71"),
        (ACTUATORS, r"drive's limit of ", "0.1"),
        (ACTUATORS, r"nodes, at most at ", "14000"),
        (ACTUATORS, r"rate, in ", "2"),
        (ACTUATORS, r"v_s''\| is at most ", "9"),
        (ACTUATORS, r"\), and in ", "71"),
        (ACTUATORS, r"turbine's limit of ", "9"),
        (ACTUATORS, r"steps by at most ", "9"),
        (RUNNING, r"a rate of ", "0.005"),
        (RUNNING, r"constant wind from ", "2.9"),
    ):
        changed = re.sub(f"({words})\\S+", rf"\g<1>{number}", texts[claim], count=1)
        assert changed != texts[claim], words
        said = [changed if place == claim else "" for place in range(4)]
        assert judge.why_shown_false(document, said) != "", words
