"""The calls of a solver: cone data in, numbers out. Its status is recorded, but decides nothing.

The first solver is chosen from the sizes (``incidence``). The others follow if its numbers do
not pass their check: clarabel with the other chordal flag, with other regularisation, unscaled,
then whatever else is installed.

Rescaling of a program by its own solution, so that the solution has entries of order one.

A solver equilibrates the data before it knows the solution. If some unknowns are of size 1e5 and
others of size one, or if an LMI's entries differ as much at the solution, the solver meets its
tolerances long before its numbers are right (SDPLIB's hinf5 to hinf11).  Here variables are divided
by the size that they were found with, and every LMI is congruent to one whose diagonal equals that
of its multiplier; powers of two, so nothing is rounded.

Source: Nesterov and Todd (1997), Self-scaled barriers and interior-point methods for convex
programming, Mathematics of Operations Research 22, whose scaling this is, diagonal by diagonal.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import scipy.sparse as sp

from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.cone.cone_program import ConeProgram, Raw
from takagi.lmi.solver.installed_solvers import (
    WIDEST_UNGUIDED,
    Guide,
    guide,
    incidence,
    prefers_sdpa,
    sdpa_is_installed,
    with_sdpa,
)
from takagi.lmi.solver.time_limit import out_of_time, remaining, stopped
from takagi.models.arrays import Floats

# The largest ratio of the scales of LMIs, and of those of variables.
FARTHEST = 2.0**40
# Squares of scales stay within this and its inverse, where nothing overflows.
SMALLEST = 2.0**-400


class Scaling:
    """A program in other units, and the way back from its solutions."""

    def __init__(self, program: ConeProgram, variables: Floats, rows: Floats) -> None:
        self._variables, self._rows = variables, rows
        self._cost = float(nearest_power(np.array([np.abs(program.q * variables).max() or 1.0]))[0])
        A = sp.diags_array(1.0 / rows) @ program.A @ sp.diags_array(variables)
        self.program = replace(
            program, q=program.q * variables / self._cost, A=sp.csc_array(A), b=program.b / rows
        )

    def back(self, raw: Raw) -> Raw:
        """Return a solution of the scaled program as one of the program itself."""
        complete = len(raw.y) == len(self._variables) and len(raw.z) == len(self._rows)
        if not complete:
            return raw
        return replace(raw, y=raw.y * self._variables, z=raw.z * self._cost / self._rows)


def scaling_of(program: ConeProgram, raw: Raw) -> Scaling | None:
    """Return the scaling by a solution, however rough; None without a usable solution."""
    if len(raw.y) != len(program.q) or len(raw.z) != len(program.b):
        return None
    if not (np.isfinite(raw.y).all() and np.isfinite(raw.z).all()):
        return None
    size = np.abs(raw.y)
    # A variable that is zero in the solution has no size of its own; it gets a small one, not zero.
    variables = nearest_power(np.maximum(size, max(float(size.max(initial=0.0)), 1.0) / FARTHEST))
    slack = program.b - program.A @ raw.y
    rows = np.ones(len(program.b))
    linear = slice(0, program.linear)
    rows[linear] = _scales(slack[linear], raw.z[linear])
    for cone in program.cones:
        cone_rows = slice(program.linear + cone.rows.start, program.linear + cone.rows.stop)
        column, row = np.tril_indices(cone.size)
        on = np.flatnonzero(column == row)
        # Squares of the congruence's diagonal, (items, size).
        d2 = _scales(
            slack[cone_rows].reshape(cone.items, -1)[:, on],
            raw.z[cone_rows].reshape(cone.items, -1)[:, on],
        )
        # d itself is a power of two, so that all products d_i d_j are, and the scaling rounds
        # nothing.
        d = np.exp2(np.round(np.log2(np.clip(d2, SMALLEST, 1 / SMALLEST)) / 2))
        rows[cone_rows] = (d[:, row] * d[:, column]).ravel()
    return Scaling(program, variables, rows)


def _scales(slack: Floats, multiplier: Floats) -> Floats:
    """Return the root of slack over multiplier, where both are positive and far from zero."""
    if not slack.size:
        return slack
    bounded_values = []
    for values in (slack, multiplier):
        largest = max(float(np.abs(values).max()), 1e-200)
        bounded_values.append(np.maximum(values, largest / FARTHEST))
    return np.asarray(np.sqrt(bounded_values[0] / bounded_values[1]))


# Chordal decomposition is wrong on some published problems and right on others where the direct
# form fails (SDPLIB control1, hinf9).
VARIANTS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "clarabel": {},
        "clarabel, chordal": {"chordal_decomposition_enable": True},
        "clarabel, regularised": {
            "static_regularization_constant": 1e-7,
            "iterative_refinement_max_iter": 50,
        },
        "clarabel, unscaled": {"equilibrate_enable": False},
    }
)
# If the solution is of order one, clarabel reaches a hundredth of its usual tolerances.
CLOSER: Mapping[str, Any] = MappingProxyType(
    {"tol_feas": 1e-10, "tol_gap_abs": 1e-10, "tol_gap_rel": 1e-10}
)
# How the status of a solver that broke down begins.
FAILED = "failed"
# The number of program shapes for which a session keeps a solver.
SOLVERS_KEPT = 4


@dataclass(frozen=True, slots=True, eq=False)
class _Kept:
    """A solver that was set up for one pattern of A, and the zeros it was given."""

    program: ConeProgram
    zeros: Guide | None
    solver: Any

    def fits(self, program: ConeProgram) -> bool:
        mine, other = self.program, program
        return (
            (mine.A.shape, mine.linear, mine.cones) == (other.A.shape, other.linear, other.cones)
            and np.array_equal(mine.A.indptr, other.A.indptr)
            and np.array_equal(mine.A.indices, other.A.indices)
        )


class Session:
    """Solvers kept between programs of one shape, so that the next starts from their set-up.

    An updated solver keeps the scaling of the first program, so its digits differ from those of a
    new solver; only the verdicts can be compared.
    """

    def __init__(self) -> None:
        self._kept: list[_Kept] = []

    def solve(self, program: ConeProgram) -> Raw:
        """Solve by clarabel, updating a solver in place when only the numbers have changed."""
        started = time.perf_counter()
        if out_of_time():
            return _not_called("clarabel")
        # A solver keeps the limit that it was set up with.
        for solver in self._kept if remaining() is None else []:
            if solver.fits(program):
                A = program.A if solver.zeros is None else solver.zeros.filled(program.A)
                solver.solver.update(q=program.q, A=A.data, b=program.b)
                return self._run(solver, started)
        zeros = guide(program)
        new = _Kept(program, zeros, _clarabel(_filled(program, zeros), {}))
        self._kept = [new, *self._kept][:SOLVERS_KEPT]
        return self._run(new, started)

    def _run(self, solver: _Kept, started: float) -> Raw:
        """Solve, and forget a solver that broke down."""
        raw = run_clarabel(solver.solver, "clarabel", started)
        if raw.status.startswith(FAILED):
            self._kept = [
                session_solver for session_solver in self._kept if session_solver is not solver
            ]
        return raw


def attempts(program: ConeProgram, session: Session | None = None) -> Iterator[Raw]:
    """Yield one solver's answer after another; the caller stops when one passes its check."""
    if out_of_time():
        yield _not_called("clarabel")
        return
    zeros, sdpa_first = None, False
    if max(cone.size for cone in program.cones) > WIDEST_UNGUIDED:
        counts = incidence(program)
        zeros = guide(program, counts)
        sdpa_first = sdpa_is_installed() and prefers_sdpa(counts)
    if sdpa_first:
        yield with_sdpa(program)
    for name in VARIANTS:
        if out_of_time():
            return
        if name == "clarabel" and session is not None:
            yield session.solve(program)
        else:
            yield _variant(program, name, zeros)
    if not sdpa_first and sdpa_is_installed() and not out_of_time():
        yield with_sdpa(program)


