"""Parallel distributed compensation: one gain a rule, one Lyapunov function for all.

The largest decay rate with gains, and one relaxation after another.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Design, RelaxationResult, RelaxationStatus
from takagi.lmi.argument_checks import corners_of, number, rate_parameter
from takagi.lmi.condition.region import EigenvalueRegion
from takagi.lmi.condition.unknown import triangle
from takagi.lmi.cone.cone_program import assemble
from takagi.lmi.decision.decide import decide
from takagi.lmi.gains.decay.condition import (
    Controlled,
    DecayRequest,
    decay_request,
    double_sums,
    size_of_motion,
)
from takagi.lmi.gains.decay.design import (
    ANY,
    EFFORTS,
    LimitedOutcome,
    decided,
    design_at,
    design_of,
    rate_of,
    stopped_by_limit,
)
from takagi.lmi.gains.requirements.limits import GivenLimits
from takagi.lmi.gains.zero_gains import warns_of_zero_gains
from takagi.lmi.solver.solve import Session
from takagi.lmi.sums.membership_shape import at_points, number_of_points
from takagi.lmi.sums.relaxations import (
    MOST_WORK,
    NAMES,
    PRODUCTS,
    Relaxation,
    RelaxationSize,
    contains,
    relaxation_named,
    size_of,
    work_of,
)
from takagi.models.errors import ModelError

# Relative width of the bracket, and how far below it the gains are designed: at the end itself
# there is no margin left for them.
TOLERANCE, BACK = 1e-5, 1e-4
STEPS = 80
# V(x+) below this share of V is a state at rest after one step, whatever the rate is called.
LEAST_CONTRACTION = 1e-8
# Q with diagonal entries further apart than this is posed anew in units of its own.
SPREAD = 16.0
# Solvers that are asked about a rate that the first did not settle.
FEW_SOLVERS = 4


class Largest:
    """The bracket of the largest decay rate, from ``start`` in 1/s upwards.

    A candidate shows a rate above the one it was asked for (``rate_of``), so the lower end
    rises by more than the bracket is halved; the cone data are assembled once for each choice of
    units, and only the number of the rate is changed in them.

    Attributes
    ----------
    limited : a candidate that shows ``low``, or the no at the start.
    low : decay rate in 1/s; -inf without gains.
    high : a rate in 1/s for which there are none, to solver accuracy; inf when none was met.  A
        rate that no solver settled ends the search, but is none.
    """

    def __init__(
        self, task: DecayRequest, relaxation: str | Relaxation, *, start: float = 0.0
    ) -> None:
        self.limited = decided(task, start, relaxation)
        self.low, self.high, self._end = -np.inf, np.inf, np.inf
        self._relaxation, self._session = relaxation, Session()
        step, status = task.sample_time, self.limited.outcome.status
        self._most = np.inf if step is None else float(-np.log(LEAST_CONTRACTION) / (2.0 * step))
        if status == "infeasible":
            self.high = start
        elif status == "candidate":
            self.low = min(rate_of(self.limited), self._most)
            self._run(start)

    def _run(self, start: float) -> None:
        """Rise in growing steps until there are no gains, then halve."""
        task = self.limited.task
        # The natural size of a decay rate of these vertices in 1/s.
        unit = size_of_motion(task.A, task.decay_rate, task.sample_time) / 2
        unit /= task.sample_time or 1.0
        # A start other than zero is a good guess.
        step = max(self.low - start, (0.1 if start == 0 else 1e-3) * unit)
        for _ in range(STEPS):
            # Near a rate of zero a relative width would never be reached.
            width = TOLERANCE * max(abs(self.low), 1e-3 * unit)
            if self.low >= self._most or self._end - self.low <= width:
                return
            rising = not np.isfinite(self._end)
            self._look(min(self._most, self.low + step) if rising else (self.low + self._end) / 2)
            step *= 2.0

    def _look(self, rate: float) -> None:
        here = self._in_fit_units(rate)
        outcome = decide(
            here.condition,
            rows={"nu": EFFORTS[-1]},
            session=self._session,
            assembled=here.data,
            most=1,
        )
        limited = replace(here, outcome=outcome)
        if outcome.status == "unknown" or stopped_by_limit(limited):
            # One solver in one choice of units did not settle it: ask more of both.
            limited = decided(here.task, rate, self._relaxation, most=FEW_SOLVERS)
        if limited.outcome.status != "candidate":
            self._end = rate
            if limited.outcome.status == "infeasible":
                self.high = rate
            return
        self.limited = limited
        self.low = max(rate, min(rate_of(self.limited), self._most))
        if self.low >= self.high:
            # Within the solver's tolerances of the end; what was checked by eigenvalues counts.
            self.high = np.inf

    def _in_fit_units(self, rate: float) -> LimitedOutcome:
        """Return the candidate with another rate; posed anew where its Q is lopsided."""
        best = self.limited
        diagonal = np.diag(best.outcome.values["Q"][0])
        if diagonal.max() > SPREAD**2 * diagonal.min():
            task = best.task.in_units_of(best.outcome.values["Q"][0])
            condition = task.condition(rate, self._relaxation)
            return LimitedOutcome(task, condition, assemble(condition), best.outcome, EFFORTS[-1])
        number = rate_parameter(rate, best.task.sample_time)
        condition = best.condition.with_parameters(**number)
        data = replace(best.data, condition=condition)
        return replace(best, condition=condition, data=data, effort=EFFORTS[-1])


def design_at_largest(task: DecayRequest, relaxation: str, *, start: float = 0.0) -> Design:
    """Return gains for 1e-4 less than the largest decay rate; the answer's bound is above it."""
    bracket = Largest(task, relaxation, start=start)
    if not np.isfinite(bracket.low):
        return design_at(task, start, relaxation)
    alpha = bracket.low - BACK * abs(bracket.low)
    design = design_at(bracket.limited.task, alpha, relaxation)
    if not design.found:
        design = design_of(bracket.limited, bracket.low, relaxation)
    return replace(design, answer=replace(design.answer, bound=bracket.high))


