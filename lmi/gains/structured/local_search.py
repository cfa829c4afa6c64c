"""A local search for structured gains from several starts; no step makes the value worse."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from takagi.lmi.argument_checks import corners_of
from takagi.lmi.cone.balance import motion, state_units
from takagi.lmi.decision.decide import decide
from takagi.lmi.gains.structured.joint_steps import StepSearch, StructuredPoint
from takagi.lmi.gains.structured.slack_matrix import slack_condition, slack_gains
from takagi.models.arrays import Floats

# The number of steps to find a stable loop, and the number of steps to give it a decay margin.
TOWARDS_DECAY, WITH_ROOM = 30, 2
# Each start takes at most this many steps and stops at such a relative gain; then only the best
# starts go on, and the last number says how many.
EXPLORED, ENOUGH, PURSUED = 15, 3e-4, 2
MOST = 80
# The shares of the margin (cost, gamma) or of the rate that are kept free, one after the other. The
# larger share comes first because it keeps P well conditioned; the smaller one comes nearer to the
# optimum.
LEVELS = ((1e-6, 3e-2), (1e-6, 3e-3), (1e-7, 1e-4))
# Factors of the spread s that are tried, relative to the one that gave the best step.
ABOUT = (1.0, 3.0, 1.0 / 3.0)
# Relative gain of a cost or gamma with which no other spread is tried.  The largest decay rate is
# where eigenvalues coincide, and there a long first step often leads to a worse result.
GOOD = 1e-2
# How often a step is doubled.
DOUBLED = 3
# The values of mu that ``slack_start`` tries, in units of 1 / size of the vertices.
MUS = (0.1, 0.3, 1.0, 3.0)


@dataclass(frozen=True, slots=True)
class LocalStep:
    """One accepted step: its start, what it improved, and the value that it reached."""

    start: str
    objective: str
    value: float


@dataclass(frozen=True, slots=True, eq=False)
class LocalStart:
    """Gains F to begin with, and P (n, n) of about the size of their Lyapunov function."""

    name: str
    F: Floats
    P: Floats


@dataclass(frozen=True, slots=True, eq=False)
class LocalSearch:
    """The search with the table of its steps; each accepted step adds a row."""

    search: StepSearch
    steps: list[LocalStep] = field(default_factory=list)

    def best(self, starts: Sequence[LocalStart], tolerance: float) -> StructuredPoint | None:
        """Return the best point that the starts lead to; None if none leads to a stable loop."""
        found: list[tuple[StructuredPoint, str]] = []
        for start in starts:
            spot = self._begun(start)
            if spot is not None:
                coarse = _at(self.search, LEVELS[0])
                spot = self._risen(coarse, spot, start.name, EXPLORED, ENOUGH)
                found.append((spot, start.name))
        sense = self.search.sense
        found.sort(key=lambda pair: -sense * pair[0].value)
        ends = []
        for spot, name in found[:PURSUED]:
            for level in LEVELS:
                finer = _at(self.search, level)
                spot = self._risen(finer, spot, name, MOST, tolerance)
            ends.append(spot)
        return max(ends, key=lambda spot: sense * spot.value) if ends else None

    def reached(self) -> float:
        """Return the largest decay rate that any start reached; -inf if none was found."""
        rates = [step.value for step in self.steps if step.objective == "decay_rate"]
        return max(rates, default=-np.inf)

    def _begun(self, start: LocalStart) -> StructuredPoint | None:
        """Return a stable point with a decay margin; the given gains need not be stable."""
        search = self.search
        decay = _at(replace(search, objective="decay_rate"), LEVELS[0])
        spot = decay.assessed(decay.bounded(start.F), start.P)
        if spot is None:
            return None
        self.steps.append(LocalStep(start.name, "decay_rate", spot.value))
        spread, room = 1.0, WITH_ROOM if spot.value <= 0 else 0
        for count in range(TOWARDS_DECAY):
            if spot.value > 0 and count >= room:
                break
            better, spread = self._stepped(decay, spot, spread)
            if better is None:
                break
            self.steps.append(LocalStep(start.name, "decay_rate", better.value))
            spot = better
        if spot.value <= 0:
            return None
        if search.objective == "decay_rate":
            return spot
        P, value = search.guessed(spot)
        return search.assessed(spot.F, P, value=value)

    def _risen(
        self, search: StepSearch, spot: StructuredPoint, name: str, most: int, enough: float
    ) -> StructuredPoint:
        """Return the point after ``most`` steps, or where a step gains at most ``enough``."""
        spread = 1.0
        for _ in range(most):
            better, spread = self._stepped(search, spot, spread)
            if better is None:
                break
            gained = search.sense * (better.value - spot.value)
            self.steps.append(LocalStep(name, search.objective, better.value))
            spot = better
            if gained <= enough * abs(spot.value):
                break
        return spot

    def _stepped(
        self, search: StepSearch, spot: StructuredPoint, spread: float
    ) -> tuple[StructuredPoint | None, float]:
        """Return the best point of a few spreads, None if no spread is better, and its spread."""
        best, at = None, spread
        for factor in ABOUT:
            F = search.moved(spot, spread * factor)
            new = None if F is None else search.assessed(F, spot.P, value=spot.value)
            if new is None or not search.sense * (new.value - spot.value) > 0:
                continue
            if best is None or search.sense * (new.value - best.value) > 0:
                best, at = new, spread * factor
            if search.sense < 0 and spot.value - best.value > GOOD * abs(spot.value):
                break
        return (best if best is None else _further(search, spot, best)), at


def _at(search: StepSearch, level: tuple[float, float]) -> StepSearch:
    held, fine = level
    return replace(search, held=held, fine=fine)


def _further(search: StepSearch, spot: StructuredPoint, best: StructuredPoint) -> StructuredPoint:
    """Return the best point beyond a step; the inner approximation makes steps too short."""
    direction, length = best.F - spot.F, 1.0
    for _ in range(DOUBLED):
        length *= 2.0
        F = search.bounded(spot.F + length * direction)
        new = search.assessed(F, best.P, value=best.value)
        if new is None or not search.sense * (new.value - best.value) > 0:
            break
        best = new
    return best


def slack_start(search: StepSearch) -> Iterator[LocalStart]:
    """Yield the gains of largest margin by ``slack_condition`` over a few mu, if any exist."""
    plant, structure = search.plant, search.structure
    step = plant.sample_time
    s = state_units(plant.A, None, step=step)
    A, B = plant.A * s / s[:, None], plant.B / s[:, None]
    size = float(np.linalg.norm(motion(A, step), 2, axis=(1, 2)).max()) or 1.0
    reach = np.abs(B).max(axis=(0, 1))
    tau = size / np.where(reach > 0, reach, 1.0)
    C = structure.C * s
    sizes = np.linalg.norm(C, axis=1)
    same = np.array_equal(structure.C, np.eye(len(s)))
    inside = replace(structure, C=np.eye(len(s)) if same else C / sizes[:, None])
    scale = np.ones(len(s)) / s if same else 1.0 / sizes
    best, F = 0.0, None
    for mu in MUS if step is None else MUS[:1]:
        condition = slack_condition(
            A,
            B * tau,
            inside,
            search.relaxation,
            mu=mu / size,
            step=step,
            corners=corners_of(plant),
        )
        outcome = decide(condition, most=1)
        search.tries.extend(outcome.tries)
        if outcome.status == "candidate" and outcome.margin > best:
            best, F = outcome.margin, slack_gains(outcome.values, inside)
    if F is not None:
        yield LocalStart("slack matrix", F * tau[:, None] * scale, np.diag(s**-2.0))
