"""docs/claims.md does what it says: its code prints what is shown, and it names every kind."""

from __future__ import annotations

from pathlib import Path

import pytest

from takagi.certificates.checker.replay.claim_kinds import KINDS
from tests.test_lmi_guide import blocks, printed

PAGE = Path(__file__).resolve().parents[1] / "docs" / "claims.md"


@pytest.mark.slow
def test_every_block_prints_what_the_page_shows() -> None:
    names: dict[str, object] = {}
    found = blocks(PAGE.read_text(encoding="utf-8"))
    for block in found:
        assert printed(block, names) == (block.shown or ""), f"line {block.line}"

    assert len(found) == 4


def test_every_kind_of_claim_is_on_the_page() -> None:
    page = PAGE.read_text(encoding="utf-8")

    missing = {kind for kind in KINDS if f"`{kind}`" not in page}

    assert missing == set()
