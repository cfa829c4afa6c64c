"""The decay rate of V = x'Px along blends, and its bound under a disturbance, in floats."""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.optimize import minimize_scalar

from takagi.models.arrays import Floats

# Multipliers that are tried, as shares of the rate at which V falls without disturbance.
SHARES = np.linspace(0.02, 0.98, 97)
# How finely the best share is looked for between two of them, and what stands for no level at all.
FINE, LARGEST = 1e-7, 1e300


def fall_rate(A: Floats, P: Floats, *, discrete: bool) -> float:
    """Return the largest s with F_k >= s P for every blend: V' <= -s V, V(x+) - V <= -s V.

    -inf where P is not positive definite in floats, as rounded to too few digits.

    Parameters
    ----------
    A : (N, n, n).
    """
    try:
        inverse = np.linalg.inv(np.linalg.cholesky(P))
    except np.linalg.LinAlgError:
        return -np.inf
    return float(np.linalg.eigvalsh(inverse @ _fall(A, P, discrete) @ inverse.T)[:, 0].min())


def held_level(A: Floats, W: Floats, P: Floats, multiplier: float, *, discrete: bool) -> float:
    """Return the least c that the disturbances hold V to at this multiplier; inf for none.

    None is found either where F - s P is singular to rounding.

    c = max_k lambda_max(H + G' (F - s P)^-1 G) / s with G = P W, H = 0, or A' P W and W' P W.

    Parameters
    ----------
    W : (N, n, q), or (C, N, n, 1) for corners of a box.
    """
    left = _fall(A, P, discrete) - multiplier * P
    if np.linalg.eigvalsh(left)[:, 0].min() <= 0:
        return np.inf
    reach = A.transpose(0, 2, 1) @ P @ W if discrete else P @ W
    try:
        total = np.swapaxes(reach, -1, -2) @ np.linalg.solve(left, reach)
    except np.linalg.LinAlgError:
        return np.inf
    if discrete:
        total = total + np.swapaxes(W, -1, -2) @ P @ W
    total = (total + np.swapaxes(total, -1, -2)) / 2
    return float(np.linalg.eigvalsh(total)[..., -1].max()) / multiplier


def best_multiplier(
    A: Floats, W: Floats, P: Floats, *, discrete: bool, known: float = 0.0
) -> tuple[float, float]:
    """Return (c, s): the least level that the disturbances hold V to, and its multiplier.

    Parameters
    ----------
    known : the multiplier that P was looked for with, where there is one: the least level is there
        as a rule, often hard at the rate of fall.
    """
    rate = fall_rate(A, P, discrete=discrete)
    if rate <= 0:
        return np.inf, 0.0

    def level(share: float) -> float:
        return held_level(A, W, P, share * rate, discrete=discrete)

    shares = np.append(SHARES, [known / rate] if 0 < known < rate else [])
    found = min((level(float(share)), float(share)) for share in shares)
    if np.isfinite(found[0]):
        # Between the neighbours on the grid, where the level is flat at its least.
        around = np.sort(np.append(SHARES, [0.0, 1.0]))
        low, high = around[around < found[1]].max(), around[around > found[1]].min()
        better = minimize_scalar(
            lambda share: min(level(float(share)), LARGEST),
            bounds=(float(low), float(high)),
            method="bounded",
            options={"xatol": FINE},
        )
        found = min(found, (level(float(better.x)), float(better.x)))
    return found[0], found[1] * rate


def box_corners(E: Floats, bounds: Floats) -> Floats:
    """Return E w at the corners of |w_k| <= b_k, one of each opposite pair, (C, N, n, 1)."""
    signs = np.array([(1.0, *rest) for rest in product((1.0, -1.0), repeat=len(bounds) - 1)])
    return np.asarray(np.einsum("knq,cq->ckn", E, signs * bounds)[..., None])


def _fall(A: Floats, P: Floats, discrete: bool) -> Floats:
    if discrete:
        return np.asarray(P - A.transpose(0, 2, 1) @ P @ A)
    PA = P @ A
    return np.asarray(-(PA + PA.transpose(0, 2, 1)))
