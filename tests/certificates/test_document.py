"""The certificate as a file: what is written is what is read, and what is hashed."""

from __future__ import annotations

import json
from typing import Any

import pytest

from takagi.certificates.checker import check_document, read_text
from takagi.certificates.checker.kernel.reader import digest
from takagi.certificates.document.certificate_file import certificate_document, dumps

TEXTS = ["},{", '"},{"', "a\\", '\\"},{', "plain"]


@pytest.mark.parametrize("text", TEXTS)
def test_line_breaks_do_not_enter_texts(text: str) -> None:
    """Rows are written one a line; a text that looks like a seam between rows stays whole."""
    document = {"rows": [{"a": 1}, {"a": text}, {text: 2}]}

    assert json.loads(dumps(document)) == document
    assert dumps(document).count("\n") == 3


def test_hashes_are_those_of_the_file(short: dict[str, Any]) -> None:
    """The hashes in the provenance are what the strict reader computes from the written text."""
    read = read_text(dumps(short), "file")

    for part, found in short["provenance"]["sha256"].items():
        assert digest(read[part]) == found
    assert check_document(json.loads(dumps(short))).verdict is check_document(short).verdict


def test_what_is_no_number_cannot_be_written() -> None:
    """NaN has no place in a certificate."""
    document = certificate_document(model={"a": 1}, gains=None, claims=[], provenance={"b": 1})

    assert document["provenance"]["b"] == 1
    with pytest.raises(ValueError, match="JSON"):
        dumps(document | {"claims": [float("nan")]})
