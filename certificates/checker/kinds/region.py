r"""``region``: the eigenvalues of every blend, for constant weights, lie in a region of the plane.

    L (x) P + M (x) (P G) + M' (x) (G'P) < 0,   P > 0

for the closed loop G of every blend and every part {z : L + z M + conj(z) M' < 0} of the region,
with L symmetric.  The region is the intersection of its parts.  Let G v = z v: the left side,
multiplied by y (x) v from both sides, is (v*Pv) y* (L + z M + conj(z) M') y < 0 for every y, so
that z lies in the part.  The condition is affine in G, so that blends suffice.

Evidence: ``P``, ``parts`` [{L, M}].  The description of a part in words is derived from its
numbers.

Source: Chilali and Gahinet (1996), IEEE Trans. Automatic Control 41(3), theorem 2.2.
"""

from __future__ import annotations

from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix, read_matrix
from takagi.certificates.checker.kernel.reader import member, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, bounded

Part = tuple[Matrix, Matrix]
MOST_PARTS, LARGEST_PART = 8, 4


def check_region(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return PROVED when every inequality holds, else UNDECIDED with the first that fails."""
    name = text(claim, "name", where)
    P = read_matrix(claim, "P", where, (loop.order, loop.order))
    parts = _parts(claim, where)
    if not P.is_positive_definite:
        return Claim(name, Verdict.UNDECIDED, "P is not symmetric positive definite")
    blends = blends_of(loop, claim, where)
    bounded(len(blends), sum(len(L.rows) for L, _ in parts) * loop.order)
    for blend in blends:
        PG = P @ blend.A
        for L, M in parts:
            if not _left_side(L, M, P, PG).is_positive_definite:
                said = {"name": name, "loop": loop, "parts": [(L, M)]}
                return Found(Verdict.UNDECIDED, "region", said | {"fails_at": blend.label})
    return Found(Verdict.PROVED, "region", {"name": name, "loop": loop, "parts": parts})


def _left_side(L: Matrix, M: Matrix, P: Matrix, PG: Matrix) -> Matrix:
    """Return the negative of the left side of the module's formula."""
    size = range(len(L.rows))
    GP = PG.T
    return -Matrix.blocks([[L[a, b] * P + M[a, b] * PG + M[b, a] * GP for b in size] for a in size])


def _parts(claim: Any, where: str) -> list[Part]:
    listed = member(claim, "parts", where)
    if not isinstance(listed, list) or not 0 < len(listed) <= MOST_PARTS:
        raise CertificateError(f"{where}.parts: a list of 1 to {MOST_PARTS} parts is needed")
    found = []
    for i, part in enumerate(listed):
        place = f"{where}.parts[{i}]"
        L = read_matrix(part, "L", place)
        k = len(L.rows)
        M = read_matrix(part, "M", place, (k, k))
        if k > LARGEST_PART or not L.is_symmetric:
            raise CertificateError(f"{place}.L: symmetric, at most {LARGEST_PART} rows, is needed")
        found.append((L, M))
    return found
