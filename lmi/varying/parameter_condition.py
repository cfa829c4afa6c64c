"""LMIs by which a polynomial P(h) > 0 shows stability; every coefficient is an LMI.

    continuous   He(P(h) A(h)) + dP/dt + 2 alpha P(h) < 0

    discrete     [ rho^2 P(h)    A(h)' P(h+) ]
                 [ .             P(h+)       ]  > 0

V = x' P(h) x then has V' <= -2 alpha V, or V(x+) <= rho^2 V(x), rho = e^(-alpha T).

Source: Oliveira and Peres (2007), IEEE Trans. Automatic Control 52(7), for polynomial P; Daafouz
and Bernussou (2001), Systems and Control Letters 43, for P(h+).

The inequality at some blends h alone, with P(h) > 0 for all h, is necessary for P(h) of this degree
by any relaxation.  It shows nothing of the blends between.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.decay_rate import vertex_weight
from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import Vertices, decay_parameter
from takagi.lmi.condition.statements import pose
from takagi.lmi.condition.term import Array, Labels, identity_like
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import Expression, He, Inequality, Parameter, block, matrix
from takagi.lmi.expressions.piece import Letter, Piece
from takagi.lmi.polynomials import (
    Basis,
    Contributions,
    Degrees,
    Known,
    UnknownPolynomial,
    contributions,
)
from takagi.lmi.varying.parameter_motion import ParameterMotion, kept_degrees, motion_of
from takagi.lmi.varying.parameter_space import (
    RateBounds,
    VaryingLoop,
    decided_lyapunov,
    degrees_of,
    membership_rates,
    varying_loop,
)
from takagi.models.arrays import Floats


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

    def product(
        self,
        unknown: Unknown,
        polynomial: UnknownPolynomial,
        factor: Known | None = None,
        *,
        behind: bool = True,
        latex: str = "",
        symbol: str = "",
    ) -> Expression:
        """Return X(l) K(l), or K(l) X(l), in every item.

        Parameters
        ----------
        factor : K; None is the identity.
        behind : K stands behind X.
        latex : of K.
        """
        part = self._contributions(polynomial, factor)
        parts = [(velocity, part) for velocity in range(self.velocities)]
        return self._sum(unknown, parts, behind=behind, latex=latex, symbol=symbol)

    def rate(
        self, unknown: Unknown, polynomial: UnknownPolynomial, symbol: str
    ) -> Expression | int:
        """Return dX/dt at the velocity of each item."""
        slopes = [
            (number, self._contributions(slope, None))
            for number, velocity in enumerate(self.motion.velocities)
            for slope in polynomial.derivatives(velocity)
        ]
        return self._sum(unknown, slopes, behind=False, symbol=symbol) if slopes else 0

    def _sum(
        self,
        unknown: Unknown,
        parts: Sequence[tuple[int, Contributions]],
        *,
        behind: bool,
        latex: str = "",
        symbol: str,
    ) -> Expression:
        """Return the contributions at their velocities, with the factor behind X or before it."""
        eye = identity_like(self.eye, unknown.rows if behind else unknown.cols)
        values = np.concatenate([part.values for _, part in parts])
        letters = (Letter(latex),) if latex else ()
        piece = Piece(
            unknown=unknown,
            left=eye if behind else values,
            right=values if behind else eye,
            members=np.concatenate([part.members for _, part in parts]),
            items=np.concatenate([k * self.basis.count + part.items for k, part in parts]),
            item_count=self.count,
            before=() if behind else letters,
            behind=letters if behind else (),
            symbol=symbol,
        )
        return Expression((piece.shape[0],), (piece.shape[1],), (piece,))

    def known(self, polynomial: Known, latex: str) -> Expression:
        """Return a known polynomial in l in every item."""
        values = polynomial.to(self.basis.degrees).values
        return matrix(np.tile(values, (self.velocities, 1, 1)), latex)

    def named(
        self, statement: Inequality, name: str, *, weight: float = 1.0, prefix: str = ""
    ) -> Inequality:
        """Return the statement with the names of its items."""
        return statement.named(name, self.index, weight=weight, labels=self.labels(prefix))

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
            factor = Known(zero, self.eye)
        return contributions(polynomial, factor, self.basis.degrees)


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class SoughtPolynomial:
    """A P(h) that is sought, and the loop it is sought for.

    Attributes
    ----------
    P : its coefficients.
    basis : of P, in h.
    A : x' = A(h) x, or x+ = A(h) x.
    motion : of h.
    polya : how far the degrees of the LMIs are raised.
    axes : names of the corners of h.
    discrete : x+ in the place of x'.
    weight : margin of the decrease for a margin 1 of P.
    """

    P: Unknown
    basis: Basis
    A: Known
    motion: ParameterMotion
    polya: int
    axes: tuple[str, ...]
    discrete: bool
    weight: float

    @classmethod
    def of(
        cls,
        loop: VaryingLoop,
        degrees: Degrees,
        rates: Sequence[Floats],
        *,
        polya: int = 0,
        weight: float | None = None,
    ) -> SoughtPolynomial:
        """Return P(h) of these degrees for a loop whose memberships keep these bounds of rates.

        ``weight`` None takes the size of the loop's matrix.
        """
        step, matrix, n = loop.sample_time, loop.matrix, loop.A.shape[1]
        basis = Basis(loop.space.sizes, degrees)
        return cls(
            P=Unknown("P", n, n, symmetric=True, count=basis.count),
            basis=basis,
            A=matrix,
            motion=motion_of(loop.space, degrees, rates, step),
            polya=polya,
            axes=loop.space.axes,
            discrete=step is not None,
            weight=vertex_weight(matrix.values, step=step) if weight is None else weight,
        )

    @property
    def now(self) -> UnknownPolynomial:
        """Return P(h) as a polynomial in l."""
        return self.motion.unknown(self.basis)

    @property
    def then(self) -> UnknownPolynomial:
        """Return P(h+) as a polynomial in l."""
        return self.motion.unknown(self.basis, then=True)

    @property
    def matrix(self) -> Known:
        """Return A as a polynomial in l."""
        return self.motion.known(self.A)

    def coefficients(self, *more_degrees: Degrees) -> TermCoefficients:
        """Return those of an LMI that holds P(h), P(h+) and parts of more degrees."""
        parts = (self.now.basis.degrees, self.then.basis.degrees, *more_degrees)
        one = identity_like(self.A.values, self.P.rows)
        return TermCoefficients.of(self.motion, one, *parts, polya=self.polya)

    def product(self, factor: Known) -> Degrees:
        """Return the degrees of P(h+) K(h)."""
        return self.then.basis.raised(factor.basis.degrees).degrees


def polynomial_lmis(sought: SoughtPolynomial, *, bounded: bool = True) -> tuple[Inequality, ...]:
    """Pose P(h) > 0, and with ``bounded`` that no coefficient is above I, which fixes the scale."""
    P, n = sought.P, sought.P.rows
    no_motion = ParameterMotion(sought.basis.sizes, (), (), sought.axes)
    one = identity_like(sought.A.values, n)
    at = TermCoefficients.of(no_motion, one, sought.basis.degrees, polya=sought.polya)
    P_h = at.product(P, UnknownPolynomial.of(sought.basis), symbol="P(h)")
    positive = at.named(P_h >> 0, "P positive definite", prefix="P, ")
    if not bounded:
        return (positive,)
    every = P.members(np.arange(P.count), "P_a") <= one[0]
    return positive, every.named("scale of P", r"\text{each } a")


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """P(h), dP/dt or P(h+), and their products with A(h) and B(h), in every item of an LMI."""

    sought: SoughtPolynomial
    at: TermCoefficients

    @property
    def P(self) -> Expression:
        return self.at.product(self.sought.P, self.sought.now, symbol="P(h)")

    @property
    def P_next(self) -> Expression:
        return self.at.product(self.sought.P, self.sought.then, symbol="P(h^+)")

    @property
    def P_dot(self) -> Expression | int:
        return self.at.rate(self.sought.P, self.sought.now, r"\dot P(h)")

    def into(self, factor: Known, latex: str) -> Expression:
        """Return P(h) K(h)."""
        return self.at.product(self.sought.P, self.sought.now, factor, latex=latex, symbol="P(h)")

    def into_next(self, factor: Known, latex: str) -> Expression:
        """Return K(h)' P(h+)."""
        turned = Known(factor.basis, factor.values.transpose(0, 2, 1))
        return self.at.product(
            self.sought.P,
            self.sought.then,
            turned,
            behind=False,
            latex=rf"{latex}^\top",
            symbol="P(h^+)",
        )


