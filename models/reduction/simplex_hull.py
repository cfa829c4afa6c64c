"""Weights of a simplex around points: nonnegative decimals whose rows add up to exactly one."""

from __future__ import annotations

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

PLACES = 12  # of the decimals; sums of so many digits are exact in integers below 2**53
MOST_STARTS = 32


def simplex_weights(points: Floats) -> Floats:
    """Return G (N, d + 1), G >= 0 with rows of sum 1, such that points = G @ (some d + 1 points).

    The corners are not returned, because the caller fits its own values at the corners to G.  Every
    facet of the simplex touches a point.  Several simplices are spanned by points and then widened,
    and the one of least volume is taken; a smaller one may exist.

    Parameters
    ----------
    points : (N, d), not all in one plane of dimension d - 1; d = 0 gives a column of ones.

    Returns
    -------
    Decimals of 12 places, exactly nonnegative and of sum one; ``points = G @ ...`` is rounded.

    Raises
    ------
    ModelError : points in a plane of lower dimension.

    Source: Baranyi (2004), IEEE Trans. Industrial Electronics 51(2), sum-normal and nonnegative
    weight functions (SN, NN); recalled.
    """
    N, d = points.shape
    if d == 0:
        return np.ones((N, 1))
    best, least = None, np.inf
    lifted = np.column_stack((points, np.ones(N)))
    for start in np.linspace(0, N - 1, min(N, MOST_STARTS)).astype(int):
        corners = _spread_out(points, int(start), d)
        spanned = lifted[corners]
        # Such corners lie almost in one plane, and weights with respect to them would be rounding
        # errors.
        if abs(np.linalg.det(spanned)) < 1e-12 * np.abs(points).max() ** d:
            continue
        weights = np.linalg.solve(spanned.T, lifted.T).T
        below = weights.min(axis=0)
        grown = 1.0 - below.sum()
        volume = abs(np.linalg.det(spanned)) * grown**d
        # A tie keeps the first simplex, whichever way the last digits fall on a processor.
        if volume < least * (1 - 1e-9):
            best, least = (weights - below) / grown, volume
    if best is None:
        raise ModelError(f"{N} points lie in a plane of less than {d} dimensions; ask for fewer")
    return _decimals(best)


def _spread_out(points: Floats, start: int, d: int) -> list[int]:
    """Return d + 1 points, each as far as can be from the plane through those before it."""
    chosen = [start]
    rest = points - points[start]
    for _ in range(d):
        lengths = np.linalg.norm(rest, axis=1)
        far = int(np.argmax(lengths))
        chosen.append(far)
        along = rest[far] / (lengths[far] or 1.0)
        rest = rest - np.outer(rest @ along, along)
    return chosen


def _decimals(weights: Floats) -> Floats:
    """Return the weights at 12 places, with what rounding took given to the largest of each row."""
    whole = np.maximum(np.rint(weights * 10**PLACES), 0).astype(np.int64)
    rows = np.arange(len(whole))
    whole[rows, whole.argmax(axis=1)] += 10**PLACES - whole.sum(axis=1)
    found: Floats = whole / 10**PLACES
    return found
