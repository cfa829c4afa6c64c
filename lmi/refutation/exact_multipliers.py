"""Exact multipliers next to a solver's, and the faces on which they are singular.

Faces of the cone of multipliers: Z_k = U_k S_k U_k' with integer U_k, S_k in the place of Z_k.

If every multiplier that excludes a solution is singular, the multipliers lie on such a face. In the
coordinates S_k of the face they are definite, and exact ones are found as in the definite case.

No result of this module is taken as a proof: the result is checked by ``Alternative`` from scratch.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.linalg import qr

from takagi.lmi.condition.term import Array
from takagi.lmi.condition.unknown import triangle
from takagi.lmi.cone.cone_program import joined
from takagi.lmi.refutation.contradiction import forced_to_zero
from takagi.lmi.refutation.exact_algebra import Adjoint, over_one_denominator, packed_places
from takagi.models.arrays import Floats, Indices

# Pairs of tolerances: eigenvalues below the first, relative to the largest one of a multiplier,
# count as zero; a ratio that differs from a fraction by less than the second counts as that
# fraction. There are several pairs because solvers differ in accuracy.
ROUGHNESS = ((1e-6, 1e-5), (1e-5, 1e-4), (1e-4, 1e-3))
LARGEST_DENOMINATOR = 64


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """Z_k = U_k S_k U_k' for every block k.

    Attributes
    ----------
    bases : U_k, (n_k, r_k) of ints, linearly independent columns; r_k may be 0.
    starts : where the entries of S_k, upper triangle column by column, begin in s.
    row, column, value : the rows of the adjoint in s: row_v . z = sum of value_t s_column(t).
    """

    read: Adjoint
    bases: tuple[Array, ...]
    starts: tuple[int, ...]
    row: Indices
    column: Indices
    value: Array

    @property
    def columns(self) -> int:
        return sum(triangle(U.shape[1]) for U in self.bases)

    @property
    def rows(self) -> int:
        return self.read.rows

    def member(self, number: int, s: Array) -> Array:
        """Return S_k, (r_k, r_k)."""
        r = self.bases[number].shape[1]
        return np.asarray(s[self.starts[number] + packed_places(r)])

    def lift(self, s: Array) -> Array:
        """Return z, (columns of the adjoint,), in the arithmetic of s."""
        zero = 0.0 if s.dtype != object else Fraction(0)
        z = np.full(self.read.columns, zero, dtype=s.dtype)
        for number, (block, U) in enumerate(zip(self.read.blocks, self.bases, strict=True)):
            picked = _coordinates(U)
            if picked is not None:
                z[block.index[np.ix_(picked, picked)]] = self.member(number, s)
            else:
                V = U if s.dtype == object else U.astype(np.float64)
                z[block.index] = V @ self.member(number, s) @ V.T
        return z

    def drop(self, z: Floats) -> Floats:
        """Return s with U_k S_k U_k' nearest to Z_k."""
        s = np.zeros(self.columns)
        for block, U, start in zip(self.read.blocks, self.bases, self.starts, strict=True):
            if U.shape[1]:
                inverse = np.linalg.pinv(U.astype(np.float64))
                s[start + packed_places(U.shape[1])] = inverse @ z[block.index] @ inverse.T
        return s


def open_face(read: Adjoint) -> Face:
    """Return the face of the entries that may differ from 0 in a contradiction.

    Others are forced to 0 by normalisations, and by unknowns that enlarge the margin in one
    direction.
    """
    owner = np.full((read.columns, 2), -1)
    for number, block in enumerate(read.blocks):
        block_positions = np.column_stack([np.full(block.size, number), np.arange(block.size)])
        owner[np.diag(block.index)] = block_positions
    diagonal = owner[:, 0] >= 0
    alive = np.ones(read.columns, dtype=bool)
    sign = np.array([1.0 if value > 0 else -1.0 for value in read.value])
    while True:
        dead = forced_to_zero(alive, diagonal, read.row, read.column, sign, read.constant)
        if not dead.any():
            break
        for number, a in owner[dead]:
            alive[read.blocks[number].index[a]] = False
    open_diagonals = [alive[np.diag(block.index)] for block in read.blocks]
    return restricted_to_face(
        read, [_identity(len(open_entries))[:, open_entries] for open_entries in open_diagonals]
    )


