r"""A fast floating-point test that rejects candidates which exact arithmetic would refuse.

Cholesky's factorisation of S + c I in floats breaks down only where S is not positive semidefinite,
for c = (gamma / (1 - gamma)) tr |S| with gamma = (n + 1) u and the unit roundoff u; c is increased
by the possible error of the entries of S.  So a breakdown shows that an exact proof would fail.
Nothing else is concluded: a candidate that passes the test is still decided in exact arithmetic.

Source: Rump (2006), Verification of positive definiteness, BIT Numerical Mathematics 46, theorem
2.3, with the opposite sign of the shift; cited from memory.
"""

from __future__ import annotations

import numpy as np

from takagi.models.arrays import Floats

ROUNDOFF = float(np.finfo(np.float64).eps)


def cannot_be_definite(stack: Floats, entry_error: float = 0.0) -> bool:
    """Return whether one of (N, n, n) symmetric matrices is certainly not positive definite.

    Parameters
    ----------
    entry_error : bound on the distance of every entry from its exact value.
    """
    n = stack.shape[1]
    gamma = (n + 1) * ROUNDOFF
    trace = np.abs(np.diagonal(stack, axis1=1, axis2=2)).sum(axis=1)
    shift = gamma / (1 - gamma) * trace + n * entry_error
    try:
        np.linalg.cholesky(stack + 2 * shift[:, None, None] * np.eye(n))
    except np.linalg.LinAlgError:
        return True
    return False


def cannot_decrease(A: Floats, P: Floats, rate: float, step: float | None) -> bool:
    """Return whether P certainly fails ``decay`` for one of A, (N, n, n), at alpha [1/s]."""
    n = len(P)
    PA = P @ A
    sizes = np.abs(P) @ np.abs(A)
    if step is None:
        stack = -(PA + PA.transpose(0, 2, 1) + 2 * rate * P)
        size = 2 * sizes.max() + 2 * rate * np.abs(P).max()
    else:
        stack = np.exp(-2 * rate * step) * P - A.transpose(0, 2, 1) @ PA
        size = np.abs(P).max() + (np.abs(A).transpose(0, 2, 1) @ sizes).max()
    return cannot_be_definite(stack, (4 * n + 8) * ROUNDOFF * float(size))