def rescaled(program: ConeProgram, raw: Raw) -> Raw | None:
    """Return clarabel's answer where a solution that was found has entries of order one."""
    scaling = None if out_of_time() else scaling_of(program, raw)
    if scaling is None:
        return None
    started = time.perf_counter()
    solver = _clarabel(scaling.program, CLOSER)
    return scaling.back(run_clarabel(solver, "clarabel, rescaled", started))


def again(program: ConeProgram, name: str, session: Session | None = None) -> Raw:
    """Return the answer of the solver that has the name of an earlier ``Raw``."""
    if out_of_time():
        return _not_called(name)
    if name == "sdpa":
        return with_sdpa(program)
    if name == "clarabel" or name not in VARIANTS:
        return (Session() if session is None else session).solve(program)
    return _variant(program, name, guide(program))


def number_of_solvers() -> int:
    """Return how many solvers there are."""
    return len(VARIANTS) + int(sdpa_is_installed())


def _not_called(name: str) -> Raw:
    return Raw(name, "not called: out of time", np.zeros(0), np.zeros(0), 0, 0.0)


def _variant(program: ConeProgram, name: str, zeros: Guide | None) -> Raw:
    started, options = time.perf_counter(), VARIANTS[name]
    # Stored zeros would hide the sparsity that chordal decomposition uses.
    chordal = options.get("chordal_decomposition_enable", False)
    data = program if chordal else _filled(program, zeros)
    return run_clarabel(_clarabel(data, options), name, started)


