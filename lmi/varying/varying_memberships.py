"""Stability for memberships that move, by a Lyapunov function that depends on them."""

from __future__ import annotations

from collections.abc import Sequence

from numpy.typing import ArrayLike

from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import Vertices, number
from takagi.lmi.condition.term import Condition
from takagi.lmi.polynomials.simplex_polynomials import Basis
from takagi.lmi.solver.time_limit import limited
from takagi.lmi.varying.answer_in_states import decided_lyapunov, no_lyapunov
from takagi.lmi.varying.fuzzy_condition import Question
from takagi.lmi.varying.parameter_condition import Form
from takagi.lmi.varying.parameter_motion import kept_degrees
from takagi.lmi.varying.parameter_space import (
    RateBounds,
    VaryingLoop,
    degrees_of,
    membership_rates,
    varying_loop,
)


def fuzzy_lyapunov_condition(
    model: Vertices,
    *,
    rate_bounds: RateBounds,
    degree: int | Sequence[int] = 1,
    decay_rate: float = 0.0,
    relaxation: str = "polya-0",
    gains: ArrayLike | None = None,
    form: Form = "direct",
    sample_time: float | None = None,
) -> Condition:
    """Pose P(h) > 0 and He(P(h) A(h)) + dP/dt + 2 alpha P(h) < 0 for bounded rates of h.

    Discrete time: A(h)' P(h+) A(h) < rho^2 P(h), as a Schur complement.  See ``fuzzy_condition``.

    Parameters
    ----------
    model, rate_bounds, degree, decay_rate, relaxation, gains, form, sample_time : as for
        ``fuzzy_lyapunov``; entries of the model may be Fractions.

    Returns
    -------
    The condition in the model's coordinates as they are, with the unknown ``P``, whose members are
    the coefficients of P(h).  Nothing is solved.

    Raises
    ------
    ModelError : as ``fuzzy_lyapunov``.

    Source: Tanaka, Hori and Wang (2003); Geromel and Colaneri (2006).
    """
    loop = varying_loop(model, gains, sample_time)
    question = _question(loop, rate_bounds, degree, relaxation, form)
    return question.condition(loop, number("decay_rate", decay_rate))


@limited
def fuzzy_lyapunov(
    model: Vertices,
    *,
    rate_bounds: RateBounds,
    degree: int | Sequence[int] = 1,
    decay_rate: float = 0.0,
    relaxation: str = "polya-0",
    gains: ArrayLike | None = None,
    form: Form = "direct",
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
    time_limit: float | None = None,
) -> Answer:
    """Return a candidate P(h) > 0 with He(P(h) A(h)) + dP/dt + 2 alpha P(h) < 0.

    V = x' P(h) x then decays as V' <= -2 alpha V while the memberships move within these rates.
    Discrete time: V(x+) <= e^(-2 alpha T) V(x).

    Parameters
    ----------
    model : a model, or vertices (r, n, n).  With premises the memberships are products of theirs.
    rate_bounds : with premises |dz_k/dt| in the unit of z_k per second, one for each in order or
        by name; without, |dh_i/dt| in 1/s; one number for all.  0 is a constant, inf no bound: in
        continuous time P then does not depend on it.  In discrete time a step is at most T times
        the bound.
    degree : of P in the memberships, or in each premise's; 0 is a common P.
    decay_rate : alpha in 1/s.
    relaxation : "polya-<d>", coefficients of the polynomials in h after d raisings of the degree
        (with premises in each of them); or, in continuous time without gains and for degree 1, one
        of the names that ``pdc`` has.
    gains : (r, m, n) of u = -sum_j h_j K_j x.
    form : "direct", or "dilated": with slack matrices in the place of products of P and A.
    scales : (n,) engineering range of each state; None balances.
    sample_time : T in s of x+ = A x, where vertices are given; a model knows its own.
    time_limit : seconds for all solver calls together, as they come; an answer stopped by it is
        "unknown", and its diagnosis reports it.  None for no limit.

    Returns
    -------
    An ``Answer``: ``family`` is P(h), ``decay_rate`` what it shows, recomputed from it.  A no is
    about P of this degree and these coefficients; the diagnosis says so, or names a blend that is
    unstable by itself.  Nothing is proved here.

    Not promised: that the memberships do move within these rates.  Where they
    depend on the state, show it by other means, for instance on a level set.

    Raises
    ------
    ModelError : shapes, numbers, names, bounds for some memberships only, options that do not go
        together, too many corners of rates to pose.

    Source: Tanaka, Hori and Wang (2003); Geromel and Colaneri (2006); in
    discrete time Daafouz and Bernussou (2001), Oliveira and Peres (2009).
    """
    loop = varying_loop(model, gains, sample_time)
    question = _question(loop, rate_bounds, degree, relaxation, form)
    alpha = float(number("decay_rate", decay_rate))
    s = loop.units(scales)
    scaled = loop.scaled(s)
    condition = question.condition(scaled, alpha)
    why = scaled.hopeless(alpha)
    if why:
        return no_lyapunov(condition, s, why)
    advice = (
        "lower the rate bounds or the decay rate, raise the degree, or take a richer relaxation "
        '("polya-2")'
    )
    return decided_lyapunov(condition, loop, s, Basis(loop.space.sizes, question.degrees), advice)


def _question(
    loop: VaryingLoop,
    rate_bounds: RateBounds,
    degree: int | Sequence[int],
    relaxation: str,
    form: Form,
) -> Question:
    bounds = membership_rates(loop.space, rate_bounds)
    degrees = degrees_of(loop.space, degree)
    return Question(
        degrees=kept_degrees(degrees, bounds, discrete=loop.sample_time is not None),
        rates=bounds,
        relaxation=relaxation,
        form=form,
    )
