"""docs/output-feedback.md: its code prints what is shown, its table is that of the list."""

from __future__ import annotations

import re
from pathlib import Path

from tests.lmi.fixed_order.plants import PRINTED, best_of_hifoo, hifoo, names, plant
from tests.test_lmi_guide import blocks, printed

DOCS = Path(__file__).resolve().parents[1] / "docs"
PAGE = (DOCS / "output-feedback.md").read_text(encoding="utf-8")


def rows() -> dict[str, list[str]]:
    """Return the table's cells after the plant's name."""
    table = PAGE.split("<!-- begin table -->")[1].split("<!-- end table -->")[0]
    cells = [
        [cell.strip() for cell in line.strip("|").split("|")]
        for line in table.strip().splitlines()[2:]
    ]
    return {name: rest for name, *rest in cells}


def test_the_code_prints_what_the_page_shows() -> None:
    found = blocks(PAGE)
    for block in found:
        assert printed(block, {}) == block.shown, f"line {block.line}"

    assert len(found) == 1


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
