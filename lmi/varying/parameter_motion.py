r"""A polynomial Lyapunov function along the motion of its parameter.

Continuous time: dP/dt at each corner v of the velocities.  Discrete time: h = H l and h+ = H+ l for
a point l of a product of simplexes that has the corners of the possible steps (h, h+), so that
A(h), P(h) and P(h+) are polynomials in l.  Where a membership may jump anywhere, h and h+ have
simplexes of their own; where it stays, they are one.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from takagi.lmi.polynomials.simplex_polynomials import Basis, Degrees, Known
from takagi.lmi.polynomials.unknown_polynomial import UnknownPolynomial, substituted
from takagi.lmi.varying.parameter_space import Space
from takagi.lmi.varying.rate_polytopes import step_corners, velocity_corners
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

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
        self, basis: Basis, places: Sequence[MotionPoint]
    ) -> tuple[Basis, Floats | None]:
        degrees = [0] * len(self.sizes)
        for degree, place in zip(basis.degrees, places, strict=True):
            degrees[place.simplex] += degree
        placed = Basis(self.sizes, tuple(degrees))
        if all(place.identity for place in places):
            return placed, None
        T: Floats = np.ones((1, 1))
        for degree, place in zip(basis.degrees, places, strict=True):
            T = np.asarray(np.kron(T, substituted(degree, place.points)))
        return placed, T


def kept_degrees(degrees: Degrees, rates: Sequence[Floats], *, discrete: bool) -> Degrees:
    """Return the degrees, 0 where P may not depend on a membership that jumps.

    In discrete time it may: only the next step matters.

    Raises
    ------
    ModelError : some memberships of one simplex without a bound, others with one.
    """
    found = []
    for degree, rate in zip(degrees, rates, strict=True):
        free = np.isinf(rate)
        # A single one is bounded by what the others can balance.
        if free.sum() > 1 and not free.all():
            raise ModelError(
                f"rate_bounds leaves {int(free.sum())} of {len(free)} memberships without a bound "
                "and bounds the others; bound all but one of them, or none"
            )
        found.append(0 if free.sum() > 1 and not discrete else degree)
    return tuple(found)


def motion_of(
    space: Space, degrees: Degrees, rates: Sequence[Floats], sample_time: float | None
) -> ParameterMotion:
    """Return the motion with |dw/dt| <= rates, or |w(t + T) - w(t)| <= T rates.

    Parameters
    ----------
    degrees : of P; where P has none, rates do not matter.
    rates : bounds in 1/s, as from ``membership_rates``.

    Raises
    ------
    ModelError : too many corners to pose.
    """
    if sample_time is None:
        return continuous_motion(space, degrees, rates)
    return discrete_motion(space, degrees, tuple(rate * sample_time for rate in rates))


def still_motion(space: Space) -> ParameterMotion:
    """Return the motion of memberships whose rates do not matter, or are zero."""
    places = tuple(MotionPoint(k, np.eye(size)) for k, size in enumerate(space.sizes))
    return ParameterMotion(space.sizes, places, places, space.axes)


def continuous_motion(space: Space, degrees: Degrees, rates: Sequence[Floats]) -> ParameterMotion:
    """Return the motion with |dw/dt| <= rates.

    Parameters
    ----------
    degrees : of P; where P has none, velocities do not matter.
    rates : bounds in 1/s, as from ``membership_rates``.

    Raises
    ------
    ModelError : too many corners of velocities to pose.
    """
    corners = [
        velocity_corners(rate) if degree else np.zeros((1, len(rate)))
        for degree, rate in zip(degrees, rates, strict=True)
    ]
    count = int(np.prod([len(one) for one in corners]))
    if count > MOST_CORNERS:
        raise ModelError(
            f"the rates have {count} corners, more than {MOST_CORNERS}; let P depend on fewer "
            "premises (degree 0 in the others), or give inf or 0 for the rates that matter least"
        )
    return replace(still_motion(space), velocities=tuple(product(*corners)))


def discrete_motion(space: Space, degrees: Degrees, steps: Sequence[Floats]) -> ParameterMotion:
    """Return the motion with |w(t + T) - w(t)| <= steps.

    Parameters
    ----------
    degrees : of P; where P has none, steps do not matter.
    steps : bounds of one step, one array a simplex.
    """
    sizes: list[int] = []
    axes: list[str] = []
    now: list[MotionPoint] = []
    then: list[MotionPoint] = []
    starts = np.cumsum([0, *space.sizes])
    for k, (degree, bound, size) in enumerate(zip(degrees, steps, space.sizes, strict=True)):
        names = space.axes[starts[k] : starts[k + 1]]
        first = second = np.eye(size)
        here = after = len(sizes)
        if degree and size > 1 and (bound >= 1).all():
            after += 1
            axes += [*names, *(f"{name}+" for name in names)]
            sizes += [size, size]
        else:
            if degree and bound.any():
                first, second = step_corners(bound)
                names = _step_names(space, k, first.shape[1])
            axes += names
            sizes.append(first.shape[1])
        now.append(MotionPoint(here, first))
        then.append(MotionPoint(after, second))
    return ParameterMotion(tuple(sizes), tuple(now), tuple(then), tuple(axes))


def _step_names(space: Space, simplex: int, count: int) -> tuple[str, ...]:
    if not space.premises:
        return tuple(f"step{c + 1}" for c in range(count))
    return tuple(f"({space.premises[simplex]} step {c + 1})" for c in range(count))
