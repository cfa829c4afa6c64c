"""Every pinned expression has the value that stands below it; see ``pins``.

A test for each room, so that a campaign of broken lines looks at the room's own pins first.
"""

from __future__ import annotations

import pytest

from tests.certificates.pinned.pins import rooms, sections, value

# Few, so that a campaign can run those that matter.
TOGETHER = 12
PINS = {(room, section.heading): section.pins for room in rooms() for section in sections(room)}


def _firsts(pins: list[tuple[str, str]]) -> range:
    return range(0, len(pins), TOGETHER)


def of(room: str) -> pytest.MarkDecorator:
    """Return the parameters of a room's test: headings, and the first of some expressions."""
    parts = [(h, k) for (r, h), pins in PINS.items() if r == room for k in _firsts(pins)]
    return pytest.mark.parametrize(("heading", "first"), parts)


def compare(room: str, heading: str, first: int) -> None:
    for expression, pinned in PINS[room, heading][first : first + TOGETHER]:
        assert value(expression) == pinned, expression


@of("arithmetic")
def test_arithmetic(heading: str, first: int) -> None:
    compare("arithmetic", heading, first)


@of("kernel")
def test_kernel(heading: str, first: int) -> None:
    compare("kernel", heading, first)


@of("kinds")
def test_kinds(heading: str, first: int) -> None:
    compare("kinds", heading, first)


@of("loop")
def test_loop(heading: str, first: int) -> None:
    compare("loop", heading, first)


@of("plant")
def test_plant(heading: str, first: int) -> None:
    compare("plant", heading, first)


@of("replay")
def test_replay(heading: str, first: int) -> None:
    compare("replay", heading, first)


@of("words")
def test_words(heading: str, first: int) -> None:
    compare("words", heading, first)


def test_every_heading_stands_once_in_a_room_that_is_tested() -> None:
    """Two sections of one name would hide one of them."""
    headings = [(room, section.heading) for room in rooms() for section in sections(room)]
    assert len(headings) == len(PINS)
    assert all(PINS.values())
    assert all(f"test_{room}" in globals() for room in rooms())
