"""States in which the mean of the vertices decays equally in all directions.

For a loop of high gain the condition number of P may be that of the gains squared, in any units of
the states. The margin is then below a solver's tolerance. In states where the P of the mean's
Lyapunov equation is |x|^2, the mean decays equally in all directions, and vertices near the mean
almost equally. This only gives coordinates; nothing is claimed from it.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 2.7 (Lyapunov's equation).
"""

from __future__ import annotations

import warnings

import numpy as np

from takagi.lmi.argument_checks import rate_parameter
from takagi.models.arrays import Floats


def states_of_mean(A: Floats, alpha: float, step: float | None) -> Floats | None:
    """Return T of x = T xhat; None where the mean does not decay at the rate alpha [1/s]."""
    from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

    one = np.eye(A.shape[1])
    if step is None:
        mean = A.mean(axis=0) + alpha * one
        falls = np.linalg.eigvals(mean).real.max() < 0
    else:
        mean = A.mean(axis=0) / np.sqrt(rate_parameter(alpha, step)["contraction"])
        falls = np.abs(np.linalg.eigvals(mean)).max() < 1
    if not falls:
        return None
    try:
        with warnings.catch_warnings():
            # A solution with large rounding errors is detected below, and by the checks of the
            # caller.
            warnings.simplefilter("ignore")
            if step is None:
                P = solve_continuous_lyapunov(mean.T, -one)
            else:
                P = solve_discrete_lyapunov(mean.T, one)
        P = (P + P.T) / 2
        if not (np.isfinite(P).all() and np.diag(P).min() > 0):
            return None
        size = np.sqrt(np.diag(P))
        # Shaped, so that the factor is accurate row by row.
        R = np.linalg.cholesky(P / size / size[:, None]).T * size
        T = np.linalg.inv(R)
    except (np.linalg.LinAlgError, ValueError):
        return None
    return T if np.isfinite(T).all() else None
