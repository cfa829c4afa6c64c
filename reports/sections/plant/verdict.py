"""The first screen: the answer in one sentence, the picture of the set, and six tiles."""

from __future__ import annotations

from typing import TYPE_CHECKING

from takagi.reports.page.rounded_bounds import at_least
from takagi.reports.page.text import CaptionedFigure, Section, Tile
from takagi.reports.sections.plant.summary import ALL_OF_RANGE, answer_sentence, summary_rows

if TYPE_CHECKING:
    from takagi.certificates.design.plant.result import PlantDesign

# Row of the summary -> what its tile says where the design has no such row.
TILES = {
    "settles": "no rate is proved",
    "safe start": "no set is proved",
    "disturbance": "the file has none",
    "input": "no bound",
    "margins": "there is no loop",
    "not covered": "",
}
PART = {"follows": "the steps of ", "disturbance": "a varying "}  # before what is proved in part


def verdict_section(design: PlantDesign, picture: CaptionedFigure | None) -> Section:
    """Return the first screen of a plant's report."""
    rows = {row.name: row for row in summary_rows(design)}
    tiles = []
    for name, absent in TILES.items():
        row = rows.get(name)
        if row is None:
            ranged = any(state in design.model.box for state in design.model.states)
            tiles.append(Tile(name, (absent,), partial=ranged and name == "safe start"))
        else:
            basis = row.basis or "proved"
            tiles.append(Tile(name, row.parts, basis, row.regulator, row.partial, row.shortfall))
    content = {
        "verdict": design.checked.verdict.name,
        "sentence": answer_sentence(design),
        "tiles": tiles,
        "picture": picture,
        "parts": [
            f"{at_least(100 * number.share, 2)} % of {PART.get(row.name, '')}{number.quantity}"
            for row in rows.values()
            for number in row.numbers
            if row.partial and number.share is not None and number.share < ALL_OF_RANGE
        ],
        "messages": list(design.checked.messages),
    }
    return Section("verdict", "The answer", content)