def decrease_lmi(sought: SoughtPolynomial, rate: Parameter) -> Inequality:
    """Pose the decrease."""
    A = sought.matrix
    at = sought.coefficients(sought.product(A))
    motion = Motion(sought, at)
    if sought.discrete:
        rows: list[list[object]] = [
            [rate * motion.P, motion.into_next(A, "A(h)")],
            [None, motion.P_next],
        ]
        decrease = block(rows) >> 0
    else:
        decrease = He(motion.into(A, "A(h)")) + motion.P_dot + 2 * rate * motion.P << 0
    return at.named(decrease, "decrease", weight=sought.weight)


def function_at_points(
    model: Vertices,
    blends: ArrayLike,
    *,
    rate_bounds: RateBounds = np.inf,
    degree: int | tuple[int, ...] = 1,
    decay_rate: float = 0.0,
    gains: ArrayLike | None = None,
) -> Answer:
    """Return a candidate P(h) for the module's inequalities.

    ``model``, ``rate_bounds``, ``degree``, ``decay_rate``, ``gains`` : as for ``fuzzy_lyapunov``;
    in discrete time the next memberships are arbitrary, and rate_bounds is not read.
    ``blends`` : (N, sum of sizes), the weights of each premise's corners, or of the rules.

    Raises ModelError: as ``fuzzy_lyapunov``.
    """
    loop = varying_loop(model, gains)
    step = loop.sample_time
    rates = membership_rates(loop.space, rate_bounds if step is None else np.inf)
    degrees = kept_degrees(degrees_of(loop.space, degree), rates, discrete=step is not None)
    s = loop.units(None)
    scaled = loop.scaled(s)
    sought = SoughtPolynomial.of(scaled, degrees, rates)
    P, basis, weight = sought.P, sought.basis, sought.weight
    w, loop_matrix = np.asarray(blends, dtype=np.float64), sought.A
    rate = decay_parameter(decay_rate, step)
    G = np.tensordot(loop_matrix.basis.values(w), loop_matrix.values.astype(np.float64), axes=1)
    B = basis.values(w)
    if step is None:
        # dB_a/dt at the blends, velocity after velocity.
        slopes = np.concatenate(
            [
                sum(
                    (slope.basis.values(w) @ slope.weights for slope in directions),
                    start=np.zeros_like(B),
                )
                for directions in (
                    UnknownPolynomial.of(basis).derivatives(v) for v in sought.motion.velocities
                )
            ]
        )
        many = len(slopes) // len(w)
        blend = _blended(P, np.tile(B, (many, 1)))
        falling = He(blend @ matrix(np.tile(G, (many, 1, 1)), "G(h_k)"))
        decrease = falling + _blended(P, slopes) + 2 * rate * blend << 0
    else:
        now = _blended(P, np.repeat(B, P.count, axis=0))
        following = P.members(np.tile(np.arange(P.count), len(G)), "P_c")
        G_k = matrix(np.repeat(G, P.count, axis=0), "G(h_k)")
        decrease = block([[rate * now, G_k.T @ following], [None, following]]) >> 0
    count = decrease.expression.count
    labels = tuple(f"blend {k + 1}" for k in range(count))
    condition = pose(
        *polynomial_lmis(sought),
        decrease.named("decrease", rf"k = 1, \dots, {count}", weight=weight, labels=labels),
        name="function of the memberships at single blends",
        source="necessary for every relaxation",
    )
    return decided_lyapunov(condition, loop, s, basis, "lower the rate bounds or the decay rate")


def _blended(P: Unknown, weights: Floats) -> Expression:
    """Return sum_a weights[k, a] P_a for each blend k."""
    total = matrix(weights[:, 0, None, None], "b_{k,1}") * P.member(0)
    for a in range(1, P.count):
        total += matrix(weights[:, a, None, None], f"b_{{k,{a + 1}}}") * P.member(a)
    return total
