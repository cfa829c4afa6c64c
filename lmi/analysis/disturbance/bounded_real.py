r"""The energy gain of one vertex, and a P that nearly shows it, by a Riccati equation.

    A' P + P A + (P B + C' D / gamma) S^-1 (P B + C' D / gamma)' + C' C / gamma + R = 0,
    S = gamma I - D' D / gamma,

has a solution P > 0 for every gamma above the norm of the path from w to y and to the outputs that
R adds. With R > 0 the bounded real lemma holds with a margin, so P may be rounded. No program is
solved.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.3.2; Zhou, Doyle, Glover (1996),
Robust and Optimal Control, section 13.4; Kleinman (1968), IEEE Trans. Automatic Control 13(1), for
the steps that mend what rounding left.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.linalg import solve_continuous_are, solve_continuous_lyapunov
from scipy.optimize import minimize_scalar

from takagi.lmi.cone.balance import state_units
from takagi.models.arrays import Floats

# Frequencies beside those of the poles: so many decades about them, so many in each.
AROUND, DENSITY = 3.0, 20
# R weighs each state by its size in the output, but with at least this share of the largest size:
# some states hardly appear in the output.
LEAST = 1e-6
# Newton's steps: with gains of 1e4 the error of the first solution is larger than the margin of R.
STEPS = 4
# The share of the tolerance that R may use.
SHARE = 0.5


def bounded_real(A: Floats, B: Floats, C: Floats, D: Floats, *, tolerance: float) -> Floats | None:
    """Return P that shows a gamma about the tolerance above the norm, relative.

    Parameters
    ----------
    A, B, C, D : (n, n), (n, q), (p, n), (p, q) of one vertex in continuous time.

    Returns
    -------
    P > 0 but for rounding; None where A is not stable, or no such P was found in floating point.
    """
    s = state_units(A[None], None)
    A, B, C = A * s / s[:, None], B / s[:, None], C * s
    if not np.linalg.eigvals(A).real.max() < 0:
        return None
    least = norm_seen(A, B, C, D)
    # The size of a state is that of its own effect on the output.
    size = np.diag(_quiet(solve_continuous_lyapunov, A.T, -C.T @ C))
    if not (np.isfinite(least) and least > 0 and np.isfinite(size).all() and size.max() > 0):
        return None
    root = np.diag(np.sqrt(np.maximum(size, LEAST * size.max())))
    shown = norm_seen(A, B, root, np.zeros((len(A), B.shape[1])))
    # The squares of the outputs' norms add up at most.
    root *= np.sqrt(2.0 * SHARE * tolerance) * least / shown if shown > 0 else 0.0
    gamma = (1.0 + tolerance) * least
    S = gamma * np.eye(B.shape[1]) - D.T @ D / gamma
    weight = (C.T @ C + root @ root) / gamma
    both = C.T @ D / gamma
    try:
        P = _quiet(solve_continuous_are, A, B, weight, -S, s=both)
        for _ in range(STEPS):
            P = (P + P.T) / 2.0
            F = np.linalg.solve(S, B.T @ P + both.T)
            missed = A.T @ P + P @ A + (P @ B + both) @ F + weight
            P = P + _quiet(solve_continuous_lyapunov, (A + B @ F).T, -(missed + missed.T) / 2.0)
    except (np.linalg.LinAlgError, ValueError):
        return None
    P = (P + P.T) / 2.0
    good = np.isfinite(P).all() and np.diag(P).min() > 0
    return P / s / s[:, None] if good else None


def norm_seen(A: Floats, B: Floats, C: Floats, D: Floats) -> float:
    """Return the largest gain at the evaluated frequencies: at most the norm."""
    poles = np.linalg.eigvals(A)
    sizes = np.abs(poles)[np.abs(poles) > 0]
    if not len(sizes):
        return float(np.linalg.norm(D, 2))
    low, high = np.log10(sizes.min()) - AROUND, np.log10(sizes.max()) + AROUND
    grid = np.logspace(low, high, int(DENSITY * (high - low)) + 2)
    grid = np.unique(np.concatenate([grid, np.abs(poles.imag)[poles.imag != 0], sizes]))

    def gain(frequency: float) -> float:
        at = 1j * frequency * np.eye(len(A)) - A
        return float(np.linalg.norm(C @ np.linalg.solve(at, B) + D, 2))

    seen = np.array([gain(float(one)) for one in grid])
    found = [gain(0.0), float(np.linalg.norm(D, 2)), float(seen.max())]
    last = len(grid) - 1
    for k in range(len(grid)):
        before, after = max(k - 1, 0), min(k + 1, last)
        # Only a peak that may be the highest one is refined.
        if seen[k] < max(seen[before], seen[after], 0.5 * seen.max()):
            continue
        best = minimize_scalar(
            lambda at: -gain(float(np.exp(at))),
            bounds=(float(np.log(grid[before])), float(np.log(grid[after]))),
            method="bounded",
            options={"xatol": 1e-9},
        )
        found.append(-float(best.fun))
    return max(found)


def _quiet(solve: Callable[..., Any], *arguments: Floats, **named: Floats) -> Floats:
    """Return a scipy solver's result in floats without its warnings: P is checked elsewhere."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return np.asarray(solve(*arguments, **named), dtype=np.float64)
