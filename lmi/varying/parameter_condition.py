"""The LMIs of P(h), and their terms as polynomial coefficients.

What a polynomial P(h) contributes to an LMI along the motion of h: terms, items and labels.

LMIs by which a polynomial P(h) > 0 shows stability; every coefficient is an LMI.

    continuous   He(P(h) A(h)) + dP/dt + 2 alpha P(h) < 0

    discrete     [ rho^2 P(h)    A(h)' P(h+) ]
                 [ .             P(h+)       ]  > 0

V = x' P(h) x then has V' <= -2 alpha V, or V(x+) <= rho^2 V(x), rho = e^(-alpha T).

Source: Oliveira and Peres (2007), IEEE Trans. Automatic Control 52(7), for polynomial P; Daafouz
and Bernussou (2001), Systems and Control Letters 43, for P(h+).

Two forms of the same decrease: with products of P(h) and A(h), or held apart by slacks.

    continuous   [ He(F A(h)) + dP/dt + 2 alpha P(h)   kappa (P(h) - F) + A(h)' G' ]
                 [ .                                   -kappa (G + G')             ]  < 0

    discrete     [ rho^2 P(h)    A(h)' G'        ]
                 [ .             G + G' - P(h+)  ]  > 0

The slacks F and G are the same for all h: with [x; x' / kappa] for x' = A x, or [x; -x+] for x+ =
A x, on both sides they vanish, and V' < -2 alpha V, or V(x+) < rho^2 V(x), is left.  Linear in P(h)
and in A(h), so that one LMI a vertex is enough where P is linear in h.  F = P and small G, or G = P
in discrete time, shows whatever a common P shows.  The number kappa, about the size of A, only
balances the blocks.

Source: Peaucelle, Arzelier, Bachelier and Bernussou (2000), Systems and Control Letters 40, for
continuous time; de Oliveira, Bernussou and Geromel (1999), Systems and Control Letters 37, for
discrete time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal, TypeAlias

import numpy as np

from takagi.lmi.analysis.decay_rate import vertex_weight
from takagi.lmi.condition.term import LMI, Array, Constant, Labels, Position, Term, identity_like
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.polynomials import (
    Basis,
    Contributions,
    Degrees,
    Known,
    UnknownPolynomial,
    contributions,
)
from takagi.lmi.varying.parameter_motion import ParameterMotion, motion_of
from takagi.lmi.varying.parameter_space import VaryingLoop
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError


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
        step, matrix = loop.sample_time, loop.matrix
        basis = Basis(loop.space.sizes, degrees)
        return cls(
            P=unknown_lyapunov(basis, loop.A.shape[1]),
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


def unknown_lyapunov(basis: Basis, states: int) -> Unknown:
    """Return P, with a member for each coefficient of P(h)."""
    return Unknown("P", states, states, symmetric=True, count=basis.count)


def polynomial_lmis(sought: SoughtPolynomial, *, bounded: bool = True) -> tuple[LMI, ...]:
    """Pose P(h) > 0, and with ``bounded`` that no coefficient is above I, which fixes the scale."""
    P, n = sought.P, sought.P.rows
    no_motion = ParameterMotion(sought.basis.sizes, (), (), sought.axes)
    one = identity_like(sought.A.values, n)
    at = TermCoefficients.of(no_motion, one, sought.basis.degrees, polya=sought.polya)
    positive = LMI(
        name="P positive definite",
        blocks=(n,),
        terms=(at.term(P, UnknownPolynomial.of(sought.basis), symbol="P(h)"),),
        count=at.count,
        labels=at.labels("P, "),
        index=at.index,
    )
    if not bounded:
        return (positive,)
    scale = LMI(
        name="scale of P",
        blocks=(n,),
        terms=(Term(unknown=P, left=one, right=one, members=np.arange(P.count), symbol="P_a"),),
        constants=(Constant(value=-one, latex="-I"),),
        sign=-1,
        count=P.count,
        strict=False,
        index=r"\text{each } a",
    )
    return positive, scale


def direct_terms(
    sought: SoughtPolynomial, at: TermCoefficients, *, next_block: int = 1, rated: bool = True
) -> tuple[Term, ...]:
    """Return the terms of the direct form.

    Parameters
    ----------
    next_block : where P(h+) stands on the diagonal, in discrete time.
    rated : a decay rate is a parameter of the condition.
    """
    P, A = sought.P, sought.matrix
    if sought.discrete:
        back = Known(A.basis, A.values.transpose(0, 2, 1))
        last = next_block
        return (
            at.term(
                P,
                sought.now,
                parameter="contraction" if rated else None,
                latex=(r"\rho^2" if rated else "", ""),
                symbol="P(h)",
            ),
            at.term(
                P,
                sought.then,
                back,
                at=(0, last),
                behind=False,
                latex=(r"A(h)^\top", ""),
                symbol="P(h^+)",
            ),
            at.term(P, sought.then, at=(last, last), symbol="P(h^+)"),
        )
    motion_terms = (
        at.term(P, sought.now, A, plus_transpose=True, latex=("", "A(h)"), symbol="P(h)"),
        *at.rate_terms(P, sought.now, r"\dot P(h)"),
    )
    return (*motion_terms, decay_term(sought, at)) if rated else motion_terms


def decay_term(sought: SoughtPolynomial, at: TermCoefficients) -> Term:
    """Return 2 alpha P(h)."""
    return at.term(
        sought.P, sought.now, factor=2, parameter="alpha", latex=(r"2\alpha", ""), symbol="P(h)"
    )


def direct_lmi(sought: SoughtPolynomial) -> LMI:
    """Pose the module's direct form."""
    n = sought.P.rows
    at = sought.coefficients(sought.product(sought.matrix))
    return LMI(
        name="decrease",
        blocks=(n, n) if sought.discrete else (n,),
        terms=direct_terms(sought, at),
        sign=1 if sought.discrete else -1,
        count=at.count,
        weight=sought.weight,
        labels=at.labels(),
        index=at.index,
    )


