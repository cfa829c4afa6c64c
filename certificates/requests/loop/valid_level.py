"""The largest level of an ellipsoid in the model's box, and its inputs, in floats."""

from __future__ import annotations

import numpy as np

from takagi.certificates.checker.loop.box_of_validity import bounded_inputs
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.models.arrays import Floats

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