def faces_near(face: Face, z: Floats) -> Iterator[Face]:
    """Yield smaller faces in which the multipliers z lie to solver accuracy.

    Only directions with small rational ratios are recognised.
    """
    largest = max((np.trace(z[block.index]) for block in face.read.blocks), default=0.0)
    previous: list[Array] = list(face.bases)
    for singular, tolerance in ROUGHNESS:
        bases = []
        for block, U in zip(face.read.blocks, face.bases, strict=True):
            W = _range(z[block.index], largest, singular, tolerance) if U.shape[1] else None
            bases.append(U if W is None or W.shape[1] >= U.shape[1] else W)
        if any(not np.array_equal(U, V) for U, V in zip(bases, previous, strict=True)):
            yield restricted_to_face(face.read, bases)
        previous = bases


def restricted_to_face(read: Adjoint, bases: list[Array]) -> Face:
    """Return the face with these bases."""
    starts, total = [], 0
    for U in bases:
        starts.append(total)
        total += triangle(U.shape[1])
    # z = E s. Most entries of E are 1: they copy an entry of S to its place in Z.
    z_entry: list[Indices] = []
    s_entry: list[Indices] = []
    factor: list[Array] = []
    for block, U, start in zip(read.blocks, bases, starts, strict=True):
        outer, inner, value = _congruence(U)
        high, low = np.tril_indices(block.size)
        z_entry.append(block.index[low, high][outer])
        s_entry.append(start + inner)
        factor.append(value)
    row, column, entry = _product(
        read, np.concatenate(z_entry), np.concatenate(s_entry), np.concatenate(factor), total
    )
    return Face(read, tuple(bases), tuple(starts), row, column, entry)


def _congruence(U: Array) -> tuple[Indices, Indices, Array]:
    """Return (entry of Z, entry of S, factor) of Z = U S U', upper triangles column by column."""
    picked = _coordinates(U)
    if picked is not None:
        d, c = np.tril_indices(len(picked))
        entry = packed_places(len(U))[picked[c], picked[d]]
        return entry, np.arange(len(entry)), np.full(len(entry), 1, dtype=object)
    b, a = np.tril_indices(len(U))
    d, c = np.tril_indices(U.shape[1])
    first = U[a][:, c] * U[b][:, d]
    factor = first + np.where(c == d, 0, U[a][:, d] * U[b][:, c])
    z_entry, s_entry = np.nonzero(factor)
    return z_entry, s_entry, factor[z_entry, s_entry]


def _coordinates(U: Array) -> Indices | None:
    """Return which coordinates the columns of U are, in order; None where they are others."""
    row, column = np.nonzero(U)
    picks = len(row) == U.shape[1] and np.array_equal(np.sort(column), np.arange(U.shape[1]))
    return row if picks and all(U[row, column] == 1) else None


def _product(
    read: Adjoint, z_entry: Indices, s_entry: Indices, factor: Array, columns: int
) -> tuple[Indices, Indices, Array]:
    """Return the entries of the adjoint's matrix times E."""
    order = np.argsort(z_entry, kind="stable")
    z_entry, s_entry, factor = z_entry[order], s_entry[order], factor[order]
    t, factor_entry = joined(read.column, z_entry, read.columns)
    position = read.row[t] * max(columns, 1) + s_entry[factor_entry]
    positions, where = np.unique(position, return_inverse=True)
    total = np.zeros(len(positions), dtype=object)
    np.add.at(total, where, read.value[t] * factor[factor_entry])
    keep = np.flatnonzero(total != 0)
    row, column = np.divmod(positions[keep], max(columns, 1))
    return row, column, total[keep]