# A decay rate in 1/s, or the largest there is.
Goal: TypeAlias = float | Literal["max"]

# Relaxations without gains, or with a smaller rate, before the rate that any relaxation can have is
# bounded.
BEFORE_OUTER = 2
FEW_BLENDS = 40
# A rate as near as this to what no relaxation exceeds does not justify another relaxation.
NOTHING_LEFT = 1e-3


@dataclass(slots=True, eq=False)
class RelaxationSearch:
    """What was tried so far.

    Attributes
    ----------
    results : results of the relaxations, in the order in which they were tried.
    designs : of those that were tried.
    no : why no relaxation has gains, where that was found.
    largest_rate : decay rate in 1/s that no relaxation exceeds, to solver accuracy; nan until it
        was looked for, inf where that did not settle it.
    """

    results: list[RelaxationResult] = field(default_factory=list)
    designs: list[Design] = field(default_factory=list)
    no: Design | None = None
    largest_rate: float = np.nan

    @property
    def best(self) -> Design | None:
        """Return the design of the largest rate; of equal ones the first, which is the cheapest."""
        designs = [design for design in self.designs if design.found]
        return max(designs, key=lambda design: design.decay_rate, default=None)


def default_relaxations(task: DecayRequest) -> tuple[str, ...]:
    """Return the relaxations that apply, by the work of one iteration."""
    if len(task.A) == 1:
        return ("common-gain",)
    names = NAMES + (PRODUCTS if len(task.premises) > 1 else ())
    return tuple(sorted(names, key=lambda name: work_of(_size(task, name))))


def search_relaxations(task: DecayRequest, goal: Goal) -> RelaxationSearch:
    """Try the relaxations until there are gains; for "max", until none can have 0.1 % more.

    A relaxation is left out where a theorem settles it or its size is too large.  After two, the
    condition at single blends is looked at where it can say something: every relaxation implies it,
    so where it has no unknowns, no further relaxation has gains, and the rate that it has, none
    exceeds.

    ``goal`` : decay rate in 1/s, or "max".
    """
    search = RelaxationSearch()
    for position, name in enumerate(default_relaxations(task)):
        if position == BEFORE_OUTER and len(task.A) > 1 and (goal == "max" or search.best is None):
            _look_outside(search, task, goal)
        if _enough(search, goal):
            break
        reason = _reason_to_skip(search, task, name)
        if reason:
            search.results.append(_result(task, name, "not tried", reason))
        else:
            _try(search, task, goal, name)
    return search


