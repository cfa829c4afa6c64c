"""A condition as one integer matrix, and exact tests of definiteness.

For symmetric Z_k, one an item, and z their entries on and above the diagonal,

    D sum_k <sign F_k(x), Z_k> = constant . z + sum_v x_v (row_v . z)     for all unknowns x,

with integers on the right and one positive integer D.  Floats count as the dyadic numbers they
store, so nothing is rounded.

A second exact reason for a no: a function that decays but is not positive definite.

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

import math
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from takagi.lmi.condition.evaluate import exact_matrices, fractions
from takagi.lmi.condition.term import LMI, Array, Condition, Constant, Term
from takagi.lmi.condition.unknown import Unknown, triangle
from takagi.lmi.cone.cone_program import joined
from takagi.models.arrays import Floats, Indices


@dataclass(frozen=True, slots=True, eq=False)
class Block:
    """One multiplier: item ``item`` of LMI number ``lmi``; entry (a, b) is at index[a, b] of z."""

    lmi: int
    item: int
    index: Indices

    @property
    def size(self) -> int:
        return len(self.index)


@dataclass(frozen=True, slots=True, eq=False)
class Adjoint:
    """The integer matrix of the module's formula, as entries without repetition or zeros.

    Attributes
    ----------
    condition : what was read.
    row, column, value : entry t is value_t (an int) in row_t (a number of an unknown, in the
        order of the unknowns), column_t (an entry of z).
    constant : (columns,) ints.
    denominator : D.
    blocks : where each multiplier appears in z.
    """

    condition: Condition
    row: Indices
    column: Indices
    value: Array
    constant: Array
    denominator: int
    blocks: tuple[Block, ...]

    @property
    def rows(self) -> int:
        return sum(unknown.length for unknown in self.condition.unknowns)

    @property
    def columns(self) -> int:
        return len(self.constant)

    def strict(self, block: Block) -> bool:
        """Return whether the block's LMI is strict; a normalisation may hold with equality."""
        return self.condition.lmis[block.lmi].strict

    def name(self, block: Block) -> str:
        """Return the item's name."""
        return self.condition.lmis[block.lmi].label(block.item)

    def products(self, z: Array) -> Array:
        """Return row_v . z, (rows,), in the arithmetic of z (ints, Fractions)."""
        total = np.zeros(self.rows, dtype=object)
        np.add.at(total, self.row, self.value * z[self.column])
        return total


def adjoint(condition: Condition) -> Adjoint:
    """Return the integer matrix of a condition.  Nothing is solved, nothing is rounded.

    Raises
    ------
    ModelError : an entry that is not a finite number, or equalities, which have no multipliers
        here.
    """
    condition.refuse_equalities()
    offsets, variables = {}, 0
    for unknown in condition.unknowns:
        offsets[unknown.name] = variables
        variables += unknown.length
    term_entries, constants, blocks, start = [_Entries.none()], [], [], 0
    for number, lmi in enumerate(condition.lmis):
        width = triangle(lmi.size)
        for item in range(lmi.count):
            blocks.append(Block(number, item, start + item * width + packed_places(lmi.size)))
        for term in lmi.terms:
            factor = 1 if term.parameter is None else condition.parameters[term.parameter]
            triplets = _term_entries(term, lmi, start, offsets[term.unknown.name])
            term_entries.append(triplets.times(lmi.sign * Fraction(factor)))
        constants += [
            _constant_entries(constant, lmi, start).times(Fraction(lmi.sign))
            for constant in lmi.constants
        ]
        start += lmi.count * width
    together = math.lcm(*(entries.denominator for entries in (*term_entries, *constants)))
    row, column, value = _joined([entries.over(together) for entries in term_entries], start)
    constant = np.zeros(start, dtype=object)
    for entries in constants:
        np.add.at(constant, entries.column, entries.over(together).value)
    return Adjoint(condition, row, column, value, constant, together, tuple(blocks))


