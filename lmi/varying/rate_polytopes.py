r"""Where memberships can go: the corners of what bounds on their rates leave.

    velocities   { v : |v_c| <= phi_c, sum_c v_c = 0 }
    steps        { (h, h+) : both on the simplex, |h+_c - h_c| <= phi_c }

Source: Geromel and Colaneri (2006), Systems and Control Letters 55, for the first; Oliveira and
Peres (2009), Automatica 45(11), for the second.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

# Memberships of one simplex that may move with bounds of their own: corners multiply beyond it.
MOST_MOVING = 12
MOST_STEPPING = 4
# A bound on a step that is smaller is made this, so that the polytope has an inside.
SMALLEST_STEP = 1e-6


def velocity_corners(bound: Floats) -> Floats:
    """Return the corners of the velocities, (count, corners of the simplex).

    All but one of the v_c are at their bounds, and the last balances them.

    Parameters
    ----------
    bound : phi, (corners of the simplex,), in 1/s; at most one is infinite.

    Raises
    ------
    ModelError : too many memberships for a list of corners.
    """
    phi = _balanced(bound)
    moving = np.flatnonzero(phi > 0)
    if not len(moving):
        return np.zeros((1, len(phi)))
    if len(moving) > MOST_MOVING:
        raise ModelError(
            f"{len(moving)} memberships move with rates of their own, more than {MOST_MOVING}; "
            'take rates="slack", or give the model its premises, with a rate for each'
        )
    signs = np.array(list(product((-1.0, 1.0), repeat=len(moving) - 1)))
    found = []
    for free in range(len(moving)):
        others = np.delete(moving, free)
        rest = signs * phi[others]
        balance = -rest.sum(axis=1)
        # A rate that balances the others exactly is a corner, although rounding may exceed its
        # bound.
        fits = np.abs(balance) <= phi[moving[free]] * (1 + 1e-12)
        corners = np.zeros((int(fits.sum()), len(phi)))
        corners[:, others] = rest[fits]
        corners[:, moving[free]] = balance[fits]
        found.append(corners)
    return _distinct(np.concatenate(found), float(phi.max()))


def step_corners(bound: Floats) -> tuple[Floats, Floats]:
    """Return the corners (h, h+) of the steps, each (corners of the simplex, count).

    Parameters
    ----------
    bound : phi, (corners of the simplex,), of one step.

    Raises
    ------
    ModelError : too many memberships for a list of corners.
    """
    size = len(bound)
    phi = _balanced(bound)
    if not phi.any():
        return np.eye(size), np.eye(size)
    phi = np.maximum(np.minimum(phi, 1.0), SMALLEST_STEP)
    if size == 2:
        return _two(float(phi.min()))
    if size > MOST_STEPPING:
        raise ModelError(
            f"{size} memberships step with bounds of their own, more than {MOST_STEPPING}; let "
            "them step freely (inf), or give the model its premises, with a rate for each"
        )
    return _more(phi)


def _balanced(bound: Floats) -> Floats:
    """Return the bounds that matter: what the others cannot balance, no membership can do."""
    others = np.array([np.delete(bound, c).sum() for c in range(len(bound))])
    return np.asarray(np.minimum(bound, others))


def _two(phi: float) -> tuple[Floats, Floats]:
    """Return the corners of |b - a| <= phi in the square, a and b being h_1 and h+_1."""
    a = np.array([0.0, 0.0, phi, 1.0, 1.0, 1.0 - phi])
    b = np.array([0.0, phi, 0.0, 1.0, 1.0 - phi, 1.0])
    return np.stack([a, 1.0 - a]), np.stack([b, 1.0 - b])


def _more(phi: Floats) -> tuple[Floats, Floats]:
    from scipy.spatial import HalfspaceIntersection

    free = len(phi) - 1
    one, none = np.eye(free), np.zeros((free, free))
    sums, nothing = np.ones((1, free)), np.zeros((1, free))
    # Rows g with g . (h, h+) <= c, for all but the last membership of each.
    rows = [
        (np.hstack([-one, none]), np.zeros(free)),
        (np.hstack([none, -one]), np.zeros(free)),
        (np.hstack([sums, nothing]), np.ones(1)),
        (np.hstack([nothing, sums]), np.ones(1)),
        (np.hstack([-one, one]), phi[:-1]),
        (np.hstack([one, -one]), phi[:-1]),
        (np.hstack([-sums, sums]), phi[-1:]),
        (np.hstack([sums, -sums]), phi[-1:]),
    ]
    planes = np.vstack([np.hstack([g, -c[:, None]]) for g, c in rows])
    inside = np.full(2 * free, 1.0 / len(phi))
    corners = _distinct(HalfspaceIntersection(planes, inside).intersections, 1.0)
    # Rounding may have left the simplexes by 1e-16.
    corners = np.clip(corners, 0.0, 1.0)
    now, then = corners[:, :free].T, corners[:, free:].T
    return np.vstack([now, 1.0 - now.sum(axis=0)]), np.vstack([then, 1.0 - then.sum(axis=0)])


def _distinct(corners: Floats, size: float) -> Floats:
    """Return the rows that differ by more than rounding."""
    _, first = np.unique(np.round(corners / size, 9), axis=0, return_index=True)
    return np.asarray(corners[np.sort(first)])
