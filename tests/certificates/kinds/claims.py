"""Certificates of small loops for the tests of kinds: what the checker says about plain data."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from takagi.certificates import CertificateError, Claim
from takagi.certificates.checker import check_document, read_text
from takagi.certificates.checker.kernel.reader import digest
from takagi.certificates.document.certificate_file import certificate_document

Data = dict[str, Any]


def model_data(A: Any, *, sample_time: Any = None, **others: Any) -> Data:
    names = [f"x{i + 1} [-]" for i in range(len(A[0]))]
    kind = {"kind": "takagi-sugeno", "sample_time": sample_time, "state_names": names}
    return {**kind, "A": A, **others}


def law_data(K: Any, *, sample_time: Any = None, **others: Any) -> Data:
    names = [f"x{i + 1} [-]" for i in range(len(K[0][0]))]
    return {"name": "pdc", "sample_time": sample_time, "state_names": names, "K": K, **others}


def sealed(model: Data, gains: Data | None, *claims: Data) -> Data:
    return certificate_document(model=model, gains=gains, claims=list(claims), provenance={})


def said_of(model: Data, gains: Data | None, claim: Data) -> Claim:
    return check_document(sealed(model, gains, claim)).claims[0]


def as_read(data: Any) -> Any:
    """Return plain data as the checker's reader has it: numbers as they are written."""
    return read_text(json.dumps({"data": data}), "document")["data"]


def resealed(document: Data, *further: str) -> Data:
    """Return the document with the hashes of what it now says, as a forger would make them."""
    read = read_text(json.dumps(document), "document")
    hashes = {part: digest(read.get(part)) for part in ("model", "gains", "claims", *further)}
    return document | {"provenance": {"sha256": hashes}}


def verdicts(document: Mapping[str, Any]) -> list[str]:
    """Return the verdict on each claim; REFUSED alone where the file is refused."""
    try:
        return [claim.verdict.name for claim in check_document(document).claims]
    except CertificateError:
        return ["REFUSED"]


def verdict_of(model: Data, gains: Data | None, *claims: Data) -> str:
    """Return the verdict on the last claim; REFUSED where the file is refused."""
    return verdicts(sealed(model, gains, *claims))[-1]
