"""Certificates about the running loop that were changed: hashes made again, and both verdicts."""

from __future__ import annotations

import json
from typing import Any

from takagi.certificates import CertificateError
from takagi.certificates.checker import check_document, read_text
from takagi.certificates.checker.kernel.reader import digest
from takagi.certificates.cross_check import Refusal, judge_document


def sealed(document: dict[str, Any]) -> dict[str, Any]:
    """Return the document with the hashes of what it now says."""
    read = read_text(json.dumps(document), "document")
    parts = ("model", "gains", "claims", "controller")
    return document | {"provenance": {"sha256": {part: digest(read.get(part)) for part in parts}}}


def verdicts(document: dict[str, Any]) -> tuple[str, str]:
    """Return what both checkers say; "refused" where one does not read the file to its end."""
    whole = sealed(document)
    try:
        first = check_document(whole).verdict.name
    except CertificateError:
        first = "refused"
    try:
        second = judge_document(whole)[0].verdict
    except Refusal:
        second = "refused"
    return first, second
