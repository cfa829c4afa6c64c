"""Parallel distributed compensation with a Lyapunov function that depends on the memberships."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.argument_checks import input_stack, number, sample_time_of, vertex_stack
from takagi.lmi.condition.term import Condition
from takagi.lmi.gains.decay.condition import Controlled
from takagi.lmi.gains.fuzzy.design import FuzzyDesign, searched, units_of
from takagi.lmi.gains.fuzzy.request import FuzzyRequest, SlackKind
from takagi.lmi.solver.time_limit import limited
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.lmi.varying.parameter_space import RateBounds, membership_rates, space_of
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

# Powers of four, so that their roots are powers of two: the middle of what helps, then outward.
EPSILONS = tuple(4.0**k for k in (-2, -1, -3, 0, -4, 1, -5, 2, -6, -8))


def fuzzy_pdc_condition(
    model: Controlled,
    *,
    rate_bounds: RateBounds | None = None,
    decay_rate: float = 0.0,
    relaxation: str = "wang-tanaka-griffin",
    slack: SlackKind = "common",
    epsilon: float = 1.0,
    sample_time: float | None = None,
) -> Condition:
    """Pose the double sums of ``fuzzy.sums``, 0 < P_i <= I, and the input effort nu.

    Parameters
    ----------
    model, rate_bounds, decay_rate, relaxation, slack, sample_time : as for ``fuzzy_pdc``.
    epsilon : the scalar of continuous time, relative to the time of the vertices.

    Returns
    -------
    The condition in the model's coordinates as they are, with the unknowns ``P`` (``S`` in
    discrete time), ``G``, ``M``, ``nu`` and those of the relaxation.  Nothing is solved.

    Raises
    ------
    ModelError : as ``fuzzy_pdc``.

    Source: de Oliveira, Bernussou and Geromel (1999); Guerra and Vermeiren (2004); Mozelli,
    Palhares and Avellar (2009).
    """
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    step = sample_time_of(model, sample_time)
    task = _task(model, A, B, step, rate_bounds, relaxation, slack)
    return task.condition(float(number("decay_rate", decay_rate)), _epsilon(epsilon))


@limited
def fuzzy_pdc(
    model: Controlled,
    *,
    rate_bounds: RateBounds | None = None,
    decay_rate: float = 0.0,
    relaxation: str = "wang-tanaka-griffin",
    slack: SlackKind = "common",
    epsilons: Sequence[float] = EPSILONS,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
    time_limit: float | None = None,
) -> FuzzyDesign:
    """Return gains K_i for u = -sum_i h_i K_i x with V' <= -2 alpha V, V = x' P(h) x.

    In discrete time V(x+) <= e^(-2 alpha T) V(x) for whatever memberships come next.

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    rate_bounds : in continuous time, how fast the memberships may move, as for
        ``fuzzy_lyapunov``; in discrete time left out.
    decay_rate : alpha in 1/s that must hold.
    relaxation : as for ``pdc``.
    slack : "common", one G for all rules; "rules", one a rule, in discrete time: the law is
        then u = -M(h) G(h)^-1 x, which is not a blend of gains.
    epsilons : tried in this order in continuous time until there are gains; relative to the time
        of the vertices.
    scales : (n,) engineering range of each state; None balances.
    sample_time : T in s of x+ = A x + B u; a model knows its own.
    time_limit : seconds for all solver calls together, as they come; an answer stopped by it is
        "unknown", and its diagnosis reports it.  None for no limit.

    Returns
    -------
    A ``FuzzyDesign``; without gains its answer says which rules bind and what to relax.  Nothing is
    proved here.

    Not promised: that the closed loop keeps the memberships to their rates; in continuous time
    that a no for all epsilons is one for those between them.

    Raises
    ------
    ModelError : shapes, numbers, an unknown relaxation, inputs that are dependent or do nothing, a
        vertex with an unstable mode that no input moves, rate bounds missing or not used.

    Source: de Oliveira, Bernussou and Geromel (1999); Guerra and Vermeiren (2004); Mozelli,
    Palhares and Avellar (2009).
    """
    alpha = float(number("decay_rate", decay_rate))
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    step = sample_time_of(model, sample_time)
    units = units_of(A, B, step, scales, tuple(getattr(model, "states", ())))
    task = _task(model, *units.scaled(A, B), step, rate_bounds, relaxation, slack)
    tried = (1.0,) if task.discrete else tuple(_epsilon(epsilon) for epsilon in epsilons)
    if not tried:
        raise ModelError("epsilons is empty; give at least one positive number")
    return searched(task, units, alpha, tried)


def _task(
    model: Controlled,
    A: Floats,
    B: Floats,
    step: float | None,
    rate_bounds: RateBounds | None,
    relaxation: str,
    slack: SlackKind,
) -> FuzzyRequest:
    relaxation_named(relaxation)
    if step is not None and rate_bounds is not None:
        raise ModelError(
            "rate_bounds are for continuous time; in discrete time the next memberships are "
            "arbitrary: leave them out"
        )
    if step is None and rate_bounds is None:
        raise ModelError(
            "rate_bounds is missing; give how fast the memberships may move (inf: at any rate)"
        )
    if slack not in ("common", "rules") or (slack == "rules" and step is None):
        raise ModelError(f'slack is {slack!r}; there are "common" and, in discrete time, "rules"')
    space = space_of(model, len(A))
    bounds = membership_rates(space, np.inf if rate_bounds is None else rate_bounds)
    return FuzzyRequest(
        A=A,
        B=B,
        space=space,
        rates=bounds,
        sample_time=step,
        relaxation=relaxation,
        slack=slack,
    )


def _epsilon(epsilon: float) -> float:
    value = float(number("epsilon", epsilon))
    if value <= 0:
        raise ModelError(f"epsilon is {value:g}; it must be positive")
    return value
