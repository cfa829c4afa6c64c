r"""``region``: the eigenvalues of every blend, with weights at rest, lie in a region of the plane.

    L (x) P + M (x) (P G) + M' (x) (G'P) < 0,   P > 0

for the closed loop G of every blend and every part {z : L + z M + conj(z) M' < 0} of the region,
L symmetric; the region is the intersection of its parts.  For G v = z v the left side, between
y (x) v on both sides, is (v*Pv) y* (L + z M + conj(z) M') y < 0 for every y.  It is affine in G, so
that blends suffice.

Evidence: ``P``, ``parts`` [{L, M}].  What a part is in words is found from its numbers here.

Source: Chilali and Gahinet (1996), IEEE Trans. Automatic Control 41(3), theorem 2.2.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.family import Family, bounded
from takagi.certificates.checker.kernel.matrices import Matrix, read_matrix
from takagi.certificates.checker.kernel.reader import member, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Verdict
from takagi.certificates.checker.words.shown import at_least, at_most, exactly

__all__ = ["check_region", "in_words"]

Part = tuple[Matrix, Matrix]
DIGITS = 6
MOST_PARTS, LARGEST_PART = 8, 4


def check_region(claim: Any, family: Family, where: str) -> Claim:
    """Return PROVED when every inequality holds, else UNDECIDED with the first that fails."""
    name = text(claim, "name", where)
    P = read_matrix(claim, "P", where, (family.order, family.order))
    parts = _parts(claim, where)
    if not P.is_positive_definite:
        return Claim(name, Verdict.UNDECIDED, "P is not symmetric positive definite")
    blends = family.blends(claim, where)
    bounded(len(blends), sum(len(L.rows) for L, _ in parts) * family.order)
    for blend in blends:
        PG = P @ blend.A
        for L, M in parts:
            if not _left_side(L, M, P, PG).is_positive_definite:
                words = f"the inequality of {in_words(L, M)} fails at {blend.label}"
                return Claim(name, Verdict.UNDECIDED, words)
    region = " and ".join(in_words(L, M) for L, M in parts)
    return Claim(
        name,
        Verdict.PROVED,
        f"with weights at rest the eigenvalues z of {family.about} lie where {region}",
    )


def _left_side(L: Matrix, M: Matrix, P: Matrix, PG: Matrix) -> Matrix:
    """Return the module's left side, negated."""
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


def in_words(L: Matrix, M: Matrix) -> str:
    """Return a part as a set of z, with numbers rounded so that the true set is inside."""
    size = range(len(L.rows))
    low, m = ([[X[i, j] for j in size] for i in size] for X in (L, M))
    if m == [[1]]:
        return f"Re z < {at_most(-low[0][0] / 2, DIGITS)}"
    if m == [[-1]]:
        return f"Re z > {at_least(low[0][0] / 2, DIGITS)}"
    if m == [[0, 1], [0, 0]] and low[0][0] == low[1][1] < 0:
        centre, radius = -low[0][1], at_most(-low[0][0], DIGITS)
        if centre == 0:
            return f"|z| < {radius}"
        return f"|z {'+' if centre < 0 else '-'} {exactly(abs(centre))}| < {radius}"
    diagonal = len(low) == 2 and low[0][0] == low[1][1] and low[0][1] == 0 and m[0][0] == m[1][1]
    if diagonal and m[0][1] == -m[1][0] == 1 and m[0][0] >= 0:
        t, w = m[0][0], -low[0][0] / 2
        if t == 0:
            return f"|Im z| < {at_most(w, DIGITS)}"
        apex = f"{at_most(w, DIGITS)} - " if w else "-"
        return f"|Im z| < {apex}{exactly(t)} Re z"
    return f"L + z M + conj(z) M' < 0 with L = {_shown(low)}, M = {_shown(m)}"


def _shown(rows: list[list[Fraction]]) -> str:
    return str([[str(value) for value in row] for row in rows]).replace("'", "")
