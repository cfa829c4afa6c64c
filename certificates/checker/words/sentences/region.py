"""What a claim of kind ``region`` says, proved or not: each part as a set of the plane."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words.loop_words import about
from takagi.certificates.checker.words.rounded import at_least, at_most, exactly

DIGITS = 6


def said(
    name: str, loop: PolytopicLoop, parts: Sequence[tuple[Matrix, Matrix]], fails_at: str = ""
) -> tuple[str, str]:
    """Return name and sentence; a failure names the part and the blend."""
    region = " and ".join(in_words(L, M) for L, M in parts)
    if fails_at:
        return name, f"the inequality of {region} fails at {fails_at}"
    return name, (f"with weights at rest the eigenvalues z of {about(loop)} lie where {region}")


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
