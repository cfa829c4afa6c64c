r"""All matrices of a certificate as a file for Coq, whose kernel decides their definiteness.

The matrices are the obligations of the claims, from the certificate's own numbers: theorems for
each claim say that so many matrices are positive definite (or semidefinite), for real vectors.  Coq
does not verify that the claim needs exactly these matrices; only the checker does.  The file
contains the certificate's numbers, and none of its texts.

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
from pathlib import Path
from typing import NamedTuple

from flint import fmpz_mat

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Inequality, Obligation, Relation
from takagi.certificates.checker.kernel.reader import read_json
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.checker.replay.certificate import check
from takagi.certificates.cross_check.comparison import is_definite

# Coq parses a text recursively; a text of about ten thousand characters fits its stack.
LONGEST_TEXT, MOST_IN_ONE = 8_000, 200


@dataclass(frozen=True, slots=True)
class CoqFile:
    """The file's text, and how many matrices each claim has in it."""

    text: str
    matrices: Mapping[int, int]

    @property
    def count(self) -> int:
        return sum(self.matrices.values())


def coq_file(certificate: Path) -> CoqFile:
    """Return the matrices of a certificate file as a Coq file.

    Raises
    ------
    CertificateError : the file is no certificate, or a claim of it is not proved, so that there is
        no theorem to be written.
    """
    theorems: dict[int, Theorems] = {}
    checked = check(certificate, decider_of=lambda index: theorems.setdefault(index, Theorems()))
    for number, claim in enumerate(checked.claims, start=1):
        if claim.verdict is Verdict.UNDECIDED:
            raise CertificateError(f"claim {number} is not proved: {claim.text}")
    blocks = [files("takagi.certificates.coq").joinpath("definite.v").read_text(encoding="utf-8")]
    kinds = [claim["kind"] for claim in read_json(certificate)["claims"]]
    for i, kind in enumerate(kinds):
        blocks.append(theorems[i].section(f"claim {i + 1} ({kind})", i + 1))
    counts = {i + 1: theorems[i].count for i in range(len(kinds))}
    blocks.append(
        f"(* {sum(counts.values())} matrices of {len(counts)} claims; equal ones stand once. *)\n"
        "(* What the proof rests on beside Coq's kernel: *)\nPrint Assumptions hold_sound.\n"
    )
    return CoqFile("\n".join(blocks), counts)


class Theorems:
    """Decides the obligations of one claim, and keeps the text of each of its matrices once."""

    def __init__(self) -> None:
        self._texts: dict[str, dict[str, None]] = {"strict": {}, "weak": {}}

    @property
    def count(self) -> int:
        return sum(map(len, self._texts.values()))

    def __call__(self, required: Obligation) -> bool:
        """Return whether an obligation holds; a matrix must have a proof for Coq."""
        if not isinstance(required, Inequality) or not isinstance(required.value, Matrix):
            return required.holds
        value = required.value
        if required.relation is Relation.NOT_POSITIVE:
            return required.holds
        if required.relation is Relation.NONNEGATIVE:
            self._texts["weak"][text_of(value.reduced().rows)] = None
            return required.holds
        proof = shorter(value.reduced().rows) if value.is_symmetric else None
        if proof is None:
            return False
        row = ",".join(map(str, proof.units)) + ",/;"
        self._texts["strict"][text_of(proof.matrix) + row + text_of(proof.rounded)] = None
        return True

    def section(self, where: str, number: int) -> str:
        """Return the theorems of a claim."""
        strict, weak = (list(texts) for texts in self._texts.values())
        count = f"{len(strict)} positive definite, {len(weak)} semidefinite matrices"
        lines = [f"(* {where}: {count} *)"]
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


BITS = (12, 16, 24, 32, 48, 64, 96, 128, 256, 512, 1024, 4096)
Rows = list[list[int]]


class Shorter(NamedTuple):
    """M over some positive denominator, the units s, and N."""

    matrix: Rows
    units: list[int]
    rounded: Rows


def shorter(rows: Rows) -> Shorter | None:
    """Return M, s and N with N positive definite; None where symmetric rows are not definite."""
    if not is_definite(fmpz_mat(rows)):
        return None
    n = len(rows)
    for bits in BITS:
        # If the entries have fewer bits than N should have, all are multiplied by one factor.
        up = max(0, bits - min(rows[i][i].bit_length() for i in range(n)))
        M = [[entry << up for entry in row] for row in rows]
        e = [max(0, (M[i][i].bit_length() - bits) // 2) for i in range(n)]
        N = [[_nearest(M[i][j], e[i] + e[j]) for j in range(n)] for i in range(n)]
        for i in range(n):
            N[i][i] = (M[i][i] >> 2 * e[i]) - (n - 1)
        if is_definite(fmpz_mat(N)):
            return Shorter(M, [1 << k for k in e], N)
    return None


def _nearest(value: int, shift: int) -> int:
    return (value + (1 << shift >> 1)) >> shift


def text_of(rows: Rows) -> str:
    """Return the upper triangle of a symmetric matrix as ``definite.v`` reads it."""
    triangle = (row[i:] for i, row in enumerate(rows))
    return "".join(",".join(map(str, row)) + ",/" for row in triangle) + ";"
