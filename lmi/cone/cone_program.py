"""A condition as cone-program data, one PSD triangle an item, and bounds on its optimum.

For multipliers z in the dual cone the bound contains the residual A' z + q of the stationarity
condition times the size of y.  Only the size of the y that was found is known; ten times this size
is assumed for every feasible y.  So these bounds are as accurate as the solver, and not a proof.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from takagi.lmi.condition.term import LMI, Array, Condition, Term
from takagi.lmi.condition.unknown import triangle
from takagi.models.arrays import Floats, Indices


@dataclass(frozen=True, slots=True, eq=False)
class SolverRow:
    """coefficients . (x, t) <= bound."""

    coefficients: Floats
    bound: float


@dataclass(frozen=True, slots=True, eq=False)
class ConeProgram:
    """Minimise q . y with b - A y nonnegative in the first ``linear`` rows, then in ``cones``."""

    q: Floats
    A: sp.csc_array
    b: Floats
    linear: int
    cones: tuple[Cone, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Raw:
    """What a solver returned: its name and words, variables y, multipliers z, work done."""

    solver: str
    status: str
    y: Floats
    z: Floats
    iterations: int
    seconds: float


def cone_program(
    assembled: Assembled,
    minimise: Floats,
    rows: tuple[SolverRow, ...],
    *,
    margin: float | None = None,
) -> ConeProgram:
    """Return: minimise over y = (x, t) with rows, and every LMI held with margin t.

    ``margin`` : None keeps t as the last variable; a number fixes it, then y = x.
    """
    G, first = assembled.matrix().tocoo(), len(rows)
    b = assembled.constant
    # (row, column, value) of A, put together once: stacking sparse matrices takes longer.
    entries: list[tuple[Indices, Indices, Floats]] = [
        (np.asarray(first + G.row, dtype=np.intp), np.asarray(G.col, dtype=np.intp), -G.data)
    ]
    if margin is None:
        at = np.flatnonzero(assembled.margin_column)
        entries.append((first + at, np.full_like(at, G.shape[1]), assembled.margin_column[at]))
    else:
        b = b - margin * assembled.margin_column
    if rows:
        extra = np.array([row.coefficients for row in rows])
        row_of, column_of = np.nonzero(extra)
        entries.append((row_of, column_of, extra[row_of, column_of]))
    row, column, value = (np.concatenate(axis) for axis in zip(*entries, strict=True))
    shape = first + G.shape[0], G.shape[1] + (margin is None)
    A = sp.csc_array((value, (row, column)), shape=shape)
    bounds = np.array([row.bound for row in rows])
    return ConeProgram(minimise, A, np.concatenate([bounds, b]), len(rows), assembled.cones)


ALLOWED = 10.0
# b . z counts as negative if it is below minus this share of |b| . |z|, which exceeds rounding.
CLEARLY = 1e-6


def margin_bound(program: ConeProgram, raw: Raw) -> tuple[float, Floats]:
    """Return an upper bound on t, the last variable, and the multipliers made semidefinite.

    For z in the dual cone and all feasible y: t <= b . z - (A' z + q) . y, where q . y = -t.
    Without multipliers the bound is inf, and they are empty.  It is -inf where the multipliers
    leave no y at all, for any t: LMIs without a margin contradict one another.
    """
    if not _usable(program, raw):
        return np.inf, np.zeros(0)
    z = in_dual_cone(program, raw.z)
    residual = program.A.T @ z + program.q
    # Normalised multipliers leave no residual in t.
    scale = 1.0 + residual[-1]
    # Such multipliers hardly use the margin t, so they cannot bound it. They may still show that
    # the LMIs without a margin contradict one another.
    if scale <= 0.5:
        return -np.inf if _contradict(program, z, raw) else np.inf, z[program.linear :]
    z, residual = z / scale, (residual - program.q) / scale + program.q
    residual_bound = np.abs(residual[:-1]) @ _size(raw)[:-1]
    return float(program.b @ z + residual_bound), z[program.linear :]


def _contradict(program: ConeProgram, z: Floats, raw: Raw) -> bool:
    """Return whether 0 <= z . (b - A y) = b . z - (A' z) . y fails for all y of about that size."""
    value = float(program.b @ z)
    residual_bound = float(np.abs(program.A.T @ z) @ _size(raw))
    return value + residual_bound < -CLEARLY * float(np.abs(program.b) @ np.abs(z))


def least_objective_bound(program: ConeProgram, raw: Raw) -> float:
    """Return a lower bound on q . y over the program: -b . z - |A' z + q| . size of y.

    -inf without multipliers.
    """
    if not _usable(program, raw):
        return -np.inf
    z = in_dual_cone(program, raw.z)
    residual = program.A.T @ z + program.q
    return float(-program.b @ z - np.abs(residual) @ _size(raw))


def _usable(program: ConeProgram, raw: Raw) -> bool:
    complete = len(raw.z) == len(program.b) and len(raw.y) == len(program.q)
    return complete and bool(np.isfinite(raw.z).all() and np.isfinite(raw.y).all())


def _size(raw: Raw) -> Floats:
    return ALLOWED * np.maximum(1.0, np.abs(raw.y))


def in_dual_cone(program: ConeProgram, multipliers: Floats) -> Floats:
    """Return the nearest multipliers that are nonnegative and semidefinite."""
    z = multipliers.copy()
    z[: program.linear] = np.maximum(z[: program.linear], 0.0)
    for cone in program.cones:
        rows = slice(program.linear + cone.rows.start, program.linear + cone.rows.stop)
        # A solver's multipliers leave the cone by its tolerances, and only those inside give a
        # bound.
        eigenvalues, vectors = np.linalg.eigh(unpack(z[rows], cone.size))
        if eigenvalues.min() < 0:
            positive = np.maximum(eigenvalues, 0.0)
            z[rows] = pack((vectors * positive[:, None, :]) @ vectors.transpose(0, 2, 1)).ravel()
    return z


class Cone(NamedTuple):
    """``items`` cones of symmetric (size, size) matrices, whose rows start at ``start``."""

    size: int
    items: int
    start: int

    @property
    def rows(self) -> slice:
        return slice(self.start, self.start + self.items * triangle(self.size))


@dataclass(frozen=True, slots=True, eq=False)
class Assembled:
    """constant + matrix x - margin_column t in the cones: sign F(X) >= t weight I.

    Rows are the upper triangles, column by column, off-diagonals times sqrt(2).

    Attributes
    ----------
    condition : what was assembled.
    offsets : unknown name -> its first variable.
    entries : (row, column, value) of the matrix without parameters.
    parametric : parameter name -> the entries it multiplies.
    constant, margin_column : (rows,).
    objective : (variables,), zero without one.
    cones : one group per LMI, in the condition's order.
    """

    condition: Condition
    offsets: Mapping[str, int]
    entries: Triplets
    parametric: Mapping[str, Triplets]
    constant: Floats
    margin_column: Floats
    objective: Floats
    cones: tuple[Cone, ...]

    def matrix(self, parameters: Mapping[str, float] | None = None) -> sp.csc_array:
        """Return (rows, variables) at the given parameters, or the condition's own.

        The sparsity pattern is the same for all parameter values, so a solver that was set up
        for one can be updated to another.
        """
        values = {**self.condition.parameters, **(parameters or {})}
        summands = [self.entries]
        summands += [
            Triplets(triplets.row, triplets.column, triplets.value * values[name])
            for name, triplets in self.parametric.items()
        ]
        row, column, value = (np.concatenate(axis) for axis in zip(*summands, strict=True))
        shape = (len(self.constant), len(self.objective))
        return sp.csc_array(sp.coo_array((value, (row, column)), shape=shape))

    def values(self, x: Floats) -> dict[str, Floats]:
        """Return unknown name -> (count, rows, cols) from the solver's variables."""
        return {
            unknown.name: unknown.value(x[self.offsets[unknown.name] :][: unknown.length])
            for unknown in self.condition.unknowns
        }

    def multipliers(self, z: Floats) -> dict[str, Floats]:
        """Return LMI name -> (count, size, size) from the solver's dual variables."""
        return {
            lmi.name: unpack(z[cone.rows], cone.size)
            for lmi, cone in zip(self.condition.lmis, self.cones, strict=True)
        }


class Triplets(NamedTuple):
    """Entries of a sparse matrix; equal positions add up."""

    row: Indices
    column: Indices
    value: Floats


def assemble(condition: Condition) -> Assembled:
    """Return the cone data of a condition.

    Nothing is solved.  Memory grows with the number of nonzero products of coefficients only.

    Raises
    ------
    ModelError : a condition with equalities.
    """
    condition.refuse_equalities()
    offsets, variables = {}, 0
    for unknown in condition.unknowns:
        offsets[unknown.name] = variables
        variables += unknown.length
    cones, rows = [], 0
    for lmi in condition.lmis:
        cones.append(Cone(lmi.size, lmi.count, rows))
        rows += lmi.count * triangle(lmi.size)
    constant, margin_column = np.zeros(rows), np.zeros(rows)
    nothing = np.zeros(0, dtype=np.intp)
    groups: dict[str | None, list[Triplets]] = {None: [Triplets(nothing, nothing, np.zeros(0))]}
    for lmi, cone in zip(condition.lmis, cones, strict=True):
        constant[cone.rows] = pack(lmi.sign * _constant(lmi)).ravel()
        margin_column[cone.rows] = np.tile(pack(lmi.weight * np.eye(lmi.size)), lmi.count)
        for term in lmi.terms:
            triplets = _triplets(term, lmi, cone, offsets[term.unknown.name])
            groups.setdefault(term.parameter, []).append(triplets)
    joined = {
        name: Triplets(*(np.concatenate(axis) for axis in zip(*group, strict=True)))
        for name, group in groups.items()
    }
    base = joined.pop(None)
    parametric = {name: matrix for name, matrix in joined.items() if name is not None}
    return Assembled(
        condition,
        offsets,
        base,
        parametric,
        constant,
        margin_column,
        _objective(condition, variables, offsets),
        tuple(cones),
    )


def pack(matrices: Array) -> Floats:
    """Return (..., size (size + 1) / 2): upper triangles by columns, off-diagonals * sqrt(2)."""
    column, row, diagonal = _triangle_of(matrices.shape[-1])
    # With the factor sqrt(2) the scalar product of two packed triangles is trace(X Y).
    scale = np.where(diagonal, 1.0, np.sqrt(2.0))
    return np.asarray(matrices[..., row, column], dtype=np.float64) * scale


def unpack(numbers: Floats, size: int) -> Floats:
    """Return (count, size, size) symmetric matrices: the inverse of ``pack``."""
    column, row, diagonal = _triangle_of(size)
    scale = np.where(diagonal, 1.0, np.sqrt(0.5))
    packed = numbers.reshape(-1, triangle(size)) * scale
    matrices = np.empty((len(packed), size, size))
    matrices[:, row, column] = packed
    matrices[:, column, row] = packed
    return matrices


@lru_cache(maxsize=256)
def _triangle_of(size: int) -> tuple[Indices, Indices, NDArray[np.bool_]]:
    """Return column and row of each entry of a packed triangle, and whether it is diagonal.

    They are kept, since they are asked for more often than a triangle is packed.
    """
    column, row = np.tril_indices(size)
    indices = column, row, row == column
    for array in indices:
        array.flags.writeable = False
    return indices


def _objective(condition: Condition, variables: int, offsets: Mapping[str, int]) -> Floats:
    total = np.zeros(variables)
    for unknown in condition.unknowns:
        if unknown.name in condition.objective:
            members = np.arange(unknown.count)[:, None, None] * unknown.entries
            position = offsets[unknown.name] + members + unknown.entry_index()
            np.add.at(total, position, condition.objective[unknown.name].astype(np.float64))
    return total


def _constant(lmi: LMI) -> Floats:
    total = np.zeros((lmi.count, lmi.size, lmi.size))
    for constant in lmi.constants:
        row, column = lmi.spans(constant.at)
        # The lower triangle is never read, so a mirrored block is written where it counts.
        value = np.asarray(constant.value, dtype=np.float64)
        if row.start > column.start:
            row, column, value = column, row, value.transpose(0, 2, 1)
        total[:, row, column] += value
    return total


def _triplets(term: Term, lmi: LMI, cone: Cone, offset: int) -> Triplets:
    """Return the matrix entries of one term."""
    item, member, a, b, entry, value = _products(term, lmi.count)
    rows, columns = lmi.spans(term.at)
    row, column = a + rows.start, b + columns.start
    if rows == columns:
        if term.plus_transpose:
            # X + X' doubles the diagonal; off the diagonal both of its entries share one place.
            value = np.where(row == column, 2.0 * value, value)
        else:
            keep = row <= column
            item, member, entry, value = item[keep], member[keep], entry[keep], value[keep]
            row, column = row[keep], column[keep]
    low, high = np.minimum(row, column), np.maximum(row, column)
    value = np.where(low == high, value, np.sqrt(2.0) * value) * lmi.sign
    packed_row = cone.start + item * triangle(cone.size) + high * (high + 1) // 2 + low
    return Triplets(packed_row, offset + member * term.unknown.entries + entry, value)


def joined(left: Indices, right: Indices, count: int) -> tuple[Indices, Indices]:
    """Return every pair of positions in two lists of keys at which the keys are equal.

    ``right`` : in rising order.  ``count`` : keys are below it.
    """
    per = np.bincount(right, minlength=count)
    first, repeats = np.cumsum(per) - per, per[left]
    i = np.repeat(np.arange(len(left)), repeats)
    within = np.arange(len(i)) - np.repeat(np.cumsum(repeats) - repeats, repeats)
    return i, first[left[i]] + within


def _products(term: Term, count: int) -> tuple[Indices, Indices, Indices, Indices, Indices, Floats]:
    """Return item, member, block row, block column, entry, value of every nonzero product."""
    item, member, left, right = term.spread(count)
    left = np.asarray(left, dtype=np.float64)
    index = term.unknown.entry_index()
    t, a, k = np.nonzero(left)
    if right is None:
        return item[t], member[t], a, k, np.zeros_like(a), left[t, a, k]
    right = np.asarray(right, dtype=np.float64)
    s, m, b = np.nonzero(right)
    i, j = joined(t, s, len(right))
    value = left[t[i], a[i], k[i]] * right[s[j], m[j], b[j]]
    return item[t[i]], member[t[i]], a[i], b[j], index[k[i], m[j]], value