def _filled(program: ConeProgram, zeros: Guide | None) -> ConeProgram:
    return program if zeros is None else replace(program, A=zeros.filled(program.A))


def _clarabel(program: ConeProgram, options: Mapping[str, Any]) -> Any:
    import clarabel

    settings = clarabel.DefaultSettings()
    settings.verbose = False
    # Presolve drops rows, after which neither update nor multipliers fit the condition.
    settings.presolve_enable = False
    settings.chordal_decomposition_enable = False
    if hasattr(settings, "max_threads"):
        # More than one thread has never been quicker, and rounds differently at every run.
        settings.max_threads = 1
    seconds_left = remaining()
    if seconds_left is not None:
        settings.time_limit = seconds_left
    for name, value in options.items():
        setattr(settings, name, value)
    cones = [clarabel.NonnegativeConeT(program.linear)] if program.linear else []
    for cone in program.cones:
        # A 1 x 1 semidefinite matrix is a number, and a linear inequality is cheaper for the
        # solver.
        if cone.size == 1:
            cones.append(clarabel.NonnegativeConeT(cone.items))
        else:
            cones.extend([clarabel.PSDTriangleConeT(cone.size)] * cone.items)
    size = len(program.q)
    nothing = sp.csc_matrix((size, size))
    A = sp.csc_matrix(program.A)
    return clarabel.DefaultSolver(nothing, program.q, A, program.b, cones, settings)


def run_clarabel(solver: Any, name: str, started: float) -> Raw:
    """Return what a clarabel solver that is set up finds; a breakdown is a status.

    ``started`` : the time by ``time.perf_counter`` from which the seconds count.
    """
    try:
        solution = solver.solve()
    except BaseException as error:
        # A panic inside clarabel (Rust) is a BaseException, not an Exception; the next solver is
        # then called as after any other failure.
        if type(error).__name__ != "PanicException":
            raise
        nothing = np.zeros(0)
        return Raw(name, f"{FAILED}: {error}", nothing, nothing, 0, time.perf_counter() - started)
    if "MaxTime" in str(solution.status):
        stopped()
    return Raw(
        name,
        str(solution.status),
        np.array(solution.x),
        np.array(solution.z),
        int(solution.iterations),
        time.perf_counter() - started,
    )
