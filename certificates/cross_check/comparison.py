r"""The verdicts of both deciders on one certificate, claim by claim.

Both decide the same obligations: the checker in fractions, the other in FLINT's numbers and balls.
A range that FLINT's balls do not settle is left to the checker, and its claim is named.

Decides obligations in FLINT's exact numbers and balls, in another way than the checker.

All eigenvalues of a symmetric matrix are real.  With its characteristic polynomial

    det(x I - M) = x^n - c_1 x^(n-1) + c_2 x^(n-2) - ...,

where c_k is the k-th elementary symmetric function of the eigenvalues, all eigenvalues are
positive if and only if every c_k is positive, and no eigenvalue is negative if and only if no c_k
is negative (Descartes' rule of signs).  The checker and the proof assistant use elimination; this
test does not, so that it cannot repeat an error of theirs.

Source: Horn and Johnson (2013), Matrix Analysis, theorem 7.2.1 and corollary 7.2.4, recalled.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flint import fmpq, fmpz_mat

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Inequality, Obligation, Relation
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Checked, Claim
from takagi.certificates.checker.replay.certificate import (
    DeciderOf,
    check,
    check_document,
    exact_decider,
)
from takagi.certificates.cross_check.ball_ranges import keeps_bounds


@dataclass(slots=True)
class FlintDecider:
    """Decides the obligations of one claim, and counts them.

    Attributes
    ----------
    matrices, numbers, ranges : how many of each it has decided.
    left_open : ranges of expressions that it could not decide; there the checker's answer stands.
    """

    matrices: int = 0
    numbers: int = 0
    ranges: int = 0
    left_open: int = 0

    def __call__(self, required: Obligation) -> bool:
        """Return whether an obligation holds."""
        if isinstance(required, Inequality):
            if isinstance(required.value, Matrix):
                self.matrices += 1
                return _holds(required.value, required.relation)
            self.numbers += 1
            value = fmpq(required.value.numerator, required.value.denominator)
            if required.relation is Relation.NONNEGATIVE:
                return bool(value >= 0)
            return bool((value > 0) == (required.relation is Relation.POSITIVE))
        decided = keeps_bounds(required)
        if decided is None:
            self.left_open += 1
            return required.holds
        self.ranges += 1
        return decided


def _holds(matrix: Matrix, relation: Relation) -> bool:
    # The denominator is positive, so that it changes no sign of an eigenvalue.
    integers = fmpz_mat(matrix.rows)
    if integers.nrows() != integers.ncols() or integers != integers.transpose():
        return False
    if relation is Relation.NOT_POSITIVE:
        return not is_definite(integers)
    return is_definite(integers, strict=relation is Relation.POSITIVE)


def is_definite(integers: fmpz_mat, *, strict: bool = True) -> bool:
    """Return whether a symmetric matrix is positive definite; semidefinite if not strict."""
    coefficients, n = integers.charpoly().coeffs(), integers.nrows()
    for k in range(1, n + 1):
        c = coefficients[n - k] * (-1 if k % 2 else 1)
        if c < 0 or (strict and c == 0):
            return False
    return True


REFUSED, NOT_REPLAYED = "REFUSED", "NOT REPLAYED"


@dataclass(frozen=True, slots=True)
class VerdictRow:
    """The verdicts of both deciders on one claim, or on the whole file.

    ``matrices`` : how many the second one decided; ``reason`` : what differs, or was left open.
    """

    name: str
    first: str
    second: str
    matrices: int
    reason: str = ""
    is_claim: bool = True

    @property
    def shown(self) -> str:
        """The name; a claim's name is free text of the file, so it is quoted."""
        return json.dumps(self.name, ensure_ascii=False) if self.is_claim else self.name

    @property
    def agrees(self) -> bool:
        """Whether both verdicts agree."""
        return self.second in (NOT_REPLAYED, self.first)


@dataclass(frozen=True, slots=True)
class VerdictComparison:
    """Both verdicts on every claim; a refused file gives one row for the whole file."""

    rows: Sequence[VerdictRow]

    @property
    def agrees(self) -> bool:
        return all(row.agrees for row in self.rows)

    @property
    def replayed(self) -> int:
        """How many claims the second decider has decided."""
        return sum(row.second != NOT_REPLAYED for row in self.rows)

    @property
    def left_open(self) -> tuple[str, ...]:
        """The names of the claims with a range that the second decider left to the first."""
        return tuple(row.name for row in self.rows if row.second == NOT_REPLAYED)

    @property
    def data(self) -> dict[str, Any]:
        """The comparison as plain data for JSON."""
        return {
            "agree": self.agrees,
            "replayed": self.replayed,
            "not_replayed": list(self.left_open),
            "claims": [
                {"name": row.name, "first": row.first, "second": row.second, "reason": row.reason}
                for row in self.rows
            ],
        }

    @property
    def text(self) -> str:
        """One line for each claim, and a summary that names the claims not replayed."""
        wide = max(len(row.first) for row in self.rows)
        second = max(len(row.second) for row in self.rows)
        lines = [
            f"  {row.first:<{wide}}  {row.second:<{second}}  {row.shown}"
            + (f" ({row.matrices} matrices)" if row.matrices else "")
            + (f": {row.reason}" if row.reason else "")
            for row in self.rows
        ]
        lines.insert(0, "Two deciders, the checker's verdict and FLINT's:")
        count, last = len(self.rows), "they agree" if self.agrees else "THEY DIFFER"
        summed = f"{self.replayed} of {count} claims decided twice: {last}"
        open_claims = [row.shown for row in self.rows if row.second == NOT_REPLAYED]
        if open_claims:
            summed += f"; with a range left to the checker: {', '.join(open_claims)}"
        return "\n".join([*lines, summed])


def cross_checked(path: Path | str) -> VerdictComparison:
    """Return what both deciders say of a certificate file; a refusal is a row, no exception."""
    return _compared(lambda decider_of: check(path, decider_of=decider_of))


def cross_checked_document(document: Mapping[str, Any]) -> VerdictComparison:
    """Return the same for a certificate in memory."""
    return _compared(lambda decider_of: check_document(document, decider_of))


def _compared(verdicts: Callable[[DeciderOf], Checked]) -> VerdictComparison:
    deciders: dict[int, FlintDecider] = {}
    first_verdict = REFUSED
    try:
        first = verdicts(exact_decider)
        first_verdict = first.verdict.name
        second = verdicts(lambda index: deciders.setdefault(index, FlintDecider()))
    except CertificateError as error:
        # A refusal by FLINT's run alone is a difference, not a refused file.
        return VerdictComparison(
            [VerdictRow("the file", first_verdict, REFUSED, 0, str(error), is_claim=False)]
        )
    return VerdictComparison([
        _row(claim, by_flint, deciders[index])
        for index, (claim, by_flint) in enumerate(zip(first.claims, second.claims, strict=True))
    ])  # fmt: skip


def _row(claim: Claim, by_flint: Claim, decider: FlintDecider) -> VerdictRow:
    first, second, reason = claim.verdict.name, by_flint.verdict.name, ""
    if first != second:
        reason = by_flint.text
    elif decider.left_open:
        second, reason = NOT_REPLAYED, f"{decider.left_open} ranges, which balls do not settle"
    return VerdictRow(claim.name, first, second, decider.matrices, reason)
