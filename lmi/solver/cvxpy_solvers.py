"""Other installed solvers, called through cvxpy if the first solvers fail; posing is slow."""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator
from importlib import import_module
from typing import Any

import numpy as np
import scipy.sparse as sp

from takagi.lmi.condition.unknown import triangle
from takagi.lmi.cone.program import ConeProgram, Raw
from takagi.lmi.solver.time_limit import out_of_time, remaining, stopped
from takagi.models.arrays import Floats

# Most accurate first.
OTHER_SOLVERS = ("MOSEK", "CVXOPT", "SCS")
SECONDS_FOR_OTHERS = 20.0


def with_others(program: ConeProgram) -> Iterator[Raw]:
    """Yield the answer of one installed solver after another."""
    cp: Any = import_module("cvxpy")

    installed = set(cp.installed_solvers())
    for name in OTHER_SOLVERS:
        if out_of_time():
            return
        # CVXOPT takes no limit on its time.
        if name in installed and (name != "CVXOPT" or remaining() is None):
            yield with_cvxpy(program, name)


def with_cvxpy(program: ConeProgram, name: str) -> Raw:
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
    seconds_left = remaining()
    options: dict[str, Any] = {}
    if name == "SCS":
        seconds_allowed = (
            SECONDS_FOR_OTHERS if seconds_left is None else min(seconds_left, SECONDS_FOR_OTHERS)
        )
        options = {"time_limit_secs": seconds_allowed, "eps": 1e-8}
    elif name == "MOSEK" and seconds_left is not None:
        options = {"mosek_params": {"MSK_DPAR_OPTIMIZER_MAX_TIME": seconds_left}}
    try:
        with warnings.catch_warnings():
            # cvxpy warns if a solution is inaccurate; the recorded status says so too.
            warnings.simplefilter("ignore", UserWarning)
            problem.solve(solver=name, **options)
    except cp.SolverError as error:
        nothing = np.zeros(0)
        return Raw(name, f"failed: {error}", nothing, nothing, 0, time.perf_counter() - started)
    if seconds_left is not None and remaining() == 0.0:
        stopped()
    duals = [np.atleast_1d(c.dual_value) for c in constraints if c.dual_value is not None]
    z = np.concatenate([_packed_dual(dual) for dual in duals]) if duals else np.zeros(0)
    values = np.zeros(0) if y.value is None else np.asarray(y.value)
    iterations = int(getattr(problem.solver_stats, "num_iters", None) or 0)
    return Raw(name, problem.status, values, z, iterations, time.perf_counter() - started)


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
