"""docs/plant-theorems.md does what it says: its code prints what is shown."""

from __future__ import annotations

from pathlib import Path

from tests.test_lmi_guide import blocks, printed

PAGE = Path(__file__).resolve().parents[1] / "docs" / "plant-theorems.md"


def test_every_block_prints_what_the_page_shows() -> None:
    names: dict[str, object] = {}
    found = blocks(PAGE.read_text(encoding="utf-8"))
    for block in found:
        assert printed(block, names) == (block.shown or ""), f"line {block.line}"

    assert len(found) == 2
