"""docs/architecture.md: the rooms as they are, and a number that can be followed."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "architecture.md"
MOST_STOPS = 25
MOST_ROOT_FILES = 10


@pytest.fixture(scope="module")
def rooms() -> Iterator[Any]:
    """The module that makes the list; it lies beside the page, not in the package."""
    sys.path.insert(0, str(ROOT / "docs"))
    try:
        yield import_module("catalogue.rooms")
    finally:
        sys.path.remove(str(ROOT / "docs"))


def test_the_rooms_are_those_of_the_code(rooms: Any) -> None:
    """Run ``make docs`` when this fails."""
    assert rooms.page() == PAGE.read_text(encoding="utf-8")
    picture = ROOT / "docs" / "figures" / "rooms.svg"
    assert rooms.picture() == picture.read_text(encoding="utf-8")


def test_every_room_says_what_lies_in_it(rooms: Any) -> None:
    dumb = [room.path for floor in rooms.FLOORS for room in rooms.rooms(floor) if not room.about]

    assert dumb == []


@pytest.mark.parametrize("floor", ["models", "lmi", "certificates", "reports", "cli"])
def test_few_files_lie_in_the_root_of_a_floor(floor: str) -> None:
    assert len(list((ROOT / floor).glob("*.py"))) <= MOST_ROOT_FILES


def test_one_number_can_be_followed() -> None:
    """Each stop is a file that exists, with a name that occurs in it."""
    text = PAGE.read_text(encoding="utf-8").partition("## Follow one number")[2]
    stops = re.findall(r"^(\d+)\. `([^`]+)` `([^`]+)`:", text.partition("\n## ")[0], re.MULTILINE)

    assert [int(number) for number, _, _ in stops] == list(range(1, len(stops) + 1))
    assert 15 <= len(stops) <= MOST_STOPS
    for _, place, name in stops:
        content = (ROOT / place).read_text(encoding="utf-8")
        assert re.search(rf"\b{re.escape(name)}\b", content), f"{place} has no {name}"
