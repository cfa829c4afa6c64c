r"""Claims that contain their own matrices: ``quadratic-decay`` and ``no-common-quadratic``.

They are about the vertices ``A``, and ``B`` and ``K`` if present, in the claim itself, in
continuous time.  Otherwise they are the claims ``decay`` and ``no-common-decay``; the second has in
``multiplier_factors`` one L_i for each vertex, Z_i = L_i L_i'.  They have no connection with the
model or the gains of the file, and their sentences say so.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from takagi.certificates.checker.kernel.matrices import read_stack
from takagi.certificates.checker.kernel.reader import Number, member
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Found, Outcome
from takagi.certificates.checker.kinds.decay import check_decay
from takagi.certificates.checker.kinds.no_common_decay import check_no_common_decay
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop


def check_quadratic(claim: Any, _model: Any, _gains: Any, where: str) -> Outcome:
    """Return the verdict on a claim of kind ``quadratic-decay``."""
    loop = _loop(claim, where)
    if "K" not in claim:
        return _of_own(check_decay(claim, loop, where), "own_matrices")
    B, K = read_stack(claim, "B", where), read_stack(claim, "K", where)
    n, m = loop.order, len(B[0].rows[0])
    if not len(K) == len(B) == loop.rules or B[0].shape != (n, m) or K[0].shape != (m, n):
        raise CertificateError(f"{where}: one B, {n} by {m}, and one K per rule are needed")
    found = check_decay(claim, PolytopicLoop(loop.A, B=B, K=K), where)
    return _of_own(found, "own_matrices")


def check_impossibility(claim: Any, _model: Any, _gains: Any, where: str) -> Outcome:
    """Return DISPROVED when the multipliers show that no common P exists, else UNDECIDED."""
    loop = _loop(claim, where)
    factors = member(claim, "multiplier_factors", where)
    if not isinstance(factors, list) or len(factors) != loop.rules:
        raise CertificateError(f"{where}: one of multiplier_factors per vertex is needed")
    listed = [{"blend": Number(i), "factor": L} for i, L in enumerate(factors)]
    found = check_no_common_decay({**claim, "multipliers": listed}, loop, where)
    return _of_own(found, "no_common_quadratic")


def _of_own(found: Outcome, words: str) -> Outcome:
    """Return the outcome with a sentence that says whose matrices these are."""
    return replace(found, words=words) if isinstance(found, Found) else found


def _loop(claim: Any, where: str) -> PolytopicLoop:
    A = read_stack(claim, "A", where)
    if A[0].shape[0] != A[0].shape[1]:
        raise CertificateError(f"{where}.A: square matrices are needed")
    return PolytopicLoop(A)
