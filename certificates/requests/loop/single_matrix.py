r"""Quadratic functions of a single matrix, and a test in floats that rejects hopeless candidates.

Cholesky's factorisation of S + c I in floats breaks down only where S is not positive semidefinite,
for c = (gamma / (1 - gamma)) tr |S| with gamma = (n + 1) u and the unit roundoff u; c is increased
by the possible error of the entries of S.  So a breakdown shows that an exact proof would fail.
Nothing else is concluded: a candidate that passes the test is still decided in exact arithmetic.

Source: Rump (2006), Verification of positive definiteness, BIT Numerical Mathematics 46, theorem
2.3, with the opposite sign of the shift; cited from memory.
"""

from __future__ import annotations

import warnings

import numpy as np

from takagi.models.arrays import Floats

# A solution with larger numbers is dominated by rounding errors.
LARGEST = 1e14
FASTEST = 30.0


def modal_function(G: Floats) -> Floats | None:
    """Return P = T^-* T^-1, T the eigenvectors: x'Px is the sum of the squared modes.

    This P proves every region that contains the eigenvalues, up to the region's edge. None if the
    matrix of eigenvectors is nearly singular.
    """
    balanced, s = _balanced(G)
    vectors = np.linalg.eig(balanced)[1]
    if np.linalg.cond(vectors) > np.sqrt(LARGEST):
        return None
    inverse = np.linalg.inv(vectors)
    return _in_states(np.real(inverse.conj().T @ inverse), s)


def equation_function(G: Floats, rate: float, step: float | None) -> Floats | None:
    """Return P with G'P + PG + 2 alpha P = -Q, or G'PG - rho^2 P = -Q; None where there is none.

    Q = I in balanced states.  P is positive definite exactly when G decays faster than alpha [1/s].
    """
    from scipy.linalg import LinAlgError, solve_continuous_lyapunov, solve_discrete_lyapunov

    balanced, s = _balanced(G)
    identity = np.eye(len(G))
    try:
        # SciPy warns of nearly singular equations; the checker decides about the result anyway.
        with warnings.catch_warnings(), np.errstate(all="ignore"):
            warnings.simplefilter("ignore")
            if step is None:
                P = solve_continuous_lyapunov((balanced + rate * identity).T, -identity)
            else:
                # If all eigenvalues exceed rho, the function is valid for every smaller rho too.
                P = solve_discrete_lyapunov(
                    (balanced * np.exp(min(rate * step, FASTEST))).T, identity
                )
    except (LinAlgError, np.linalg.LinAlgError, ValueError):
        return None
    size = np.abs(P).max()
    if not (np.isfinite(P).all() and 0 < size < LARGEST):
        return None
    return _in_states(np.asarray(P / size, dtype=np.float64), s)


def _balanced(G: Floats) -> tuple[Floats, Floats]:
    """Return S^-1 G S with rows and columns of similar size, and the powers of two s."""
    from scipy.linalg import matrix_balance

    # The permutation, which is not used, is made of integers that very large scales overflow.
    with warnings.catch_warnings(), np.errstate(all="ignore"):
        warnings.simplefilter("ignore")
        balanced, (s, _) = matrix_balance(G, permute=False, separate=True)
    if not (np.isfinite(balanced).all() and np.isfinite(s).all() and s.min() > 0):
        return G, np.ones(len(G))
    return np.asarray(balanced, dtype=np.float64), np.asarray(s, dtype=np.float64)


def _in_states(P: Floats, s: Floats) -> Floats:
    """Return S^-1 P S^-1, scaled to a size around 1."""
    function = (P + P.T) / 2 / s / s[:, None]
    diagonal = np.abs(np.diag(function))
    middle = np.sqrt(diagonal.max()) * np.sqrt(diagonal[diagonal > 0].min(initial=diagonal.max()))
    return np.asarray(function / np.exp2(np.round(np.log2(middle)))) if middle > 0 else function


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
