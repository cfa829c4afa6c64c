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
from takagi.lmi.argument_checks import Vertices, rate_parameter
from takagi.lmi.condition.term import LMI, Condition, Term
from takagi.lmi.condition.unknown import Unknown
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
    w, matrix = np.asarray(blends, dtype=np.float64), sought.A
    G = np.tensordot(matrix.basis.values(w), matrix.values.astype(np.float64), axes=1)
    if step is None:
        slopes = np.array([_slopes(basis, velocity, w) for velocity in sought.motion.velocities])
        decrease = _falling(P, basis.values(w), slopes, G, weight)
    else:
        decrease = _next_falling(P, basis.values(w), G, weight)
    condition = Condition(
        name="function of the memberships at single blends",
        unknowns=(P,),
        lmis=(*polynomial_lmis(sought), decrease),
        parameters=rate_parameter(decay_rate, step),
        source="necessary for every relaxation",
    )
    return decided_lyapunov(condition, loop, s, basis, "lower the rate bounds or the decay rate")


def _slopes(basis: Basis, velocity: tuple[Floats, ...], w: Floats) -> Floats:
    """Return dB_a/dt at the blends, (N, count)."""
    rates = np.zeros((len(w), basis.count))
    for slope in UnknownPolynomial.of(basis).derivatives(velocity):
        rates += slope.basis.values(w) @ slope.weights
    return rates


def _falling(P: Unknown, B: Floats, slopes: Floats, G: Floats, weight: float) -> LMI:
    """Pose the continuous inequality: B (N, count), slopes (velocities, N, count), G (N, n, n)."""
    many, n = len(slopes), P.rows
    loops, shares = np.tile(G, (many, 1, 1)), np.tile(B, (many, 1))[:, :, None, None] * np.eye(n)
    rate_factors = slopes.reshape(-1, P.count)[:, :, None, None] * np.eye(n)
    identities = np.tile(np.eye(n), (len(loops), 1, 1))
    terms: list[Term] = []
    for a in range(P.count):
        of, B_a = np.full(len(loops), a), shares[:, a]
        terms += [
            Term(unknown=P, members=of, left=B_a, right=loops, plus_transpose=True),
            Term(unknown=P, members=of, left=rate_factors[:, a], right=identities),
            Term(unknown=P, members=of, left=2 * B_a, right=identities, parameter="alpha"),
        ]
    return _lmi((n,), terms, len(loops), weight, -1)


def _next_falling(P: Unknown, B: Floats, G: Floats, weight: float) -> LMI:
    """Pose the discrete inequality: B (N, count), G (N, n, n)."""
    n, count = P.rows, len(G) * P.count
    identities, loops = np.tile(np.eye(n), (count, 1, 1)), np.repeat(G, P.count, axis=0)
    shares = np.repeat(B, P.count, axis=0)[:, :, None, None] * np.eye(n)
    terms = [
        Term(
            unknown=P,
            members=np.full(count, a),
            left=shares[:, a],
            right=identities,
            parameter="contraction",
        )
        for a in range(P.count)
    ]
    following, back = np.tile(np.arange(P.count), len(G)), loops.transpose(0, 2, 1)
    terms += [
        Term(unknown=P, members=following, left=back, right=identities, at=(0, 1)),
        Term(unknown=P, members=following, left=identities, right=identities, at=(1, 1)),
    ]
    return _lmi((n, n), terms, count, weight, 1)


def _lmi(blocks: tuple[int, ...], terms: list[Term], count: int, weight: float, sign: int) -> LMI:
    return LMI(
        name="decrease",
        blocks=blocks,
        terms=tuple(terms),
        sign=sign,
        count=count,
        weight=weight,
        labels=tuple(f"blend {k + 1}" for k in range(count)),
        index=rf"k = 1, \dots, {count}",
    )
