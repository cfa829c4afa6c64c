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

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, positive
from takagi.certificates.checker.kernel.reader import listed, read_matrix
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kinds.loop_claim import NOT_DEFINITE, LoopClaim, matrix
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.loop.polytopic_loop import bounded
from takagi.certificates.checker.words.loop_words import about
from takagi.certificates.checker.words.rounded import at_least, at_most, exactly

MOST_PARTS, LARGEST_PART = 8, 4
DIGITS = 6


@dataclass(frozen=True)
class Region(LoopClaim):
    """The eigenvalues of every blend lie in a region of the plane; see the module."""

    asks: ClassVar[tuple[str, ...]] = ("parts",)
    P: Matrix = matrix("n", "n")

    def obligations(self) -> Obligations:
        P, subregions = self.P, list(self.parts())
        yield positive(P, NOT_DEFINITE)
        blends = blends_of(self.loop, self.claim, self.where)
        bounded(len(blends), sum(len(L.rows) for L, _ in subregions) * self.loop.order)
        for blend in blends:
            PG = P @ blend.A
            for L, M in subregions:
                size = range(len(L.rows))
                left_side = Matrix.blocks([
                    [L[a, b] * P + M[a, b] * PG + M[b, a] * PG.T for b in size] for a in size
                ])  # fmt: skip
                yield positive(
                    -left_side, f"the inequality of {part_of_plane(L, M)} fails at {blend.label}"
                )

    def parts(self) -> Iterator[tuple[Matrix, Matrix]]:
        """Yield (L, M) of every part."""
        listed_parts = listed(self.claim, "parts", self.where, 1, MOST_PARTS)
        for i, subregion in enumerate(listed_parts):
            subregion_place = f"{self.where}.parts[{i}]"
            L = read_matrix(subregion, "L", subregion_place)
            M = read_matrix(subregion, "M", subregion_place, (len(L.rows), len(L.rows)))
            if len(L.rows) > LARGEST_PART or not L.is_symmetric:
                raise CertificateError(
                    f"{subregion_place}.L: symmetric, at most {LARGEST_PART} rows, is needed"
                )
            yield L, M

    def sentence(self) -> str:
        region = " and ".join(part_of_plane(L, M) for L, M in self.parts())
        return f"with weights at rest the eigenvalues z of {about(self.loop)} lie where {region}"


def part_of_plane(L: Matrix, M: Matrix) -> str:
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
