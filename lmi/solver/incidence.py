"""Which variable of a cone program appears in which cone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.lmi.cone.program import ConeProgram
from takagi.models.arrays import Indices


@dataclass(frozen=True, slots=True, eq=False)
class Incidence:
    """Pairs (variable, cone), one for each cone in which a variable appears.

    Attributes
    ----------
    size, first, rows : (cones,) width of a cone, its first row in A, how many rows it has.
    variable, cone : (pairs,) by variable, then by cone.
    touched : (variables,) in how many cones each variable appears.
    degree : (variables,) in how many rows.
    entries : (cones,) entries of A in each.
    """

    size: Indices
    first: Indices
    rows: Indices
    variable: Indices
    cone: Indices
    touched: Indices
    degree: Indices
    entries: Indices


def incidence(program: ConeProgram) -> Incidence:
    """Return the pairs, in one pass over the entries of A."""
    A = program.A if program.A.has_sorted_indices else program.A.sorted_indices()
    size = np.concatenate([np.full(cone.items, cone.size) for cone in program.cones])
    rows = size * (size + 1) // 2
    first = program.linear + np.cumsum(rows) - rows
    owner = np.repeat(np.arange(-1, len(size)), np.concatenate([[program.linear], rows]))
    degree = np.diff(A.indptr)
    cone, variable = owner[A.indices], np.repeat(np.arange(A.shape[1]), degree)
    inside = cone >= 0
    cone, variable = cone[inside], variable[inside]
    entries = np.bincount(cone, minlength=len(size))
    # Row numbers increase within a column, so the entries of a pair are adjacent.
    new = np.ones(len(cone), dtype=bool)
    new[1:] = (cone[1:] != cone[:-1]) | (variable[1:] != variable[:-1])
    variable, cone = variable[new], cone[new]
    touched = np.bincount(variable, minlength=A.shape[1])
    return Incidence(size, first, rows, variable, cone, touched, degree, entries)
