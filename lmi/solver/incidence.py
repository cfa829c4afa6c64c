"""Which variable of a cone program appears in which cone.

Explicit zeros that keep clarabel's elimination order from joining all cones to one.

clarabel factors [[eps I, A'], [A, -W]], W with one dense block a cone, in an order of least degree.
A variable that appears in few rows of many cones (a slack in every pair of rules, a gain, the norm
bound) has the least degree of all; eliminated first, it joins these cones to one dense block.
Zeros that are stored give it the degree of a whole cone, so the cones are eliminated one by one,
and the variables last.  Measured: 36 LMIs of width 21 with a common slack in 3.5 s instead of 93,
without in 1.9 s instead of 5.9.

The choice of the first solver, by a model of the time of an iteration.

The two models were fitted to 70 programs (Lyapunov, compensation, energy gain, discrete time; six
relaxations; cones 2 to 84 wide, 4 to 2500 variables) on one core: two of three times lie within a
factor 1.3 of the model for clarabel, and within 1.5 for sdpa. sdpa is preferred only if it is
clearly quicker and the program takes long.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp

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


# Cones with fewer rows than this are factored quickly in any order.
WIDEST_UNGUIDED = 8
# A variable of only two cones may be eliminated first: it joins these two in any order.
MANY_CONES = 3
# If a variable's degree is more than this many times the rows of its largest cone, it is high
# enough without zeros.
ENOUGH = 1.25


@dataclass(frozen=True, slots=True, eq=False)
class Guide:
    """The pattern of A with the zeros, and where the entries of A appear in it."""

    indices: Indices
    indptr: Indices
    stored: Indices

    def filled(self, A: sp.csc_array) -> sp.csc_array:
        """Return A with the zeros; its pattern must be that of the guide's program."""
        data = np.zeros(len(self.indices))
        data[self.stored] = A.data
        return sp.csc_array((data, self.indices, self.indptr), shape=A.shape)


def guide(program: ConeProgram, inside: Incidence | None = None) -> Guide | None:
    """Return the zeros for a program; None if they would not help."""
    if max(cone.size for cone in program.cones) <= WIDEST_UNGUIDED:
        return None
    counts = incidence(program) if inside is None else inside
    variable, cone = _raised(counts)
    if not len(variable):
        return None
    A, count = program.A, counts.rows[cone]
    first_row = np.cumsum(count) - count
    row = np.repeat(counts.first[cone] - first_row, count) + np.arange(count.sum())
    column = np.repeat(np.arange(A.shape[1]), counts.degree)
    old = column * A.shape[0] + A.indices
    keys = np.union1d(old, np.repeat(variable, count) * A.shape[0] + row)
    indptr = np.searchsorted(keys, np.arange(A.shape[1] + 1) * A.shape[0])
    return Guide(keys % A.shape[0], indptr, np.searchsorted(keys, old))


def _raised(counts: Incidence) -> tuple[Indices, Indices]:
    """Return the variables whose degree is raised, and in which cone: a largest that each has.

    The cones are taken in turns, because clarabel's ordering treats a row with many entries as
    dense and puts it last.
    """
    turn = (counts.cone + counts.variable) % len(counts.size)
    order = np.lexsort((turn, counts.rows[counts.cone], counts.variable))
    last = np.cumsum(np.bincount(counts.variable))
    variable, cone = counts.variable[order], counts.cone[order]
    ends = np.unique(last[last > 0]) - 1
    variable, cone = variable[ends], cone[ends]
    many = counts.touched[variable] >= MANY_CONES
    low = counts.degree[variable] < ENOUGH * counts.rows[cone]
    return variable[many & low], cone[many & low]


# clarabel is called first if it takes less than this many seconds, or if sdpa is not so many times
# quicker.
LONG, CLEARLY = 0.5, 1.5
ITERATIONS_CLARABEL, ITERATIONS_SDPA = 25, 30


def prefers_sdpa(counts: Incidence) -> bool:
    """Return whether sdpa is expected to be clearly quicker than clarabel."""
    clarabel = ITERATIONS_CLARABEL * clarabel_iteration(counts)
    return clarabel > LONG and clarabel > CLEARLY * ITERATIONS_SDPA * sdpa_iteration(counts)


def clarabel_iteration(counts: Incidence) -> float:
    """Return about the seconds of one iteration: factors of a dense block a cone.

    The cones are eliminated one by one, then the variables that they share.  A variable of two
    cones is eliminated before the wider of them.
    """
    rows = counts.rows.astype(np.float64)
    shared = counts.touched[counts.variable] >= 3
    joined = np.where(shared, 1.0, 0.0)
    small_cones = rows[counts.cone] < rows.max()
    joined += np.where((counts.touched[counts.variable] == 2) & small_cones, 1.0, 0.0)
    p = np.bincount(counts.cone, joined, len(rows))
    last = float(np.count_nonzero(counts.touched >= 3))
    return float(
        9e-6 * len(rows)
        + 4.1e-8 * (rows**2).sum()
        + 1.7e-11 * (rows**3).sum() / 3
        + 5.1e-11 * ((rows**2 * p + rows * p**2).sum() + last**3 / 3)
    )


def sdpa_iteration(counts: Incidence) -> float:
    """Return about the seconds of one iteration: the Schur complement, formed and factored."""
    n = counts.size.astype(np.float64)
    p = np.bincount(counts.cone, minlength=len(n)).astype(np.float64)
    dense, sparse = p * n**3 + p**2 * n**2 / 2, counts.entries.astype(np.float64) ** 2
    return float(
        1.8e-5 * len(n)
        + 7.2e-11 * len(counts.touched) ** 3 / 3
        + 2.1e-10 * np.minimum(dense, sparse).sum()
        + 3.2e-8 * np.minimum(p * n**2, counts.entries * n).sum()
        + 8.9e-8 * counts.degree.sum()
    )
