"""Gains with a fuzzy Lyapunov function: the function that is called, and its design."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import chain, islice

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Answer, Try, WithAnswer
from takagi.lmi.argument_checks import (
    check_stabilisable,
    fixed_mode,
    input_stack,
    number,
    positive_number,
    sample_time_of,
    too_slow,
    vertex_stack,
)
from takagi.lmi.condition.evaluate import rate_of_values
from takagi.lmi.condition.term import Condition
from takagi.lmi.cone.balance import balanced_inputs, state_units
from takagi.lmi.cone.cone_program import assemble
from takagi.lmi.decision.decide import decide, improve
from takagi.lmi.decision.outcome import Outcome, advice_about_limit, asks_for_decay, binding_items
from takagi.lmi.gains.decay.condition import Controlled, size_of_motion
from takagi.lmi.gains.fuzzy.condition import FuzzyRequest
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.lmi.varying.parameter_space import RateBounds, membership_rates, space_of
from takagi.models.arrays import Floats, ShortRepr
from takagi.models.errors import ModelError


@dataclass(frozen=True, slots=True, eq=False, kw_only=True, repr=False)
class FuzzyDesign(ShortRepr, WithAnswer):
    """u = -sum_i h_i K_i x and V = x' P(h) x.

    Attributes
    ----------
    gains : (r, m, n), K_i = M_i G^-1; None unless found.
    matrices : (r, n, n): P_i of P(h) = sum_i h_i P_i; in discrete time S_i of P(h) = S(h)^-1.
    discrete : whether time is.
    decay_rate : alpha in 1/s that was asked for and holds; the answer's own is what was found.
    margin : as in ``Answer``.
    relaxation : name of the double-sum relaxation.
    answer : how it was found; its condition is in balanced states and inputs.
    """

    gains: Floats | None = None
    matrices: Floats | None = None
    discrete: bool
    decay_rate: float
    margin: float
    relaxation: str
    answer: Answer


# Bound on the effort nu: the largest margin exists only if every unknown is bounded.
LARGEST_EFFORT = 1e6
# More solvers than there are.
MANY = 99


@dataclass(frozen=True, slots=True, eq=False)
class FuzzyUnits:
    """x = states xhat, u = inputs uhat: powers of two, so that no digit is touched."""

    states: Floats
    inputs: Floats

    def scaled(self, A: Floats, B: Floats) -> tuple[Floats, Floats]:
        """Return the vertices in these units."""
        s = self.states
        return A * s / s[:, None], B * self.inputs / s[:, None]


def _searched(task: FuzzyRequest, units: FuzzyUnits, alpha: float) -> FuzzyDesign:
    """Return the first design that has gains, with the least effort at half its margin.

    ``task`` : in these units.
    """
    fixed = fixed_mode(task.A, task.B, alpha, step=task.sample_time)
    if fixed is not None:
        return _no_by_fixed_mode(task, units, alpha, fixed[:2])
    tries: tuple[Try, ...] = ()
    epsilons = (1.0,) if task.discrete else EPSILONS
    # Many solvers for one epsilon only: the last, or the first that a single one left open.
    undecided: list[float] = []
    # The list is read when all epsilons have been tried.
    again = ((epsilon, MANY) for epsilon in islice(undecided, 1))
    for epsilon, most in chain(((epsilon, 1) for epsilon in epsilons), again):
        condition = task.condition(alpha, epsilon)
        data = assemble(condition)
        outcome = decide(condition, rows={"nu": LARGEST_EFFORT}, assembled=data, most=most)
        tries = (*tries, *outcome.tries)
        outcome = replace(outcome, tries=tries)
        if outcome.status == "candidate":
            less = improve(condition, outcome, assembled=data)
            return _design(task, units, condition, less, alpha)
        if outcome.status == "unknown":
            undecided.append(epsilon)
    return _design(task, units, condition, outcome, alpha)


def _design(
    task: FuzzyRequest, units: FuzzyUnits, condition: Condition, outcome: Outcome, alpha: float
) -> FuzzyDesign:
    good = outcome.status == "candidate"
    answer = replace(
        outcome.as_answer(condition, units.states),
        decay_rate=rate_of_values(condition, outcome.values, task.sample_time) if good else None,
        diagnosis="" if good else _diagnosis(task, condition, outcome),
    )
    plain = FuzzyDesign(
        discrete=task.discrete,
        decay_rate=alpha,
        margin=outcome.margin,
        relaxation=task.relaxation,
        answer=answer,
    )
    return _with_gains(plain, task, units, outcome) if good else plain


def _with_gains(
    plain: FuzzyDesign, task: FuzzyRequest, units: FuzzyUnits, outcome: Outcome
) -> FuzzyDesign:
    """Return the design with its law, in the model's units: x = s xhat, u = tau uhat."""
    s, tau, r = units.states, units.inputs, len(task.A)
    G, M = outcome.values["G"], outcome.values["M"]
    lyapunov_members = outcome.values[task.P.name][task.members]
    slacks = np.broadcast_to(G * s[:, None], (r, *G.shape[1:])).copy()
    numerators = np.broadcast_to(M * tau[:, None], (r, *M.shape[1:])).copy()
    K = np.linalg.solve(slacks.transpose(0, 2, 1), numerators.transpose(0, 2, 1))
    gains = np.asarray(K.transpose(0, 2, 1), dtype=np.float64)
    if task.discrete:
        matrices = lyapunov_members * s * s[:, None]
    else:
        back = np.linalg.inv(slacks)
        matrices = back.transpose(0, 2, 1) @ lyapunov_members @ back
        matrices = (matrices + matrices.transpose(0, 2, 1)) / 2
    return replace(plain, gains=gains, matrices=matrices)


