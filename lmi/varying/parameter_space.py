"""The memberships of a model as a point of a product of simplexes, and how fast they may move."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.argument_checks import corners_of
from takagi.lmi.condition.term import Array
from takagi.lmi.polynomials.simplex_polynomials import Degrees, Known
from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError, did_you_mean

# A bound for each premise, by name or in order, in its unit per second; or for each membership.
RateBounds: TypeAlias = ArrayLike | Mapping[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class Space:
    """Rule i is the corner corners[i] of the product: h_i = prod_k w^k_(corners[i, k]).

    Attributes
    ----------
    sizes : corners of each simplex: two for a premise, one where it is constant; all rules in a
        single simplex for a model without premises.
    corners : (r, K).
    premises : names of the premises; empty without.
    widths : (K,) upper - lower of each premise, in its unit; 1 without premises.
    """

    sizes: tuple[int, ...]
    corners: Indices
    premises: tuple[str, ...]
    widths: Floats

    @property
    def axes(self) -> tuple[str, ...]:
        """Return the names of all corners, ``"h1"`` or ``"(z low)"``; empty for constant ones."""
        if not self.premises:
            return tuple(f"h{c + 1}" for c in range(self.sizes[0]))
        ends = {1: ("",), 2: ("low", "high")}
        return tuple(
            f"({name} {end})" if end else ""
            for name, size in zip(self.premises, self.sizes, strict=True)
            for end in ends[size]
        )

    def known(self, vertices: Array) -> Known:
        """Return the polynomial of degree 1 in each simplex with these values at the rules."""
        return Known.of_vertices(self.sizes, self.corners, vertices)


def space_of(model: object, rules: int) -> Space:
    """Return the product of the model's premises, or one simplex with a corner for each rule."""
    corners = corners_of(model)
    if corners is None:
        return Space((rules,), np.arange(rules)[:, None], (), np.ones(1))
    premises = tuple(getattr(model, "premises", ()))
    return Space(
        tuple(len(premise.corners) for premise in premises),
        corners,
        tuple(premise.name for premise in premises),
        np.array([float(premise.upper - premise.lower) for premise in premises]),
    )


def degrees_of(space: Space, degree: int | Sequence[int]) -> Degrees:
    """Return the degree in each simplex; one number stands for all.

    Raises
    ------
    ModelError : not whole, negative, or not one for each.
    """
    given = tuple(degree) if isinstance(degree, Sequence) else (degree,) * len(space.sizes)
    if len(given) != len(space.sizes) or not all(
        isinstance(one, (int, np.integer)) and not isinstance(one, bool) and one >= 0
        for one in given
    ):
        what = f"one for each of {', '.join(space.premises)}" if space.premises else "one number"
        raise ModelError(f"degree is {degree!r}; whole numbers from 0 are needed, {what}")
    # A constant premise has nothing to be a polynomial of.
    return tuple(int(one) if size > 1 else 0 for one, size in zip(given, space.sizes, strict=True))


def polya_of(polya: object) -> int:
    """Return a degree to raise by.

    Raises
    ------
    ModelError : not a whole number from 0.
    """
    if isinstance(polya, bool) or not isinstance(polya, (int, np.integer)) or polya < 0:
        raise ModelError(f"polya is {polya!r}; a whole number from 0 is needed")
    return int(polya)


def membership_rates(space: Space, bounds: RateBounds) -> tuple[Floats, ...]:
    """Return the bound of |dw^k_c/dt| in 1/s, (corners of simplex k,), for each simplex k.

    Parameters
    ----------
    bounds : with premises, of |dz_k/dt| in the unit of z_k per second, by name or in order;
        without, of |dh_i/dt| in 1/s.  One number stands for all, inf is not a bound, 0 is constant.

    Raises
    ------
    ModelError : a premise missing or unknown, a wrong length, a negative number or NaN.
    """
    if isinstance(bounds, Mapping):
        bounds = _by_name(space, bounds)
    count = len(space.premises) or space.sizes[0]
    try:
        given = np.asarray(bounds, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ModelError(f"rate_bounds cannot be read as real numbers ({error})") from error
    if given.shape not in ((), (count,)):
        raise ModelError(
            f"rate_bounds has shape {given.shape}; ({count},) is needed, one for each "
            f"{'premise' if space.premises else 'membership'}, or one number for all"
        )
    given = np.broadcast_to(given, (count,))
    if not (given >= 0).all():
        raise ModelError(
            f"rate_bounds[{int(np.argmin(given >= 0))}] is {given[np.argmin(given >= 0)]}; it must "
            "be 0, positive, or inf for no bound"
        )
    if not space.premises:
        return (given.copy(),)
    return tuple(
        np.full(size, rate / width if size > 1 else 0.0)
        for rate, width, size in zip(given, space.widths, space.sizes, strict=True)
    )


def _by_name(space: Space, bounds: Mapping[str, float]) -> list[float]:
    if not space.premises:
        raise ModelError(
            "rate_bounds is given by name, but the model has no premises; give one bound for "
            "each membership, in 1/s"
        )
    for name in bounds:
        if name not in space.premises:
            raise ModelError(
                f"rate_bounds: there is no premise {name!r}; there are {', '.join(space.premises)}"
                + did_you_mean(str(name), list(space.premises))
            )
    missing = [name for name in space.premises if name not in bounds]
    if missing:
        raise ModelError(
            f"rate_bounds: none is given for {', '.join(missing)}; give a bound for each premise, "
            "inf where there is none"
        )
    return [bounds[name] for name in space.premises]
