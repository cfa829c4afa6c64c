"""The claim about the coherent loop that another claim of the same file rests on."""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.kernel.reader import integer, member, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Outcome, Verdict

__all__ = ["earlier_loop"]


def earlier_loop(
    claim: Any, data: Any, found: list[Outcome], where: str
) -> tuple[Any, Outcome | None]:
    """Return the claim whose place in the file ``loop`` names, and its verdict if it is not PROVED.

    Parameters
    ----------
    found : the verdicts on the claims before this one; a later one has none yet.

    Raises
    ------
    CertificateError : there is no such claim before this one, or it is of another kind.
    """
    place = integer(claim, "loop", where)
    if not 0 <= place < len(found):
        raise CertificateError(f"{where}.loop: {place}; the place of an earlier claim is needed")
    loop = member(data, "claims", "certificate")[place]
    if text(loop, "kind", f"claims[{place}]") != "coherent-loop":
        raise CertificateError(f"{where}.loop: claims[{place}] is not of kind coherent-loop")
    if found[place].verdict is not Verdict.PROVED:
        return loop, found[place]
    return loop, None