def _enough(search: RelaxationSearch, goal: Goal) -> bool:
    best = search.best
    if best is None or goal != "max":
        return best is not None
    return best.decay_rate >= (1.0 - NOTHING_LEFT) * search.largest_rate


def _reason_to_skip(search: RelaxationSearch, task: DecayRequest, name: str) -> str:
    size = _size(task, name)
    if work_of(size) > MOST_WORK:
        return f"too large: {_count(size.lmis)} LMIs, the widest {size.width}"
    if search.no is not None:
        return "no relaxation has gains"
    for result in search.results:
        if result.status == "infeasible" and contains(result.relaxation, name):
            return f"{result.relaxation} contains it and has no gains"
    return ""


def _try(search: RelaxationSearch, task: DecayRequest, goal: Goal, name: str) -> None:
    started = time.perf_counter()
    # Gains of a relaxation that this one contains are gains for this one.
    served = [d for d in search.designs if d.found and contains(name, d.relaxation)]
    if goal == "max":
        start = max((design.decay_rate for design in served), default=0.0)
        design = design_at_largest(task, name, start=start)
        rate = design.decay_rate
    else:
        design = design_at(task, goal, name)
        rate = design.answer.decay_rate or goal
    status: RelaxationStatus = design.status
    if status == "infeasible" and served:
        status = "unknown"
    result = _result(task, name, status)
    search.results.append(
        replace(
            result,
            seconds=time.perf_counter() - started,
            margin=design.margin,
            decay_rate=rate if design.found else None,
        )
    )
    search.designs.append(design)


def _look_outside(search: RelaxationSearch, task: DecayRequest, goal: Goal) -> None:
    """Solve the condition at single blends, about as large as that of all pairs."""
    started = time.perf_counter()
    # The finest grid of blends that is about as large as all pairs of rules.
    r, corners = len(task.A), corners_of(task)
    pair_count = max(triangle(r), FEW_BLENDS)
    fine = (p for p in (6, 5, 4, 3) if number_of_points(r, corners, p) <= pair_count)
    pose = at_points(next(fine, 2))
    if goal == "max":
        bracket = Largest(task, pose, start=0.0 if search.best is None else search.best.decay_rate)
        limited, search.largest_rate = bracket.limited, bracket.high
    else:
        limited = decided(task, goal, pose)
    settled_no = limited.outcome.status == "infeasible" and search.best is None
    blends = [lmi for lmi in limited.condition.lmis if lmi.name.endswith("blend")]
    count = sum(lmi.count for lmi in blends)
    result = RelaxationResult(
        relaxation=ANY,
        status="infeasible" if settled_no else "bound",
        lmis=count,
        variables=task.B.size,
        width=max(lmi.size for lmi in blends),
        seconds=time.perf_counter() - started,
        margin=limited.outcome.margin,
        decay_rate=search.largest_rate
        if np.isfinite(search.largest_rate) and not settled_no
        else None,
        note=f"at {_count(count)} blends",
    )
    search.results.append(result)
    if settled_no:
        search.no = design_of(limited, 0.0 if goal == "max" else goal, ANY)


def _result(
    task: DecayRequest, name: str, status: RelaxationStatus, note: str = ""
) -> RelaxationResult:
    size = _size(task, name)
    gains = task.B.size // (len(task.A) if name == "common-gain" else 1)
    return RelaxationResult(
        relaxation=name,
        status=status,
        lmis=size.lmis,
        variables=gains + size.slack_variables,
        width=size.width,
        note=note,
    )


def _size(task: DecayRequest, name: str) -> RelaxationSize:
    """Return the size of all double sums together."""
    loops = double_sums(task, task.decay_rate, name, task.region, task.sample_time)[2]
    sizes = [size_of(name, loop) for loop in loops]
    cones = tuple(cone for size in sizes for cone in size.cones)
    return RelaxationSize(cones, sum(size.slack_variables for size in sizes))


def _count(number: int) -> str:
    return f"{number:,}".replace(",", " ")


