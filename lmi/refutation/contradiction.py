r"""Multipliers that prove that a set of LMIs has no solution of any size.

A solver returns approximate multipliers z.  They bound the margin only for unknowns of moderate
size, for two reasons: the solver neglects the residual A' z, which large unknowns amplify, and it
treats a margin below its tolerance as zero.  If gains are 1e5 times the states that they multiply,
solutions are large and their margins are small, and both approximations fail.  The LMIs b - A x
have no solution of any size if some z in the dual cone satisfies

    A' z = 0    and    b . z < 0,    or b . z = 0 and z is nonzero at a strict LMI.

The search starts from the given multipliers Z_k = L_k L_k'.  It takes L_k (I + S_k) L_k' with
|S_k| < 1, which stays in the cone, and computes the smallest S with A' z = 0 from a linear system.
The result allows for the rounding errors of A' z: if the system has a solution here, it has one in
exact arithmetic.  If the LMIs have a solution, no such z exists, even when the margin is small.  If
every such z is singular, only exact arithmetic finds one (``exact_no``).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from takagi.lmi.condition.unknown import triangle
from takagi.lmi.cone.cone_program import ConeProgram, pack, unpack
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
        columns_of = np.repeat(np.arange(columns.shape[1]), np.diff(columns.indptr))
        matrices = []
        for entries, size in self.parts():
            stored = slice(columns.indptr[entries.start], columns.indptr[entries.stop])
            equalities, row = np.unique(columns.indices[stored], return_inverse=True)
            packed = np.zeros((len(equalities), entries.stop - entries.start))
            packed[row, columns_of[stored] - entries.start] = columns.data[stored]
            matrices.append((equalities.astype(np.intp), unpack(packed, size)))
        return tuple(matrices)

    def spread(self, z: Floats, count: int) -> Floats:
        """Return the multipliers of all rows of the program."""
        all_rows = np.zeros(count)
        all_rows[self.rows] = z
        return all_rows

    def parts(self) -> Iterator[tuple[slice, int]]:
        for start, end, size in zip(self.starts, self.starts[1:], self.sizes, strict=False):
            yield slice(int(start), int(end)), size


def equalities_of(program: ConeProgram, z: Floats, share: float) -> Equalities | None:
    """Return the equalities; None without any multiplier that may differ from 0, or if too large.

    ``program`` : with the margin as its last variable.
    ``share`` : of the largest multiplier, below which a coordinate is left out.
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

    A semidefinite multiplier with a zero diagonal entry has zeros in that row and column.
    """
    A = sp.csr_array(program.A[:, :-1])
    A.eliminate_zeros()
    entries = A.tocoo()
    row, variable = entries.row.astype(np.intp), entries.col.astype(np.intp)
    sign = np.sign(entries.data)
    groups = list(_diagonals(program))
    diagonal = np.zeros(len(program.b), dtype=bool)
    for _, diagonal_rows in groups:
        diagonal[diagonal_rows] = True
    alive = np.ones(len(program.b), dtype=bool)
    empty = np.diff(A.indptr) == 0
    alive[: program.linear] = ~(empty[: program.linear] & (program.b[: program.linear] >= 0))
    if share:
        largest = float(np.abs(z[diagonal]).max())
        alive[diagonal] &= z[diagonal] > share * largest
        _spread(groups, alive)
    while True:
        dead = forced_to_zero(alive, diagonal, variable, row, sign, program.b)
        if not dead.any():
            return alive
        alive &= ~dead
        _spread(groups, alive)


def forced_to_zero(
    alive: NDArray[np.bool_],
    diagonal: NDArray[np.bool_],
    row: Indices,
    column: Indices,
    sign: Floats,
    constant: NDArray[Any],
) -> NDArray[np.bool_]:
    """Return which entries of multipliers, of those that are alive, an equality forces to be 0.

    A row, or the constant, whose living entries are all diagonal and of one sign forces them.

    ``row``, ``column``, ``sign`` : of the entries of the equalities; a column is an entry of a
    multiplier.
    """
    here = alive[column]
    row, column, rows = row[here], column[here], int(row.max(initial=-1)) + 1
    count = np.bincount(row, minlength=rows)
    signs = np.abs(np.bincount(row, sign[here], minlength=rows))
    on_diagonal = np.bincount(row, diagonal[column], minlength=rows)
    closed = (signs == count) & (on_diagonal == count)
    dead = np.zeros(len(alive), dtype=bool)
    dead[column[closed[row]]] = True
    in_constant = alive & (constant != 0)
    if diagonal[in_constant].all() and (constant[in_constant] > 0).all():
        dead |= in_constant
    return dead


def _spread(groups: list[tuple[Indices, Indices]], alive: NDArray[np.bool_]) -> None:
    """Leave out the rows and columns of diagonal entries that are left out."""
    for first, diagonal_rows in groups:
        size = diagonal_rows.shape[1]
        column, row = np.tril_indices(size)
        open_rows = alive[diagonal_rows]
        alive[first[:, None] + np.arange(triangle(size))] &= (
            open_rows[:, row] & open_rows[:, column]
        )


def _equalities(program: ConeProgram, alive: NDArray[np.bool_]) -> Equalities | None:
    """Return the equalities of the rows that are used; None without any, or with too many."""
    open_rows, sizes = [], []
    for first, diagonal_rows in _diagonals(program):
        for begin, on in zip(first, diagonal_rows, strict=True):
            triangle_rows = begin + np.arange(triangle(len(on)))
            if alive[on].any():
                open_rows.append(triangle_rows[alive[triangle_rows]])
                sizes.append(int(alive[on].sum()))
    if not open_rows:
        return None
    rows = np.concatenate(open_rows)
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
        np.cumsum([0, *(len(triangle_rows) for triangle_rows in open_rows)]),
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


# The number of corrections, and the largest |S| of one correction.  At |S| = 1 the multiplier
# I + S may become singular and leave the cone.
STEPS, FARTHEST = 6, 0.9
# If one of the first two corrections asks for a larger |S| than this, the search ends without a
# result: the corrections do not converge.
HOPELESS = 30.0
# Later, |S| may be at most this multiple of the last one; a larger one means divergence.  The first
# one is no measure, because it also removes what ``BEGIN`` added.
NEARER = 1.5
# The rounding error of A' z, relative to the sum of the absolute values of its terms; and the
# largest |S| of the last correction with the effect of that error included.
ROUNDING, ROOM = 8.0 * np.finfo(float).eps, 0.5
# Pairs that are tried in this order.  First: a coordinate is left out if it is below this share of
# the largest multiplier.  Second: a number that is added to the other eigenvalues, to move the
# multipliers away from the boundary of the cone.  The addition is harmless if b . z is clearly
# negative, and is tried only then.
BEGIN = ((0.0, 0.0), (0.0, 1e-8), (0.0, 1e-6), (1e-5, 0.0))
# Eigenvalues are raised by at least this, relative to the largest entry: a solver may leave small
# negative ones.
SMALLEST_EIGENVALUE = 1e-13


def contradiction(program: ConeProgram, z: Floats) -> Floats | None:
    """Return multipliers that exclude every solution; None if none are found near z.

    ``program`` : with the margin as its last variable.
    ``z`` : (rows,) in the dual cone, as a solver leaves them.
    """
    if len(z) != len(program.b) or not np.isfinite(z).all() or not z.any():
        return None
    posed: dict[float, Equalities | None] = {}
    for share, added in BEGIN:
        if share not in posed:
            posed[share] = equalities_of(program, z, share)
        equalities = posed[share]
        if equalities is None or (added and not equalities.constant):
            continue
        corrected = _corrected(equalities, z, added)
        if corrected is not None:
            return equalities.spread(corrected, len(z))
    return None


def _corrected(posed: Equalities, multipliers: Floats, added: float) -> Floats | None:
    """Return multipliers near the given ones that satisfy the equalities up to rounding."""
    z = multipliers[posed.rows] / np.abs(multipliers[posed.rows]).max()
    previous = HOPELESS
    for step in range(STEPS):
        factors = [
            _factor(z[entries], size, 0.0 if step else added) for entries, size in posed.parts()
        ]
        z = np.concatenate([pack(L @ L.T) for L in factors])
        residual = posed.matrix @ z
        size = abs(posed.matrix) @ np.abs(z)
        if posed.constant:
            # The last row is b . z.  Only its positive part is corrected; the term 1e-9 keeps it
            # below zero by more than rounding can add.
            residual[-1] = max(residual[-1] + 1e-9 * size[-1], 0.0)
        s, reach = _least(_moved(posed, factors), residual, ROUNDING * size)
        if s is None:
            return None
        moves = [unpack(s[entries], size)[0] for entries, size in posed.parts()]
        farthest = max(float(np.abs(np.linalg.eigvalsh(move)).max()) for move in moves)
        share = 1.0 if farthest < FARTHEST else FARTHEST / farthest
        z = np.concatenate(
            [
                pack(L @ (np.eye(len(move)) + share * move) @ L.T)
                for L, move in zip(factors, moves, strict=True)
            ]
        )
        if farthest + reach < ROOM:
            return z if posed.constant or posed.strict @ z > 0 else None
        if farthest > (previous if step != 1 else HOPELESS):
            return None
        previous = max(NEARER * farthest, ROOM)
    return None


def _factor(packed: Floats, size: int, added: float) -> Floats:
    """Return L with L L' close to the multiplier; negative eigenvalues become zero first."""
    values, vectors = np.linalg.eigh(unpack(packed, size)[0])
    return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0) + max(added, SMALLEST_EIGENVALUE)))


