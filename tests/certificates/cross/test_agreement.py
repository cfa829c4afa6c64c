"""The checker's and FLINT's decisions on the same certificates."""

from __future__ import annotations

from collections import Counter
from copy import deepcopy

import pytest

from takagi.certificates.checker.replay.claim_kinds import KINDS
from takagi.certificates.cross_check.comparison import cross_checked_document
from tests.certificates.cross.documents import documents, mutants
from tests.certificates.kinds.claims import Data, resealed, verdicts


@pytest.fixture(scope="module", name="documents")
def _documents() -> dict[str, Data]:
    return documents()


def test_every_true_claim_is_seen_by_all(documents: dict[str, Data]) -> None:
    """Every kind about a loop is among them."""
    kinds = set()
    for name, document in documents.items():
        kinds |= {claim["kind"] for claim in document["claims"]}
        compared = cross_checked_document(document)
        assert compared.agrees, (name, compared.text)
        assert {row.first for row in compared.rows} <= {"PROVED", "DISPROVED"}, name
    assert set(KINDS) <= kinds


@pytest.mark.slow
def test_damaged_certificates_are_seen_alike(documents: dict[str, Data], reduced: bool) -> None:
    """Of 5000 damaged ones (reduced: 200) some are still true, some open, some refused: by all."""
    met: Counter[str] = Counter()
    count = 200 if reduced else 5_000
    for change, document in mutants(list(documents.values()), count, seed=1):
        compared = cross_checked_document(document)
        assert compared.agrees, (change, compared.text)
        met.update(row.first for row in compared.rows)

    assert min(met[verdict] for verdict in ("PROVED", "UNDECIDED", "REFUSED")) > 10, met


@pytest.mark.parametrize("lower", ["text", "upper"])
def test_a_law_s_own_weights_sum_to_one(documents: dict[str, Data], lower: str) -> None:
    refused = 0
    for document in documents.values():
        gains = document["gains"]
        if not gains or not gains.get("premises") or len(gains["K"]) < 2:
            continue
        changed = deepcopy(document)
        premise = changed["gains"]["premises"][0]
        premise["lower"] = premise["upper"] if lower == "upper" else "1"
        refused += verdicts(resealed(changed)) == ["REFUSED"]
    assert refused > 3
