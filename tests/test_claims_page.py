"""The code of docs/claims.md and docs/plant-theorems.md prints what is shown; kinds are named."""

from __future__ import annotations

from pathlib import Path

import pytest

from takagi.certificates.checker.replay.claim_kinds import KINDS
from tests.test_lmi_guide import blocks, printed

DOCS = Path(__file__).resolve().parents[1] / "docs"


@pytest.mark.parametrize(
    ("page", "count"),
    [pytest.param("claims.md", 4, marks=pytest.mark.slow), ("plant-theorems.md", 2)],
)
def test_every_block_prints_what_the_page_shows(page: str, count: int) -> None:
    names: dict[str, object] = {}
    found = blocks((DOCS / page).read_text(encoding="utf-8"))
    for block in found:
        assert printed(block, names) == (block.shown or ""), f"line {block.line}"

    assert len(found) == count


def test_every_kind_of_claim_is_on_the_page() -> None:
    page = (DOCS / "claims.md").read_text(encoding="utf-8")

    assert {kind for kind in KINDS if f"`{kind}`" not in page} == set()