def over_one_denominator(array: Array) -> tuple[Array, int]:
    """Return integers N and a positive integer D with array = N / D exactly.

    Raises
    ------
    ModelError : an entry that is not a finite number.
    """
    # Wide integers have more digits than a float, and NaN has a mantissa like any other.
    if array.dtype.kind == "f" and array.dtype.itemsize <= 8 and np.isfinite(array).all():
        mantissa, exponent = np.frexp(np.asarray(array, dtype=np.float64))
        integers = (mantissa * 2.0**53).astype(np.int64).astype(object)
        nonzero = mantissa != 0
        smallest_exponent = int(exponent[nonzero].min()) if nonzero.any() else 53
        shift = np.where(nonzero, exponent - smallest_exponent, 0).astype(object)
        power = smallest_exponent - 53
        integers = np.asarray(integers * 2**shift, dtype=object)
        return (integers * 2**power, 1) if power > 0 else (integers, 2**-power)
    exact = fractions(array)
    denominator = math.lcm(*(entry.denominator for entry in exact.flat))
    integers = np.empty(exact.shape, dtype=object)
    for index, entry in np.ndenumerate(exact):
        integers[index] = entry.numerator * (denominator // entry.denominator)
    return integers, denominator


@dataclass(frozen=True, slots=True, eq=False)
class _Entries:
    row: Indices
    column: Indices
    value: Array
    denominator: int

    @classmethod
    def none(cls) -> _Entries:
        nothing = np.zeros(0, dtype=np.intp)
        return cls(nothing, nothing, np.zeros(0, dtype=object), 1)

    def times(self, factor: Fraction) -> _Entries:
        value = self.value * factor.numerator
        return _Entries(self.row, self.column, value, self.denominator * factor.denominator)

    def over(self, denominator: int) -> _Entries:
        value = self.value * (denominator // self.denominator)
        return _Entries(self.row, self.column, value, denominator)


def packed_places(size: int) -> Indices:
    """Return (size, size): where entry (a, b) appears in the upper triangle, column by column."""
    a, b = np.indices((size, size))
    low, high = np.minimum(a, b), np.maximum(a, b)
    return np.asarray(high * (high + 1) // 2 + low)


def _term_entries(term: Term, lmi: LMI, start: int, offset: int) -> _Entries:
    """Return the entries of one term: the coefficient of z_ab is F_ab + F_ba off the diagonal."""
    item, member, left, right = term.spread(lmi.count)
    index = term.unknown.entry_index()
    N, D = _spread_integers(term.left, left.shape)
    t, a, k = np.nonzero(N)
    if right is None or term.right is None:
        i, b, entry, value = t, k, np.zeros_like(t), N[t, a, k]
    else:
        M, E = _spread_integers(term.right, right.shape)
        s, m, q = np.nonzero(M)
        # The product L X R has a term for each pair of an entry of L and an entry of R.
        left_index, right_index = joined(t, s, len(M))
        i, b, entry = t[left_index], q[right_index], index[k[left_index], m[right_index]]
        value = N[t, a, k][left_index] * M[s, m, q][right_index]
        a, D = a[left_index], D * E
    rows, columns = lmi.spans(term.at)
    # <F, Z> counts F_ab and F_ba; a block off the diagonal, and a transpose, bring their mirrors.
    mirrored = rows != columns or term.plus_transpose
    value = value * (2 if mirrored else 1)
    position = (
        start
        + item[i] * triangle(lmi.size)
        + packed_places(lmi.size)[a + rows.start, b + columns.start]
    )
    return _Entries(offset + member[i] * term.unknown.entries + entry, position, value, D)


def _spread_integers(array: Array, shape: tuple[int, ...]) -> tuple[Array, int]:
    integers, denominator = over_one_denominator(array)
    return np.broadcast_to(integers, shape), denominator


def _constant_entries(constant: Constant, lmi: LMI, start: int) -> _Entries:
    rows, columns = lmi.spans(constant.at)
    N, D = _spread_integers(constant.value, (lmi.count, *constant.shape))
    item, a, b = np.nonzero(N)
    position = (
        start
        + item * triangle(lmi.size)
        + packed_places(lmi.size)[a + rows.start, b + columns.start]
    )
    value = N[item, a, b] * (2 if rows != columns else 1)
    return _Entries(np.zeros_like(item), position, value, D)


def _joined(entries: list[_Entries], columns: int) -> tuple[Indices, Indices, Array]:
    """Return row, column, value with equal positions added up and zeros left out."""
    row = np.concatenate([triplets.row for triplets in entries]).astype(np.int64)
    column = np.concatenate([triplets.column for triplets in entries]).astype(np.int64)
    value = np.concatenate([triplets.value for triplets in entries])
    position, where = np.unique(row * columns + column, return_inverse=True)
    total = np.zeros(len(position), dtype=object)
    np.add.at(total, where, value)
    keep = np.flatnonzero(total != 0)
    row, column = np.divmod(position[keep], max(columns, 1))
    return row, column, total[keep]


def is_semidefinite(matrix: Array) -> bool:
    """Return whether x' M x >= 0 for all x; M is (n, n), symmetric, of Fractions or ints.

    Both answers are exact.
    """
    return _signs_alternate(matrix, zero=True)


def is_definite(matrix: Array) -> bool:
    """Return whether x' M x > 0 for all x other than 0; both answers are exact."""
    return _signs_alternate(matrix, zero=False)


def _signs_alternate(matrix: Array, *, zero: bool) -> bool:
    """Return whether the roots of the characteristic polynomial, all real, are positive.

    They are just where its signs alternate (Descartes); ``zero`` also allows zeros.
    """
    import flint

    integers, _ = over_one_denominator(np.asarray(matrix))
    highest_first = flint.fmpz_mat(integers.tolist()).charpoly().coeffs()[::-1]
    signed = [-c if k % 2 else c for k, c in enumerate(highest_first)]
    return all(c > 0 or (zero and c == 0) for c in signed)


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
        lyapunov = _solved(read, block, P)
        unit = 2.0 ** (np.ceil(np.log2(np.abs(lyapunov).max() or 1.0)) - DIGITS)
        values = {P.name: fractions(np.round(lyapunov / unit) * unit)[None]}
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
