r"""A polynomial Lyapunov function along the motion of its parameter.

Continuous time: dP/dt at each corner v of the velocities.  Discrete time: h = H l and h+ = H+ l for
a point l of a product of simplexes that has the corners of the possible steps (h, h+), so that
A(h), P(h) and P(h+) are polynomials in l.  Where a membership may jump anywhere, h and h+ have
simplexes of their own; where it stays, they are one.

Where memberships can go: the corners of what bounds on their rates leave.

    velocities   { v : |v_c| <= phi_c, sum_c v_c = 0 }
    steps        { (h, h+) : both on the simplex, |h+_c - h_c| <= phi_c }

Source: Geromel and Colaneri (2006), Systems and Control Letters 55, for the first; Oliveira and
Peres (2009), Automatica 45(11), for the second.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from takagi.lmi.polynomials import Basis, Degrees, Known, UnknownPolynomial, substituted
from takagi.lmi.varying.parameter_space import Space
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

# The most memberships whose rates' corners are listed, about r 2^(r-1) of them.
MOST_RULES = 12
# Memberships of one simplex that may step with bounds of their own: corners multiply beyond it.
MOST_STEPPING = 4
# A bound on a step that is smaller is made this, so that the polytope has an inside.
SMALLEST_STEP = 1e-6


def velocity_corners(bound: Floats) -> Floats:
    """Return the corners of the velocities, (count, corners of the simplex).

    All but one of the v_c are at their bounds, and the last balances them.

    ``bound`` : phi, (corners of the simplex,), in 1/s; at most one is infinite.

    Raises ModelError: too many memberships for a list of corners.
    """
    phi = balanced_bounds(bound)
    moving = np.flatnonzero(phi > 0)
    if not len(moving):
        return np.zeros((1, len(phi)))
    if len(moving) > MOST_RULES:
        raise ModelError(
            f"{len(moving)} memberships move with rates of their own, more than {MOST_RULES}; "
            "give the model its premises, with a rate for each"
        )
    signs = np.array(list(product((-1.0, 1.0), repeat=len(moving) - 1)))
    corner_groups = []
    for free in range(len(moving)):
        other_rates = np.delete(moving, free)
        other_values = signs * phi[other_rates]
        balance = -other_values.sum(axis=1)
        # A rate that balances the others exactly is a corner, although rounding may exceed its
        # bound.
        fits = np.abs(balance) <= phi[moving[free]] * (1 + 1e-12)
        corners = np.zeros((int(fits.sum()), len(phi)))
        corners[:, other_rates] = other_values[fits]
        corners[:, moving[free]] = balance[fits]
        corner_groups.append(corners)
    return distinct_rows(np.concatenate(corner_groups), float(phi.max()))


def balanced_bounds(bound: Floats) -> Floats:
    """Return the bounds that matter: what the others cannot balance, no membership can do."""
    sums_of_others = np.array([np.delete(bound, c).sum() for c in range(len(bound))])
    return np.asarray(np.minimum(bound, sums_of_others))


def distinct_rows(corners: Floats, size: float) -> Floats:
    """Return the rows that differ by more than rounding."""
    _, first = np.unique(np.round(corners / size, 9), axis=0, return_index=True)
    return np.asarray(corners[np.sort(first)])


def step_corners(bound: Floats) -> tuple[Floats, Floats]:
    """Return the corners (h, h+) of the steps, each (corners of the simplex, count).

    ``bound`` : phi, (corners of the simplex,), of one step.

    Raises ModelError: too many memberships for a list of corners.
    """
    size = len(bound)
    phi = balanced_bounds(bound)
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


def _two(phi: float) -> tuple[Floats, Floats]:
    """Return the corners of |b - a| <= phi in the square, a and b being h_1 and h+_1."""
    a = np.array([0.0, 0.0, phi, 1.0, 1.0, 1.0 - phi])
    b = np.array([0.0, phi, 0.0, 1.0, 1.0 - phi, 1.0])
    return np.stack([a, 1.0 - a]), np.stack([b, 1.0 - b])


def _more(phi: Floats) -> tuple[Floats, Floats]:
    from scipy.spatial import HalfspaceIntersection

    free = len(phi) - 1
    eye, none = np.eye(free), np.zeros((free, free))
    sums, nothing = np.ones((1, free)), np.zeros((1, free))
    # Rows g with g . (h, h+) <= c, for all but the last membership of each.
    rows = [
        (np.hstack([-eye, none]), np.zeros(free)),
        (np.hstack([none, -eye]), np.zeros(free)),
        (np.hstack([sums, nothing]), np.ones(1)),
        (np.hstack([nothing, sums]), np.ones(1)),
        (np.hstack([-eye, eye]), phi[:-1]),
        (np.hstack([eye, -eye]), phi[:-1]),
        (np.hstack([-sums, sums]), phi[-1:]),
        (np.hstack([sums, -sums]), phi[-1:]),
    ]
    planes = np.vstack([np.hstack([g, -c[:, None]]) for g, c in rows])
    inside = np.full(2 * free, 1.0 / len(phi))
    corners = distinct_rows(HalfspaceIntersection(planes, inside).intersections, 1.0)
    # Rounding may have left the simplexes by 1e-16.
    corners = np.clip(corners, 0.0, 1.0)
    now, then = corners[:, :free].T, corners[:, free:].T
    return np.vstack([now, 1.0 - now.sum(axis=0)]), np.vstack([then, 1.0 - then.sum(axis=0)])


MOST_CORNERS = 1024


@dataclass(frozen=True, slots=True, eq=False)
class MotionPoint:
    """h^k = points l^simplex; points is (corners of h^k, corners of l^simplex)."""

    simplex: int
    points: Floats

    @property
    def identity(self) -> bool:
        rows, columns = self.points.shape
        return rows == columns and bool((self.points == np.eye(rows)).all())


@dataclass(frozen=True, slots=True, eq=False)
class ParameterMotion:
    """Where h is, and where it goes.

    Attributes
    ----------
    sizes : of the simplexes of l.
    now, then : h and h+ as functions of l, one ``MotionPoint`` a simplex of h; ``then`` is ``now``
        in continuous time.
    axes : names of the corners of l.
    velocities : corners of dh/dt, each one array a simplex; in continuous time only.
    """

    sizes: tuple[int, ...]
    now: tuple[MotionPoint, ...]
    then: tuple[MotionPoint, ...]
    axes: tuple[str, ...]
    velocities: tuple[tuple[Floats, ...], ...] = ()

    def known(self, polynomial: Known) -> Known:
        """Return a known polynomial in h as one in l."""
        basis, T = self._substitution(polynomial.basis, self.now)
        if T is None:
            return Known(basis, polynomial.values)
        return Known(basis, np.tensordot(T, polynomial.values, axes=1))

    def unknown(self, basis: Basis, *, then: bool = False) -> UnknownPolynomial:
        """Return P(h), or P(h+), as a polynomial in l, the members being P's coefficients."""
        placed, T = self._substitution(basis, self.then if then else self.now)
        return UnknownPolynomial.of(placed) if T is None else UnknownPolynomial(placed, T)

    def _substitution(
        self, basis: Basis, points: Sequence[MotionPoint]
    ) -> tuple[Basis, Floats | None]:
        degrees = [0] * len(self.sizes)
        for degree, point in zip(basis.degrees, points, strict=True):
            degrees[point.simplex] += degree
        placed = Basis(self.sizes, tuple(degrees))
        if all(point.identity for point in points):
            return placed, None
        T: Floats = np.ones((1, 1))
        for degree, point in zip(basis.degrees, points, strict=True):
            T = np.asarray(np.kron(T, substituted(degree, point.points)))
        return placed, T