Form: TypeAlias = Literal["direct", "dilated"]
SOURCES = {
    "direct": "Oliveira and Peres (2007); Daafouz and Bernussou (2001)",
    "dilated": "Peaucelle et al. (2000); de Oliveira, Bernussou and Geromel (1999)",
}


def check_form(form: object) -> None:
    """Raise ModelError for a form that there is not."""
    if form not in SOURCES:
        raise ModelError(f"form {form!r} is not known; there are {', '.join(SOURCES)}")


def form_lmis(sought: SoughtPolynomial, form: Form) -> tuple[tuple[Unknown, ...], tuple[LMI, ...]]:
    """Return the slacks of a form, and P(h) > 0, its scale and the decrease."""
    if form == "direct":
        return (), (*polynomial_lmis(sought), direct_lmi(sought))
    slack, decrease = dilated_lmi(sought)
    return slack, (*polynomial_lmis(sought), decrease)


def dilated_lmi(sought: SoughtPolynomial) -> tuple[tuple[Unknown, ...], LMI]:
    """Pose the module's dilated form; the slacks come with it."""
    n = sought.P.rows
    at = sought.coefficients(sought.matrix.basis.degrees)
    pose = _dilated_discrete if sought.discrete else _dilated_continuous
    unknowns, terms = pose(sought, at)
    return unknowns, LMI(
        name="decrease",
        blocks=(n, n),
        terms=terms,
        sign=1 if sought.discrete else -1,
        count=at.count,
        weight=sought.weight,
        labels=at.labels(),
        index=at.index,
    )


def _dilated_discrete(
    sought: SoughtPolynomial, at: TermCoefficients
) -> tuple[tuple[Unknown, ...], tuple[Term, ...]]:
    P, n = sought.P, sought.P.rows
    G = Unknown("G", n, n)
    eye = at.eye
    return (G,), (
        at.term(P, sought.now, parameter="contraction", latex=(r"\rho^2", ""), symbol="P(h)"),
        at.term(G, _same(sought), sought.matrix, at=(1, 0), latex=("", "A(h)")),
        Term(unknown=G, left=eye, right=eye, at=(1, 1), plus_transpose=True),
        at.term(P, sought.then, at=(1, 1), factor=-1, latex=("-", ""), symbol="P(h^+)"),
    )


def _dilated_continuous(
    sought: SoughtPolynomial, at: TermCoefficients
) -> tuple[tuple[Unknown, ...], tuple[Term, ...]]:
    P, n, A = sought.P, sought.P.rows, sought.matrix
    F, G = Unknown("F", n, n), Unknown("G", n, n)
    eye = at.eye
    # A power of two: no digit is touched.
    kappa = 2.0 ** round(np.log2(sought.weight / 2))
    scale = eye * (type(eye[0, 0, 0])(kappa))
    first = Term(unknown=F, left=-scale, right=eye, at=(0, 1), latex=(r"-\kappa", ""))
    return (F, G), (
        at.term(F, _same(sought), A, plus_transpose=True, latex=("", "A(h)")),
        *at.rate_terms(P, sought.now, r"\dot P(h)"),
        decay_term(sought, at),
        at.term(P, sought.now, factor=kappa, at=(0, 1), latex=(r"\kappa", ""), symbol="P(h)"),
        first,
        at.term(G, _same(sought), A, at=(1, 0), latex=("", "A(h)")),
        Term(
            unknown=G,
            left=-scale,
            right=eye,
            at=(1, 1),
            plus_transpose=True,
            latex=(r"-\kappa", ""),
        ),
    )


def _same(sought: SoughtPolynomial) -> UnknownPolynomial:
    """Return an unknown that does not change with h, as a polynomial of degree 0."""
    return UnknownPolynomial.of(Basis(sought.motion.sizes, (0,) * len(sought.motion.sizes)))
