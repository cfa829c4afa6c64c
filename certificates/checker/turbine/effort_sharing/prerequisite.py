"""The claim on which another claim of the same file depends; it comes first in the file."""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.kernel.reader import integer, member, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Outcome, Verdict


def prerequisite_claim(
    claim: Any, data: Any, found: list[Outcome], where: str, name: str, kind: str
) -> tuple[Any, Outcome | None]:
    """Return the claim at the place that a member names, and its verdict if it is not PROVED.

    Parameters
    ----------
    found : the verdicts on the claims before this one; a later one has none yet.
    name : of the member;  kind : that the claim must be of.

    Raises
    ------
    CertificateError : there is no such claim before this one, or it is of another kind.
    """
    place = integer(claim, name, where)
    if not 0 <= place < len(found):
        raise CertificateError(f"{where}.{name}: {place}; the place of an earlier claim is needed")
    other = member(data, "claims", "certificate")[place]
    if text(other, "kind", f"claims[{place}]") != kind:
        raise CertificateError(f"{where}.{name}: claims[{place}] is not of kind {kind}")
    if found[place].verdict is not Verdict.PROVED:
        return other, found[place]
    return other, None
