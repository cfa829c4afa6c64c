r"""A common Lyapunov function of a polytope of matrices that is a form of degree 2d in the state.

With m(x) all monomials of degree d, m' = Abar_i m along x' = A_i x, and V(x) = m(x)' G m(x),

    G > 0,     He(G Abar_i) + 2 d alpha G + sum_k lambda_ik L_k < 0     at every vertex i,

where the L_k are a basis of all L with m(x)' L m(x) = 0 for all x.  Then V > 0 and
V' <= -2 d alpha V along every blend of the vertices, however fast it varies: V' is affine in A, and
the terms with L_k vanish.  V^(1 / 2d) is of degree 1 and decays at the rate alpha.  d = 1 is the
quadratic function; a larger d is less conservative.  In two states, and for d = 1, every positive
form is a sum of squares, so that the Gram matrix is no restriction; otherwise the condition is only
sufficient.

There is no version for discrete time: V(A x) is not affine in A, so its values at the vertices do
not bound its values at a blend.

Source: Chesi, Garulli, Tesi, Vicino (2003), Automatica 39, Homogeneous Lyapunov functions for
systems with structured uncertainties; the same (2009), Homogeneous Polynomial Forms for Robustness
Analysis of Uncertain Systems, chapters 1 and 3; Parrilo (2000), thesis, chapter 7.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Status, Try
from takagi.lmi.argument_checks import Vertices, number, sample_time_of, vertex_stack
from takagi.lmi.condition.evaluate import fractions
from takagi.lmi.condition.term import LMI, Array, Condition, Term, bounded, positive
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import state_units
from takagi.lmi.decision.decide import decide
from takagi.lmi.decision.outcome import binding_items
from takagi.lmi.equalities.exact_solution import ExactSolution, exact_solution
from takagi.lmi.solver.time_limit import limited
from takagi.lmi.sums_of_squares.polynomial import (
    Exponent,
    StatePolynomial,
    extended,
    monomials,
    sizes_of,
    vanishing,
)
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

SOURCE = "Chesi, Garulli, Tesi, Vicino (2003), Automatica 39; the same (2009), chapters 1 and 3"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class HomogeneousLyapunov:
    """V(x) = m(x)' G m(x), a form of degree 2d; a candidate by floating point.

    Attributes
    ----------
    status : as of an ``Answer``.
    degree : 2d.
    exponents : (N, n), the monomials m.
    gram : (N, N) G for m(x) in the model's states; None unless a candidate.
    decay_rate : the required alpha in 1/s; None unless a candidate.
    margin, bound : as of an ``Answer``.
    condition, values : what was solved, in balanced states and monomials of like size.
    units : (N,) powers of two by which the condition's monomials are multiplied.
    diagnosis : why there is none.
    tries : every solver call.
    """

    status: Status
    degree: int
    exponents: tuple[Exponent, ...]
    gram: Floats | None
    decay_rate: float | None
    margin: float
    bound: float
    condition: Condition
    values: Mapping[str, Floats] = field(default_factory=dict)
    units: Floats
    diagnosis: str = ""
    tries: tuple[Try, ...] = ()

    @property
    def found(self) -> bool:
        """Return whether there is a candidate."""
        return self.status == "candidate"

    def exact(self) -> ExactSolution:
        """Return the unknowns as rationals; ``holds`` decides every LMI in exact arithmetic.

        If it holds, V > 0 and V' <= -2 d alpha V are proved along every blend of the matrices as
        they are stored: powers of two in the units round nothing, and the L_k vanish identically.

        Raises
        ------
        ModelError : there is no candidate.
        """
        if not self.found:
            raise ModelError(f"no form of degree {self.degree} was found: {self.diagnosis}")
        found = exact_solution(self.condition, self.values)
        assert found is not None  # the condition has no equalities
        return found

    @property
    def polynomial(self) -> StatePolynomial:
        """Return V in the model's states, with the rational coefficients that ``exact`` decides.

        Raises
        ------
        ModelError : there is no candidate.
        """
        G = self.exact().values["G"][0]
        w = [Fraction(float(unit)) for unit in self.units]
        terms: dict[Exponent, Fraction] = {}
        for i, a in enumerate(self.exponents):
            for j, b in enumerate(self.exponents):
                place = tuple(p + q for p, q in zip(a, b, strict=True))
                terms[place] = terms.get(place, Fraction(0)) + w[i] * w[j] * G[i, j]
        return StatePolynomial(len(self.exponents[0]), {a: c for a, c in terms.items() if c})


def homogeneous_lyapunov_condition(
    model: Vertices, *, degree: int = 4, decay_rate: float = 0.0
) -> Condition:
    """Pose the module's LMIs with one G > 0, and a lambda for each vertex and each L_k.

    Parameters
    ----------
    model : a model (its A), or vertices (r, n, n), in continuous time.
    degree : 2d, even.
    decay_rate : alpha in 1/s.

    Returns
    -------
    The condition in the model's states as they are, with the unknowns ``G`` and, where there are
    L_k, ``lambda``.  Nothing is solved.

    Raises
    ------
    ModelError : shapes, a degree that is not even and positive, too many monomials, a model of
        discrete time.

    Source: Chesi, Garulli, Tesi, Vicino (2003), Automatica 39.
    """
    A, d = _asked(model, degree)
    basis = monomials(A.shape[1], [d])
    return _condition(A, basis, sizes_of(basis), float(number("decay_rate", decay_rate)))


@limited
def homogeneous_lyapunov(
    model: Vertices,
    *,
    degree: int = 4,
    decay_rate: float = 0.0,
    scales: ArrayLike | None = None,
    time_limit: float | None = None,
) -> HomogeneousLyapunov:
    """Return a common form V of degree 2d with V' <= -2 d alpha V at every vertex, or why none.

    Parameters
    ----------
    model : a model (its A), or vertices (r, n, n), in continuous time.
    degree : 2d, even: 2 is ``common_lyapunov``.
    decay_rate : alpha in 1/s at which V^(1 / 2d) decays.
    scales : (n,) engineering range of each state; None balances the vertices.
    time_limit : seconds for all solver calls together.

    Returns
    -------
    A ``HomogeneousLyapunov``.  A candidate is floating point; its ``exact().holds`` decides it in
    rational arithmetic.  "infeasible" says that no form of this degree with these Gram matrices
    exists, not that the polytope is unstable.

    Raises
    ------
    ModelError : as ``homogeneous_lyapunov_condition``; scales that are not positive.

    Source: Chesi, Garulli, Tesi, Vicino (2003), Automatica 39; Parrilo (2000), chapter 7.
    """
    A, d = _asked(model, degree)
    alpha = float(number("decay_rate", decay_rate))
    s = state_units(A.astype(np.float64), scales)
    basis = monomials(A.shape[1], [d])
    w = sizes_of(basis)
    # x = s xhat with powers of two, so that nothing is rounded.
    exact = fractions(s)
    condition = _condition(fractions(A) * exact / exact[:, None], basis, w, alpha)
    outcome = decide(condition)
    units = w / np.prod(s ** np.array(basis), axis=1)
    found = outcome.status == "candidate"
    gram = units[:, None] * outcome.values["G"][0] * units if found else None
    why = ""
    if outcome.status == "infeasible":
        names = [lmi.name for lmi in condition.lmis]
        why = (
            f"no form of degree {degree}: {binding_items(condition, outcome.multipliers, *names)}; "
            "raise the degree, lower the decay rate, or shrink the polytope"
        )
    elif not found:
        why = outcome.unsettled("raise the degree, or lower the decay rate a little")
    return HomogeneousLyapunov(
        status=outcome.status,
        degree=degree,
        exponents=basis,
        gram=gram,
        decay_rate=alpha if found else None,
        margin=outcome.margin,
        bound=outcome.bound,
        condition=condition,
        values=outcome.values,
        units=units,
        diagnosis=why,
        tries=outcome.tries,
    )


def _asked(model: Vertices, degree: int) -> tuple[Array, int]:
    if sample_time_of(model) is not None:
        raise ModelError(
            "the model is of discrete time; a form of the state decays along every blend of the "
            "vertices in continuous time only, as V(A x) is not affine in A"
        )
    if isinstance(degree, bool) or not isinstance(degree, int) or degree < 2 or degree % 2:
        raise ModelError(f"degree is {degree!r}; an even whole number from 2 is needed")
    return vertex_stack(model), degree // 2


def _condition(A: Array, basis: Sequence[Exponent], w: Floats, alpha: float) -> Condition:
    r, N, d = len(A), len(basis), sum(basis[0])
    W = fractions(w)
    moved = np.array([extended(one, basis) * W[:, None] / W for one in A])
    L = vanishing(basis, w)
    G = Unknown("G", N, N, symmetric=True)
    one = np.eye(N)[None]
    terms = [
        Term(unknown=G, left=one, right=moved, plus_transpose=True, latex=("", r"\bar A_{i}")),
        Term(
            unknown=G, left=2 * d * one, right=one, parameter="alpha", latex=(rf"{2 * d}\alpha", "")
        ),
    ]
    unknowns: tuple[Unknown, ...] = (G,)
    if len(L):
        free = Unknown("lambda", 1, 1, count=r * len(L), latex=r"\lambda")
        unknowns += (free,)
        items, members = np.divmod(np.arange(r * len(L)), len(L))
        terms.append(
            Term(
                unknown=free,
                left=L[members],
                items=items,
                members=np.arange(r * len(L)),
                latex=("", "L_k"),
                symbol=r"\lambda_{ik}",
                factor=r"\textstyle\sum_k",
            )
        )
    size = float(np.abs(moved.astype(np.float64)).sum(axis=2).max()) or 1.0
    falls = LMI(
        name="vertex",
        blocks=(N,),
        terms=tuple(terms),
        sign=-1,
        count=r,
        weight=size,
        index=rf"i = 1, \dots, {r}",
    )
    return Condition(
        name=f"common homogeneous Lyapunov function of degree {2 * d}",
        unknowns=unknowns,
        lmis=(positive(G), bounded(G), falls),
        parameters={"alpha": alpha},
        source=SOURCE,
    )
