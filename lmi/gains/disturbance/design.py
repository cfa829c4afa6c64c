"""Gains against disturbances: posed where the numbers are of order one, solved, and checked."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from itertools import product
from typing import TypeAlias

import numpy as np

from takagi.lmi.answer import Answer, Design, ObjectiveUnit, Try
from takagi.lmi.argument_checks import positive_number
from takagi.lmi.condition.evaluate import SMALLEST_MARGIN, holds, margin
from takagi.lmi.condition.statements import condition_of, pose
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.cone_program import assemble
from takagi.lmi.decision.decide import decide, least_inside, optimise
from takagi.lmi.decision.outcome import Outcome, binding_items, not_least, objective_at
from takagi.lmi.expressions.expression import block, trace
from takagi.lmi.gains.disturbance.decoupling import decoupling
from takagi.lmi.gains.disturbance.request import (
    ASK,
    NOT_NEAR,
    RATES,
    ROUNDED,
    WHY,
    DisturbanceCoordinates,
    DisturbanceRequest,
    Regulator,
    _guesses,
    guessed_regulator,
    is_definite,
)
from takagi.lmi.gains.requirements.closed_loop import without_rounding
from takagi.lmi.parameter_search.parameter_sweep import least_objective
from takagi.lmi.refutation.refutation import objective_below
from takagi.lmi.solver.time_limit import out_of_time
from takagi.models.arrays import Floats

# Shares of its size that the output has left where a disturbance is kept from it, the objective
# that is looked for there.
APART, LOOSE = (1e-12, 1e-9, 1e-6), 100.0
# How much larger than a regulator's gains are absurd, how much smaller others must be, and by how
# much the effort may be above its least.
ABSURD_GAINS, MILDER_FACTOR, PER_CENT = 1e6, 10.0, 0.01
# Of the size of a regulator's norm, below which a norm is zero.
LEAST_SHARE = 1e-4
# Other coordinates are tried so often, when what they claim differs by more than this.
ROUNDS, AGREED = 3, 1e-5
# Other sizes are tried so often, each by so few solvers.
SIZES, FEW = 6, 2
# Sum of the cubes of the LMIs' widths above which a second look costs too much: then the bound of
# the multipliers, a thousandth, has to do.
LARGEST_SECOND_LOOK = 1e5


KnownSolution: TypeAlias = tuple[DisturbanceCoordinates, Condition, Outcome]


@dataclass(frozen=True, slots=True, eq=False)
class _Solved:
    """A condition in some coordinates, and what came of it."""

    units: DisturbanceCoordinates
    condition: Condition
    outcome: Outcome

    @property
    def P(self) -> Floats:
        """Return P of x' P x = xhat' Q^-1 xhat in the model's states."""
        return self.units.quadratic(self.outcome.values["Q"][0])


def asked_or_least(
    task: DisturbanceRequest,
    norm_below: float | None,
    known_solution: Callable[[], KnownSolution | None] = lambda: None,
) -> Design:
    """Return gains with a norm of at most what is asked for, where it is, else with the least."""
    if norm_below is not None:
        return below(task, positive_number("norm_below", norm_below))
    design = hidden(task) or designed(task, known_solution())
    return tamed(task, design, lambda value: below(task, value))


def tamed(task: DisturbanceRequest, design: Design, redesign: Callable[[float], Design]) -> Design:
    """Return the design with a note where its gains are absurd; others where its norm is zero.

    ``redesign`` : the gains with a norm of at most a value.
    """
    natural = None if design.gain is None else guessed_regulator(task.plant, 1.0)
    size = 0.0 if natural is None else _size_of(task, natural, design)
    if natural is None or not size > ABSURD_GAINS:
        return design
    value = None if out_of_time() else _zero(task)
    alternative = design if value is None else redesign(value)
    if alternative.found and _size_of(task, natural, alternative) < size / MILDER_FACTOR:
        return _noted(alternative, f"a least norm of zero is approached alone; {ASK}")
    return _noted(design, f"the gains are {size:.0e} times a regulator's; {ASK}")