def _no_by_fixed_mode(
    task: FuzzyRequest, units: FuzzyUnits, alpha: float, fixed: tuple[int, complex]
) -> FuzzyDesign:
    condition = task.condition(alpha)
    outcome = Outcome("infeasible", {}, -np.inf, 0.0, {}, ())
    plain = _design(task, units, condition, outcome, alpha)
    why = too_slow(task.A, fixed, alpha, task.sample_time)
    return replace(plain, answer=replace(plain.answer, diagnosis=why))


def _diagnosis(task: FuzzyRequest, condition: Condition, outcome: Outcome) -> str:
    if outcome.status == "unknown":
        return outcome.unsettled(f"{advice_about_limit(condition)}, or give scales")
    names = [lmi.name for lmi in condition.lmis if lmi.strict][1:]
    advice = ['take a richer relaxation ("liu-zhang", "polya-2")']
    advice += ["lower the decay rate"] if asks_for_decay(condition) else []
    if not task.discrete:
        advice.insert(0, "lower the rate bounds")
    binding = binding_items(condition, outcome.multipliers, *names)
    return (
        f"no gains by {task.relaxation} with one P a rule: {binding}; {', or '.join(advice)}, or "
        "shrink the box that the rules span"
    )


# Powers of four, so that their roots are powers of two: the middle of what helps, then outward.
EPSILONS = tuple(4.0**k for k in (-2, -1, -3, 0, -4, 1, -5, 2, -6, -8))


def fuzzy_pdc_condition(
    model: Controlled,
    *,
    rate_bounds: RateBounds | None = None,
    decay_rate: float = 0.0,
    relaxation: str = "wang-tanaka-griffin",
    epsilon: float = 1.0,
    sample_time: float | None = None,
) -> Condition:
    """Pose the double sums of ``fuzzy.sums``, 0 < P_i <= I, and the input effort nu.

    Parameters
    ----------
    model, rate_bounds, decay_rate, relaxation, sample_time : as for ``fuzzy_pdc``.
    epsilon : the scalar of continuous time, relative to the time of the vertices.

    Returns the condition in the model's coordinates as they are, with the unknowns ``P`` (``S`` in
    discrete time), ``G``, ``M``, ``nu`` and those of the relaxation.  Nothing is solved.

    Raises ModelError: as ``fuzzy_pdc``.

    Source: de Oliveira, Bernussou and Geromel (1999); Guerra and Vermeiren (2004); Mozelli,
    Palhares and Avellar (2009).
    """
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    step = sample_time_of(model, sample_time)
    task = _task(model, A, B, step, rate_bounds, relaxation)
    return task.condition(
        float(number("decay_rate", decay_rate)), positive_number("epsilon", epsilon)
    )


def fuzzy_pdc(
    model: Controlled,
    *,
    rate_bounds: RateBounds | None = None,
    decay_rate: float = 0.0,
    relaxation: str = "wang-tanaka-griffin",
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
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
    scales : (n,) engineering range of each state; None balances.
    sample_time : T in s of x+ = A x + B u; a model knows its own.

    Returns a ``FuzzyDesign``; without gains its answer says which rules bind and what to relax.
    Nothing is proved here.

    Not promised: that the closed loop keeps the memberships to their rates; in continuous time
    that a no for the scalars epsilon that are tried is one for those between them.

    Raises ModelError: shapes, numbers, an unknown relaxation, inputs that are dependent or do
    nothing, a vertex with an unstable mode that no input moves, rate bounds missing or not used.

    Source: de Oliveira, Bernussou and Geromel (1999); Guerra and Vermeiren (2004); Mozelli,
    Palhares and Avellar (2009).
    """
    alpha = float(number("decay_rate", decay_rate))
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    step = sample_time_of(model, sample_time)
    s = state_units(A, scales, step=step)
    size = size_of_motion(A * s / s[:, None], 0.0, step) / 2
    units = FuzzyUnits(s, balanced_inputs(B / s[:, None], size))
    names = tuple(getattr(model, "states", ()))
    check_stabilisable(*units.scaled(A, B), units=s, names=names, step=step)
    task = _task(model, *units.scaled(A, B), step, rate_bounds, relaxation)
    return _searched(task, units, alpha)


def _task(
    model: Controlled,
    A: Floats,
    B: Floats,
    step: float | None,
    rate_bounds: RateBounds | None,
    relaxation: str,
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
    space = space_of(model, len(A))
    bounds = membership_rates(space, np.inf if rate_bounds is None else rate_bounds)
    return FuzzyRequest(
        A=A, B=B, space=space, rates=bounds, sample_time=step, relaxation=relaxation
    )
