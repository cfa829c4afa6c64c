r"""The covariance that bounds a signal of a loop with constant unknown parameters under noise.

dx = A x dt + S dW with (A, S) constant in the hull of the vertices, y = h x.  With

    A_i C + C A_i' + S_i S_i' < 0,     C > 0,     h A_i C A_i' h' <= rho,

the stationary covariance is at most C for each (A, S) of the hull: the deviation of y is at most
sqrt(h C h'), and that of its rate h A x at most sqrt(rho).  h C h' + w rho is least, with a weight
w in s^2: the bound of Rice's formula depends on both.

Source: docs/crossing-probability.md; Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.1.
"""

from __future__ import annotations

import numpy as np
from scipy.linalg import solve_continuous_lyapunov

from takagi.lmi.condition.term import LMI, Condition, Constant, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.decision.decide import optimise
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

# Noise that is added to all states to scale them, as a share of their size and rate; the least size
# of a state, as a share of the largest.
ADDED, LEAST = 1e-2, 1e-6
# The margin that is asked for in these units, with which one solve is nearly always all.  The bound
# that the multipliers of a solve of 32 vertices show is up to a tenth below the objective found,
# though a longer search finds one that is less by a thousandth at most.
INSIDE, SLACK = 1e-6, 0.1
# w as a share of (deviation / deviation of the rate)^2: (s / b)^2, for b = 4.5 s, weighs h C h' and
# rho as the logarithm of the bound does.
WEIGHT = 0.05


def covariance_condition(A: Floats, S: Floats, row: Floats, *, weight: float) -> Condition:
    """Pose the module's LMIs; the objective is h C h' + weight rho.

    Parameters
    ----------
    A, S : (N, n, n) and (N, n, q).
    row : h, (n,).
    weight : w in s^2, not negative.

    Returns
    -------
    The condition with the unknowns ``C`` and ``rho``.  Nothing is solved.  Continuous time only: in
    discrete time a signal crosses no limit.

    Raises
    ------
    ModelError : sizes that do not fit, or a negative weight.
    """
    N, n = A.shape[:2]
    if A.shape != (N, n, n) or S.shape[:2] != (N, n) or row.shape != (n,):
        raise ModelError(f"A {A.shape}, S {S.shape}, row {row.shape}: (N, n, n), (N, n, q), (n,)")
    if weight < 0:
        raise ModelError(f"weight = {weight:g}: a number that is not negative is needed")
    C, rho = Unknown("C", n, n, symmetric=True), Unknown("rho", 1, 1, latex=r"\rho")
    one, every = np.eye(n)[None], rf"i = 1, \dots, {N}"
    rates = (row @ A)[:, None, :]
    return Condition(
        name="covariance under noise",
        unknowns=(C, rho),
        lmis=(
            LMI(
                name="covariance",
                blocks=(n,),
                terms=(
                    Term(unknown=C, left=A, right=one, plus_transpose=True, latex=("A_{i}", "")),
                ),
                constants=(Constant(value=S @ S.transpose(0, 2, 1), latex=r"S_{i} S_{i}^\top"),),
                sign=-1,
                count=N,
                index=every,
            ),
            LMI(name="positive", blocks=(n,), terms=(Term(unknown=C, left=one, right=one),)),
            LMI(
                name="rate",
                blocks=(1,),
                terms=(
                    Term(unknown=rho, left=np.ones((1, 1, 1))),
                    Term(
                        unknown=C,
                        left=-rates,
                        right=rates.transpose(0, 2, 1),
                        latex=("-h A_{i}", r"A_{i}^\top h^\top"),
                    ),
                ),
                count=N,
                strict=False,
                index=every,
            ),
        ),
        objective={
            "C": np.asarray(np.outer(row, row)[None], dtype=np.float64),
            "rho": np.full((1, 1, 1), float(weight)),
        },
        source="docs/crossing-probability.md",
    )


def covariance_bound(A: Floats, S: Floats, row: Floats) -> Floats | None:
    """Return C, (n, n), with nearly the least h C h' and rate; None where none is found.

    Parameters
    ----------
    A, S : (N, n, n) and (N, n, q); None is returned where a vertex is not stable.
    row : h, (n,), of a signal that the noise does not reach directly: h S = 0.
    """
    if np.linalg.eigvals(A).real.max() >= 0:
        return None
    T = _unit_states(A, S)
    seen = row @ T
    inside, noisy = (np.asarray(np.linalg.solve(T, part), dtype=np.float64) for part in (A @ T, S))
    size = float(seen @ seen)
    if not size > 0:
        return None
    seen = seen / np.sqrt(size)
    mean = seen @ inside.mean(axis=0)
    posed = covariance_condition(inside, noisy, seen, weight=WEIGHT / float(mean @ mean))
    outcome = optimise(posed, slack=SLACK, inside=INSIDE)
    values = outcome.values or outcome.feasible
    if not values:
        return None
    # Where one C is not enough for all vertices the values nearly meet the inequalities, or not.
    scaled = values["C"][0]
    growth = inside @ scaled
    growth = growth + growth.transpose(0, 2, 1) + noisy @ noisy.transpose(0, 2, 1)
    if np.linalg.eigvalsh(growth).max() >= 0 or np.linalg.eigvalsh(scaled).min() <= 0:
        return None
    C = T @ scaled @ T.T
    return np.asarray((C + C.T) / 2, dtype=np.float64)


def _unit_states(A: Floats, S: Floats) -> Floats:
    """Return T of x = T xhat: about unit covariance of the mean loop with some noise everywhere.

    The covariance without it may be singular, or nearly so: one noise hardly moves some directions.
    """
    mean, spread = A.mean(axis=0), (S @ S.transpose(0, 2, 1)).mean(axis=0)
    slowest = -float(np.linalg.eigvals(mean).real.max())
    sizes = np.abs(solve_continuous_lyapunov(mean, -spread).diagonal())
    root = np.sqrt(np.maximum(sizes, LEAST * sizes.max()))
    inside, noisy = mean / root[:, None] * root, spread / root / root[:, None]
    X = solve_continuous_lyapunov(inside, -noisy - ADDED * slowest * np.eye(len(mean)))
    return np.asarray(root[:, None] * np.linalg.cholesky((X + X.T) / 2), dtype=np.float64)
