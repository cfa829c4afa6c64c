"""Every pinned expression has the value that stands below it; see ``pins``."""

from __future__ import annotations

import pytest

from tests.certificates.pinned.pins import rooms, sections, value

# Few, so that a campaign of broken lines can run those that matter.
TOGETHER = 20
PINS = {(room, section.heading): section.pins for room in rooms() for section in sections(room)}
PARTS = [(*name, first) for name, pins in PINS.items() for first in range(0, len(pins), TOGETHER)]


@pytest.mark.parametrize(("room", "heading", "first"), PARTS)
def test_it_is_as_pinned(room: str, heading: str, first: int) -> None:
    for expression, pinned in PINS[room, heading][first : first + TOGETHER]:
        assert value(expression) == pinned, expression


def test_every_heading_stands_once() -> None:
    """Two sections of one name would hide one of them."""
    headings = [(room, section.heading) for room in rooms() for section in sections(room)]
    assert len(headings) == len(PINS)
    assert all(PINS.values())
