"""The first minute in a console or a notebook: large values show themselves in short."""

from __future__ import annotations

import pytest

from takagi.certificates import certify
from takagi.lmi import pdc
from takagi.models import load_model, sector_model
from takagi.models.plant_files.loader import load_plant

PLANT = load_plant("lorenz")
MODEL = sector_model(PLANT)
DESIGN = pdc(MODEL, decay_rate=0.1)


@pytest.mark.parametrize(
    ("value", "words"),
    [
        (load_model("nrel5mw"), "NREL 5-MW"),
        (PLANT, "Lorenz system"),
        (MODEL, "A=<array 2 x 3 x 3>"),
        (DESIGN, "gains=<array 2 x 1 x 3>"),
        (DESIGN.answer, "candidate"),
        (certify(MODEL, gains=DESIGN.gains), "PROVED"),
    ],
)
def test_a_large_value_is_one_line_and_one_table(value: object, words: str) -> None:
    """Its class and its first members; a notebook shows all members."""
    text = repr(value)
    assert text.startswith(f"{type(value).__name__}(") and words in text
    assert len(text) < 400 and "\n" not in text
    page = value._repr_html_()  # type: ignore[attr-defined]
    assert page.startswith("<table>") and len(page) < 5000
