"""The choice of the first solver, by a model of the time of an iteration.

The two models were fitted to 70 programs (Lyapunov, compensation, energy gain, discrete time; six
relaxations; cones 2 to 84 wide, 4 to 2500 variables) on one core: two of three times lie within a
factor 1.3 of the model for clarabel, and within 1.5 for sdpa. sdpa is preferred only if it is
clearly quicker and the program takes long.
"""

from __future__ import annotations

import numpy as np

from takagi.lmi.solver.incidence import Incidence

# clarabel is called first if it takes less than this many seconds, or if sdpa is not so many times
# quicker.
LONG, CLEARLY = 0.5, 1.5
ITERATIONS_CLARABEL, ITERATIONS_SDPA = 25, 30


def prefers_sdpa(found: Incidence) -> bool:
    """Return whether sdpa is expected to be clearly quicker than clarabel."""
    clarabel = ITERATIONS_CLARABEL * clarabel_iteration(found)
    return clarabel > LONG and clarabel > CLEARLY * ITERATIONS_SDPA * sdpa_iteration(found)


def clarabel_iteration(found: Incidence) -> float:
    """Return about the seconds of one iteration: factors of a dense block a cone.

    The cones are eliminated one by one, then the variables that they share.  A variable of two
    cones is eliminated before the wider of them.
    """
    rows = found.rows.astype(np.float64)
    shared = found.touched[found.variable] >= 3
    joined = np.where(shared, 1.0, 0.0)
    small = rows[found.cone] < rows.max()
    joined += np.where((found.touched[found.variable] == 2) & small, 1.0, 0.0)
    p = np.bincount(found.cone, joined, len(rows))
    last = float(np.count_nonzero(found.touched >= 3))
    return float(
        9e-6 * len(rows)
        + 4.1e-8 * (rows**2).sum()
        + 1.7e-11 * (rows**3).sum() / 3
        + 5.1e-11 * ((rows**2 * p + rows * p**2).sum() + last**3 / 3)
    )


def sdpa_iteration(found: Incidence) -> float:
    """Return about the seconds of one iteration: the Schur complement, formed and factored."""
    n = found.size.astype(np.float64)
    p = np.bincount(found.cone, minlength=len(n)).astype(np.float64)
    dense, sparse = p * n**3 + p**2 * n**2 / 2, found.entries.astype(np.float64) ** 2
    return float(
        1.8e-5 * len(n)
        + 7.2e-11 * len(found.touched) ** 3 / 3
        + 2.1e-10 * np.minimum(dense, sparse).sum()
        + 3.2e-8 * np.minimum(p * n**2, found.entries * n).sum()
        + 8.9e-8 * found.degree.sum()
    )
