"""docs/architecture.md: the rooms as they are, and a number that can be followed."""

from __future__ import annotations

import re

import pytest

from tests.docs_pages import ROOT, catalogue, text_of

MOST_STOPS = 25
MOST_ROOT_FILES = 10


def test_every_room_says_what_lies_in_it() -> None:
    rooms = catalogue("catalogue.rooms")
    dumb = [room.path for floor in rooms.FLOORS for room in rooms.rooms(floor) if not room.about]

    assert dumb == []


@pytest.mark.parametrize("floor", ["models", "lmi", "certificates", "reports", "cli"])
def test_few_files_lie_in_the_root_of_a_floor(floor: str) -> None:
    assert len(list((ROOT / floor).glob("*.py"))) <= MOST_ROOT_FILES


def test_one_number_can_be_followed() -> None:
    """Each stop is a file that exists, with a name that occurs in it."""
    text = text_of("architecture.md").partition("## Follow one number")[2]
    stops = re.findall(r"^(\d+)\. `([^`]+)` `([^`]+)`:", text.partition("\n## ")[0], re.MULTILINE)

    assert [int(number) for number, _, _ in stops] == list(range(1, len(stops) + 1))
    assert 15 <= len(stops) <= MOST_STOPS
    for _, place, name in stops:
        content = (ROOT / place).read_text(encoding="utf-8")
        assert re.search(rf"\b{re.escape(name)}\b", content), f"{place} has no {name}"
