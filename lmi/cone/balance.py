"""Coordinates in which the numbers are of order one: powers of two, so nothing is rounded."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.argument_checks import positive_vector
from takagi.lmi.condition.term import Array

SWEEPS = 40
FARTHEST = 2.0**200


def nearest_power(values: ArrayLike) -> Array:
    """Return the nearest power of two to each positive value."""
    return np.asarray(np.exp2(np.round(np.log2(np.asarray(values)))))


def balanced_states(A: Array) -> Array:
    """Return s, (n,), powers of two, so that rows and columns of S^-1 A_i S have similar sizes.

    S = diag(s); x = S xhat.  One s for all vertices, from the mean of their absolute values.  A
    state that has a row or a column only (nothing acts on it, or it acts on nothing) cannot be
    balanced: its one entry is made as large as the spectral radius of the mean.  The same is done
    between groups of states, such as the model of a disturbance, if the sweeps do not converge.
    Balancing removes the choice of units (rad against N m) and changes no significant digit.

    Source: Osborne (1960), On pre-conditioning of matrices, J. ACM 7; Parlett and Reinsch (1969).
    """
    M = np.abs(A.astype(np.float64)).mean(axis=0)
    # The spectral radius is the same in all units.  It is 0 for integrators alone; then 1 is taken.
    time = float(np.abs(np.linalg.eigvals(M)).max()) or 1.0
    np.fill_diagonal(M, 0.0)
    s, ended = _swept(M, time)
    if not ended:
        s = _by_groups(M, time)
    # Relative to the first state, so that the rounding is the same in all units.
    return nearest_power(s / s[0])


def _swept(M: Array, time: float) -> tuple[Array, bool]:
    """Return the scales after Osborne's sweeps over M >= 0, and whether they converged."""
    s = np.ones(len(M))
    for _ in range(SWEEPS):
        previous = s.copy()
        for k in range(len(M)):
            acted_on, acting = M[:, k] / s, M[k] * s
            column = math.sqrt(acted_on @ acted_on) * s[k]
            row = math.sqrt(acting @ acting) / s[k]
            if row or column:
                s[k] *= (
                    np.sqrt(row / column)
                    if row and column
                    else row / time
                    if row
                    else time / column
                )
                # With a chain of entries that are nearly zero the scales would grow without limit.
                s[k] = min(max(s[k], 1.0 / FARTHEST), FARTHEST)
        # Scales are rounded to powers of two later, so they need no more digits than this.
        if (np.abs(s - previous) <= 1e-6 * previous).all():
            return s, True
    return s, False


def _by_groups(M: Array, time: float) -> Array:
    """Return scales of a graph with groups of states that act on others and are not acted upon.

    Such a group can be made smaller and smaller: what it does to the others vanishes, and nothing
    grows.  So each group is balanced by itself, and between groups the logarithms of the couplings
    are, by least squares, those of the time.
    """
    from scipy.sparse.csgraph import connected_components

    count, group = connected_components(M > 0, directed=True, connection="strong")
    s = np.ones(len(M))
    for k in range(count):
        inside = np.flatnonzero(group == k)
        s[inside] = _swept(M[np.ix_(inside, inside)], time)[0]
    scaled = M * s / s[:, None]
    rows, log_ratios = [], []
    for a in range(count):
        for b in range(count):
            acting = float(np.linalg.norm(scaled[np.ix_(group == a, group == b)]))
            if a != b and acting:
                # Group b acts on group a; with s_b it is ``acting`` s_b / s_a.
                rows.append(np.eye(count)[b] - np.eye(count)[a])
                log_ratios.append(np.log(time / acting))
    coupled = np.array(rows).reshape(-1, count)
    between = np.linalg.lstsq(coupled, np.array(log_ratios), rcond=None)[0]
    return np.asarray(s * np.exp(between)[group])


def balanced_inputs(B: Array, size: float) -> Array:
    """Return s, (m,), powers of two, so that the largest |B_i s_k| of input k is about size."""
    largest = np.abs(B.astype(np.float64)).max(axis=(0, 1))
    return nearest_power(size / largest)


def motion(A: Array, step: float | None) -> Array:
    """Return what moves the states: A of x' = A x, and A - I of x+ = A x.

    Sampled fast, A is nearly I and says nothing of the size of what happens; A - I does.

    ``step`` : sample time T in s; None for continuous time.
    """
    return A if step is None else A - np.eye(A.shape[-1])


def state_units(A: Array, scales: ArrayLike | None, *, step: float | None = None) -> Array:
    """Return s, (n,): the powers of two next to the given scales, or those that balance A.

    ``step`` : as for ``motion``, which is what is balanced.

    Raises ModelError: scales of another length, or not positive.
    """
    if scales is None:
        return balanced_states(motion(A, step))
    return nearest_power(positive_vector("scales", scales, A.shape[1]))
