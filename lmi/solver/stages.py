"""From a condition to numbers that withstand their check: decide, optimise, improve.

``decide`` asks for the largest margin t, one solve.  ``optimise`` takes two stages, because at the
least objective the LMIs touch zero, where no check can hold:

1. the least objective, with no margin; its multipliers bound the objective of all unknowns from
   below;
2. the objective fixed a hair above what was found, the margin as large as it can be (re-centred).

What is handed back is re-evaluated from the unknowns by eigenvalues, and its objective is compared
with the bound: a solver that stops early, or at a wrong value, is found out by either, and the next
one is asked.  Every stage takes ``parameters``, the cone data (``assembled``) and a ``Session``, so
that a sequence of parameter values costs one assembly (see ``parameter_sweep``).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.answer import Status, Try
from takagi.lmi.evaluate import margin
from takagi.lmi.solver.assemble import Assembled, assemble
from takagi.lmi.solver.duality import least_objective_bound, margin_bound
from takagi.lmi.solver.outcome import Outcome, better, measured, objective_at
from takagi.lmi.solver.solve import (
    ConeProgram,
    Raw,
    Row,
    Session,
    again,
    attempts,
    cone_program,
    quick,
)
from takagi.lmi.term import Condition

__all__ = ["Outcome", "decide", "improve", "optimise"]

Floats = NDArray[np.float64]

# A margin is recomputed from the unknowns, so it is wrong by rounding only, some 1e-15.
SMALLEST_MARGIN = 1e-10
# What the solver's tolerances can tell from zero.
SMALLEST_BOUND = 1e-7
# Looseness of the second stage, in units of ``slack``, until it leaves a margin.
LOOSENESS = (1.0, 30.0, 1e3)


def decide(
    condition: Condition,
    *,
    cap: float = 1.0,
    rows: Mapping[str, float] | None = None,
    parameters: Mapping[str, float] | None = None,
    session: Session | None = None,
    assembled: Assembled | None = None,
    most: int = 99,
) -> Outcome:
    """Return the unknowns with the largest margin t <= cap.

    Always solvable when every unknown is bounded, so a failure is the solver's, not the
    condition's.  The condition is feasible with margin exactly when the largest t is positive.

    Parameters
    ----------
    rows : scalar unknown -> its upper bound.
    parameters : values in the place of the condition's own.
    session : keeps the solver for the next condition of the same shape.
    assembled : the condition's cone data, if known already, at whatever parameters.
    most : give up after so many tries.
    """
    data = _posed(condition, parameters, assembled)
    variables = len(data.objective)
    t = np.eye(variables + 1)[variables]
    limits = [Row(t, cap)]
    for name, bound in (rows or {}).items():
        limits.append(Row(np.eye(variables + 1)[data.offsets[name]], bound))
    program = cone_program(data, -t, tuple(limits))
    best: Outcome | None = None
    tries: list[Try] = []
    for raw in _few(attempts(program, session), most):
        found = _judge(data, program, raw)
        tries.append(_try(raw, found.margin))
        if best is None or (found.status != "unknown") or found.margin > best.margin:
            best = found
        if best.status != "unknown":
            break
    assert best is not None  # attempts yields at least one
    return replace(best, tries=tuple(tries))


def improve(
    condition: Condition,
    start: Outcome,
    *,
    keep: float = 0.5,
    parameters: Mapping[str, float] | None = None,
    session: Session | None = None,
    assembled: Assembled | None = None,
) -> Outcome:
    """Return unknowns with the least objective among those with margin keep * start.margin.

    A result that is worse, or does not withstand its check, is dropped for ``start``.  ``least``
    and ``settled`` refer to the margin that is kept.
    """
    data = _posed(condition, parameters, assembled)
    program = cone_program(data, data.objective, (), margin=keep * start.margin)
    tries = list(start.tries)
    before = objective_at(data.condition, start.values)
    for raw in _few(attempts(program, session)):
        values = _values(data, raw)
        held = margin(data.condition, values) if values else -np.inf
        tries.append(_try(raw, held))
        if held < 0.5 * keep * start.margin:
            continue
        after = objective_at(data.condition, values)
        if after <= before:
            found = replace(start, status="candidate", values=values, margin=held, objective=after)
            least = least_objective_bound(program, raw)
            return measured(data.condition, replace(found, least=least, tries=tuple(tries)), 0.0)
    return replace(start, tries=tuple(tries), objective=before)


def optimise(
    condition: Condition,
    *,
    slack: float = 1e-6,
    cap: float = 1.0,
    parameters: Mapping[str, float] | None = None,
    session: Session | None = None,
    assembled: Assembled | None = None,
) -> Outcome:
    """Return unknowns whose objective is within ``slack`` (relative) of the least, centred.

    Parameters
    ----------
    slack : how far above the least value the second stage may go; thirty and a thousand times
        that where it leaves no margin.
    cap, parameters, session, assembled : as for ``decide``.

    Returns
    -------
    An outcome with status "infeasible" when no unknowns satisfy the condition with a margin.
    Where no solver comes near the least value, a candidate that is not ``settled``.
    """
    data = _posed(condition, parameters, assembled)
    kept = Session() if session is None else session
    program = cone_program(data, data.objective, (), margin=0.0)
    tries: list[Try] = []
    best: Outcome | None = None
    plain: Outcome | None = None
    least, given = -np.inf, 0.0
    for raw in _few(attempts(program, session), quick()):
        values = _values(data, raw)
        held = margin(data.condition, values) if values else -np.inf
        tries.append(_try(raw, held))
        if values and "nfeasible" not in raw.status:
            least = max(least, least_objective_bound(program, raw))
            centred, loose = _centred(data, raw, held, slack, cap, kept)
            tries.extend(centred.tries)
            if best is None or better(centred, best):
                best, given = centred, loose
            best = measured(data.condition, replace(best, least=least), given)
            if best.settled:
                return replace(best, tries=tuple(tries))
        if plain is None and (best is None or best.status != "candidate"):
            plain = decide(data.condition, cap=cap, session=session, assembled=data)
            tries.extend(plain.tries)
            if plain.status == "infeasible":
                break
    if best is None or best.status != "candidate":
        assert plain is not None  # decided as soon as an attempt left no candidate
        found = plain.values if plain.status == "candidate" else {}
        best = replace(plain, objective=objective_at(data.condition, found), least=least)
    return replace(best, tries=tuple(tries))


def _centred(
    data: Assembled, raw: Raw, held: float, slack: float, cap: float, session: Session
) -> tuple[Outcome, float]:
    """Return the largest margin with the objective a hair above that of ``raw``, and the hair.

    The first that holds; otherwise ``raw`` itself if it does, or what was nearest.  By the solver
    of ``raw``: where others failed, they would fail again.
    """
    variables = len(data.objective)
    t, cost = np.eye(variables + 1)[variables], np.append(data.objective, 0.0)
    least = float(data.objective @ raw.y)
    tries: list[Try] = []
    best: Outcome | None = None
    for loose in np.multiply(LOOSENESS, slack):
        limit = least + loose * max(abs(least), 1e-9)
        program = cone_program(data, -t, (Row(t, cap), Row(cost, limit)))
        centred = again(program, raw.solver, session)
        found = _judge(data, program, centred)
        tries.append(_try(centred, found.margin))
        if best is None or found.margin > best.margin:
            best = found
        if found.status == "candidate":
            break
    assert best is not None  # there is a looseness
    if best.status != "candidate" and held > SMALLEST_MARGIN:
        best = Outcome("candidate", _values(data, raw), held, np.inf, {}, ())
    objective = objective_at(data.condition, best.values)
    return replace(best, tries=tuple(tries), objective=objective), float(loose)


def _posed(
    condition: Condition, parameters: Mapping[str, float] | None, assembled: Assembled | None
) -> Assembled:
    posed = condition.with_parameters(**parameters) if parameters else condition
    if assembled is None:
        return assemble(posed)
    return assembled if assembled.condition is posed else replace(assembled, condition=posed)


def _judge(data: Assembled, program: ConeProgram, raw: Raw) -> Outcome:
    """Check the solver's numbers from scratch; its status is not read."""
    values = _values(data, raw)
    held = margin(data.condition, values) if values else -np.inf
    bound, packed = margin_bound(program, raw)
    multipliers = data.multipliers(packed) if len(packed) else {}
    status: Status = "unknown"
    if held > SMALLEST_MARGIN:
        status = "candidate"
    elif bound < SMALLEST_BOUND:
        status = "infeasible"
    return Outcome(status, values, held, bound, multipliers, ())


def _values(data: Assembled, raw: Raw) -> dict[str, Floats]:
    """Return the unknowns, or nothing where there are no finite numbers for all of them."""
    usable = len(raw.y) >= len(data.objective) and bool(np.all(np.isfinite(raw.y)))
    return data.values(raw.y) if usable else {}


def _try(raw: Raw, held: float) -> Try:
    return Try(raw.solver, raw.status, held, raw.iterations, raw.seconds)


def _few(raws: Iterator[Raw], count: int = 3) -> Iterator[Raw]:
    for _, raw in zip(range(count), raws, strict=False):
        yield raw
