r"""A second exact reason for a no: a function that decays but is not positive definite.

Of a condition in one symmetric P, with P > 0 and an item F(P) > 0 without constants, such that

    P >= 0 and P x = 0   imply   x' F(P) x <= 0,                                        (*)

let F(P_0) > 0 for a P_0 that is not positive definite.  Then no P_1 > 0 has F(P_1) > 0: on the
way from P_0 to P_1 there is a last P_t that is singular; P_t >= 0, P_t x = 0 for an x other than
0, and x' F(P_t) x > 0, against (*).  (*) holds for sums of P R + R' P, any multiple of P, and
-R' P R.  For F(P) = -(A' P + P A) this is Lyapunov's instability theorem; it still gives an answer
if the multipliers of an unstable vertex are unique and irrational.

Source: Schneider (1965), Positive operators and an inertia theorem, Numerische Mathematik 7.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

import numpy as np

from takagi.lmi.condition.evaluate import exact_matrices, fractions
from takagi.lmi.condition.term import LMI, Array, Condition, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.refutation.adjoint import Adjoint, Block, over_one_denominator
from takagi.models.arrays import Floats, Indices

# The first test keeps only so many leading bits of the entries, which is fast.  It succeeds unless
# the matrix is singular to that accuracy.
SHORT = 96


def is_semidefinite(matrix: Array) -> bool:
    """Return whether x' M x >= 0 for all x; M is (n, n), symmetric, of Fractions or ints.

    Both answers are exact.
    """
    integers, _ = over_one_denominator(np.asarray(matrix))
    if _clearly_definite(integers):
        return True
    # M is semidefinite if its restriction to a complement of its null space is.  The kept
    # coordinates span such a complement.
    coordinates = _without_null(integers)
    inside = integers[np.ix_(coordinates, coordinates)]
    return _clearly_definite(inside) or _pivots_hold(inside, zero=True)


def is_definite(matrix: Array) -> bool:
    """Return whether x' M x > 0 for all x other than 0; both answers are exact."""
    integers, _ = over_one_denominator(np.asarray(matrix))
    return _clearly_definite(integers) or _pivots_hold(integers, zero=False)


def _clearly_definite(integers: Array) -> bool:
    """Return True if the leading bits of the entries prove definiteness; False decides nothing.

    After the shift the omitted part is a symmetric matrix with entries in [0, 1).  Its norm is at
    most n, so the truncated matrix minus n I is a lower bound of the shifted matrix.
    """
    n = len(integers)
    bits = max((abs(entry).bit_length() for entry in integers.flat), default=0)
    if bits <= SHORT:
        return _pivots_hold(integers, zero=False)
    cut = np.right_shift(integers, bits - SHORT) - n * np.eye(n, dtype=object)
    return _pivots_hold(cut, zero=False)


def _without_null(integers: Array) -> Indices:
    """Return coordinates whose span contains no null vector but 0; there are rank(M) of them."""
    import flint

    n = len(integers)
    vectors, count = flint.fmpz_mat(integers.tolist()).nullspace()
    if not count:
        return np.arange(n)
    rows = [[vectors[i, k] for i in range(n)] for k in range(count)]
    reduced, _, rank = flint.fmpz_mat(rows).rref()
    pivots = [next(i for i in range(n) if reduced[k, i] != 0) for k in range(rank)]
    return np.setdiff1d(np.arange(n), pivots)


def _pivots_hold(integers: Array, *, zero: bool) -> bool:
    """Return whether all pivots are positive; ``zero`` also allows zero pivots in zero rows.

    The elimination is fraction-free: all divisions are exact.

    Source: Bareiss (1968), Sylvester's identity and multistep integer-preserving Gaussian
    elimination, Mathematics of Computation 22.
    """
    M, previous = integers.copy(), 1
    for k in range(len(M)):
        pivot = M[k, k]
        if pivot < 0 or (pivot == 0 and (not zero or any(M[k, k + 1 :]))):
            return False
        if pivot == 0:
            continue
        complement = M[k + 1 :, k + 1 :] * pivot - np.outer(M[k + 1 :, k], M[k, k + 1 :])
        M[k + 1 :, k + 1 :] = complement // previous
        previous = pivot
    return True


# Binary digits to which the function is rounded, and items that are tried.
DIGITS, MOST_ITEMS = 48, 256


