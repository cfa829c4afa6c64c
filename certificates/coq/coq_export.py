r"""All matrices of a certificate as a file for Coq, whose kernel decides their definiteness.

The matrices are those that the second checker makes of the claims, from the certificate's own
numbers: one theorem for each claim says that so many matrices are positive definite (or
semidefinite), for real vectors.  Coq does not verify that the claim needs exactly these matrices;
only the checkers do.  The file contains the certificate's numbers, and none of its texts.

A positive definite integer matrix M, and a smaller matrix N that proves it: M, s, N.

    N_ij = round(M_ij / (s_i s_j)),    N_ii = floor(M_ii / s_i^2) - (n - 1)

with powers of two s_i.  The rounding error of each entry off the diagonal is at most s_i s_j; the
n - 1 units subtracted on the diagonal cover it: x'Mx >= y'Ny with y_i = s_i x_i.  So M is positive
definite if N is, and N has entries of a few digits if M is not nearly singular.  ``definite.v``
proves this, and Coq's kernel computes with N.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from typing import Any, NamedTuple

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.exact import Definite, Obligations, is_definite
from takagi.certificates.cross_check.kernel.reading import NotReplayed, Refusal
from takagi.certificates.cross_check.opinion import claims_of

# Coq parses a text recursively; a text of about ten thousand characters fits its stack.
LONGEST_TEXT, MOST_IN_ONE = 8_000, 200


@dataclass(frozen=True, slots=True)
class CoqFile:
    """The file's text, and how many matrices each claim has in it.

    ``left_out`` : claims that are not exported, by number, and the reason.
    """

    text: str
    matrices: Mapping[int, int]
    left_out: Mapping[int, str]

    @property
    def count(self) -> int:
        return sum(self.matrices.values())


def coq_file(document: Mapping[str, Any]) -> CoqFile:
    """Return a certificate's matrices as a Coq file.

    Parameters
    ----------
    document : as ``cross_check.kernel.reading.load`` returns it, numbers as they are written.

    Raises
    ------
    Refusal : the file is no certificate, or a matrix of a claim is not definite, so that there is
        no theorem to be written.
    """
    parts = [files("takagi.certificates.coq").joinpath("definite.v").read_text(encoding="utf-8")]
    counts: dict[int, int] = {}
    left_out: dict[int, str] = {}
    for number, (kind, found) in enumerate(claims_of(dict(document)), start=1):
        where = f"claim {number} ({kind if kind.replace('-', '').isalnum() else 'unknown'})"
        strict, weak, reason = _sorted(found, where)
        counts[number] = len(strict) + len(weak)
        if reason:
            left_out[number] = reason
        parts.append(_section(number, where, strict, weak))
    parts.append(_summary(counts))
    return CoqFile("\n".join(parts), counts, left_out)


def _sorted(found: Obligations | None, where: str) -> tuple[list[str], list[str], str]:
    """Return the texts of definite matrices, of semidefinite ones, and what is left out."""
    strict: dict[str, None] = {}
    weak: dict[str, None] = {}
    if found is None:
        return [], [], "no reading of this kind of claim"
    try:
        for one in found:
            if not isinstance(one, Definite):
                if not one.holds:
                    raise Refusal(f"{where}: {one.label} does not hold")
            elif one.strict:
                proof = shorter(one.matrix)
                if proof is None:
                    raise Refusal(f"{where}: {one.label} is not positive definite")
                whole, units, rounded = proof
                row = ",".join(map(str, units)) + ",/;"
                strict[text_of(whole) + row + text_of(rounded)] = None
            else:
                if not is_definite(one.matrix, strict=False):
                    raise Refusal(f"{where}: {one.label} is not positive semidefinite")
                weak[text_of(whole_numbers(one.matrix))] = None
    except (NotReplayed, RecursionError) as reason:
        return list(strict), list(weak), str(reason)
    return list(strict), list(weak), ""


def _section(number: int, where: str, strict: list[str], weak: list[str]) -> str:
    lines = [f"(* {where}: {len(strict)} positive definite, {len(weak)} semidefinite matrices *)"]
    for name, tester, texts in (("strict", "hold", strict), ("weak", "hold_semi", weak)):
        for k, some in enumerate(_pieces(texts), start=1):
            theorem = f"claim_{number}_{name}_{k}"
            lines.append(f'Theorem {theorem} : {tester} {len(some)} "\n' + "\n".join(some))
            lines.append(
                f'"%text.\nProof. apply {tester}_sound. vm_cast_no_check (eq_refl true). Qed.'
            )
    return "\n".join(lines)


def _pieces(texts: list[str]) -> Iterator[list[str]]:
    some: list[str] = []
    size = 0
    for text in texts:
        if some and (size + len(text) > LONGEST_TEXT or len(some) == MOST_IN_ONE):
            yield some
            some, size = [], 0
        some.append(text)
        size += len(text)
    if some:
        yield some


def _summary(counts: Mapping[int, int]) -> str:
    return (
        f"(* {sum(counts.values())} matrices of {len(counts)} claims; equal ones stand once. *)\n"
        "(* What the proof rests on beside Coq's kernel: *)\nPrint Assumptions hold_sound.\n"
    )


BITS = (12, 16, 24, 32, 48, 64, 96, 128, 256, 512, 1024, 4096)
Rows = list[list[int]]


class Shorter(NamedTuple):
    """M over some positive denominator, the units s, and N."""

    matrix: Rows
    units: list[int]
    rounded: Rows


def whole_numbers(matrix: fmpq_mat) -> Rows:
    """Return a positive multiple of a matrix, without fractions."""
    whole, _ = matrix.numer_denom()
    return [[int(whole[i, j]) for j in range(whole.ncols())] for i in range(whole.nrows())]


def shorter(matrix: fmpq_mat) -> Shorter | None:
    """Return M, s and N with N positive definite; None where M is not symmetric and definite."""
    if not is_definite(matrix):
        return None
    whole = whole_numbers(matrix)
    n = len(whole)
    for bits in BITS:
        # If the entries have fewer bits than N should have, all are multiplied by one factor.
        up = max(0, bits - min(whole[i][i].bit_length() for i in range(n)))
        M = [[entry << up for entry in row] for row in whole]
        e = [max(0, (M[i][i].bit_length() - bits) // 2) for i in range(n)]
        N = [[_nearest(M[i][j], e[i] + e[j]) for j in range(n)] for i in range(n)]
        for i in range(n):
            N[i][i] = (M[i][i] >> 2 * e[i]) - (n - 1)
        if is_definite(fmpq_mat([[fmpq(entry) for entry in row] for row in N])):
            return Shorter(M, [1 << k for k in e], N)
    return None


def _nearest(value: int, shift: int) -> int:
    return (value + (1 << shift >> 1)) >> shift


def text_of(rows: Rows) -> str:
    """Return the upper triangle of a symmetric matrix as ``definite.v`` reads it."""
    triangle = (row[i:] for i, row in enumerate(rows))
    return "".join(",".join(map(str, row)) + ",/" for row in triangle) + ";"