def _noted(design: Design, note: str) -> Design:
    return replace(design, answer=replace(design.answer, note=note))


def _size_of(task: DisturbanceRequest, natural: Regulator, design: Design) -> float:
    """Return the largest gain where those of a regulator are of order one."""
    if design.gains is None:
        return 0.0
    units = DisturbanceCoordinates.of(task.plant, natural.P, noise=task.noise)
    return float(np.abs(units.scaled_gains(design.gains)).max())


def designed(task: DisturbanceRequest, known_solution: KnownSolution | None = None) -> Design:
    """Return the gains with the least objective, or why there are none.

    ``known_solution`` : what needs no program, coordinates with the condition and its outcome in
    them; None where there is no such answer.

    Posed where the cost of a regulator at the mean vertex is |x|^2, and counted from its gains: as
    a rule one solve there is all.  Where it shows no gains, plain compensation says whether there
    are any; then posed where its function is |x|^2, and in the plant's own coordinates.
    """
    if known_solution is not None:
        design = _design(task, _Solved(*known_solution))
        if design.found:
            return design
    plain = cache(task.plain)
    own_size_tried = False
    tries: tuple[Try, ...] = ()
    for number, (P, feedback) in enumerate(_guesses(task)):
        if not own_size_tried and (number or P is None):
            own_size_tried = True
            tries += plain().answer.tries
            if plain().P is None:
                return _without_any(plain(), tries)
            own_solution = _in_own_size(task, plain())
            tries += own_solution.outcome.tries if own_solution is not None else ()
            if own_solution is not None and own_solution.outcome.status == "candidate":
                design = _design(task, own_solution)
                if design.found:
                    return _with_tries(design, tries)
        P = plain().P if P is None else P
        if P is None or not is_definite(P):
            continue
        # That there are no gains at all is known sooner than that no objective is the least.
        solution = _solved(
            task,
            *_in_coordinates(task, P, feedback),
            may_exist=lambda: plain().answer.status != "infeasible",
        )
        tries += solution.outcome.tries
        if solution.outcome.status == "candidate":
            return _with_tries(_design(task, _confirmed(task, solution)), tries)
        if plain().answer.status == "infeasible":
            return _without_any(plain(), tries + plain().answer.tries)
    return _with_tries(_nearly_zero(task) or _without(task, solution), tries)


def _without_any(plain: Design, tries: tuple[Try, ...]) -> Design:
    """Return a no, or doubt, about gains of whatever norm, as that about gains with one."""
    answer = replace(
        plain.answer, diagnosis=f"of gains with whatever norm: {plain.answer.diagnosis}"
    )
    return _with_tries(replace(plain, answer=answer), tries)


def _nearly_zero(task: DisturbanceRequest) -> Design | None:
    """Return gains with a norm that is zero but for the tolerance; None where none were found.

    A tolerance relative to a least norm of zero is none, so it is a share of what a regulator that
    weighs states and inputs alike would leave of the disturbance.
    """
    value = _zero(task)
    design = None if value is None else below(task, value)
    note = f"a least norm of zero is approached alone; {ASK}"
    return _noted(design, note) if design is not None and design.found else None


def _zero(task: DisturbanceRequest) -> float | None:
    """Return the norm that is zero but for the tolerance; None without a regulator."""
    natural = guessed_regulator(task.plant, 1.0)
    if natural is None:
        return None
    units = DisturbanceCoordinates.of(task.plant, natural.P, noise=task.noise)
    nothing, size = task.gain(units, 0.0), task.gain(units, 1.0)
    return nothing + max(task.tolerance, LEAST_SHARE) * (size - nothing)


