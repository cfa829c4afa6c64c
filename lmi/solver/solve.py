"""The only calls of a solver: cone data in, numbers out.  Its word is recorded, never believed."""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib import import_module
from types import MappingProxyType
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from takagi.lmi.solver.assemble import Assembled, Cone
from takagi.lmi.unknown import triangle

__all__ = ["ConeProgram", "Raw", "Row", "Session", "attempts", "cone_program"]

Floats = NDArray[np.float64]

# Tried in this order until an answer withstands its check.  Chordal decomposition is wrong on
# some published problems and right on others where the direct form fails (SDPLIB control1, hinf9).
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
# Other solvers, through cvxpy, when they are installed; most accurate first.
OTHERS = ("MOSEK", "SDPA", "CVXOPT", "SCS")
SECONDS_FOR_OTHERS = 20.0


@dataclass(frozen=True, slots=True, eq=False)
class Row:
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
    rows: tuple[Row, ...],
    *,
    margin: float | None = None,
    parameters: Mapping[str, float] | None = None,
) -> ConeProgram:
    """Return: minimise over y = (x, t) with rows, and every LMI held with margin t.

    Parameters
    ----------
    margin : None keeps t as the last variable; a number fixes it, then y = x.
    """
    G = assembled.matrix(parameters)
    b = assembled.constant
    if margin is None:
        G = sp.hstack([G, -sp.csc_array(assembled.margin_column[:, None])], format="csc")
    else:
        b = b - margin * assembled.margin_column
    if rows:
        extra = sp.csc_array(np.array([row.coefficients for row in rows]))
        A = sp.vstack([extra, -G], format="csc")
    else:
        A = -G
    bounds = np.array([row.bound for row in rows])
    return ConeProgram(minimise, A, np.concatenate([bounds, b]), len(rows), assembled.cones)


class Session:
    """A solver kept between programs of one shape, so that the next starts from its set-up.

    An updated solver keeps the scaling of the first program: compare verdicts with a fresh one,
    not digits.
    """

    def __init__(self) -> None:
        self._solver: Any = None
        self._shape: tuple[object, ...] = ()

    def solve(self, program: ConeProgram) -> Raw:
        """Solve, updating the solver in place when only the numbers have changed."""
        started = time.perf_counter()
        A = program.A
        shape = (A.shape, program.cones, A.indices.tobytes(), A.indptr.tobytes())
        if self._solver is not None and shape == self._shape:
            self._solver.update(q=program.q, A=A.data, b=program.b)
        else:
            self._solver, self._shape = _clarabel(program, {}), shape
        return _run(self._solver, "clarabel", started)


def attempts(program: ConeProgram, session: Session | None = None) -> Iterator[Raw]:
    """Yield one solver's answer after another; stop asking when one withstands its check."""
    for name, options in VARIANTS.items():
        if name == "clarabel" and session is not None:
            yield session.solve(program)
            continue
        started = time.perf_counter()
        yield _run(_clarabel(program, options), name, started)
    yield from _others(program)


def _clarabel(program: ConeProgram, options: Mapping[str, Any]) -> Any:
    import clarabel

    settings = clarabel.DefaultSettings()
    settings.verbose = False
    # Presolve drops rows, after which neither update nor multipliers fit the condition.
    settings.presolve_enable = False
    settings.chordal_decomposition_enable = False
    for name, value in options.items():
        setattr(settings, name, value)
    cones = [clarabel.NonnegativeConeT(program.linear)] if program.linear else []
    for cone in program.cones:
        if cone.size == 1:
            cones.append(clarabel.NonnegativeConeT(cone.items))
        else:
            cones.extend([clarabel.PSDTriangleConeT(cone.size)] * cone.items)
    size = len(program.q)
    nothing = sp.csc_matrix((size, size))
    A = sp.csc_matrix(program.A)
    return clarabel.DefaultSolver(nothing, program.q, A, program.b, cones, settings)


def _run(solver: Any, name: str, started: float) -> Raw:
    solution = solver.solve()
    return Raw(
        name,
        str(solution.status),
        np.array(solution.x),
        np.array(solution.z),
        int(solution.iterations),
        time.perf_counter() - started,
    )


def _others(program: ConeProgram) -> Iterator[Raw]:
    cp: Any = import_module("cvxpy")

    installed = set(cp.installed_solvers())
    for name in OTHERS:
        if name in installed:
            yield _with_cvxpy(program, name)


def _with_cvxpy(program: ConeProgram, name: str) -> Raw:
    """Solve the same cone data by another solver, y and z in the same order."""
    cp: Any = import_module("cvxpy")

    started = time.perf_counter()
    y = cp.Variable(len(program.q))
    slack = program.b - program.A @ y
    constraints: list[Any] = [slack[: program.linear] >= 0] if program.linear else []
    for cone in program.cones:
        entries = triangle(cone.size)
        # Symmetric entries of the matrix, taken from its packed triangle.
        spread = _unpacking(cone.size)
        for k in range(cone.items):
            first = program.linear + cone.start + k * entries
            square = cp.reshape(
                spread @ slack[first : first + entries], (cone.size,) * 2, order="F"
            )
            constraints.append(square >> 0)
    problem = cp.Problem(cp.Minimize(program.q @ y), constraints)
    options = {"time_limit_secs": SECONDS_FOR_OTHERS, "eps": 1e-8} if name == "SCS" else {}
    try:
        with warnings.catch_warnings():
            # The status says it too, and is recorded.
            warnings.simplefilter("ignore", UserWarning)
            problem.solve(solver=name, **options)
    except cp.SolverError as error:
        nothing = np.zeros(0)
        return Raw(name, f"failed: {error}", nothing, nothing, 0, time.perf_counter() - started)
    duals = [np.atleast_1d(c.dual_value) for c in constraints if c.dual_value is not None]
    z = np.concatenate([_packed_dual(dual) for dual in duals]) if duals else np.zeros(0)
    found = np.zeros(0) if y.value is None else np.asarray(y.value)
    iterations = int(getattr(problem.solver_stats, "num_iters", None) or 0)
    return Raw(name, problem.status, found, z, iterations, time.perf_counter() - started)


def _unpacking(size: int) -> sp.csr_array:
    column, row = np.tril_indices(size)
    packed = np.arange(triangle(size))
    scale = np.where(row == column, 1.0, np.sqrt(0.5))
    off = row != column
    position = np.concatenate([row + size * column, (column + size * row)[off]])
    source = np.concatenate([packed, packed[off]])
    values = np.concatenate([scale, scale[off]])
    return sp.csr_array((values, (position, source)), shape=(size * size, triangle(size)))


def _packed_dual(dual: Floats) -> Floats:
    if dual.ndim == 1:
        return dual
    column, row = np.tril_indices(dual.shape[0])
    scale = np.where(row == column, 1.0, np.sqrt(2.0))
    return np.asarray((dual + dual.T)[row, column] / 2 * scale)
