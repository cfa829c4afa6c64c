"""From a condition to numbers that withstand their check: decide, optimise, improve.

``decide`` asks for the largest margin t, one solve.  ``optimise`` takes two steps, because at the
least objective the LMIs touch zero, where no check can hold:

1. the least objective, with no margin; its multipliers bound the objective of all unknowns from
   below;
2. the objective fixed slightly above the optimum found, with the largest margin (re-centred).

The returned answer is re-evaluated from the unknowns by eigenvalues, and its objective is compared
with the bound: a solver that stops early, or at a wrong value, is found out by either, and the next
one is asked.  ``decide`` takes the cone data (``assembled``) and a ``Session``, so that
a sequence of parameter values costs one assembly.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np

from takagi.lmi.answer import Try
from takagi.lmi.condition.evaluate import holds, margin
from takagi.lmi.condition.statements import StatedCondition, condition_of
from takagi.lmi.condition.term import Condition
from takagi.lmi.cone.cone_program import (
    Assembled,
    ConeProgram,
    Raw,
    SolverRow,
    assemble,
    cone_program,
    least_objective_bound,
    pack,
)
from takagi.lmi.decision.outcome import (
    Outcome,
    better,
    concluded,
    exactly_held,
    exactly_judged,
    falling,
    judged,
    measured,
    nothing,
    objective_at,
    promised,
    says_no,
    values_of,
    weighed,
)
from takagi.lmi.solver.solve import Session, again, attempts, rescaled
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

# Solvers that are asked where none of their multipliers shows a no, though the bound says one.
DOUBTFUL = 3
# Looseness of the second stage, in units of ``slack``, until it leaves a margin.
LOOSENESS = (1.0, 30.0, 1e3)
# What it may take of what is promised; the rest is for the accuracy of the first stage's bound.
SHARE = 0.9
# The smallest margin that is asked for at once: what is found is good to the solver's tolerances.
LEAST_INSIDE = 1e-7
# How often a program is posed anew where the solution that was found is of order one.
RESCALED = 2


def decide(
    condition: StatedCondition,
    *,
    rows: Mapping[str, float] | None = None,
    session: Session | None = None,
    assembled: Assembled | None = None,
    most: int = 99,
) -> Outcome:
    """Return the unknowns with the largest margin t <= 1.

    Equalities are solved exactly first (``parametrised``), and the LMIs in what they leave free.

    Always solvable when every unknown is bounded, so a failure is the solver's, not the
    condition's.  The condition is feasible with margin exactly when the largest t is positive.

    "infeasible" only where multipliers leave no unknowns of any size (``contradiction``), or
    exact ones were found (``exact_no``): a bound on the margin below what solvers can distinguish
    from zero is none, for a margin may be as small where the numbers differ in size.

    Parameters
    ----------
    condition : or statements, ``decide([P >> 0, He(P @ A) << 0])``.
    rows : scalar unknown -> its upper bound.
    session : keeps the solver for the next condition of the same shape.
    assembled : the condition's cone data, if known already, at whatever parameters.
    most : stop after this number of attempts.
    """
    condition = condition_of(condition, "decide")
    if condition.equalities:
        # Imported here: few conditions have equalities, and solving them exactly needs much code.
        from takagi.lmi.decision.free_numbers import in_free_numbers, refuse_kept

        refuse_kept(condition, assembled, rows)
        return in_free_numbers(condition, lambda free: decide(free, session=session, most=most))
    data = _program_data(condition, assembled)
    program = _largest_margin(data, rows or {})
    best: Outcome | None = None
    tries: list[Try] = []
    doubtful = 0
    for raw in _few(attempts(program, session), most):
        outcome = judged(data, program, raw)
        tries.append(_try(raw, outcome.margin))
        if outcome.status == "unknown" and says_no(data, outcome):
            doubtful += 1
            # Exact arithmetic is tried at the first doubtful no only: it takes longer than the next
            # solver.
            if doubtful == 1 and most > 1:
                outcome = exactly_judged(data.condition, outcome)
        if best is None or (outcome.status != "unknown") or outcome.margin > best.margin:
            best = outcome
        if best.status != "unknown" or doubtful >= DOUBTFUL:
            break
    assert best is not None  # attempts yields at least one
    if most > 1:
        best = exactly_held(data.condition, best)
    return replace(best, tries=tuple(tries))


def first_weighed(data: Assembled, session: Session) -> Outcome:
    """Return the first solver's answer to ``decide``, without equalities and never "infeasible".

    For a search that reads values, bound and multipliers: whether these leave no unknowns at all
    takes longer than the solver.
    """
    data = _program_data(data.condition, data)
    program = _largest_margin(data, {})
    raw = next(attempts(program, session))
    outcome = weighed(data, program, raw)
    return replace(outcome, tries=(_try(raw, outcome.margin),))


def _largest_margin(data: Assembled, rows: Mapping[str, float]) -> ConeProgram:
    """Return: maximise t <= 1, with an upper bound for each scalar unknown of ``rows``."""
    variables = len(data.objective)
    t = np.eye(variables + 1)[variables]
    # The largest t is the last variable, so the cost -t maximises it; the row t <= 1 keeps the
    # program bounded where the condition can be scaled up.
    limits = [SolverRow(t, 1.0)]
    for name, bound in rows.items():
        limits.append(SolverRow(np.eye(variables + 1)[data.offsets[name]], bound))
    return cone_program(data, -t, tuple(limits))


def improve(condition: Condition, start: Outcome, *, assembled: Assembled | None = None) -> Outcome:
    """Return unknowns with the least objective among those with half the margin of ``start``.

    A result that does not withstand its check is moved towards ``start`` until it does; one that is
    worse than ``start`` is dropped for it.  ``lower_bound`` and ``settled`` refer to the margin
    that is kept.
    """
    data = _program_data(condition, assembled)
    # At the full margin of ``start`` there would be no freedom left to lower the objective.
    program = cone_program(data, data.objective, (), margin=0.5 * start.margin)
    tries = list(start.tries)
    objective_before = objective_at(data.condition, start.values)
    for raw in _few(attempts(program)):
        values: Mapping[str, Floats] = values_of(data, raw)
        checked_margin = margin(data.condition, values) if values else -np.inf
        tries.append(_try(raw, checked_margin))
        # A quarter, not the half that was posed: a solver meets its LMIs only up to its tolerances.
        if values and checked_margin < 0.25 * start.margin:
            values, checked_margin = _moved_inside(data.condition, values, start)
        if not checked_margin >= 0.25 * start.margin:
            continue
        objective_after = objective_at(data.condition, values)
        if objective_after <= objective_before:
            improved = replace(
                start,
                status="candidate",
                values=values,
                margin=checked_margin,
                objective=objective_after,
            )
            lower_bound = least_objective_bound(program, raw)
            return measured(
                data.condition, replace(improved, lower_bound=lower_bound, tries=tuple(tries)), 0.0
            )
    return replace(start, tries=tuple(tries), objective=objective_before)


def _moved_inside(
    condition: Condition, values: Mapping[str, Floats], start: Outcome
) -> tuple[Mapping[str, Floats], float]:
    """Return unknowns on the way to ``start`` that have a quarter of its margin, and their margin.

    A solver that stops early leaves a non-strict LMI violated by a little more than its tolerance.
    The set is convex: so a small step towards ``start``, which is inside it, mends that, while
    another solver may need a hundred times as long.
    """
    step, checked_margin = 1e-6, -np.inf
    while step < 1.0:
        shifted = {
            name: (1.0 - step) * value + step * start.values[name] for name, value in values.items()
        }
        checked_margin = margin(condition, shifted)
        if checked_margin >= 0.25 * start.margin:
            return shifted, checked_margin
        step *= 10.0
    return values, checked_margin


def optimise(
    condition: StatedCondition,
    *,
    slack: float = 1e-6,
    inside: float | None = None,
    assembled: Assembled | None = None,
    most: int | None = None,
) -> Outcome:
    """Return unknowns whose objective is within ``slack`` (relative) of the least, centred.

    Equalities are solved exactly first, as by ``decide``; ``slack`` is then relative to what of the
    objective they leave free.

    Parameters
    ----------
    slack : how far above the least value the second stage may go; thirty and a thousand times
        that where it leaves no margin, but never more than ``slack`` or a thousandth.
    inside : a margin that is asked for at once.  Where it costs the objective no more than
        ``slack`` by the bound of the multipliers, one solve is all; else it is dropped.
    assembled, most : as for ``decide``.

    A candidate's objective is above the bound of the multipliers by ``slack`` of that bound
    at most, or by a thousandth where less was asked for.  Where no solver comes as near, the status
    is "unknown", ``reason`` says both numbers, and ``feasible`` has the unknowns that satisfy the
    condition, if any were found.  "infeasible" when none satisfy it with a margin, "unbounded" when
    the objective falls without end.

    Raises ModelError: a condition without an objective.
    """
    condition = condition_of(condition, "optimise")
    if not condition.objective:
        raise ModelError(
            f"optimise: {condition.name} has no objective; write pose(..., minimise=trace(P)), or "
            "call decide for a condition without one"
        )
    if condition.equalities:
        from takagi.lmi.decision.free_numbers import in_free_numbers, refuse_kept

        refuse_kept(condition, assembled, None)
        return in_free_numbers(
            condition,
            lambda free: (
                optimise(free, slack=slack, inside=inside, most=most)
                if any(np.any(cost) for cost in free.objective.values())
                else replace(decide(free), objective=0.0, lower_bound=0.0, settled=True)
            ),
        )
    data = _program_data(condition, assembled)
    session = Session()
    program = cone_program(data, data.objective, (), margin=0.0)
    tries: list[Try] = []
    if inside is not None:
        with_margin = least_inside(data, inside, slack)
        if with_margin.settled:
            return with_margin
        tries.extend(with_margin.tries)
    best: Outcome | None = None
    plain: Outcome | None = None
    for raw in _few(_attempts(program), 99 if most is None else most):
        values = values_of(data, raw)
        checked_margin = margin(data.condition, values) if values else -np.inf
        tries.append(_try(raw, checked_margin))
        if values and "nfeasible" not in raw.status:
            bound = least_objective_bound(program, raw)
            centred = _centred(data, raw, checked_margin, bound, slack, session)
            tries.extend(centred.tries)
            best = _nearer(data.condition, best, replace(centred, lower_bound=bound), slack)
            if best.settled:
                return replace(best, tries=tuple(tries))
        # At the least objective the margin is zero, so an answer may fail its check although the
        # condition is feasible. Whether it is feasible is therefore decided without the objective,
        # once.
        if plain is None and (best is None or best.status != "candidate"):
            count = most or 99
            plain = decide(data.condition, assembled=data, most=count)
            tries.extend(plain.tries)
            if plain.status == "infeasible":
                break
        unbounded = falling(data, raw, plain) if plain and "Dual" in raw.status else None
        if unbounded is not None:
            return replace(unbounded, tries=tuple(tries))
    if best is None or best.status != "candidate":
        assert plain is not None  # decided as soon as an attempt left no candidate
        feasible = plain.values if plain.status == "candidate" else {}
        lower_bound = -np.inf if best is None else best.lower_bound
        best = replace(
            plain, objective=objective_at(data.condition, feasible), lower_bound=lower_bound
        )
    return concluded(replace(best, tries=tuple(tries)))


def _attempts(program: ConeProgram) -> Iterator[Raw]:
    """Yield one answer after another; the first also where its own solution is of order one."""
    for number, raw in enumerate(attempts(program)):
        yield raw
        for _ in range(RESCALED if number == 0 else 0):
            second = None if "nfeasible" in raw.status else rescaled(program, raw)
            if second is None:
                break
            raw = second
            yield raw


def _nearer(condition: Condition, best: Outcome | None, new: Outcome, slack: float) -> Outcome:
    """Return the better of the two, compared with the higher of their bounds.

    A bound above an objective that was found is none: its multipliers were not good enough.
    """
    chosen = new if best is None or better(new, best) else best
    bounds = [-np.inf if best is None else best.lower_bound, new.lower_bound]
    if chosen.status == "candidate":
        highest = chosen.objective + promised(slack) * abs(chosen.objective) + nothing(condition)
        bounds = [bound for bound in bounds if bound <= highest]
    return measured(condition, replace(chosen, lower_bound=max(bounds, default=-np.inf)), slack)


def least_inside(data: Assembled, inside: float, slack: float) -> Outcome:
    """Return the least objective with a margin; ``settled`` where the margin costs next to nothing.

    The multipliers bound the objective without a margin too: the two programs differ in b alone.
    The least objective is convex in the margin, so where it costs too much, that share of it which
    costs ``slack`` is asked for, once.
    """
    program = cone_program(data, data.objective, (), margin=0.0)
    session = Session()
    outcome = _with_margin(data, program, inside, slack, session)
    cost = outcome.objective - outcome.lower_bound
    smaller = 0.99 * inside * slack * abs(outcome.lower_bound) / cost if cost > 0 else 0.0
    if outcome.status != "candidate" or outcome.settled or smaller < LEAST_INSIDE:
        return outcome
    second = _with_margin(data, program, smaller, slack, session)
    return replace(second, tries=(*outcome.tries, *second.tries))


def _with_margin(
    data: Assembled, program: ConeProgram, inside: float, slack: float, session: Session
) -> Outcome:
    raw = next(attempts(cone_program(data, data.objective, (), margin=inside), session))
    values = values_of(data, raw)
    checked_margin = margin(data.condition, values) if values else -np.inf
    outcome = Outcome("unknown", values, checked_margin, np.inf, {}, (_try(raw, checked_margin),))
    if checked_margin < 0.5 * inside:
        return outcome
    objective = objective_at(data.condition, values)
    lower_bound = least_objective_bound(program, raw)
    settled = objective - lower_bound <= slack * abs(lower_bound)
    return replace(
        outcome, status="candidate", objective=objective, lower_bound=lower_bound, settled=settled
    )


def _centred(
    data: Assembled,
    raw: Raw,
    checked_margin: float,
    bound: float,
    slack: float,
    session: Session,
) -> Outcome:
    """Return the largest margin with the objective slightly above that of ``raw``.

    The first that holds; otherwise ``raw`` itself if it does, or what was nearest.  By the solver
    of ``raw``: where others failed, they would fail again.
    """
    least_found = float(data.objective @ raw.y)
    tries: list[Try] = []
    best: Outcome | None = None
    share = SHARE * promised(slack)
    # Above the bound, so that what the first stage was short of is not added to it.
    highest = bound + share * abs(bound)
    zero = nothing(data.condition)
    # If the least objective is zero, a relative slack is zero too; an absolute one replaces it.
    room = SHARE * zero if abs(least_found) <= zero else 0.0
    limits = [
        least_found + max(min(times * slack, share) * abs(least_found), room) for times in LOOSENESS
    ]
    if highest > least_found and not room:
        limits = [min(limit, highest) for limit in limits]
    for program, centred in _nearby(data, raw, list(dict.fromkeys(limits)), session):
        outcome = judged(data, program, centred)
        tries.append(_try(centred, outcome.margin))
        if best is None or outcome.margin > best.margin:
            best = outcome
        if outcome.status == "candidate":
            break
    assert best is not None  # there is a looseness
    if best.status != "candidate" and holds(data.condition, checked_margin):
        best = Outcome("candidate", values_of(data, raw), checked_margin, np.inf, {}, ())
    objective = objective_at(data.condition, best.values)
    return replace(best, tries=tuple(tries), objective=objective)


def _nearby(
    data: Assembled, raw: Raw, limits: list[float], session: Session
) -> Iterator[tuple[ConeProgram, Raw]]:
    """Yield the largest margin below one objective after another.

    The last step is the widest: before it, once more in units of what was found.
    """
    t, cost = np.eye(len(data.objective) + 1)[-1], np.append(data.objective, 0.0)
    for limit in limits:
        program = cone_program(data, -t, (SolverRow(t, 1.0), SolverRow(cost, limit)))
        centred = again(program, raw.solver, session)
        yield program, centred
        closer = rescaled(program, centred) if limit in limits[-2:-1] else None
        if closer is not None:
            yield program, closer


def _program_data(condition: Condition, assembled: Assembled | None) -> Assembled:
    if assembled is None:
        data = assemble(condition)
    elif assembled.condition is condition:
        data = assembled
    else:
        data = replace(assembled, condition=condition)
    return data if any(lmi.strict for lmi in condition.lmis) else _all_weighed(data)


def _all_weighed(data: Assembled) -> Assembled:
    """Return the data of non-strict LMIs alone, with a margin for each, relative to its constants.

    So they are decided, and centred, as strict ones are; a margin of 0 is enough.
    """
    columns = []
    for lmi, cone in zip(data.condition.lmis, data.cones, strict=True):
        sizes = [float(np.abs(c.value.astype(np.float64)).max(initial=0.0)) for c in lmi.constants]
        size = max(sizes, default=0.0) or 1.0
        columns.append(np.tile(pack(size * np.eye(cone.size)), cone.items))
    return replace(data, margin_column=np.concatenate(columns))


def _try(raw: Raw, checked_margin: float) -> Try:
    return Try(raw.solver, raw.status, checked_margin, raw.iterations, raw.seconds)


def _few(raws: Iterator[Raw], count: int = 3) -> Iterator[Raw]:
    for _, raw in zip(range(count), raws, strict=False):
        yield raw
