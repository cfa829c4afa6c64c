"""What a polynomial P(h) contributes to an LMI along the motion of h: terms, items and labels."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from takagi.lmi.condition.term import Array, Constant, Labels, Position, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.polynomials.simplex_polynomials import (
    Basis,
    Contributions,
    Degrees,
    Known,
    UnknownPolynomial,
    contributions,
)
from takagi.lmi.varying.parameter_motion import ParameterMotion


@dataclass(frozen=True, slots=True, eq=False)
class TermCoefficients:
    """The coefficients of an LMI in l, once for each corner of the velocities.

    Item v * count + b is coefficient b at velocity v.

    Attributes
    ----------
    basis : of the coefficients.
    motion : whose l it is.
    eye : (1, n, n), exact where the model is.
    """

    basis: Basis
    motion: ParameterMotion
    eye: Array

    @classmethod
    def of(
        cls, motion: ParameterMotion, eye: Array, *parts: Degrees, polya: int = 0
    ) -> TermCoefficients:
        """Return those of the least degrees that hold all parts, raised by ``polya``."""
        degrees = tuple(
            max(all_degrees) + (polya if size > 1 else 0)
            for all_degrees, size in zip(zip(*parts, strict=True), motion.sizes, strict=True)
        )
        return cls(Basis(motion.sizes, degrees), motion, eye)

    @property
    def velocities(self) -> int:
        return max(1, len(self.motion.velocities))

    @property
    def count(self) -> int:
        """Return how many items there are."""
        return self.basis.count * self.velocities

    def term(
        self,
        unknown: Unknown,
        polynomial: UnknownPolynomial,
        factor_given: Known | None = None,
        *,
        at: Position = (0, 0),
        factor: float = 1,
        behind: bool = True,
        plus_transpose: bool = False,
        parameter: str | None = None,
        latex: tuple[str, str] = ("", ""),
        symbol: str = "",
    ) -> Term:
        """Return X(l) K(l), or K(l) X(l), in every item.

        Parameters
        ----------
        factor_given : K; None is the identity.
        factor : multiplies K.
        behind : K stands behind X.
        """
        product = self._contributions(polynomial, factor_given)
        offsets = np.arange(self.velocities)[:, None] * self.basis.count
        items = (offsets + product.items).ravel()
        members = np.tile(product.members, self.velocities)
        # A fraction times a float is a float.
        size = Fraction(factor) if product.values.dtype == object else factor
        values = np.tile(size * product.values, (self.velocities, 1, 1))
        eye = self._identity(unknown.cols if not behind else unknown.rows)
        return Term(
            unknown=unknown,
            left=eye if behind else values,
            right=values if behind else eye,
            at=at,
            plus_transpose=plus_transpose,
            items=items,
            members=members,
            parameter=parameter,
            latex=latex,
            symbol=symbol,
        )

    def rate_terms(
        self, unknown: Unknown, polynomial: UnknownPolynomial, symbol: str
    ) -> tuple[Term, ...]:
        """Return dX/dt at the velocity of each item."""
        slopes: list[tuple[int, Contributions]] = []
        for number, velocity in enumerate(self.motion.velocities):
            for slope in polynomial.derivatives(velocity):
                slopes.append((number, self._contributions(slope, None)))
        if not slopes:
            return ()
        eye = self._identity(unknown.rows)
        return (
            Term(
                unknown=unknown,
                left=np.concatenate([slope_part.values for _, slope_part in slopes]),
                right=eye,
                items=np.concatenate(
                    [number * self.basis.count + slope_part.items for number, slope_part in slopes]
                ),
                members=np.concatenate([slope_part.members for _, slope_part in slopes]),
                symbol=symbol,
            ),
        )

    def constant(self, polynomial: Known, at: Position, latex: str) -> Constant:
        """Return a known polynomial in l in every item."""
        values = polynomial.to(self.basis.degrees).values
        return Constant(value=np.tile(values, (self.velocities, 1, 1)), at=at, latex=latex)

    @property
    def index(self) -> str:
        """Return the range of the items in LaTeX."""
        degrees = ", ".join(map(str, self.basis.degrees))
        degrees = degrees if len(self.basis.degrees) == 1 else f"({degrees})"
        rates = r" \text{ at each rate}" if self.velocities > 1 else ""
        return rf"\text{{each coefficient of degree }} {degrees}{rates}"

    def labels(self, prefix: str = "") -> Sequence[str]:
        """Return names of the items, e.g. ``"h1 h2, rates 3 of 6"``."""
        count, velocities = self.basis.count, self.velocities

        def name(item: int) -> str:
            velocity, coefficient = divmod(item, count)
            moving = f", rates {velocity + 1} of {velocities}" if velocities > 1 else ""
            product = self.basis.label(coefficient, self.motion.axes) or "all memberships"
            return f"{prefix}{product}{moving}"

        return Labels(self.count, name)

    def _contributions(self, polynomial: UnknownPolynomial, factor: Known | None) -> Contributions:
        if factor is None:
            zero = Basis(self.motion.sizes, (0,) * len(self.motion.sizes))
            factor = Known(zero, self._identity(self.eye.shape[1]))
        return contributions(polynomial, factor, self.basis.degrees)

    def _identity(self, size: int) -> Array:
        return identity_like(self.eye, size)


def identity_like(array: Array, size: int) -> Array:
    """Return (1, size, size), of Fractions where the array has them."""
    if array.dtype != object:
        return np.eye(size)[None]
    one = np.full((1, size, size), Fraction(0), dtype=object)
    one[:, range(size), range(size)] = Fraction(1)
    return one
