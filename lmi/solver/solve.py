"""The calls of a solver: cone data in, numbers out. Its status is recorded, but decides nothing.

The first solver is chosen from the sizes (``solver_choice``). The others follow if its numbers do
not pass their check: clarabel with the other chordal flag, with other regularisation, unscaled,
then whatever else is installed.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
import scipy.sparse as sp

from takagi.lmi.cone.program import ConeProgram, Raw
from takagi.lmi.solver.cvxpy_solvers import with_others
from takagi.lmi.solver.elimination_order import Guide, guide
from takagi.lmi.solver.incidence import incidence
from takagi.lmi.solver.rescaled import scaling_of
from takagi.lmi.solver.sdpa_solver import sdpa_is_installed, with_sdpa
from takagi.lmi.solver.solver_choice import prefers_sdpa
from takagi.lmi.solver.time_limit import out_of_time, remaining, stopped

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
KEPT = 4


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
        for kept in self._kept if remaining() is None else []:
            if kept.fits(program):
                A = program.A if kept.zeros is None else kept.zeros.filled(program.A)
                kept.solver.update(q=program.q, A=A.data, b=program.b)
                return self._run(kept, started)
        zeros = guide(program)
        new = _Kept(program, zeros, _clarabel(_filled(program, zeros), {}))
        self._kept = [new, *self._kept][:KEPT]
        return self._run(new, started)

    def _run(self, kept: _Kept, started: float) -> Raw:
        """Solve, and forget a solver that broke down."""
        raw = _run(kept.solver, "clarabel", started)
        if raw.status.startswith(FAILED):
            self._kept = [one for one in self._kept if one is not kept]
        return raw


def attempts(program: ConeProgram, session: Session | None = None) -> Iterator[Raw]:
    """Yield one solver's answer after another; the caller stops when one passes its check."""
    if out_of_time():
        yield _not_called("clarabel")
        return
    zeros, sdpa_first = _advice(program)
    if sdpa_first:
        yield with_sdpa(program)
    for name in VARIANTS:
        if out_of_time():
            return
        if name == "clarabel" and session is not None:
            yield session.solve(program)
        else:
            yield _variant(program, name, zeros)
    if out_of_time():
        return
    if not sdpa_first and sdpa_is_installed():
        yield with_sdpa(program)
    yield from with_others(program)


def rescaled(program: ConeProgram, raw: Raw) -> Raw | None:
    """Return clarabel's answer where a solution that was found has entries of order one."""
    scaling = None if out_of_time() else scaling_of(program, raw)
    if scaling is None:
        return None
    started = time.perf_counter()
    solver = _clarabel(scaling.program, CLOSER)
    return scaling.back(_run(solver, "clarabel, rescaled", started))


def again(program: ConeProgram, name: str, session: Session | None = None) -> Raw:
    """Return the answer of the solver that has the name of an earlier ``Raw``."""
    if out_of_time():
        return _not_called(name)
    if name == "sdpa":
        return with_sdpa(program)
    if name == "clarabel" or name not in VARIANTS:
        return (Session() if session is None else session).solve(program)
    return _variant(program, name, guide(program))


def quick() -> int:
    """Return how many attempts come before the solvers that are slow to pose."""
    return len(VARIANTS) + int(sdpa_is_installed())


def _not_called(name: str) -> Raw:
    return Raw(name, "not called: out of time", np.zeros(0), np.zeros(0), 0, 0.0)


def _variant(program: ConeProgram, name: str, zeros: Guide | None) -> Raw:
    started, options = time.perf_counter(), VARIANTS[name]
    # Stored zeros would hide the sparsity that chordal decomposition uses.
    chordal = options.get("chordal_decomposition_enable", False)
    given = program if chordal else _filled(program, zeros)
    return _run(_clarabel(given, options), name, started)


def _advice(program: ConeProgram) -> tuple[Guide | None, bool]:
    """Return the zeros that help clarabel, and whether sdpa is called before it."""
    if max(cone.size for cone in program.cones) <= 8:
        return None, False
    found = incidence(program)
    return guide(program, found), sdpa_is_installed() and prefers_sdpa(found)


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
    left = remaining()
    if left is not None:
        settings.time_limit = left
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


def _run(solver: Any, name: str, started: float) -> Raw:
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
