"""From the LMIs of one relaxation to gains in the model's units, or to a reasoned no."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from takagi.lmi.answer import Answer, Design, Status
from takagi.lmi.argument_checks import too_slow
from takagi.lmi.condition.evaluate import holds, margin, rate_of_values
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import triangle
from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.cone.cone_program import Assembled, assemble, pack
from takagi.lmi.decision.decide import decide, improve
from takagi.lmi.decision.outcome import Outcome, advice_about_limit, asks_for_decay, binding_items
from takagi.lmi.decision.rounds import ALL_AT_ONCE, decide_by_rounds, improve_by_rounds
from takagi.lmi.gains.decay.condition import LARGEST_ELLIPSOID, DecayRequest
from takagi.lmi.gains.requirements.closed_loop import without_rounding
from takagi.lmi.sums.relaxations import Relaxation
from takagi.models.arrays import Floats

# Largest input effort nu, in inputs and states of order one, that is tried; the others only when
# the first is not enough, in better units or without: huge gains cost the solver digits.
EFFORTS = (1e4, 1e6, 1e8)
# The share in the bound on the margin from which the limit on Q may be what excludes gains.
LIMIT_SHARE = 1e-3
# How far inside its limits an ellipsoid is put, in the squares of them.
INSIDE = 2.0


@dataclass(frozen=True, slots=True, eq=False)
class LimitedOutcome:
    """An outcome with what it is an outcome of: the task's units may have changed for it.

    ``effort`` is the largest nu that was allowed.
    """

    task: DecayRequest
    condition: Condition
    data: Assembled
    outcome: Outcome
    effort: float = EFFORTS[0]


def stopped_by_limit(limited: LimitedOutcome) -> bool:
    """Return whether a no says nothing of larger Q or greater effort than were allowed.

    Without limits on states and inputs Q may be divided by any number: nothing is lost then.  With
    them, a no counts where the bound on the margin is below zero by more than its multipliers leave
    to any Q and gains of the sizes that the condition allows.  The bound itself counts what is left
    of stationarity for unknowns about as large as those that were found only (``cone/duality``):
    where gains exist far from those, that is not a bound.
    """
    outcome, data = limited.outcome, limited.data
    if not limited.task.limits.level or outcome.status == "candidate":
        return False
    if "scale of Q" not in outcome.multipliers:
        return False
    size = LARGEST_ELLIPSOID * float(np.trace(outcome.multipliers["scale of Q"][0]))
    if size > LIMIT_SHARE * abs(outcome.bound) or not outcome.bound < 0:
        return True
    # Q <= 1000 I and [[Q, M'], [M, nu I]] >= 0 allow |Q_ij| <= 1000 and |M_ij|^2 <= 1000 nu.
    effort = EFFORTS[-1]
    allowed = {"Q": LARGEST_ELLIPSOID, "M": np.sqrt(effort * LARGEST_ELLIPSOID), "nu": effort}
    lmis = limited.condition.lmis
    packed = np.concatenate([pack(outcome.multipliers[lmi.name]).ravel() for lmi in lmis])
    residual = np.abs(data.matrix().T @ packed)
    total = 0.0
    for unknown in limited.condition.unknowns:
        if unknown.name in allowed:
            residual_part = residual[data.offsets[unknown.name] :][: unknown.length]
            total += float(allowed[unknown.name] * residual_part.sum())
    return total > abs(outcome.bound)


def in_fitting_size(
    plain: LimitedOutcome, limited: DecayRequest, rate: float, pose: str | Relaxation
) -> LimitedOutcome:
    """Return gains without limits as an outcome with them, their ellipsoid in a size that fits.

    Without limits every multiple of Q is as good: in the coordinates d x, d u the condition is the
    same for all d > 0 but for the limits, |d x| and |d u| against theirs.

    ``plain`` : a candidate of ``limited`` without its limits.

    A candidate where some power of two d serves all limits; "unknown" otherwise.
    """
    task, outcome = plain.task, plain.outcome
    limits = limited.limits.scaled(task.s, task.tau)
    Q, M = outcome.values["Q"][0], outcome.values["M"]
    low, high = 0.0, np.inf
    if limits.initial is not None:
        solved = np.linalg.solve(Q, limits.initial.T).T
        low = float(np.sqrt(INSIDE * np.einsum("ki,ki->k", limits.initial, solved).max()))
    if limits.states is not None:
        high = min(high, float((limits.states / np.sqrt(INSIDE * np.diag(Q))).min()))
    if limits.inputs is not None:
        K = np.linalg.solve(Q, M.transpose(0, 2, 1)).transpose(0, 2, 1)
        largest_inputs = np.sqrt(INSIDE * np.einsum("rki,rki->rk", M, K).max(axis=0))
        high = min(high, float((limits.inputs / np.maximum(largest_inputs, 1e-300)).min()))
    middle = np.sqrt(low * high) if low and np.isfinite(high) else (low or high)
    d = float(nearest_power(np.array([middle]))[0])
    if not low <= d:
        d *= 2.0
    if not d <= high:
        d /= 2.0
    task = replace(task, limits=limited.limits, s=task.s * d, tau=task.tau * d)
    condition = task.condition(rate, pose)
    checked_margin = margin(condition, outcome.values)
    status: Status = "candidate" if holds(condition, checked_margin) else "unknown"
    outcome = replace(outcome, status=status, margin=checked_margin, multipliers={}, bound=np.inf)
    return replace(plain, task=task, condition=condition, data=assemble(condition), outcome=outcome)


# Of more entries than this the items that bind are improved alone, and the others are checked.
MOST_AT_ONCE = 5_000_000
# A margin below this may be one of unfit units, or of gains held too small.
SECOND_LOOK = 1e-6
# Without gains Q vanishes to solver accuracy; a larger one that misses its margin says in which
# states to look again.
NOISE = 1e-3
# Attempts with a larger ellipsoid or greater effort.
ROUNDS = 6
# In the place of a relaxation's name: what each of them implies has no unknowns.
ANY = "any relaxation"


def design_at(task: DecayRequest, decay_rate: float, relaxation: str) -> Design:
    """Return the gains of least effort at half the largest margin, or why there are none."""
    # A mode that does not decay at all was refused when the request was made.
    fixed = task.fixed_mode(decay_rate) if decay_rate > 0 else None
    if fixed is not None:
        return _no_by_fixed_mode(task, fixed, decay_rate, relaxation)
    limited = decided(task, decay_rate, relaxation)
    if limited.outcome.status == "candidate":
        factored = sum(lmi.count * triangle(lmi.size) ** 2 for lmi in limited.condition.lmis)
        less = (
            improve_by_rounds(limited.condition, limited.outcome)
            if limited.outcome.multipliers and factored > MOST_AT_ONCE
            else improve(limited.condition, limited.outcome, assembled=limited.data)
        )
        limited = replace(limited, outcome=less)
    return design_of(limited, decay_rate, relaxation)


def design_of(limited: LimitedOutcome, decay_rate: float, relaxation: str) -> Design:
    """Return an outcome as a design in the model's units."""
    answer = _answer(limited, relaxation)
    return Design(
        gains=_gains(limited.task, limited.outcome) if answer.found else None,
        P=answer.P,
        decay_rate=decay_rate,
        margin=limited.outcome.margin,
        relaxation=relaxation,
        answer=answer,
    )


