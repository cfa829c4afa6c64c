"""The linear equalities of multipliers that exclude every solution of a cone program."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from takagi.lmi.condition.unknown import triangle
from takagi.lmi.cone.assemble import unpack
from takagi.lmi.cone.program import ConeProgram
from takagi.models.arrays import Floats, Indices

# Reciprocal condition number below which a row of A' follows from others.
DEPENDENT = 1e-13
# The linear system is not posed if it has more entries than this; it would take some seconds.
LARGEST = 40_000_000


@dataclass(frozen=True, eq=False)
class Equalities:
    """What the entries of multipliers must satisfy: matrix . z = 0, and sign . z <= 0.

    Attributes
    ----------
    rows : of the program, those whose multipliers may differ from zero.
    sizes, starts : of each multiplier, and where it begins among these rows.
    matrix : independent equalities of length 1; the last is the constant's, where it has a sign.
    constant : whether the last row of ``matrix`` is that of the constant.
    strict : weights of the rows in the margin.
    """

    rows: Indices
    sizes: tuple[int, ...]
    starts: Indices
    matrix: sp.csr_array
    constant: bool
    strict: Floats

    @cached_property
    def coefficients(self) -> tuple[tuple[Indices, Floats], ...]:
        """Of each multiplier: the equalities that it is in, and its symmetric matrices in them."""
        columns = self.matrix.tocsc()
        places = np.repeat(np.arange(columns.shape[1]), np.diff(columns.indptr))
        found = []
        for part, size in self.parts():
            own = slice(columns.indptr[part.start], columns.indptr[part.stop])
            used, row = np.unique(columns.indices[own], return_inverse=True)
            packed = np.zeros((len(used), part.stop - part.start))
            packed[row, places[own] - part.start] = columns.data[own]
            found.append((used.astype(np.intp), unpack(packed, size)))
        return tuple(found)

    def spread(self, z: Floats, count: int) -> Floats:
        """Return the multipliers of all rows of the program."""
        whole = np.zeros(count)
        whole[self.rows] = z
        return whole

    def parts(self) -> Iterator[tuple[slice, int]]:
        for start, end, size in zip(self.starts, self.starts[1:], self.sizes, strict=False):
            yield slice(int(start), int(end)), size


def equalities_of(program: ConeProgram, z: Floats, share: float) -> Equalities | None:
    """Return the equalities; None without any multiplier that may differ from 0, or if too large.

    Parameters
    ----------
    program : with the margin as its last variable.
    share : of the largest multiplier, below which a coordinate is left out.
    """
    return _equalities(program, _alive(program, z, share))


def _diagonals(program: ConeProgram) -> Iterator[tuple[Indices, Indices]]:
    """Yield (first row, coordinates' diagonal rows) of each group: (items,), (items, size)."""
    for row in range(program.linear):
        yield np.array([row]), np.array([[row]])
    for cone in program.cones:
        first = program.linear + cone.start + triangle(cone.size) * np.arange(cone.items)
        k = np.arange(cone.size)
        yield first, first[:, None] + k * (k + 3) // 2


def _alive(program: ConeProgram, z: Floats, share: float) -> NDArray[np.bool_]:
    """Return which rows may differ from zero: entries of multipliers that nothing forces to be 0.

    If a variable, or the constant, only has diagonal entries, and all of one sign, the equality
    forces these to be zero. A semidefinite multiplier then has zeros in their rows and columns.
    """
    A = sp.csr_array(program.A[:, :-1])
    A.eliminate_zeros()
    entries = A.tocoo()
    row, variable = entries.row, entries.col
    sign = np.sign(entries.data)
    groups = list(_diagonals(program))
    diagonal = np.zeros(len(program.b), dtype=bool)
    for _, places in groups:
        diagonal[places] = True
    alive = np.ones(len(program.b), dtype=bool)
    empty = np.diff(A.indptr) == 0
    alive[: program.linear] = ~(empty[: program.linear] & (program.b[: program.linear] >= 0))
    if share:
        most = float(np.abs(z[diagonal]).max())
        alive[diagonal] &= z[diagonal] > share * most
        _spread(groups, alive)
    while True:
        here = alive[row]
        count = np.bincount(variable[here], minlength=A.shape[1])
        on = np.bincount(variable[here], diagonal[row[here]], minlength=A.shape[1])
        signs = np.abs(np.bincount(variable[here], sign[here], minlength=A.shape[1]))
        closed = (count > 0) & (on == count) & (signs == count)
        dead = np.zeros(len(alive), dtype=bool)
        dead[row[here][closed[variable[here]]]] = True
        constant = alive & (program.b != 0)
        if constant.any() and (diagonal[constant] & (program.b[constant] > 0)).all():
            dead |= constant
        dead &= alive
        if not dead.any():
            return alive
        alive &= ~dead
        _spread(groups, alive)


def _spread(groups: list[tuple[Indices, Indices]], alive: NDArray[np.bool_]) -> None:
    """Leave out the rows and columns of diagonal entries that are left out."""
    for first, places in groups:
        size = places.shape[1]
        column, row = np.tril_indices(size)
        used = alive[places]
        alive[first[:, None] + np.arange(triangle(size))] &= used[:, row] & used[:, column]


def _equalities(program: ConeProgram, alive: NDArray[np.bool_]) -> Equalities | None:
    """Return the equalities of the rows that are used; None without any, or with too many."""
    used, sizes = [], []
    for first, places in _diagonals(program):
        for begin, on in zip(first, places, strict=True):
            own = begin + np.arange(triangle(len(on)))
            if alive[on].any():
                used.append(own[alive[own]])
                sizes.append(int(alive[on].sum()))
    if not used:
        return None
    rows = np.concatenate(used)
    A = sp.csc_array(program.A[:, :-1].tocsr()[rows])
    A.eliminate_zeros()
    matrix = sp.csr_array(A[:, np.flatnonzero(np.diff(A.indptr))].T)
    if (matrix.shape[0] + 1) * matrix.shape[1] > LARGEST:
        return None
    matrix = _of_length_one(matrix)[_independent(matrix)]
    constant = program.b[rows]
    if constant.any():
        matrix = sp.vstack([matrix, _of_length_one(sp.csr_array(constant[None]))])
    return Equalities(
        rows,
        tuple(sizes),
        np.cumsum([0, *(len(own) for own in used)]),
        sp.csr_array(matrix),
        bool(constant.any()),
        program.A[:, [-1]].toarray().ravel()[rows],
    )


def _of_length_one(matrix: sp.csr_array) -> sp.csr_array:
    """Return the matrix with rows of length 1; each of them has an entry."""
    size = np.sqrt(np.add.reduceat(matrix.data**2, matrix.indptr[:-1]))
    data = matrix.data * np.repeat(1.0 / size, np.diff(matrix.indptr))
    return sp.csr_array((data, matrix.indices, matrix.indptr), shape=matrix.shape)


def _independent(matrix: sp.csr_array) -> Indices:
    """Return equalities from which the others follow."""
    from scipy.linalg import qr

    dense = _of_length_one(matrix).toarray()
    if not len(dense):
        return np.arange(0)
    # Clearly independent rows need no factorisation, which costs more than the eigenvalues.
    if np.linalg.eigvalsh(dense @ dense.T)[0] > 1e-6:
        return np.arange(len(dense))
    R, order = qr(dense.T, mode="r", pivoting=True)
    pivots = np.abs(np.diag(R))
    return np.sort(order[: int((pivots > DEPENDENT * pivots[0]).sum())])
