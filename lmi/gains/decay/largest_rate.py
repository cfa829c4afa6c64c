"""The largest decay rate that one relaxation has gains for, between a yes and a no."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from takagi.lmi.answer import Design
from takagi.lmi.argument_checks import rate_parameter
from takagi.lmi.cone.assemble import assemble
from takagi.lmi.decision.decide import decide
from takagi.lmi.gains.decay.condition import size_of_motion
from takagi.lmi.gains.decay.design import (
    EFFORTS,
    LimitedOutcome,
    decided,
    design_at,
    design_of,
    rate_of,
    stopped_by_limit,
)
from takagi.lmi.gains.decay.request import DecayRequest
from takagi.lmi.solver.solve import Session
from takagi.lmi.sums.relaxations import Relaxation

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


@dataclass(frozen=True, slots=True, eq=False)
class Largest:
    """The best unknowns found, with the rates between which the largest one lies.

    Attributes
    ----------
    limited : a candidate that shows ``low``, or the no at the start.
    low : decay rate in 1/s; -inf without gains.
    high : a rate in 1/s for which there are none, to solver accuracy; inf when none was met.  A
        rate that no solver settled ends the search, but is none.
    """

    limited: LimitedOutcome
    low: float
    high: float


def largest(task: DecayRequest, relaxation: str | Relaxation, *, start: float = 0.0) -> Largest:
    """Return the bracket of the largest decay rate, from ``start`` in 1/s upwards.

    A candidate shows a rate above the one it was asked for (``rate_of``), so the lower end
    rises by more than the bracket is halved; the cone data are assembled once for each choice of
    units, and only the number of the rate is changed in them.
    """
    first = decided(task, start, relaxation)
    if first.outcome.status != "candidate":
        settled = first.outcome.status == "infeasible"
        return Largest(first, -np.inf, start if settled else np.inf)
    search = _Search(first, relaxation)
    search.run(start)
    return Largest(search.best, search.low, search.none)


def design_at_largest(
    task: DecayRequest, relaxation: str, *, start: float = 0.0
) -> tuple[Design, Largest]:
    """Return gains for 1e-4 less than the largest decay rate, and the bracket."""
    bracket = largest(task, relaxation, start=start)
    if not np.isfinite(bracket.low):
        return design_at(task, start, relaxation), bracket
    alpha = bracket.low - BACK * abs(bracket.low)
    design = design_at(bracket.limited.task, alpha, relaxation)
    if not design.found:
        design = design_of(bracket.limited, bracket.low, relaxation)
    answer = replace(design.answer, bound=bracket.high)
    return replace(design, answer=answer), bracket


class _Search:
    """The bracket so far, with the cone data that the next rate is put into."""

    def __init__(self, first: LimitedOutcome, relaxation: str | Relaxation) -> None:
        self.best, self.most = first, _most(first.task)
        self.low, self.high, self.none = min(rate_of(first), self.most), np.inf, np.inf
        self._relaxation, self._session = relaxation, Session()
        self._effort = {"nu": EFFORTS[-1]}

    def run(self, start: float) -> None:
        """Rise in growing steps until there are no gains, then halve."""
        unit = _unit_of_rate(self.best.task)
        # A start other than zero is a good guess.
        step = max(self.low - start, (0.1 if start == 0 else 1e-3) * unit)
        for _ in range(STEPS):
            # Near a rate of zero a relative width would never be reached.
            width = TOLERANCE * max(abs(self.low), 1e-3 * unit)
            if self.low >= self.most or self.high - self.low <= width:
                return
            rising = not np.isfinite(self.high)
            self._look(min(self.most, self.low + step) if rising else (self.low + self.high) / 2)
            step *= 2.0

    def _look(self, rate: float) -> None:
        here = self._in_fit_units(rate)
        outcome = decide(
            here.condition, rows=self._effort, session=self._session, assembled=here.data, most=1
        )
        limited = replace(here, outcome=outcome)
        if outcome.status == "unknown" or stopped_by_limit(limited):
            # One solver in one choice of units did not settle it: ask more of both.
            limited = decided(here.task, rate, self._relaxation, most=FEW_SOLVERS)
        if limited.outcome.status != "candidate":
            self.high = rate
            if limited.outcome.status == "infeasible":
                self.none = rate
            return
        self.best = limited
        self.low = max(rate, min(rate_of(self.best), self.most))
        if self.low >= self.none:
            # Within the solver's tolerances of the end; what was checked by eigenvalues counts.
            self.none = np.inf

    def _in_fit_units(self, rate: float) -> LimitedOutcome:
        """Return the best with another rate in its data; posed anew where its Q is lopsided."""
        best = self.best
        diagonal = np.diag(best.outcome.values["Q"][0])
        if diagonal.max() > SPREAD**2 * diagonal.min():
            task = best.task.in_units_of(best.outcome.values["Q"][0])
            condition = task.condition(rate, self._relaxation)
            return LimitedOutcome(task, condition, assemble(condition), best.outcome, EFFORTS[-1])
        number = rate_parameter(rate, best.task.sample_time)
        condition = best.condition.with_parameters(**number)
        data = replace(best.data, condition=condition)
        return replace(best, condition=condition, data=data, effort=EFFORTS[-1])


def _unit_of_rate(task: DecayRequest) -> float:
    """Return the natural size of a decay rate of these vertices in 1/s."""
    size = size_of_motion(task.A, task.decay_rate, task.sample_time) / 2
    return size if task.sample_time is None else size / task.sample_time


def _most(task: DecayRequest) -> float:
    if task.sample_time is None:
        return np.inf
    return float(-np.log(LEAST_CONTRACTION) / (2.0 * task.sample_time))
