"""From multipliers in floating point to exact ones next to them, which satisfy every equality.

No result of this module is taken as a proof: the result is checked by ``Alternative`` from scratch.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import scipy.sparse as sp
from scipy.linalg import qr

from takagi.lmi.condition.term import Array
from takagi.lmi.refutation.adjoint import over_one_denominator
from takagi.lmi.refutation.multiplier_face import Face
from takagi.models.arrays import Floats, Indices

# Free entries are rounded to so many binary digits behind the largest.
DIGITS = 64
# A pivot below this share of the first belongs to an equality that follows from the others.
DEPENDENT = 1e-11


def exact_near(face: Face, s: Floats, size: Floats) -> Array | None:
    """Return exact s, (columns,) of Fractions, with row_v . z = 0 in every row, near the given.

    If an entry appears in one equality only, that entry is computed from it. The few equalities
    that are left are solved exactly for as many entries as there are equalities.

    Parameters
    ----------
    s : (columns of the face,) in floating point.
    size : (columns,) positive: how far each entry may be moved, relative to the others.

    Returns
    -------
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
