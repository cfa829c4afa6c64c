"""From a condition to numbers that withstand their check: decide, optimise, re-centre."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from takagi.lmi.answer import Status, Try
from takagi.lmi.evaluate import margin
from takagi.lmi.solver.assemble import Assembled, assemble, pack, unpack
from takagi.lmi.solver.solve import ConeProgram, Raw, Row, Session, attempts, cone_program
from takagi.lmi.term import Condition

__all__ = ["Outcome", "decide", "improve", "optimise"]

Floats = NDArray[np.float64]

# A margin is recomputed from the unknowns, so it is wrong by rounding only, some 1e-15.
SMALLEST_MARGIN = 1e-10
# What the solver's tolerances can tell from zero.
SMALLEST_BOUND = 1e-7


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """The best of the tries.

    Attributes
    ----------
    margin : largest t with sign F >= t weight I at ``values``, recomputed by eigenvalues.
    bound : no values have a larger t, to solver accuracy; inf when unknown.
    """

    status: Status
    values: Mapping[str, Floats]
    margin: float
    bound: float
    multipliers: Mapping[str, Floats]
    tries: tuple[Try, ...]
    objective: float = np.nan


def decide(
    condition: Condition,
    *,
    cap: float = 1.0,
    rows: Mapping[str, float] | None = None,
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
    session : keeps the solver for the next condition of the same shape.
    assembled : the condition's cone data, if known already.
    most : give up after so many tries.
    """
    data = assemble(condition) if assembled is None else assembled
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
        tries.append(Try(raw.solver, raw.status, found.margin, raw.iterations, raw.seconds))
        if best is None or (found.status != "unknown") or found.margin > best.margin:
            best = found
        if best.status != "unknown":
            break
    assert best is not None  # attempts yields at least one
    return _with_tries(best, tries)


def improve(
    condition: Condition,
    start: Outcome,
    *,
    keep: float = 0.5,
    assembled: Assembled | None = None,
) -> Outcome:
    """Return unknowns with the least objective among those with margin keep * start.margin.

    A result that is worse, or does not withstand its check, is dropped for ``start``.
    """
    data = assemble(condition) if assembled is None else assembled
    program = cone_program(data, data.objective, (), margin=keep * start.margin)
    tries = list(start.tries)
    before = _objective(condition, start.values)
    for raw in _few(attempts(program)):
        values = data.values(raw.y)
        held = margin(condition, values)
        tries.append(Try(raw.solver, raw.status, held, raw.iterations, raw.seconds))
        after = _objective(condition, values)
        if held >= 0.5 * keep * start.margin and after <= before:
            return Outcome(
                "candidate", values, held, start.bound, start.multipliers, tuple(tries), after
            )
    return _with_tries(start, tries, before)


def optimise(condition: Condition, *, slack: float = 1e-6, cap: float = 1.0) -> Outcome:
    """Return unknowns whose objective is within ``slack`` (relative) of the least, centred.

    The least value is approached with every LMI touching zero, where no check can hold; so the
    objective is then fixed a hair off its least value and the margin made as large as it can be.

    Returns
    -------
    An outcome with status "infeasible" when no unknowns satisfy the condition with a margin.
    """
    data = assemble(condition)
    tries: list[Try] = []
    best: Outcome | None = None
    for raw in _few(attempts(cone_program(data, data.objective, (), margin=0.0))):
        if not len(raw.y) or not np.all(np.isfinite(raw.y)) or "Infeasible" in raw.status:
            tries.append(Try(raw.solver, raw.status, -np.inf, raw.iterations, raw.seconds))
            continue
        tries.append(
            Try(
                raw.solver,
                raw.status,
                margin(condition, data.values(raw.y)),
                raw.iterations,
                raw.seconds,
            )
        )
        least = float(data.objective @ raw.y)
        for looseness in (slack, 30 * slack, 1e3 * slack):
            centred = _centre(condition, data, least + looseness * max(abs(least), 1e-9), cap)
            tries.extend(centred.tries)
            if best is None or centred.margin > best.margin:
                best = centred
            if centred.status == "candidate":
                return _with_tries(centred, tries, _objective(condition, centred.values))
    plain = decide(condition, cap=cap, assembled=data)
    return _with_tries(plain, tries + list(plain.tries))


def _centre(condition: Condition, data: Assembled, limit: float, cap: float) -> Outcome:
    variables = len(data.objective)
    t = np.eye(variables + 1)[variables]
    rows = (Row(t, cap), Row(np.append(data.objective, 0.0), limit))
    program = cone_program(data, -t, rows)
    raw = next(attempts(program))
    found = _judge(data, program, raw)
    note = Try(raw.solver, raw.status, found.margin, raw.iterations, raw.seconds)
    return _with_tries(found, [note])


def _judge(data: Assembled, program: ConeProgram, raw: Raw) -> Outcome:
    """Check the solver's numbers from scratch; its status is not read."""
    count = len(data.objective)
    usable = len(raw.y) > count and bool(np.all(np.isfinite(raw.y)))
    values = data.values(raw.y) if usable else {}
    held = margin(data.condition, values) if usable else -np.inf
    bound, multipliers = np.inf, {}
    if len(raw.z) == len(program.b) and np.all(np.isfinite(raw.z)):
        bound, packed = _margin_bound(program, raw)
        multipliers = data.multipliers(packed)
    status: Status = "unknown"
    if held > SMALLEST_MARGIN:
        status = "candidate"
    elif bound < SMALLEST_BOUND:
        status = "infeasible"
    return Outcome(status, values, held, bound, multipliers, ())


def _margin_bound(program: ConeProgram, raw: Raw) -> tuple[float, Floats]:
    """Return an upper bound on t from the multipliers, and the multipliers made semidefinite.

    For z in the dual cone and all feasible y: t <= b . z - (A' z + q) . y.  What is left of the
    stationarity A' z + q = 0 is weighed with ten times the size of the y that was found.
    """
    z = raw.z.copy()
    z[: program.linear] = np.maximum(z[: program.linear], 0.0)
    for cone in program.cones:
        rows = slice(program.linear + cone.rows.start, program.linear + cone.rows.stop)
        eigenvalues, vectors = np.linalg.eigh(unpack(z[rows], cone.size))
        positive = np.maximum(eigenvalues, 0.0)
        z[rows] = pack((vectors * positive[:, None, :]) @ vectors.transpose(0, 2, 1)).ravel()
    residual = program.A.T @ z + program.q
    # Normalised multipliers leave no residual in t, the last variable.
    scale = 1.0 + residual[-1]
    if scale <= 0.5:
        return np.inf, z[program.linear :]
    z, residual = z / scale, (residual - program.q) / scale + program.q
    size = 10.0 * np.maximum(1.0, np.abs(raw.y))
    bound = float(program.b @ z + np.abs(residual[:-1]) @ size[:-1])
    return bound, z[program.linear :]


def _objective(condition: Condition, values: Mapping[str, Floats]) -> float:
    return float(sum(np.sum(cost * values[name]) for name, cost in condition.objective.items()))


def _few(raws: Iterator[Raw], count: int = 3) -> Iterator[Raw]:
    for _, raw in zip(range(count), raws, strict=False):
        yield raw


def _with_tries(outcome: Outcome, tries: list[Try], objective: float = np.nan) -> Outcome:
    return Outcome(
        outcome.status,
        outcome.values,
        outcome.margin,
        outcome.bound,
        outcome.multipliers,
        tuple(tries),
        objective,
    )
