r"""Decides obligations in FLINT's exact numbers and balls, in another way than the checker.

All eigenvalues of a symmetric matrix are real.  With its characteristic polynomial

    det(x I - M) = x^n - c_1 x^(n-1) + c_2 x^(n-2) - ...,

where c_k is the k-th elementary symmetric function of the eigenvalues, all eigenvalues are
positive if and only if every c_k is positive, and no eigenvalue is negative if and only if no c_k
is negative (Descartes' rule of signs).  The checker and the proof assistant use elimination; this
test does not, so that it cannot repeat an error of theirs.

Source: Horn and Johnson (2013), Matrix Analysis, theorem 7.2.1 and corollary 7.2.4, recalled.
"""

from __future__ import annotations

from dataclasses import dataclass

from flint import fmpq, fmpz_mat

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Inequality, Obligation, Relation
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