def _moved(posed: Equalities, factors: list[Floats]) -> Floats:
    """Return the equalities in S of Z = L (I + S) L', (equalities, entries)."""
    in_moves = np.zeros(posed.matrix.shape)
    for (entries, _), (equalities, matrices), L in zip(
        posed.parts(), posed.coefficients, factors, strict=True
    ):
        if len(equalities):
            in_moves[equalities, entries] = pack(L.T @ matrices @ L)
    return in_moves


def _least(matrix: Floats, residual: Floats, noise: Floats) -> tuple[Floats | None, float]:
    """Return the smallest s with matrix s = -residual, and a bound on what its noise adds."""
    size = np.linalg.norm(matrix, axis=1)
    if not len(size):
        # There are no equalities, because no LMI depends on an unknown.
        return np.zeros(matrix.shape[1]), 0.0
    if not size.all():
        return None, np.inf
    scaled = matrix / size[:, None]
    values, vectors = np.linalg.eigh(scaled @ scaled.T)
    # Equalities that depend on each other up to rounding have no well-defined solution in floats.
    if values[0] <= 1e-14 * len(values) * values[-1]:
        return None, np.inf
    step = -scaled.T @ (vectors @ ((vectors.T @ (residual / size)) / values))
    return step, float(np.linalg.norm(noise / size) / np.sqrt(values[0]))
