"""Lyapunov functions that change with the memberships, constant or at bounded rates.

dP/dt is posed at every corner of the velocities: of the premises, dw_k/dt = +-rho_k, or of the
memberships, |dh_i/dt| <= phi_i with sum_i dh_i/dt = 0.

Source: Tanaka, Hori and Wang (2003), IEEE Trans. Fuzzy Systems 11(4), for bounds on dh/dt; Geromel
and Colaneri (2006), Systems and Control Letters 55, for the corners.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import Vertices, decay_parameter, number
from takagi.lmi.condition.statements import pose
from takagi.lmi.condition.term import LMI, Condition
from takagi.lmi.expressions.expression import He, Inequality, Parameter, matrix
from takagi.lmi.polynomials import Basis, Degrees
from takagi.lmi.sums.membership_shape import double_sums, rate_of, rule_table
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.lmi.varying.parameter_condition import SoughtPolynomial, decrease_lmi, polynomial_lmis
from takagi.lmi.varying.parameter_motion import kept_degrees
from takagi.lmi.varying.parameter_space import (
    RateBounds,
    VaryingLoop,
    decided_lyapunov,
    degrees_of,
    membership_rates,
    no_lyapunov,
    varying_loop,
)
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

SOURCE = "Oliveira and Peres (2007); Daafouz and Bernussou (2001)"
RATE_SOURCES = "Tanaka, Hori and Wang (2003); Geromel and Colaneri (2006)"


def _fuzzy_condition(
    loop: VaryingLoop,
    degrees: Degrees,
    rates: Sequence[Floats],
    relaxation: str,
    alpha: float | Fraction,
) -> Condition:
    """Return the condition in the loop's states, for rates of |dw/dt| in 1/s, one array a simplex.

    Raises ModelError: a relaxation by name of anything but a double sum.
    """
    relaxation_named(relaxation)
    match = re.fullmatch(r"polya-(\d+)", relaxation)
    double_sum = loop.sample_time is None and loop.K is None
    if not match and not (double_sum and max(degrees) <= 1):
        raise ModelError(
            f"relaxation {relaxation} is for a double sum: continuous time, no gains, degree 1; "
            'take "polya-<d>"'
        )
    sought = SoughtPolynomial.of(loop, degrees, rates, polya=int(match[1]) if match else 0)
    rate = decay_parameter(alpha, loop.sample_time)
    statements: Sequence[Inequality | LMI] = (
        (*polynomial_lmis(sought), decrease_lmi(sought, rate))
        if match or not any(degrees)
        else _named(sought, loop, relaxation, rate)
    )
    moving = loop.sample_time is None and any(degrees)
    return pose(
        *statements,
        parameters=(rate,),
        name=f"fuzzy Lyapunov function, degree {degrees}, {relaxation}",
        source=f"{SOURCE}; {RATE_SOURCES}" if moving else SOURCE,
    )


def _degrees_and_rates(
    loop: VaryingLoop, rate_bounds: RateBounds, degree: int | Sequence[int]
) -> tuple[Degrees, tuple[Floats, ...]]:
    """Return the degrees of P, 0 where h jumps in continuous time, and the bounds of |dw/dt|."""
    rates = membership_rates(loop.space, rate_bounds)
    degrees = degrees_of(loop.space, degree)
    return kept_degrees(degrees, rates, discrete=loop.sample_time is not None), rates


def _named(
    sought: SoughtPolynomial, loop: VaryingLoop, relaxation: str, rate: Parameter
) -> tuple[Inequality | LMI, ...]:
    """Pose sum_ij h_i h_j (He(P_j A_i) + 2 alpha P_j + dP/dt) < 0 by a named relaxation."""
    A, corners = loop.A.astype(np.float64), loop.space.corners
    members = sought.basis.corners(corners)
    P_j = sought.P.members(rule_table(len(A), "gain", members), "P_{j}")
    theta = He(P_j @ matrix(A, "A_{i}", over="i")) + 2 * rate * P_j
    thetas = [
        theta + rate_of(sought.P, corners, velocity, members=members)
        for velocity in sought.motion.velocities
    ]
    sums = double_sums(
        thetas,
        "rates",
        rules=len(A),
        weight=sought.weight,
        corners=corners if loop.space.premises else None,
    )
    statements: list[Inequality | LMI] = [*polynomial_lmis(sought)]
    for loop_at_rate in sums:
        statements += relaxation_named(relaxation)(loop_at_rate)[1]
    return tuple(statements)


def fuzzy_lyapunov_condition(
    model: Vertices,
    *,
    rate_bounds: RateBounds,
    degree: int | Sequence[int] = 1,
    decay_rate: float = 0.0,
    relaxation: str = "polya-0",
    gains: ArrayLike | None = None,
    sample_time: float | None = None,
) -> Condition:
    """Pose P(h) > 0 and He(P(h) A(h)) + dP/dt + 2 alpha P(h) < 0 for bounded rates of h.

    Discrete time: A(h)' P(h+) A(h) < rho^2 P(h), as a Schur complement.

    ``model``, ``rate_bounds``, ``degree``, ``decay_rate``, ``relaxation``, ``gains``,
    ``sample_time`` : as for ``fuzzy_lyapunov``; entries of the model may be Fractions.

    Returns the condition in the model's coordinates as they are, with the unknown ``P``, whose
    members are the coefficients of P(h).  Nothing is solved.

    Raises ModelError: as ``fuzzy_lyapunov``.
    """
    loop = varying_loop(model, gains, sample_time)
    degrees, rates = _degrees_and_rates(loop, rate_bounds, degree)
    alpha = number("decay_rate", decay_rate)
    return _fuzzy_condition(loop, degrees, rates, relaxation, alpha)


def fuzzy_lyapunov(
    model: Vertices,
    *,
    rate_bounds: RateBounds,
    degree: int | Sequence[int] = 1,
    decay_rate: float = 0.0,
    relaxation: str = "polya-0",
    gains: ArrayLike | None = None,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
) -> Answer:
    """Return a candidate P(h) > 0 with He(P(h) A(h)) + dP/dt + 2 alpha P(h) < 0.

    V = x' P(h) x then decays as V' <= -2 alpha V while the memberships move within these rates.
    Discrete time: V(x+) <= e^(-2 alpha T) V(x).

    Parameters
    ----------
    model : a model, or vertices (r, n, n).  With premises the memberships are products of theirs.
    rate_bounds : with premises |dz_k/dt| in the unit of z_k per second, one for each in order or
        by name; without, |dh_i/dt| in 1/s; one number for all.  0 is a constant: as degree and d
        grow, every stable family is found then.  inf is no bound: in continuous time P then does
        not depend on it.  In discrete time a step is at most T times
        the bound.
    degree : of P in the memberships, or in each premise's; 0 is a common P.
    decay_rate : alpha in 1/s.
    relaxation : "polya-<d>", coefficients of the polynomials in h after d raisings of the degree
        (with premises in each of them); or, in continuous time without gains and for degree 1, one
        of the names that ``pdc`` has.
    gains : (r, m, n) of u = -sum_j h_j K_j x.
    scales : (n,) engineering range of each state; None balances.
    sample_time : T in s of x+ = A x, where vertices are given; a model knows its own.

    Returns an ``Answer``: ``family`` is P(h), ``decay_rate`` what it shows, recomputed from it.  A
    no is about P of this degree and these coefficients; the diagnosis says so, or names a blend
    that is unstable by itself.  Nothing is proved here.

    Not promised: that the memberships do move within these rates.  Where they
    depend on the state, show it by other means, for instance on a level set.

    Raises ModelError: shapes, numbers, names, bounds for some memberships only, options that do not
    go together, too many corners of rates to pose.

    Source: Tanaka, Hori and Wang (2003); Geromel and Colaneri (2006); in
    discrete time Daafouz and Bernussou (2001), Oliveira and Peres (2009); for constant memberships
    Oliveira and Peres (2007), IEEE Trans. Automatic Control 52(7).
    """
    loop = varying_loop(model, gains, sample_time)
    degrees, rates = _degrees_and_rates(loop, rate_bounds, degree)
    alpha = float(number("decay_rate", decay_rate))
    s = loop.units(scales)
    scaled = loop.scaled(s)
    condition = _fuzzy_condition(scaled, degrees, rates, relaxation, alpha)
    why = scaled.hopeless(alpha)
    if why:
        return no_lyapunov(condition, s, why)
    advice = (
        "lower the rate bounds or the decay rate, raise the degree, or take a richer relaxation "
        '("polya-2")'
    )
    return decided_lyapunov(condition, loop, s, Basis(loop.space.sizes, degrees), advice)