def _range(Z: Floats, largest: float, singular: float, tolerance: float) -> Array | None:
    """Return an integer basis of the directions in which Z is not singular; None if irrational."""
    values, vectors = np.linalg.eigh(Z)
    if values[-1] <= singular * largest:
        return np.zeros((len(Z), 0), dtype=object)
    basis = vectors[:, values > singular * values[-1]]
    # Reduced so that the pivot coordinates form the identity: rational when the space is.
    r = basis.shape[1]
    order = qr(basis.T, mode="r", pivoting=True)[1]
    reduced = np.linalg.solve(basis[order[:r]].T, basis.T).T
    exact = np.full(reduced.shape, 0, dtype=object)
    for column in range(r):
        ratios = [_simplest(float(x), tolerance) for x in reduced[:, column]]
        if any(ratio is None for ratio in ratios):
            return None
        rational_ratios = [ratio for ratio in ratios if ratio is not None]
        common = lcm(*(ratio.denominator for ratio in rational_ratios))
        exact[:, column] = [int(ratio * common) for ratio in rational_ratios]
    return exact


def _simplest(x: float, tolerance: float) -> Fraction | None:
    """Return the fraction of smallest denominator that is as near to x; None if none exists."""
    for denominator in range(1, LARGEST_DENOMINATOR + 1):
        fraction = Fraction(round(x * denominator), denominator)
        if abs(float(fraction) - x) <= tolerance:
            return fraction
    return None


def _identity(n: int) -> Array:
    eye = np.full((n, n), 0, dtype=object)
    eye[range(n), range(n)] = 1
    return eye


# Free entries are rounded to so many binary digits behind the largest.
DIGITS = 64
# A pivot below this share of the first belongs to an equality that follows from the others.
DEPENDENT = 1e-11


def exact_near(face: Face, s: Floats, size: Floats) -> Array | None:
    """Return exact s, (columns,) of Fractions, with row_v . z = 0 in every row, near the given.

    If an entry appears in one equality only, that entry is computed from it. The few equalities
    that are left are solved exactly for as many entries as there are equalities.

    ``s`` : (columns of the face,) in floating point.
    ``size`` : (columns,) positive: how far each entry may be moved, relative to the others.

    None if the equalities have no solution in the entries that were picked.
    """
    entries = _Rows(face.row, face.column, face.value, face.rows)
    slack = entries.own_columns(face.columns)
    core = np.setdiff1d(np.unique(entries.row), np.flatnonzero(slack >= 0))
    settled = np.zeros(face.columns, dtype=bool)
    settled[slack[slack >= 0]] = True
    exact = np.full(face.columns, Fraction(0), dtype=object)
    free = np.flatnonzero(~settled)
    exact[free] = _short(s[free])
    if len(core):
        # A column with a single entry belongs to a row that is already solved, so that the core
        # only has columns that are still free.
        core_entries = entries.only(core)
        exact[free] = _short(_projected(core_entries, core, s, size)[free])
        if not _settle_core(core_entries, core, exact, size):
            return None
    sums = entries.sums(exact)
    for row in np.flatnonzero(slack >= 0).tolist():
        exact[slack[row]] = -sums[row] / entries.value_at(row, slack[row])
    return exact


class _Rows:
    """Entries of an integer matrix, by position."""

    def __init__(self, row: Indices, column: Indices, value: Array, rows: int) -> None:
        self.row, self.column, self.value, self.rows = row, column, value, rows

    def own_columns(self, columns: int) -> Indices:
        """Return (rows,): a column that only this row has, the largest; -1 where none exists."""
        single = np.bincount(self.column, minlength=columns)[self.column] == 1
        single_column = np.full(self.rows, -1, dtype=np.intp)
        largest: dict[int, int] = {}
        for t in np.flatnonzero(single):
            row, value = int(self.row[t]), abs(self.value[t])
            if value > largest.get(row, 0):
                largest[row], single_column[row] = value, self.column[t]
        return single_column

    def only(self, rows: Indices) -> _Rows:
        keep = np.isin(self.row, rows)
        return _Rows(self.row[keep], self.column[keep], self.value[keep], self.rows)

    def sums(self, z: Array) -> Array:
        """Return the rows' products with z, (rows,) of Fractions."""
        numerators, denominator = over_one_denominator(z)
        total = np.full(self.rows, 0, dtype=object)
        np.add.at(total, self.row, self.value * numerators[self.column])
        return np.array(
            [Fraction(int(numerator), denominator) for numerator in total], dtype=object
        )

    def value_at(self, row: int, column: int) -> int:
        return int(self.value[(self.row == row) & (self.column == column)][0])


