"""The verdicts of both checkers on all claims of a document."""

from __future__ import annotations

from typing import Any

from takagi.certificates import CertificateError
from takagi.certificates.checker import check_document
from takagi.certificates.cross_check.comparison import cross_checked_document


def verdicts(document: dict[str, Any]) -> list[str]:
    """Return the first checker's verdict on each claim; REFUSED alone where it refuses the file."""
    try:
        return [claim.verdict.name for claim in check_document(document).claims]
    except CertificateError:
        return ["REFUSED"]


def second(document: dict[str, Any]) -> list[str]:
    """Return the same of the second decider."""
    return [row.second for row in cross_checked_document(document).rows]