def kept_degrees(degrees: Degrees, rates: Sequence[Floats], *, discrete: bool) -> Degrees:
    """Return the degrees, 0 where P may not depend on a membership that jumps.

    In discrete time it may: only the next step matters.

    Raises
    ------
    ModelError : some memberships of one simplex without a bound, others with one.
    """
    kept = []
    for degree, rate in zip(degrees, rates, strict=True):
        free = np.isinf(rate)
        # A single one is bounded by what the others can balance.
        if free.sum() > 1 and not free.all():
            raise ModelError(
                f"rate_bounds leaves {int(free.sum())} of {len(free)} memberships without a bound "
                "and bounds the others; bound all but one of them, or none"
            )
        kept.append(0 if free.sum() > 1 and not discrete else degree)
    return tuple(kept)


def motion_of(
    space: Space, degrees: Degrees, rates: Sequence[Floats], sample_time: float | None
) -> ParameterMotion:
    """Return the motion with |dw/dt| <= rates, or |w(t + T) - w(t)| <= T rates.

    ``degrees`` : of P; where P has none, rates do not matter.
    ``rates`` : bounds in 1/s, as from ``membership_rates``.

    Raises ModelError: too many corners to pose.
    """
    if sample_time is None:
        return continuous_motion(space, degrees, rates)
    return discrete_motion(space, degrees, tuple(rate * sample_time for rate in rates))


def continuous_motion(space: Space, degrees: Degrees, rates: Sequence[Floats]) -> ParameterMotion:
    """Return the motion with |dw/dt| <= rates; as ``motion_of``."""
    corners = [
        velocity_corners(rate) if degree else np.zeros((1, len(rate)))
        for degree, rate in zip(degrees, rates, strict=True)
    ]
    count = int(np.prod([len(simplex_corners) for simplex_corners in corners]))
    if count > MOST_CORNERS:
        raise ModelError(
            f"the rates have {count} corners, more than {MOST_CORNERS}; let P depend on fewer "
            "premises (degree 0 in the others), or give inf or 0 for the rates that matter least"
        )
    points = tuple(MotionPoint(k, np.eye(size)) for k, size in enumerate(space.sizes))
    return ParameterMotion(space.sizes, points, points, space.axes, tuple(product(*corners)))


def discrete_motion(space: Space, degrees: Degrees, steps: Sequence[Floats]) -> ParameterMotion:
    """Return the motion with |w(t + T) - w(t)| <= steps, one array a simplex."""
    sizes: list[int] = []
    axes: list[str] = []
    now: list[MotionPoint] = []
    then: list[MotionPoint] = []
    starts = np.cumsum([0, *space.sizes])
    for k, (degree, bound, size) in enumerate(zip(degrees, steps, space.sizes, strict=True)):
        names = space.axes[starts[k] : starts[k + 1]]
        first = second = np.eye(size)
        here = next_index = len(sizes)
        if degree and size > 1 and (bound >= 1).all():
            next_index += 1
            axes += [*names, *(f"{name}+" for name in names)]
            sizes += [size, size]
        else:
            if degree and bound.any():
                first, second = step_corners(bound)
                names = tuple(
                    f"({space.premises[k]} step {c + 1})" if space.premises else f"step{c + 1}"
                    for c in range(first.shape[1])
                )
            axes += names
            sizes.append(first.shape[1])
        now.append(MotionPoint(here, first))
        then.append(MotionPoint(next_index, second))
    return ParameterMotion(tuple(sizes), tuple(now), tuple(then), tuple(axes))