def _short(z: Floats) -> Array:
    """Return dyadic numbers with few digits near z."""
    largest = float(np.abs(z).max(initial=0.0))
    power = DIGITS - int(np.ceil(np.log2(largest))) if largest > 0 else 0
    unit = Fraction(2) ** -power
    return np.array([Fraction(round(Fraction(float(x)) / unit)) * unit for x in z], dtype=object)


def _scaled(core_rows: _Rows, core: Indices, size: Floats) -> tuple[sp.csr_array, Indices, Floats]:
    """Return the core in floating point with rows of order one, its columns, and row scales."""
    columns, column_index = np.unique(core_rows.column, return_inverse=True)
    row = np.searchsorted(core, core_rows.row)
    largest = np.zeros(len(core), dtype=object)
    np.maximum.at(largest, row, np.abs(core_rows.value))
    value = np.array([v / w for v, w in zip(core_rows.value, largest[row], strict=True)])
    matrix = sp.csr_array(
        (value * size[core_rows.column], (row, column_index)), (len(core), len(columns))
    )
    length = np.sqrt(np.asarray(matrix.multiply(matrix).sum(axis=1)).ravel())
    length = np.where(length > 0, length, 1.0)
    return sp.csr_array(sp.diags_array(1.0 / length) @ matrix), columns, length


def _projected(core_rows: _Rows, core: Indices, z: Floats, size: Floats) -> Floats:
    """Return z moved the least, in units of size, so that the core's equalities hold roughly."""
    matrix, columns, _ = _scaled(core_rows, core, size)
    gram = (matrix @ matrix.T).toarray()
    corrected = z.copy()
    # Three times, because each projection leaves a residual of its own rounding errors.
    for _ in range(3):
        residual = matrix @ (corrected[columns] / size[columns])
        step = np.linalg.lstsq(gram, residual, rcond=1e-14)[0]
        corrected[columns] -= size[columns] * (matrix.T @ step)
    return corrected


def _settle_core(core_rows: _Rows, core: Indices, exact: Array, size: Floats) -> bool:
    """Move as many entries of ``exact`` as there are equalities so that the core holds exactly."""
    import flint

    matrix, columns, _ = _scaled(core_rows, core, size)
    dense = matrix.toarray()
    _, triangular, order = qr(dense, mode="economic", pivoting=True)
    pivots = np.abs(np.diag(triangular))
    rank = int((pivots > DEPENDENT * pivots[0]).sum())
    picked = order[:rank]
    rows = qr(dense[:, picked].T, mode="r", pivoting=True)[1][:rank]
    position = {int(core[r]): k for k, r in enumerate(rows)}
    column_index = {int(columns[c]): k for k, c in enumerate(picked)}
    square = [[0] * rank for _ in range(rank)]
    for row, column, value in zip(core_rows.row, core_rows.column, core_rows.value, strict=True):
        if int(row) in position and int(column) in column_index:
            square[position[int(row)]][column_index[int(column)]] = int(value)
    numerators, denominator = over_one_denominator(core_rows.sums(exact)[core[rows]])
    right_side = flint.fmpz_mat([[int(value)] for value in numerators])
    try:
        step: Any = flint.fmpz_mat(square).solve(right_side)
    except ZeroDivisionError:
        return False
    for k, column in enumerate(columns[picked]):
        entry = step[k, 0]
        exact[column] -= Fraction(int(entry.p), int(entry.q) * denominator)
    return not core_rows.sums(exact)[core].any()
