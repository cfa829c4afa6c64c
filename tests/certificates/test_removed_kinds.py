"""Kinds that earlier versions read: a file with one is refused, and the reader is named."""

from __future__ import annotations

import pytest

from takagi.certificates.checker import CertificateError, check_document
from takagi.certificates.checker.replay.claim_kinds import LAST_READER, NO_LONGER_READ
from takagi.certificates.document import certificate_document
from tests.certificates.kinds.claims import model_data


@pytest.mark.parametrize("kind", sorted(NO_LONGER_READ))
def test_a_removed_kind_is_refused_with_the_commit_that_reads_it(kind: str) -> None:
    """A true claim beside it does not make the file one that is read."""
    claims = [
        {"name": "true", "kind": "decay", "P": [[1]], "decay_rate": 0},
        {"name": "old", "kind": kind},
    ]
    document = certificate_document(
        model=model_data([[[-1]]]), gains=None, claims=claims, provenance={}
    )

    with pytest.raises(CertificateError, match=rf"claims\[1\].*{kind}.*commit {LAST_READER}"):
        check_document(document)