def decided(
    task: DecayRequest, decay_rate: float, relaxation: str | Relaxation, *, most: int = 99
) -> LimitedOutcome:
    """Return the largest margin; before it is a no, or thin, in better units and huge gains too.

    Other units settle more, and sooner, than other solvers: those are asked last, ``most`` of them.
    """
    condition = task.condition(decay_rate, relaxation)
    data = assemble(condition)
    outcome = _first_look(condition, data)
    first = LimitedOutcome(task, condition, data, outcome)
    if outcome.margin >= SECOND_LOOK:
        return first
    second = _in_better_units(first, decay_rate, relaxation)
    second = _again(second, EFFORTS[2] if second.task is task else EFFORTS[1])
    best_margin = outcome.margin
    for _ in range(ROUNDS):
        if not (stopped_by_limit(second) or _nearer(second, best_margin)):
            break
        best_margin = second.outcome.margin
        second = _in_better_units(second, decay_rate, relaxation)
        second = _again(second, EFFORTS[2])
    second_outcome, tries = second.outcome, second.outcome.tries
    first = replace(first, outcome=replace(outcome, tries=tries))
    if second_outcome.status == "candidate" and second_outcome.margin > outcome.margin:
        return second
    if outcome.status != "unknown" and not stopped_by_limit(first):
        return first
    if second_outcome.status == "infeasible" and not stopped_by_limit(second):
        return second
    third = _from_no_limits(first, decay_rate, relaxation)
    if third is not None:
        tries = (*tries, *third.outcome.tries[len(outcome.tries) :])
        if third.outcome.status != "unknown":
            return replace(third, outcome=replace(third.outcome, tries=tries))
    # Held by what was tried, it says nothing of larger ellipsoids and gains.
    last = second if stopped_by_limit(first) else first
    last_outcome = decide(last.condition, rows={"nu": last.effort}, assembled=last.data, most=most)
    if last_outcome.status == "infeasible" and stopped_by_limit(
        replace(last, outcome=last_outcome)
    ):
        last_outcome = replace(last_outcome, status="unknown", bound=np.inf)
    return replace(last, outcome=replace(last_outcome, tries=(*tries, *last_outcome.tries)))


