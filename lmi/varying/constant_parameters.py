"""Stability for every constant parameter, by a Lyapunov function polynomial in it."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import Vertices, number, rate_parameter
from takagi.lmi.condition.term import Condition
from takagi.lmi.polynomials.simplex_polynomials import Basis, Degrees
from takagi.lmi.solver.time_limit import limited
from takagi.lmi.varying.answer_in_states import decided_lyapunov, no_lyapunov
from takagi.lmi.varying.parameter_condition import (
    SOURCES,
    Form,
    SoughtPolynomial,
    check_form,
    form_lmis,
)
from takagi.lmi.varying.parameter_space import VaryingLoop, degrees_of, polya_of, varying_loop


def polynomial_lyapunov_condition(
    model: Vertices,
    *,
    degree: int | Sequence[int] = 1,
    polya: int = 0,
    decay_rate: float = 0.0,
    form: Form = "direct",
    gains: ArrayLike | None = None,
    sample_time: float | None = None,
) -> Condition:
    """Pose P(h) > 0 and He(P(h) A(h)) + 2 alpha P(h) < 0 for every constant h.

    Discrete time: A(h)' P(h) A(h) < rho^2 P(h), as a Schur complement.  Each Bernstein coefficient
    of the polynomials in h is one item; see ``parameter_condition``.

    Parameters
    ----------
    model : a model (its A), or vertices (r, n, n); entries may be Fractions.
    degree, polya, decay_rate, form, gains, sample_time : as for ``polynomial_lyapunov``.

    Returns
    -------
    The condition in the model's coordinates as they are, with the unknown ``P``, whose members are
    the coefficients of P(h).  Nothing is solved.

    Raises
    ------
    ModelError : as ``polynomial_lyapunov``.

    Source: Oliveira and Peres (2007), IEEE Trans. Automatic Control 52(7).
    """
    loop = varying_loop(model, gains, sample_time)
    degrees = degrees_of(loop.space, degree)
    return _condition(loop, degrees, polya_of(polya), number("decay_rate", decay_rate), form)


@limited
def polynomial_lyapunov(
    model: Vertices,
    *,
    degree: int | Sequence[int] = 1,
    polya: int = 0,
    decay_rate: float = 0.0,
    form: Form = "direct",
    gains: ArrayLike | None = None,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
    time_limit: float | None = None,
) -> Answer:
    """Return a candidate P(h) > 0 with He(P(h) A(h)) + 2 alpha P(h) < 0 for every constant h.

    Every blend of the vertices is then stable as long as it stays what it is.  Discrete time:
    A(h)' P(h) A(h) < e^(-2 alpha T) P(h).

    Parameters
    ----------
    model : a model, or vertices (r, n, n) of one simplex.  With premises h is the point of a
        product of simplexes, one a premise.
    degree : of P in the memberships, or in each premise's; 0 is a common P, 1 one P a rule.
    polya : how far the LMIs' degrees are raised before their coefficients are taken.  As degree
        and polya grow every stable family is found, in ever more LMIs.
    decay_rate : alpha in 1/s.
    form : "direct"; or "dilated", with slack matrices the same for all h in the place of
        products of P and A: never worse than a common P, and one LMI a vertex for degree 1.
    gains : (r, m, n) of u = -sum_j h_j K_j x; the loop is then of degree 2.
    scales : (n,) engineering range of each state; None balances.
    sample_time : T in s of x+ = A x, where vertices are given; a model knows its own.
    time_limit : seconds for all solver calls together, as they come; an answer stopped by it is
        "unknown", and its diagnosis reports it.  None for no limit.

    Returns
    -------
    An ``Answer``: ``family`` is P(h), ``decay_rate`` what it shows, recomputed from it.  A no is
    about P of this degree and these coefficients; the diagnosis says so, or names a blend that is
    unstable by itself.  Nothing is proved here.

    Not promised: anything about memberships that move; see ``fuzzy_lyapunov``.

    Raises
    ------
    ModelError : shapes, numbers, a degree that is not whole, an unknown form.

    Source: Oliveira and Peres (2007), IEEE Trans. Automatic Control 52(7).
    """
    loop = varying_loop(model, gains, sample_time)
    degrees = degrees_of(loop.space, degree)
    alpha, polya = float(number("decay_rate", decay_rate)), polya_of(polya)
    s = loop.units(scales)
    scaled = loop.scaled(s)
    condition = _condition(scaled, degrees, polya, alpha, form)
    why = scaled.hopeless(alpha)
    if why:
        return no_lyapunov(condition, s, why)
    advice = "raise the degree or polya, lower the decay rate, or shrink the box"
    return decided_lyapunov(condition, loop, s, Basis(loop.space.sizes, degrees), advice)


def _condition(
    loop: VaryingLoop, degrees: Degrees, polya: int, alpha: float | Fraction, form: Form
) -> Condition:
    check_form(form)
    no_rates = [np.zeros(size) for size in loop.space.sizes]
    sought = SoughtPolynomial.of(loop, degrees, no_rates, polya=polya)
    slack, lmis = form_lmis(sought, form)
    return Condition(
        name=f"polynomial Lyapunov function, degree {degrees}, {form}",
        unknowns=(sought.P, *slack),
        lmis=lmis,
        parameters=rate_parameter(alpha, loop.sample_time),
        source=SOURCES[form],
    )
