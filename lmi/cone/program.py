"""What a solver is given and what it gives back: cone data, and numbers with words."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

from takagi.lmi.cone.assemble import Assembled, Cone
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

    Parameters
    ----------
    margin : None keeps t as the last variable; a number fixes it, then y = x.
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
