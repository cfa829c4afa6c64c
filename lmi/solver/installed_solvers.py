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

sdpa, called on the cone data themselves; used where the package ``sdpa-python`` is installed.

In SeDuMi's form its dual is ours: maximise b' y with c - A' y in the cones, b = -q.  Cones are
whole matrices there, linear rows first.

Source: Yamashita, Fujisawa, Fukuda, Kobayashi, Nakata and Nakata (2012), Latest developments in
the SDPA family for solving large-scale SDPs, Handbook on Semidefinite, Conic and Polynomial
Optimization.
"""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np
import scipy.sparse as sp

from takagi.lmi.condition.unknown import triangle
from takagi.lmi.cone.cone_program import ConeProgram, Raw
from takagi.lmi.solver.time_limit import remaining, stopped
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


# The starting points: multiples of the identity, which must be larger than the solution. If one is
# too small, sdpa stops at once without a step; then it is called again with a larger one.
BEGINNINGS = (10.0, 1e4)
SMALLEST_BEGINNING = 1e2
STUCK = 3
# The default number of iterations of sdpa.
MOST_ITERATIONS = 100


def sdpa_is_installed() -> bool:
    """Return whether sdpa can be imported; it is not imported yet."""
    return find_spec("sdpap") is not None


def with_sdpa(program: ConeProgram) -> Raw:
    """Solve the program; y and z as clarabel's."""
    started = time.perf_counter()
    expansion, sizes = _whole(program)
    # The one entry point that takes SeDuMi's form as it is; the documented one converts first.
    solve = import_module("sdpap.sdpacall.sdpacall").solve_sdpa
    wide = tuple(size for size in sizes if size > 1)
    cone = import_module("sdpap.symcone").SymCone(l=program.linear + sizes.count(1), s=wide)
    A = sp.csc_matrix((expansion @ program.A).T)
    b, c = sp.csc_matrix(-program.q[:, None]), sp.csc_matrix((expansion @ program.b)[:, None])
    param = import_module("sdpap.param").param
    largest = max(SMALLEST_BEGINNING, float(np.abs(program.b).max(initial=0.0)))
    for times in BEGINNINGS:
        options = param({"print": "no", "lambdaStar": times * largest}) | _iterations(program)
        with quiet(1):
            x, y, _, info = solve(A, b, c, cone, options)
        if "maxIteration" in options and info["iteration"] >= options["maxIteration"]:
            stopped()
        if info["iteration"] >= STUCK:
            break
    return Raw(
        "sdpa",
        str(info["phasevalue"]),
        np.asarray(y.toarray(), dtype=np.float64).ravel(),
        expansion.T @ np.asarray(x.toarray(), dtype=np.float64).ravel(),
        int(info["iteration"]),
        time.perf_counter() - started,
    )


def _iterations(program: ConeProgram) -> dict[str, Any]:
    """Return how many iterations fit the time limit, by a model: sdpa has no time limit."""
    seconds_left = remaining()
    if seconds_left is None:
        return {}
    fit = max(1, int(seconds_left / sdpa_iteration(incidence(program))))
    return {"maxIteration": fit} if fit < MOST_ITERATIONS else {}


def _whole(program: ConeProgram) -> tuple[sp.csr_array, list[int]]:
    """Return S with S (packed rows) = linear rows, cones of size 1, whole matrices; cones' sizes.

    S' maps whole multipliers back to packed ones.
    """
    blocks: list[Any] = [sp.eye_array(program.linear)]
    blocks += [sp.kron(sp.eye_array(cone.items), _unpacking(cone.size)) for cone in program.cones]
    wide = [np.zeros(program.linear, dtype=bool)]
    wide += [np.full(cone.items * cone.size**2, cone.size > 1) for cone in program.cones]
    order = np.argsort(np.concatenate(wide), kind="stable")
    sizes = [size for cone in program.cones for size in [cone.size] * cone.items]
    return sp.csr_array(sp.block_diag(blocks, format="csr")[order]), sizes


@contextmanager
def quiet(descriptor: int) -> Iterator[None]:
    """Suppress what a solver writes directly to the standard output (1) or to that of errors (2).

    Anything that other threads write there in the meantime is lost too.
    """
    (sys.stdout, sys.stderr)[descriptor - 1].flush()
    try:
        original = os.dup(descriptor)
    except OSError:
        # There is no such output, so there is nothing to keep clean.
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, descriptor)
    try:
        yield
    finally:
        os.dup2(original, descriptor)
        os.close(original)
        os.close(nowhere)


def _unpacking(size: int) -> sp.csr_array:
    """Return S with S (packed triangle) = whole matrix; entries off the diagonal over sqrt(2)."""
    column, row = np.tril_indices(size)
    packed = np.arange(triangle(size))
    scale = np.where(row == column, 1.0, np.sqrt(0.5))
    off = row != column
    position = np.concatenate([row + size * column, (column + size * row)[off]])
    source = np.concatenate([packed, packed[off]])
    values = np.concatenate([scale, scale[off]])
    return sp.csr_array((values, (position, source)), shape=(size * size, triangle(size)))
