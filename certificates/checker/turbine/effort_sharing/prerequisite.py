"""The claim on which another claim of the same file depends; it comes first in the file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.reader import integer, member, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Verdict


def prerequisite_claim(
    claim: Any, data: Any, earlier: Sequence[Outcome], where: str, member_name: str, kind: str
) -> tuple[Any, str]:
    """Return the claim at the place that a member names, and why it is not PROVED; "" if it is.

    Parameters
    ----------
    earlier : the verdicts on the claims before this one; a later one has none yet.
    kind : that the claim must be of.

    Raises
    ------
    CertificateError : there is no such claim before this one, or it is of another kind.
    """
    place = integer(claim, member_name, where)
    if not 0 <= place < len(earlier):
        raise CertificateError(
            f"{where}.{member_name}: {place}; the place of an earlier claim is needed"
        )
    other, outcome = member(data, "claims", "certificate")[place], earlier[place]
    if text(other, "kind", f"claims[{place}]") != kind:
        raise CertificateError(f"{where}.{member_name}: claims[{place}] is not of kind {kind}")
    if outcome.verdict is Verdict.PROVED:
        return other, ""
    return other, f"the claim that it rests on is not proved: {outcome.claim.name}"
