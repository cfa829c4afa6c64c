"""Claims of kinds that are no longer read: the file is refused, and nothing of it is PROVED.

The documents are made by hand.  Their hashes are right, so it is the kind alone that is refused.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from takagi.certificates import CertificateError, check
from takagi.certificates.checker import check_document
from takagi.certificates.checker.replay.containment import LAST_READER, NO_LONGER_READ
from tests.certificates.kinds.claims import model_data
from tests.certificates.turbine.running_documents import sealed

REMOVED = sorted(NO_LONGER_READ)
SENTENCE = (
    "claims of kind '{}' are no longer read; check this file with takagi at commit "
    f"{LAST_READER}, the last that reads them, or make the certificate again"
)


def document(*kinds: str) -> dict[str, Any]:
    claim = {"name": "by hand", "P": [[1]], "decay_rate": 0.5}
    return sealed({
        "format": "takagi-certificate",
        "version": 1,
        "model": model_data([[[-1]]]),
        "gains": None,
        "claims": [{"kind": kind, **claim} for kind in kinds],
    })  # fmt: skip


def test_the_document_is_proved_with_a_kind_that_is_read() -> None:
    """So the files below are refused for their kinds, not for how they are made."""
    assert check_document(document("decay")).verdict.name == "PROVED"


@pytest.mark.parametrize("kind", REMOVED)
def test_a_file_with_the_kind_is_refused(kind: str, tmp_path: Path) -> None:
    """Also beside a claim that is proved; the sentence names the last commit that reads it."""
    path = tmp_path / "certificate.json"
    for kinds in ((kind,), ("decay", kind)):
        path.write_text(json.dumps(document(*kinds)), encoding="utf-8")
        with pytest.raises(CertificateError) as refused:
            check(path)
        assert SENTENCE.format(kind) in str(refused.value)
        assert str(refused.value).startswith(f"claims[{len(kinds) - 1}].kind: ")