def hidden(task: DisturbanceRequest) -> Design | None:
    """Return gains that keep the disturbance from the output; None without such, or with limits.

    The least norm is zero then, and nothing is near it by a share of it.
    """
    apart = None if task.limits is not None else decoupling(task.plant)
    if apart is None:
        return None
    plant = task.plant
    # The LMIs of a peak need a rate.
    free = task.peak is not None and task.decay_rate == 0
    rates = [share * apart.rate for share in RATES] if free else [task.decay_rate]
    decoupled = replace(
        plant, A=plant.A - plant.B @ apart.gains, C=plant.C - plant.D12 @ apart.gains
    )
    natural = DisturbanceCoordinates.of(plant, apart.quadratic(1.0), noise=task.noise).output
    for share, rate in product(APART, rates):
        posed = replace(task, plant=decoupled, guess=None, decay_rate=rate)
        units, _ = _in_coordinates(posed, apart.quadratic(share), None)
        output_size = float(np.abs(decoupled.C @ units.states).max())
        units = replace(units, output=max(output_size, share * natural))
        for leaving in (np.eye(plant.B.shape[2]), apart.leaving):
            limit = task.gain(units, LOOSE)
            solution = _bounded(posed, units, limit, leaving=leaving)
            if solution.outcome.status == "candidate":
                design = _design(posed, solution, earlier_gains=apart.gains)
                if design.found:
                    return design
    return None


def below(task: DisturbanceRequest, value: float) -> Design:
    """Return gains with a norm of at most the value and the largest margin, or why there are none.

    Raises
    ------
    ModelError : a value that no norm has, such as one below the direct path's.
    """
    tries: tuple[Try, ...] = ()
    plain: Design | None = None
    for P, feedback in ((None, None), *_guesses(task)):
        if P is None:
            plain = task.plain() if plain is None else plain
            if plain.P is None:
                return _without_any(plain, plain.answer.tries)
            P = plain.P
        if not is_definite(P):
            continue
        units, _ = _in_coordinates(task, P, feedback)
        solution = _bounded(task, units, value)
        tries += solution.outcome.tries
        if solution.outcome.status == "candidate":
            design = _design(task, solution)
            if design.found:
                return _with_tries(design, tries)
        if solution.outcome.status == "infeasible" or out_of_time():
            break
    return _with_tries(_without(task, solution, value), tries)


def _bounded(
    task: DisturbanceRequest,
    units: DisturbanceCoordinates,
    value: float,
    *,
    leaving: Floats | None = None,
) -> _Solved:
    """Return what is found with a norm of at most the value, the output in units of that.

    ``leaving`` : (k, m), of inputs that are not to be used: leaving M = 0.
    """
    unit = ObjectiveUnit.of("norm", lambda objective: task.gain(units, objective))
    limit = unit.objective(value)
    if task.limits is None:
        units = replace(units, output=units.output * limit ** (1 / unit.power))
        limit = 1.0
    condition = task.condition(units)
    limited = objective_below(condition, limit)
    if leaving is not None:
        M = next(unknown for unknown in condition.unknowns if unknown.name == "M")
        hiding = (leaving * units.inputs) @ M == 0
        limited = replace(limited, equalities=condition_of(hiding, "gains").equalities)
    outcome = decide(limited)
    if outcome.status == "candidate" and leaving is None:
        outcome = _mildest(limited, outcome)
    outcome = replace(outcome, objective=objective_at(condition, outcome.values))
    return _Solved(units, condition if outcome.status == "candidate" else limited, outcome)


def _mildest(condition: Condition, outcome: Outcome) -> Outcome:
    """Return unknowns with about the least K_i Q K_i', the input where V is 1; else the same."""
    Q, M = (
        next(unknown for unknown in condition.unknowns if unknown.name == name) for name in "QM"
    )
    S = Unknown("effort", M.rows, M.rows, symmetric=True)
    effort = pose((block([[S, M], [M.T, Q]]) >> 0).named("effort"), minimise=trace(S))
    with_effort = replace(
        condition,
        unknowns=(*condition.unknowns, S),
        lmis=(*condition.lmis, *effort.lmis),
        objective=effort.objective,
    )
    mild = optimise(with_effort, slack=PER_CENT, most=FEW)
    values = mild.values if mild.status == "candidate" else {}
    checked_margin = margin(condition, values) if values else -np.inf
    if not holds(condition, checked_margin):
        return replace(outcome, tries=(*outcome.tries, *mild.tries))
    return replace(
        outcome, values=values, margin=checked_margin, tries=(*outcome.tries, *mild.tries)
    )