def fault_of_function(condition: Condition, values: Mapping[str, Array]) -> str:
    """Return why the exact values prove nothing; empty when they do."""
    P = _lone_unknown(condition)
    if P is None:
        return "the condition is not one of a single symmetric unknown that is positive definite"
    if P.name not in values or np.shape(values[P.name]) != (1, P.rows, P.rows):
        return f"a value of {P.name}, (1, {P.rows}, {P.rows}), is needed"
    value = fractions(values[P.name])
    if np.any(value[0] != value[0].T):
        return f"the value of {P.name} is not symmetric"
    if is_definite(value[0]):
        return f"the value of {P.name} is positive definite"
    for lmi in condition.lmis:
        items = [item for item in range(lmi.count) if _crosses(condition, lmi, item)]
        if not items:
            continue
        matrices = exact_matrices(condition, lmi, {P.name: value})[items]
        if any(np.array_equal(F, F.T) and is_definite(F) for F in matrices):
            return ""
    return f"no vertex decays with this value of {P.name}"


def function_that_decays(read: Adjoint) -> Mapping[str, Array] | None:
    """Return exact values with which one item excludes every solution; None if none were found."""
    condition = read.condition
    P = _lone_unknown(condition)
    if P is None:
        return None
    for block in read.blocks[:MOST_ITEMS]:
        if not _crosses(condition, condition.lmis[block.lmi], block.item):
            continue
        lyapunov = _rounded(_solved(read, block, P))
        values = {P.name: lyapunov[None]}
        if not fault_of_function(condition, values):
            return values
    return None


def _lone_unknown(condition: Condition) -> Unknown | None:
    """Return P of a condition with no other unknown, and with P > 0 among its LMIs."""
    if len(condition.unknowns) != 1:
        return None
    P = condition.unknowns[0]
    if not P.symmetric or P.count != 1:
        return None
    return P if any(_is_itself(lmi) for lmi in condition.lmis) else None


def _is_itself(lmi: LMI) -> bool:
    if not lmi.strict or lmi.constants or len(lmi.terms) != 1 or lmi.sign != 1:
        return False
    term = lmi.terms[0]
    if term.right is None or term.parameter is not None or term.items is not None:
        return False
    # A multiple of P that is not positive would make the other LMI a contradiction by itself.
    return _multiple(term.left[0]) == 1 and _multiple(term.right[0]) == 1


def _crosses(condition: Condition, lmi: LMI, item: int) -> bool:
    """Return whether an item is strict and has the property (*)."""
    if not lmi.strict or lmi.constants or _is_itself(lmi):
        return False
    if lmi.size != condition.unknowns[0].rows:
        return False
    return all(_term_crosses(condition, lmi, term, item) for term in lmi.terms)


def _term_crosses(condition: Condition, lmi: LMI, term: Term, item: int) -> bool:
    items, _, left, right = term.spread(lmi.count)
    if right is None:
        # A scalar unknown, 1 x 1: a multiple of P.
        return lmi.size == 1
    if term.shape != (lmi.size, lmi.size):
        return False
    factor = lmi.sign
    if term.parameter is not None:
        factor *= 1 if condition.parameters[term.parameter] >= 0 else -1
    for t in np.flatnonzero(items == item):
        one_sided = _multiple(left[t]) is not None or _multiple(right[t]) is not None
        if not one_sided and not (factor < 0 and np.array_equal(left[t], right[t].T)):
            return False
    return True


def _multiple(matrix: Array) -> object:
    """Return c where the matrix is c times the identity; None where it is not."""
    n = len(matrix)
    if matrix.shape != (n, n) or np.any((matrix != 0) & ~np.eye(n, dtype=bool)):
        return None
    diagonal = np.diag(matrix)
    return diagonal[0] if np.all(diagonal == diagonal[0]) else None


def _solved(read: Adjoint, block: Block, P: Unknown) -> Floats:
    """Return P with F(P) = I approximately, in floating point."""
    n = block.size
    number = np.full(read.columns, -1)
    high, low = np.tril_indices(n)
    number[block.index[low, high]] = np.arange(len(low))
    here = number[read.column] >= 0
    matrix = np.zeros((len(low), P.entries))
    value = np.array([v / read.denominator for v in read.value[here]])
    matrix[number[read.column[here]], read.row[here]] = value
    target = (low == high).astype(np.float64)
    numbers = np.linalg.lstsq(matrix, target, rcond=1e-13)[0]
    return np.asarray(P.value(numbers)[0])


def _rounded(P: Floats) -> Array:
    largest = float(np.abs(P).max())
    unit = Fraction(2) ** (int(np.ceil(np.log2(largest))) - DIGITS) if largest > 0 else Fraction(1)
    rounded = np.empty(P.shape, dtype=object)
    for index, entry in np.ndenumerate(P):
        rounded[index] = round(Fraction(float(entry)) / unit) * unit
    return rounded
