"""The observer of a law with output feedback, in exact numbers, and its initial estimate."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from takagi.certificates.checker.kernel.matrices import Matrix


@dataclass(frozen=True)
class ObserverLaw:
    """xhat' = sum_i h_i (A_i xhat + B_i u + L_i (y - yhat)), u = -sum_j h_j K_j xhat.

    In discrete time xhat+ replaces xhat'.  C and D of the loop have the rows of the measured
    outputs only.

    ``at_estimate`` : the weights h are those at (xhat, u); else they are the plant's own.
    ``L`` : one matrix (n, p), or one for each rule; one alone where ``at_estimate``.
    ``slopes`` : pairs (S_k, R_k), (n, n) and (p, n), whose hull has the mean slopes of f and y by
    the state between any two points of the box; empty unless ``at_estimate``.
    """

    L: tuple[Matrix, ...]
    at_estimate: bool
    slopes: tuple[tuple[Matrix, Matrix], ...] = ()


def states_at_start(C: Sequence[Matrix], D: Sequence[Matrix], order: int) -> list[bool]:
    """Return which estimates start at the true state: those of directly measured states.

    The others start at rest.  C and D have the measured outputs.  An output measures a state
    directly if its factor is 1 and no input is added.
    """
    is_measured = [False] * order
    for k in range(C[0].shape[0] if C else 0):
        same = {tuple(M[k, j] for j in range(order)) for M in C}
        row = same.pop()
        fed = any(any(M.rows[k]) for M in D)
        nonzero_columns = [j for j, entry in enumerate(row) if entry]
        if not same and not fed and len(nonzero_columns) == 1 and row[nonzero_columns[0]] == 1:
            is_measured[nonzero_columns[0]] = True
    return is_measured