def _in_own_size(task: DisturbanceRequest, plain: Design) -> _Solved | None:
    """Return what is found where the last Q is I, in direction and in size; None where not sought.

    Of rules that can hardly be stabilised the output is large however small the disturbance: Q is
    1e-5 in units that suit others, and solvers lose their way.  What they find there, near enough
    to the LMIs, says in which units to look; the input is counted from its gains.
    """
    if task.limits is not None or task.peak is not None or task.energy is not None:
        return None
    assert plain.P is not None and plain.gains is not None  # asked for by the caller
    P, feedback, output_scale = plain.P, task.mean_of(plain), 1.0
    solution, tries = None, tuple[Try, ...]()
    for _ in range(SIZES):
        if not is_definite(P):
            break
        units, _ = _in_coordinates(task, P, feedback)
        units = replace(units, output=units.output * output_scale)
        condition, slack = task.condition(units), task.tolerance
        outcome = optimise(condition, slack=slack, inside=slack, most=FEW)
        tries += outcome.tries
        solution = _Solved(units, condition, replace(outcome, tries=tries))
        values = outcome.values or outcome.feasible
        sizes = np.linalg.eigvalsh(values["Q"][0]) if values else np.zeros(1)
        if outcome.status == "candidate" or not sizes[0] > 0 or out_of_time():
            break
        P, output_scale = units.quadratic(values["Q"][0]), output_scale / float(np.sqrt(sizes[-1]))
        feedback = units.gains(values["Q"][0], values["M"], len(task.plant.A)).mean(axis=0)
    return solution


def _in_coordinates(
    task: DisturbanceRequest, P: Floats, feedback: Floats | None
) -> tuple[DisturbanceCoordinates, Condition]:
    """Return coordinates where x' P x is |x|^2, and the condition in them."""
    units = DisturbanceCoordinates.of(
        task.plant,
        P,
        feedback=feedback,
        limits=task.limits,
        peak=task.peak,
        energy=task.energy,
        noise=task.noise,
        growth=task.growth,
    )
    return units, task.condition(units)


def _solved(
    task: DisturbanceRequest,
    units: DisturbanceCoordinates,
    condition: Condition,
    *,
    may_exist: Callable[[], bool] = lambda: True,
) -> _Solved:
    """Return what is near the least objective, with a margin of the tolerance if that is possible.

    In these coordinates both the margin and what it costs are of that size.

    ``may_exist`` : asked where no unknowns are seen at once; False ends the search.
    """
    slack, data = task.tolerance, assemble(condition)
    outcome = least_inside(data, slack, slack)
    if not outcome.settled and (outcome.status == "candidate" or may_exist()):
        full = optimise(condition, slack=slack, assembled=data)
        outcome = replace(full, tries=(*outcome.tries, *full.tries))
    return _Solved(units, condition, outcome)


def _confirmed(task: DisturbanceRequest, solution: _Solved) -> _Solved:
    """Return the best of what is found where the last P is |x|^2, until two agree.

    In coordinates that do not suit it a solver may call solved what is a per cent above the least
    objective.  Where its multipliers do not decide, other coordinates do.
    """
    size = sum(lmi.count * lmi.size**3 for lmi in solution.condition.lmis)
    for _ in range(0 if size > LARGEST_SECOND_LOOK else ROUNDS):
        objective = solution.outcome.objective
        if objective - solution.outcome.lower_bound <= (task.tolerance + AGREED) * objective:
            break
        gain = task.gain(solution.units, objective)
        gain_bound = task.gain(solution.units, objective / (1 + task.tolerance))
        if not is_definite(solution.P):
            break
        units, condition = _in_coordinates(task, solution.P, solution.units.feedback)
        claimed = least_objective(condition)
        if not 0 < claimed or not task.gain(units, claimed) < (1 - AGREED) * gain_bound:
            break
        second = _solved(task, units, condition)
        if second.outcome.status != "candidate":
            break
        if not task.gain(units, second.outcome.objective) < gain:
            break
        solution = second
    return solution


