"""Levels of an ellipsoid, in floats: those in the model's box, those that a disturbance allows."""

from __future__ import annotations

from itertools import product

import numpy as np

from takagi.certificates.checker.loop.box_of_validity import bounded_inputs
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models.arrays import Floats

# Multipliers to try, as fractions of the decay rate of V without a disturbance.
SHARES = np.linspace(0.02, 0.98, 97)
# The resolution of the search between two of them, and the value that means no level.
FINE, LARGEST = 1e-7, 1e300


def fall_rate(A: Floats, P: Floats, *, discrete: bool) -> float:
    """Return the largest s with F_k >= s P for every blend: V' <= -s V, V(x+) - V <= -s V.

    -inf if P is not positive definite in floats, for example after rounding to too few digits.

    ``A`` : (N, n, n).
    """
    try:
        inverse = np.linalg.inv(np.linalg.cholesky(P))
    except np.linalg.LinAlgError:
        return -np.inf
    return float(np.linalg.eigvalsh(inverse @ _fall(A, P, discrete) @ inverse.T)[:, 0].min())


def invariant_level(A: Floats, W: Floats, P: Floats, multiplier: float, *, discrete: bool) -> float:
    """Return the least c such that V <= c is invariant with this multiplier; inf if there is none.

    The result is inf as well if F - s P is singular in floating point.

    c = max_k lambda_max(H + G' (F - s P)^-1 G) / s with G = P W, H = 0, or A' P W and W' P W.

    ``W`` : (N, n, q), or (C, N, n, 1) for corners of a box.
    """
    decrease = _fall(A, P, discrete) - multiplier * P
    if np.linalg.eigvalsh(decrease)[:, 0].min() <= 0:
        return np.inf
    reach = A.transpose(0, 2, 1) @ P @ W if discrete else P @ W
    try:
        total = np.swapaxes(reach, -1, -2) @ np.linalg.solve(decrease, reach)
    except np.linalg.LinAlgError:
        return np.inf
    if discrete:
        total = total + np.swapaxes(W, -1, -2) @ P @ W
    total = (total + np.swapaxes(total, -1, -2)) / 2
    return float(np.linalg.eigvalsh(total)[..., -1].max()) / multiplier


def best_multiplier(
    A: Floats, W: Floats, P: Floats, *, discrete: bool, start: float = 0.0
) -> tuple[float, float]:
    """Return (c, s): the least invariant level of V under the disturbances, and its multiplier.

    ``start`` : the multiplier used in the search of P, if any. The least level is usually there,
    often close to the decay rate.
    """
    rate = fall_rate(A, P, discrete=discrete)
    if rate <= 0:
        return np.inf, 0.0
    from scipy.optimize import minimize_scalar

    def level(share: float) -> float:
        return invariant_level(A, W, P, share * rate, discrete=discrete)

    shares = np.append(SHARES, [start / rate] if 0 < start < rate else [])
    best = min((level(float(share)), float(share)) for share in shares)
    if np.isfinite(best[0]):
        # The level hardly changes near its minimum, so a search between the neighbours suffices.
        neighbours = np.sort(np.append(SHARES, [0.0, 1.0]))
        low, high = neighbours[neighbours < best[1]].max(), neighbours[neighbours > best[1]].min()
        minimum = minimize_scalar(
            lambda share: min(level(float(share)), LARGEST),
            bounds=(float(low), float(high)),
            method="bounded",
            options={"xatol": FINE},
        )
        best = min(best, (level(float(minimum.x)), float(minimum.x)))
    return best[0], best[1] * rate


def box_corners(E: Floats, bounds: Floats) -> Floats:
    """Return E w at the corners of |w_k| <= b_k, one of each opposite pair, (C, N, n, 1)."""
    signs = np.array(list(product((1.0,), *[(1.0, -1.0)] * (len(bounds) - 1))))
    return np.asarray(np.einsum("knq,cq->ckn", E, signs * bounds)[..., None])


def _fall(A: Floats, P: Floats, discrete: bool) -> Floats:
    if discrete:
        return np.asarray(P - A.transpose(0, 2, 1) @ P @ A)
    PA = P @ A
    return np.asarray(-(PA + PA.transpose(0, 2, 1)))


# The checker uses the rounded numbers of the file; this margin covers their rounding.
SPARE = 1e-9


def state_halves(loop: ClaimedLoop) -> Floats:
    """Return (n,) half-widths of the box about 0; inf for a state without a range."""
    sides = loop.exact.box or (None,) * loop.exact.order
    return np.array([np.inf if s is None else float(min(-s[0], s[1])) for s in sides])


def box_rows(loop: ClaimedLoop) -> Floats:
    """Return rows a, (T, n), with |a x| <= 1 in the box: states, and inputs by u = -K_j x."""
    halves = state_halves(loop)
    bounded = np.flatnonzero(np.isfinite(halves))
    rows = [np.eye(len(halves))[bounded] / np.maximum(halves[bounded, None], 1e-300)]
    if loop.gains is not None:
        for k, side in bounded_inputs(loop.exact).items():
            room = float(min(-side[0], side[1]))
            rows.append(loop.gains[:, k] / max(room, 1e-300))
    return np.concatenate(rows)


def largest_level(loop: ClaimedLoop, P: Floats) -> float:
    """Return about the largest c with {x'Px <= c} in the box, inf where nothing bounds it."""
    rows = box_rows(loop)
    if not len(rows):
        return np.inf
    reach = np.einsum("ti,ij,tj->t", rows, np.linalg.inv(P), rows)
    return float((1 - SPARE) / reach.max()) if reach.max() > 0 else np.inf


def input_bounds(loop: ClaimedLoop, P: Floats, level: float) -> Floats:
    """Return (m,): the largest |K_j x|_k where x'Px <= level, over all gains."""
    assert loop.gains is not None
    squares = np.einsum("rmi,ij,rmj->rm", loop.gains, np.linalg.inv(P), loop.gains)
    return np.asarray(np.sqrt(level * squares.max(axis=0)))