def _first_look(condition: Condition, data: Assembled) -> Outcome:
    """Return the largest margin; of very many pairs, about that, where few of them settle it."""
    modest = {"nu": EFFORTS[0]}
    if max(lmi.count for lmi in condition.lmis) > ALL_AT_ONCE:
        outcome = decide_by_rounds(condition, rows=modest)
        if outcome.margin >= SECOND_LOOK:
            return outcome
    return decide(condition, rows=modest, assembled=data, most=1)


def _again(posed: LimitedOutcome, effort: float) -> LimitedOutcome:
    """Solve what is posed, and count the tries before it too."""
    new_outcome = decide(posed.condition, rows={"nu": effort}, assembled=posed.data, most=1)
    outcome = replace(new_outcome, tries=(*posed.outcome.tries, *new_outcome.tries))
    return replace(posed, outcome=outcome, effort=effort)


def _nearer(limited: LimitedOutcome, margin_before: float) -> bool:
    """Return whether other units have left clearly less of what the margin misses."""
    margin = limited.outcome.margin
    return limited.task.limits.level and margin_before < 1.25 * margin < 0.0


def _in_better_units(
    first: LimitedOutcome, decay_rate: float, relaxation: str | Relaxation
) -> LimitedOutcome:
    """Return the task in the units of a Q that was nearly good; as it is where Q is but noise."""
    values = first.outcome.values
    diagonal = np.diag(values["Q"][0]) if "Q" in values else np.zeros(1)
    if diagonal.min() <= 0 or diagonal.max() < NOISE:
        return first
    task = first.task.in_units_of(values["Q"][0])
    condition = task.condition(decay_rate, relaxation)
    return LimitedOutcome(task, condition, assemble(condition), first.outcome, first.effort)