def _design(
    task: DisturbanceRequest, solution: _Solved, earlier_gains: Floats | None = None
) -> Design:
    """Return the design; its gains are added to ``earlier_gains``, (r, m, n), in the plant."""
    outcome, units = solution.outcome, solution.units
    gains = units.gains(outcome.values["Q"][0], outcome.values["M"], len(task.plant.A))
    if earlier_gains is None:
        exact = without_rounding(gains, np.asarray(np.linalg.pinv(solution.P), np.float64))
        checked_margin = _held(solution, exact)
        gains, checked_margin = (
            (exact, checked_margin)
            if checked_margin > SMALLEST_MARGIN
            else (gains, _held(solution, gains))
        )
    else:
        gains, checked_margin = (
            earlier_gains + gains,
            _held(solution, earlier_gains + gains - earlier_gains),
        )
    good = checked_margin > SMALLEST_MARGIN
    answer = replace(
        outcome.as_answer(solution.condition, None),
        status="candidate" if good else "unknown",
        P=task.norm.size(task, units) * solution.P if good else None,
        margin=checked_margin,
        gain=task.gain(units, outcome.objective) if good else None,
        objective_unit=ObjectiveUnit.of("gain", lambda value: task.gain(units, value)),
        diagnosis="" if good else ROUNDED,
    )
    return Design(
        gains=gains if good else None,
        P=answer.P,
        decay_rate=task.decay_rate,
        margin=checked_margin,
        relaxation=task.relaxation,
        answer=answer,
    )


def _with_tries(design: Design, tries: tuple[Try, ...]) -> Design:
    """Return the design with everything that was tried before it, too."""
    return replace(design, answer=replace(design.answer, tries=tries))


def _held(solution: _Solved, gains: Floats) -> float:
    """Return the margin with M = K Q, K the rounded gains that are returned."""
    Q, M = solution.outcome.values["Q"], solution.outcome.values["M"]
    K = solution.units.scaled_gains(gains[: len(M)])
    return margin(solution.condition, {**solution.outcome.values, "M": K @ Q})


def _without(task: DisturbanceRequest, solution: _Solved, value: float | None = None) -> Design:
    """Return a no, or doubt, about the disturbed loop, where the plain one has gains."""
    outcome = solution.outcome
    # Without limits a large enough gain is always shown; then the solver has met its own.
    no = outcome.status == "infeasible" and (task.limits is not None or value is not None)
    request = "" if value is None else f"a norm of at most {value:g}"
    diagnosis = f"gains exist, but no solver {f'settled {request}' if request else NOT_NEAR}; {WHY}"
    if outcome.feasible:
        objective_bounds = (outcome.objective, outcome.lower_bound)
        gain_bounds = (
            task.gain(solution.units, max(objective, 0.0)) for objective in objective_bounds
        )
        diagnosis = f"gains exist, but {not_least(*gain_bounds)}; ask for norm_below; {WHY}"
    if no:
        names = [lmi.name for lmi in solution.condition.lmis if lmi.strict]
        names.remove("Q positive definite")
        binding = binding_items(solution.condition, outcome.multipliers, *names)
        keep = "exist" if task.limits is None else "keep the limits"
        with_it = f" has {request}" if request else " with it"
        diagnosis = (
            f"gains {keep} without disturbance, but by {task.relaxation} none{with_it}: {binding}; "
            f"{'ask for a larger norm' if request else 'allow for less disturbance'}, widen the "
            "limits, or take a richer relaxation"
        )
    answer = Answer(
        status="infeasible" if no else "unknown",
        margin=min(outcome.margin, 0.0),
        bound=outcome.bound,
        multipliers=outcome.multipliers,
        condition=solution.condition,
        feasible={} if no else outcome.feasible,
        diagnosis=diagnosis,
        tries=outcome.tries,
    )
    return Design(
        decay_rate=task.decay_rate, margin=answer.margin, relaxation=task.relaxation, answer=answer
    )
