r"""A function of the memberships, sought at single blends of the rules.

    continuous   He(P(h) G(h)) + dP/dt + 2 alpha P(h) < 0     at each corner of the rates
    discrete     [ rho^2 P(h)   G(h)' P_c ]
                 [ .            P_c       ] > 0               for each coefficient P_c

at some h alone, with P(h) = sum_a B_a(h) P_a > 0 for all h.  Necessary for P(h) of this degree by
any relaxation; it says nothing of the blends between.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import Vertices, decay_parameter
from takagi.lmi.condition.statements import pose
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import Expression, He, Inequality, Parameter, block, matrix
from takagi.lmi.polynomials import Basis, UnknownPolynomial
from takagi.lmi.varying.parameter_condition import (
    SoughtPolynomial,
    polynomial_lmis,
)
from takagi.lmi.varying.parameter_motion import kept_degrees
from takagi.lmi.varying.parameter_space import (
    RateBounds,
    decided_lyapunov,
    degrees_of,
    membership_rates,
    varying_loop,
)
from takagi.models.arrays import Floats


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

    Parameters
    ----------
    model, rate_bounds, degree, decay_rate, gains : as for ``fuzzy_lyapunov``; in discrete time
        the next memberships are arbitrary, and rate_bounds is not read.
    blends : (N, sum of sizes), the weights of each premise's corners, or of the rules.

    Raises
    ------
    ModelError : as ``fuzzy_lyapunov``.
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
    if step is None:
        slopes = np.array([_slopes(basis, velocity, w) for velocity in sought.motion.velocities])
        decrease = _falling(P, basis.values(w), slopes, G, rate, weight)
    else:
        decrease = _next_falling(P, basis.values(w), G, rate, weight)
    condition = pose(
        *polynomial_lmis(sought),
        decrease,
        name="function of the memberships at single blends",
        source="necessary for every relaxation",
    )
    return decided_lyapunov(condition, loop, s, basis, "lower the rate bounds or the decay rate")


def _slopes(basis: Basis, velocity: tuple[Floats, ...], w: Floats) -> Floats:
    """Return dB_a/dt at the blends, (N, count)."""
    rates = np.zeros((len(w), basis.count))
    for slope in UnknownPolynomial.of(basis).derivatives(velocity):
        rates += slope.basis.values(w) @ slope.weights
    return rates


def _falling(
    P: Unknown, B: Floats, slopes: Floats, G: Floats, rate: Parameter, weight: float
) -> Inequality:
    """Pose the continuous inequality: B (N, count), slopes (velocities, N, count), G (N, n, n)."""
    many = len(slopes)
    blend = _blended(P, np.tile(B, (many, 1)))
    falling = He(blend @ matrix(np.tile(G, (many, 1, 1)), "G(h_k)"))
    return _named(
        falling + _blended(P, slopes.reshape(-1, P.count)) + 2 * rate * blend << 0, weight
    )


def _next_falling(P: Unknown, B: Floats, G: Floats, rate: Parameter, weight: float) -> Inequality:
    """Pose the discrete inequality: B (N, count), G (N, n, n)."""
    now = _blended(P, np.repeat(B, P.count, axis=0))
    following = P.members(np.tile(np.arange(P.count), len(G)), "P_c")
    G_k = matrix(np.repeat(G, P.count, axis=0), "G(h_k)")
    return _named(block([[rate * now, G_k.T @ following], [None, following]]) >> 0, weight)


def _blended(P: Unknown, weights: Floats) -> Expression:
    """Return sum_a weights[k, a] P_a for each blend k."""
    total = matrix(weights[:, 0, None, None], "b_{k,1}") * P.member(0)
    for a in range(1, P.count):
        total += matrix(weights[:, a, None, None], f"b_{{k,{a + 1}}}") * P.member(a)
    return total


def _named(decrease: Inequality, weight: float) -> Inequality:
    count = decrease.expression.count
    labels = tuple(f"blend {k + 1}" for k in range(count))
    return decrease.named("decrease", rf"k = 1, \dots, {count}", weight=weight, labels=labels)