def _from_no_limits(
    first: LimitedOutcome, decay_rate: float, relaxation: str | Relaxation
) -> LimitedOutcome | None:
    """Return what gains without limits settle of those with them; None where nothing is limited.

    A no without limits is one with them, and of all sizes of the ellipsoid.  Gains without limits
    have them where their ellipsoid fits in some size, as with a box to start from alone it always
    does.  Else the units of those gains are those in which to look: the solver misses in others
    where gains barely exist.
    """
    task = first.task
    if not task.limits.level:
        return None
    plain = decided(task.without_limits(), decay_rate, relaxation, most=1)
    tries = (*first.outcome.tries, *plain.outcome.tries)
    if plain.outcome.status == "candidate":
        fit = in_fitting_size(plain, task, decay_rate, relaxation)
        if fit.outcome.status == "candidate":
            plain = fit
        else:
            units = fit.task.in_units_of(plain.outcome.values["Q"][0])
            condition = units.condition(decay_rate, relaxation)
            begun = replace(plain.outcome, tries=())
            posed = LimitedOutcome(units, condition, assemble(condition), begun, EFFORTS[2])
            plain = _again(posed, EFFORTS[2])
            if stopped_by_limit(plain):
                plain = replace(plain, outcome=replace(plain.outcome, status="unknown"))
            tries = (*tries, *plain.outcome.tries)
    return replace(plain, outcome=replace(plain.outcome, tries=tries))


def rate_of(limited: LimitedOutcome) -> float:
    """Return the largest decay rate in 1/s that the unknowns of a candidate show."""
    return rate_of_values(limited.condition, limited.outcome.values, limited.task.sample_time)


def _gains(task: DecayRequest, outcome: Outcome) -> Floats:
    """Return K_i = M_i Q^-1 in the model's units, (r, m, n)."""
    Q, M = outcome.values["Q"][0], outcome.values["M"]
    K = without_rounding(np.linalg.solve(Q, M.transpose(0, 2, 1)).transpose(0, 2, 1), Q)
    shape = (len(task.A), len(task.tau), len(task.s))
    return np.broadcast_to(K * task.tau[:, None] / task.s, shape).copy()


def _lyapunov(task: DecayRequest, outcome: Outcome) -> Floats:
    """Return P = Q^-1 in the model's states; its size is free where no limit fixes it."""
    inverse = np.linalg.inv(outcome.values["Q"][0])
    inverse = (inverse + inverse.T) / 2
    if not task.limits.level:
        inverse /= np.exp2(np.floor(np.log2(np.linalg.eigvalsh(inverse)[0])))
    return np.asarray(inverse / task.s / task.s[:, None])


def _answer(limited: LimitedOutcome, relaxation: str) -> Answer:
    task, condition, outcome = limited.task, limited.condition, limited.outcome
    good = outcome.status == "candidate"
    return replace(
        outcome.as_answer(condition, task.s),
        P=_lyapunov(task, outcome) if good else None,
        decay_rate=rate_of(limited) if good else None,
        diagnosis="" if good else _diagnosis(task, condition, outcome, relaxation),
    )


def _no_by_fixed_mode(
    task: DecayRequest, fixed: tuple[int, complex], decay_rate: float, relaxation: str
) -> Design:
    answer = Answer(
        status="infeasible",
        margin=-np.inf,
        bound=0.0,
        coordinates=task.s,
        condition=task.condition(decay_rate, relaxation),
        diagnosis=too_slow(task.A, fixed, decay_rate, task.sample_time),
    )
    return Design(decay_rate=decay_rate, margin=-np.inf, relaxation=relaxation, answer=answer)


def _diagnosis(task: DecayRequest, condition: Condition, outcome: Outcome, relaxation: str) -> str:
    if outcome.status == "unknown":
        return outcome.unsettled(f"{advice_about_limit(condition)}, or give scales")
    names = [lmi.name for lmi in condition.lmis if lmi.strict]
    names.remove("Q positive definite")
    advice = ["shrink the box that the rules span"]
    if asks_for_decay(condition):
        advice.insert(0, "lower the decay rate")
    if task.limits.level:
        advice.insert(0, "widen the limits or shrink the initial box")
    if task.limits.gain is not None:
        advice.insert(0, "raise gain_bound")
    if relaxation != ANY and len(task.A) > 1:
        richer = '"polya-4", "polya-8"' if relaxation == "liu-zhang" else '"liu-zhang", "polya-2"'
        advice.insert(0, f'take a richer relaxation ({richer}, or "auto" for one after another)')
    binding = binding_items(condition, outcome.multipliers, *names)
    return f"no gains by {relaxation}: {binding}; {', or '.join(advice)}"
