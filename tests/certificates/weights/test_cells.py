"""Every kind of claim against every kind of weights: what docs/blends.md says."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import pytest
import sympy as sp

from takagi.certificates import certify
from takagi.certificates.checker.replay.claim_kinds import READ
from takagi.certificates.requests import FuzzyDecay, L2Gain, ObservedFeedback, ObserverError
from takagi.certificates.requests.request import Request
from takagi.models import ModelError
from tests.certificates.weights.cells import (
    EVIDENCE,
    cell_document,
    cubic,
    verdicts,
)
from tests.docs_pages import catalogue

table = catalogue("catalogue.kinds")


def cells() -> Iterator[tuple[str, str, str]]:
    """Yield (kind, weights, what the page says); a blend needs a plant of its own."""
    for kind, row in table.CELLS.items():
        for form, said in zip(table.COLUMNS, row, strict=False):
            if said != "theorem (8)":
                yield kind, form, said


def test_every_kind_has_a_row() -> None:
    """A new kind of claim has to say what it means for each kind of weights."""
    named = {kind.partition(",")[0] for kind in table.CELLS}

    assert named == READ
    assert set(EVIDENCE) <= set(table.CELLS)


@pytest.mark.parametrize(("kind", "form", "said"), list(cells()))
def test_the_checker_says_what_the_page_says(kind: str, form: str, said: str) -> None:
    """The claim is written by hand, so that it is the checker which refuses."""
    found = verdicts(cell_document(kind, form))

    if said.startswith("refused"):
        assert found[0] == "REFUSED"
        return
    wanted = {"disproof": "DISPROVED"}.get(said, "PROVED")
    wanted = "UNDECIDED" if said.startswith("open") else wanted
    assert found[-1] == wanted


x, v, u, w = sp.symbols("x v u w", real=True)


@pytest.mark.parametrize(
    ("gains", "request_", "words"),
    [
        # Held at x = 0.9, V = (x - xhat)^2 tends to (2 x^3 / (1 + 3 x^2 + L))^2 = 0.108, not to 0.
        (None, ObserverError([[1.0]]), "they cannot be evaluated; claim it of a sector model"),
        # V = x^2 + 100 e^2 rises at (x, e) = (0.9, 0.3), where every corner says V' < -V.
        ([[1.0]], ObservedFeedback([[1.0]]), "an observer needs the weights"),
        # Of x' = -10 x - x^3, V = (2 - x^2) x^2 has V' = 0 at x = 1; every slope says V' < -3.98 V.
        (None, FuzzyDecay(rate_bounds=22.0), r"P\(h\) needs the weights"),
        # w = 2 brings x to 1, and y = x^2 x to w / 2: more than the 0.3 that every corner shows.
        (None, L2Gain(output=([[[1.0]], [[0.0]]],)), "an output with a matrix for each rule"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_needs_the_weights_is_refused_of_averages_of_slopes(
    gains: Any, request_: Request, words: str
) -> None:
    """Each would be false.  That such a claim is refused is in ``cells``."""
    with pytest.raises(ModelError, match=words):
        certify(cubic("secants"), gains, claims=[request_])
