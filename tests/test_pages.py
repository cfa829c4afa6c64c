"""Pages of docs/: code prints what is shown, and what is made from the code is not stale."""

from __future__ import annotations

import re

import pytest

from takagi.certificates.checker.replay.claim_kinds import KINDS
from tests.docs_pages import DOCS, blocks, catalogue, printed, text_of
from tests.lmi.fixed_order.plants import PRINTED, best_of_hifoo, hifoo, names, plant

CODE = [
    pytest.param("claims.md", "", 4, marks=pytest.mark.slow),
    pytest.param("lmi.md", "", 16, marks=pytest.mark.slow),
    ("plant-theorems.md", "", 2),
    ("output-feedback.md", "", 1),
    ("models.md", "How premises are bounded", 3),
]


@pytest.mark.parametrize(("page", "section", "least"), CODE)
def test_every_block_prints_what_the_page_shows(page: str, section: str, least: int) -> None:
    """All blocks in one namespace, in order; a block without output prints nothing."""
    shared: dict[str, object] = {}
    text = text_of(page)
    if section:
        text = text.split(f"\n## {section}\n", 1)[1].split("\n## ", 1)[0]
    found = blocks(text)
    for block in found:
        assert printed(block, shared, page) == (block.shown or ""), f"line {block.line}"

    assert len(found) >= least and len(found) == text.count("\n```python\n")


def test_every_output_stands_below_its_code() -> None:
    """A block of text that no code precedes would be shown and never checked."""
    page = text_of("lmi.md")

    assert sum(block.shown is not None for block in blocks(page)) == page.count("\n```text\n")


@pytest.mark.parametrize("page", catalogue("make_pages").PAGES)
def test_a_page_is_what_its_generator_gives(page: str) -> None:
    """Run ``make docs`` when this fails."""
    assert catalogue("make_pages").PAGES[page]() == (DOCS / page).read_text(encoding="utf-8")


def test_every_kind_of_claim_is_on_the_page() -> None:
    page = text_of("claims.md")

    assert {kind for kind in KINDS if f"`{kind}`" not in page} == set()


def rows() -> dict[str, list[str]]:
    """Return the cells after the plant's name of the table of static output feedback."""
    text = text_of("output-feedback.md")
    table = text.split("<!-- begin table -->")[1].split("<!-- end table -->")[0]
    cells = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in table.strip().splitlines()[2:]
    ]
    return {name: rest for name, *rest in cells}


def test_the_table_has_every_plant_with_hifoos_figures() -> None:
    table = rows()

    assert list(table) == names()
    for name, (sizes, *shown, _, _, _, _) in table.items():
        system = plant(name)
        assert sizes == f"{len(system.A)}, {system.B2.shape[1]}, {len(system.C2)}"
        figures = [f"{value:.5g}" if value is not None else "-" for value in hifoo(name)]
        assert shown == figures


def test_every_bound_is_proved_and_within_five_per_cent() -> None:
    for name, cells in rows().items():
        bound, ratio = cells[3], cells[4]
        found = re.fullmatch(r"(\S+)( \*)?", bound)
        assert found is not None, f"{name}: {bound}"
        gain = float(found[1])
        assert gain <= 1.05 * best_of_hifoo(name) + PRINTED
        if ratio != "both 0":
            assert abs(gain / best_of_hifoo(name) - float(ratio)) < 2e-3
