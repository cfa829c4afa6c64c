"""Every kind of claim against every kind of weights: what docs/blends.md says of both checkers."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates.checker.replay.claim_kinds import READ
from takagi.certificates.document.certificate_file import certificate_document
from tests.certificates.weights.cells import EVIDENCE, LAWLESS, column, observed, verdicts

DOCS = Path(__file__).resolve().parents[3] / "docs"


@cache
def table() -> Any:
    """Return the module that makes the page."""
    sys.path.insert(0, str(DOCS))
    try:
        return import_module("catalogue.weights")
    finally:
        sys.path.remove(str(DOCS))


def cells() -> Iterator[tuple[str, str, str]]:
    """Yield (kind, weights, what the page says); a blend needs a plant of its own."""
    for kind, row in table().CELLS.items():
        for form, said in zip(table().COLUMNS, row, strict=False):
            if not (kind == "effort-blend" and said == "theorem (8)"):
                yield kind, form, said


def test_the_page_is_what_the_generator_gives() -> None:
    assert table().page() == (DOCS / "blends.md").read_text(encoding="utf-8")


def test_every_kind_has_a_row() -> None:
    """A new kind of claim has to say what it means for each kind of weights."""
    named = {kind.partition(",")[0] for kind in table().CELLS}

    assert named == READ
    assert set(EVIDENCE) == set(table().CELLS)


@pytest.mark.parametrize(("kind", "form", "said"), list(cells()))
def test_both_checkers_say_what_the_page_says(kind: str, form: str, said: str) -> None:
    """The claim is written by hand, so that it is the checkers which refuse."""
    model, law, before = observed(kind, form, column(form))
    claim = {"name": "cell", "kind": kind.partition(",")[0], **EVIDENCE[kind]}
    gains = None if (kind, form) in LAWLESS else law
    document = certificate_document(
        model=model, gains=gains, claims=[*before, claim], provenance={}
    )

    first, second = verdicts(document)

    if said.startswith("refused"):
        assert first[0] == "REFUSED"
        assert second[0] == "REFUSED" or second[-1] == "NOT REPLAYED"
        return
    wanted = {"disproof": "DISPROVED"}.get(said, "PROVED")
    wanted = "UNDECIDED" if said.startswith("open") else wanted
    assert first[-1] == wanted
    # Ranges of tables are left to the first checker, and a claim's verdict is its own.
    assert second[-1] in ((wanted, "NOT REPLAYED") if form == "tables" else (wanted,))
