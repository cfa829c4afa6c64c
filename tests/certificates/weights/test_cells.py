"""Every kind of claim against every kind of weights: what docs/blends.md says."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
import sympy as sp
from numpy.typing import NDArray

from takagi.certificates import Verdict, certify
from takagi.certificates.checker.replay.claim_kinds import READ
from takagi.certificates.requests import FuzzyDecay, H2Norm, L2Gain, ObservedFeedback, ObserverError
from takagi.certificates.requests.request import Request
from takagi.models import ModelError, TSModel, sector_model
from takagi.models.laws.pdc import PdcLaw
from tests.certificates.weights.cells import (
    EVIDENCE,
    cell_document,
    cubic,
    plant_document,
    verdicts,
)
from tests.docs_pages import catalogue
from tests.symbolic_plants import plant_of as symbolic_plant

table = catalogue("catalogue.kinds")


def cells() -> Iterator[tuple[str, str, str]]:
    """Yield (kind, weights, what the page says); a blend needs a plant of its own."""
    for kind, row in table.CELLS.items():
        for form, said in zip(table.COLUMNS, row, strict=False):
            if said != "theorem (8)":
                yield kind, form, said


def test_every_kind_has_a_row() -> None:
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


Floats = NDArray[np.float64]
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


def circular() -> tuple[TSModel, Floats]:
    """Return x' = x + (5 - u^2) u and gains for u = 0 and for |u| = 2."""
    z = sp.Symbol("z", real=True)
    plant = symbolic_plant(
        [x + (5 - u**2) * u],
        [x],
        [u],
        box={x: (-10, 10), u: (-2, 2)},
        premises={z: u**2},
        name="weak",
    )
    model = sector_model(plant)
    weak_at_rest = float(model.B[0, 0, 0]) > 3
    gains = np.array([[[0.3]], [[1.2]]] if weak_at_rest else [[[1.2]], [[0.3]]])
    return model, gains


def test_a_law_cannot_schedule_by_its_own_command() -> None:
    """Blends with the same u^2 in plant and law decay; the law as it is run does not."""
    model, gains = circular()
    law = PdcLaw(model, gains, np.zeros(1), np.zeros(1))

    command = float(law.command([6.5])[0])

    assert abs(command) <= 2
    assert 6.5 + (5 - command**2) * command > 4
    claim = {"kind": "decay", "P": [[1]], "decay_rate": 0.1}
    assert verdicts(plant_document(model, claim, gains)) == ["PROVED", "UNDECIDED"]
    assert verdicts(plant_document(model, claim, [[1.2]])) == ["PROVED", "PROVED"]


def test_white_noise_through_a_secant_embedding() -> None:
    """x' = -x - x^3 + noise: E V' = -2 x^2 - 2 x^4 + 1, so the mean of x^2 is at most 1/2."""
    assert certify(cubic("secants"), claims=[H2Norm(0.7072)]).verdict is Verdict.PROVED
