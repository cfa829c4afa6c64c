"""Turn a condition into cone data: one PSD triangle per LMI item, without a loop over items."""

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
    groups: dict[str | None, list[Triplets]] = {None: [_none()]}
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


def _none() -> Triplets:
    nothing = np.zeros(0, dtype=np.intp)
    return Triplets(nothing, nothing, np.zeros(0))


def _objective(condition: Condition, variables: int, offsets: Mapping[str, int]) -> Floats:
    total = np.zeros(variables)
    for unknown in condition.unknowns:
        if unknown.name in condition.objective:
            start = offsets[unknown.name]
            total[start : start + unknown.length] = _cost(
                condition.objective[unknown.name], unknown.entry_index(), unknown.entries
            )
    return total


def _cost(cost: Array, index: Indices, entries: int) -> Floats:
    flat = np.zeros((len(cost), entries))
    members = np.arange(len(cost))[:, None, None]
    np.add.at(flat, (members, index[None]), np.asarray(cost, dtype=np.float64))
    return flat.ravel()


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
    # Join the two lists on the contribution: every left entry meets every right entry of its t.
    per = np.bincount(s, minlength=len(right))
    first = np.cumsum(per) - per
    repeats = per[t]
    i = np.repeat(np.arange(len(t)), repeats)
    within = np.arange(len(i)) - np.repeat(np.cumsum(repeats) - repeats, repeats)
    j = first[t[i]] + within
    value = left[t[i], a[i], k[i]] * right[s[j], m[j], b[j]]
    return item[t[i]], member[t[i]], a[i], b[j], index[k[i], m[j]], value
