"""Candidates for a conic problem by clarabel: a solution, points well inside, contradictions."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import scipy.sparse as sp

from takagi.lmi.problem_files.problem import (
    NONNEGATIVE,
    SECOND_ORDER,
    ZERO,
    Block,
    ConicProblem,
    Solution,
)
from takagi.lmi.solver.installed_solvers import quiet
from takagi.lmi.solver.solve import run_clarabel
from takagi.models.arrays import Floats

# Of a direction d with c'd = -1, and of multipliers with <B, y> = -1.
LONGEST_RAY = 1e6
TOLERANCE = 1e-11


@dataclass(frozen=True, slots=True)
class Solved:
    """The solver's word, which decides nothing, and its numbers; None where it has none."""

    status: str
    solution: Solution | None


def solve_conic(problem: ConicProblem) -> Solved:
    """Return clarabel's solution and multipliers."""
    import clarabel

    A, constant = problem.stacked()
    scale = np.concatenate([block.solver_scale for block in problem.blocks])
    cones: list[Any] = []
    for block in problem.blocks:
        if block.cone == ZERO:
            cones.append(clarabel.ZeroConeT(block.size))
        elif block.cone == NONNEGATIVE or block.size == 1:
            cones.append(clarabel.NonnegativeConeT(block.size))
        elif block.cone == SECOND_ORDER:
            cones.append(clarabel.SecondOrderConeT(block.size))
        else:
            cones.append(clarabel.PSDTriangleConeT(block.size))
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.presolve_enable = False
    settings.chordal_decomposition_enable = False
    # What is proved is as near to the optimum as the solver goes.
    for name in ("tol_gap_abs", "tol_gap_rel", "tol_feas"):
        setattr(settings, name, TOLERANCE)
    if hasattr(settings, "max_threads"):
        settings.max_threads = 1
    variables = len(problem.objective)
    scaled = sp.csc_matrix(sp.diags_array(-scale) @ A)
    nothing = sp.csc_matrix((variables, variables))
    solver = clarabel.DefaultSolver(
        nothing, problem.objective, scaled, constant * scale, cones, settings
    )
    # Where it breaks down, clarabel writes that to the standard output of errors.
    with quiet(2):
        raw = run_clarabel(solver, "clarabel", time.perf_counter())
    x, z = raw.y, raw.z
    usable = (
        len(x) == variables
        and len(z) == len(scale)
        and bool(np.isfinite(x).all() and np.isfinite(z).all())
    )
    # <S, Y> = sum of weight * s * y, and the solver has sum of (scale s) (scale y): y = z / scale.
    return Solved(raw.status, Solution(x, z / scale) if usable else None)


def multiplier_problem(problem: ConicProblem, right: Floats | None = None) -> ConicProblem:
    """Return the problem of y: minimise <B, y> with <A_i, y> = right_i, and y_k in its dual cone.

    ``right`` : c of the problem unless given.
    """
    A, constant = problem.stacked()
    weights = problem.weights
    products = sp.coo_array((sp.diags_array(weights) @ A).T)
    equations = Block(ZERO, A.shape[1])
    for row, column, value in zip(*products.coords, products.data, strict=True):
        equations.add(int(column) + 1, int(row), float(value))
    right = problem.objective if right is None else right
    for i in np.flatnonzero(right):
        equations.add(0, int(i), -float(right[i]))
    blocks, first = [equations], 0
    for block in problem.blocks:
        if block.cone != ZERO:
            dual = Block(block.cone, block.size, block.scaled)
            for k in range(block.length):
                dual.add(first + k + 1, k, 1.0)
            blocks.append(dual)
        first += block.length
    return ConicProblem(problem.name, weights * constant, 0.0, False, tuple(blocks))


def shrunken(problem: ConicProblem, by: float) -> ConicProblem:
    """Return the problem with every S_k(x) - by * e_k in its cone, e_k well inside."""
    blocks = []
    for block in problem.blocks:
        smaller = replace(block, entries=dict(block.entries))
        for k in np.flatnonzero(block.interior):
            smaller.add(0, int(k), -by)
        blocks.append(smaller)
    return replace(problem, blocks=tuple(blocks))


def most_inside(problem: ConicProblem, farthest: float) -> tuple[Floats, float] | None:
    """Return x with S_k(x) - t e_k in its cone for the largest t <= 1, and that t.

    ``farthest`` : |x_i| is kept within this.
    """
    count = len(problem.objective)
    blocks = []
    for block in problem.blocks:
        narrowed = replace(block, entries=dict(block.entries))
        for k in np.flatnonzero(block.interior):
            narrowed.add(count + 1, int(k), -1.0)
        blocks.append(narrowed)
    limits = Block(NONNEGATIVE, 2 * count + 1)
    for i in range(count):
        for place, sign in ((2 * i, 1.0), (2 * i + 1, -1.0)):
            limits.add(0, place, farthest)
            limits.add(i + 1, place, sign)
    limits.add(0, 2 * count, 1.0)
    limits.add(count + 1, 2 * count, -1.0)
    objective = np.append(np.zeros(count), -1.0)
    widened = ConicProblem(problem.name, objective, 0.0, False, (*blocks, limits))
    solution = solve_conic(widened).solution
    return None if solution is None else (solution.x[:-1], float(solution.x[-1]))


def falling_ray(problem: ConicProblem) -> tuple[Floats, float] | None:
    """Return d with c'd = -1 and sum_i d_i A_ik - t e_k in its cone, for the largest t, and that t.

    From any solution the objective falls without end along d, where t >= 0.
    """
    blocks = [
        replace(block, entries={at: v for at, v in block.entries.items() if at[0]})
        for block in problem.blocks
    ]
    row = Block(ZERO, 1)
    row.add(0, 0, 1.0)
    for i in np.flatnonzero(problem.objective):
        row.add(int(i) + 1, 0, float(problem.objective[i]))
    return most_inside(replace(problem, blocks=(*blocks, row)), LONGEST_RAY)


def contradiction(problem: ConicProblem) -> tuple[Floats, float] | None:
    """Return y with <A_i, y> = 0, <B, y> = -1 and y_k - t e_k in its cone, for the largest t."""
    return falling_ray(multiplier_problem(problem, np.zeros(len(problem.objective))))
