"""Bounds on the optimum from multipliers, which do not depend on the solver's status.

For multipliers z in the dual cone the bound contains the residual A' z + q of the stationarity
condition times the size of y.  Only the size of the y that was found is known; ten times this size
is assumed for every feasible y.  So these bounds are as accurate as the solver, and not a proof.
"""

from __future__ import annotations

import numpy as np

from takagi.lmi.cone.assemble import pack, unpack
from takagi.lmi.cone.program import ConeProgram, Raw
from takagi.models.arrays import Floats

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
