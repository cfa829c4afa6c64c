"""Every pinned expression has the value that stands below it; see ``pins``."""

from __future__ import annotations

import pytest

from tests.certificates.pinned.pins import rooms, sections, value

SECTIONS = [(room, section.heading) for room in rooms() for section in sections(room)]
PINS = {(room, section.heading): section.pins for room in rooms() for section in sections(room)}


@pytest.mark.parametrize(("room", "heading"), SECTIONS)
def test_it_is_as_pinned(room: str, heading: str) -> None:
    for expression, pinned in PINS[room, heading]:
        assert value(expression) == pinned, expression


def test_every_heading_stands_once() -> None:
    """Two sections of one name would hide one of them."""
    assert len(SECTIONS) == len(PINS)
    assert all(section.pins for room in rooms() for section in sections(room))