@warns_of_zero_gains
def pdc(
    model: Controlled,
    *,
    decay_rate: Goal = 0.0,
    relaxation: str = "wang-tanaka-griffin",
    input_limit: ArrayLike | None = None,
    initial_box: ArrayLike | None = None,
    state_box: ArrayLike | None = None,
    gain_bound: float | None = None,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
    region: EigenvalueRegion | None = None,
) -> Design:
    """Return gains K_i for u = -sum_i h_i K_i x with V' <= -2 alpha V, V = x' P x.

    In discrete time V(x+) <= e^(-2 alpha T) V(x).  First the largest margin (of very many pairs: at
    least half of it) decides whether there are gains; then, at half that margin, those of least
    input effort are taken.

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    decay_rate : alpha in 1/s that must hold; or "max", for the largest.  That needs bounded gains
        (gain_bound, or input_limit with initial_box), for without a bound there
        may be no largest; the gains are designed 1e-4 below it.
    relaxation : "common-gain", "wang-tanaka-griffin" (all pairs), "tanaka-wang", "tuan",
        "kim-lee", "liu-zhang" or "polya-<d>", roughly from cheap to rich; "product-<d>" or
        "product-liu-zhang" where premises are known.  "auto" tries one after another, and takes
        the first that has gains (of decay rate "max": of the largest rate).
    input_limit : (m,) with |u_k| <= input_limit_k wherever x' P x <= 1.
    initial_box : (n,) half-widths, 0 for a state at rest; the box lies inside x' P x <= 1.
    state_box : (n,) half-widths, inf for none; x' P x <= 1 lies inside the box.  In discrete time
        nothing is said of a plant between its samples.
    gain_bound : bound on the spectral norm of every K_i, by a sufficient condition: "max" is the
        largest rate that this condition has, gains of that norm may do better.
    scales : (n,) engineering range of each state; None takes the boxes, or balances.
    sample_time : T in s of x+ = A x + B u; None takes the model's own.
    region : where all eigenvalues lie while the memberships stand still, an
        ``EigenvalueRegion``; in 1/s, of
        x+ = A x without unit.  Of moving memberships it says what its quadratic function does.

    Returns a ``Design``; without gains its answer says which rules bind and what to relax.  The
    answer's ``decay_rate`` is what its unknowns show, at least what was asked for; of "max", its
    ``bound`` is a rate that there are no gains for, to solver accuracy: next to the design's,
    further off where the rates between were not settled, inf where no rate was ruled out (in
    discrete time a loop may reach zero in one step: rates end where V falls by 1e-8 in a sample).
    With "auto" ``ladder`` says what was tried.  Gains that do nothing beside the plant itself bring
    a ``ZeroGainsWarning``.  Nothing is proved here.

    Raises ModelError: shapes, numbers, an unknown relaxation, inputs that are dependent or do
    nothing, a vertex with an unstable mode that no input moves, "max" without bounded gains.

    Source: Tanaka and Wang (2001), chapter 3.
    """
    if relaxation != "auto":
        relaxation_named(relaxation)
    largest = isinstance(decay_rate, str) and decay_rate == "max"
    goal: Goal = "max" if largest else float(number("decay_rate", decay_rate))
    limits = GivenLimits(
        input_limit=input_limit,
        initial_box=initial_box,
        state_box=state_box,
        gain_bound=gain_bound,
        scales=scales,
        sample_time=sample_time,
        region=region,
    )
    task = decay_request(model, limits, decay_rate=0.0 if goal == "max" else goal)
    unbounded = task.limits.inputs is None or task.limits.initial is None
    if goal == "max" and task.limits.gain is None and unbounded:
        raise ModelError(
            'decay_rate is "max", but nothing bounds the gains, so there may be no largest decay '
            "rate; give gain_bound, or input_limit with initial_box"
        )
    if relaxation == "auto":
        return _first_gains(task, goal)
    if goal == "max":
        return design_at_largest(task, relaxation)
    return design_at(task, goal, relaxation)


def _first_gains(task: DecayRequest, goal: Goal) -> Design:
    search = search_relaxations(task, goal)
    best = search.best
    if best is None:
        best = search.designs[-1] if search.no is None else search.no
        reason = best.answer.diagnosis
        if search.no is None:
            untried = [r.relaxation for r in search.results if r.status == "not tried"]
            skipped = f" (not tried: {', '.join(untried)})" if untried else ""
            names = ", ".join(design.relaxation for design in search.designs)
            reason = f"no gains by any of {names}{skipped}; of the last, {reason}"
        best = replace(best, relaxation="auto", answer=replace(best.answer, diagnosis=reason))
    return replace(best, ladder=tuple(search.results))
