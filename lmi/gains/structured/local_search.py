"""A local search for structured gains from several starts; no step makes the value worse."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from takagi.lmi.analysis.common_quadratic import lyapunov
from takagi.lmi.analysis.disturbance.guessed_function import bounded_real
from takagi.lmi.cone.balance import state_units
from takagi.lmi.gains.descent.many_starts import Found, GainLoops, best_gains
from takagi.lmi.gains.structured.joint_steps import StepSearch, StructuredPoint
from takagi.models.arrays import Floats

# The number of steps to find a stable loop, and the number of steps to give it a decay margin.
TOWARDS_DECAY, WITH_ROOM = 30, 2
# Each start takes at most this many steps and stops at such a relative gain; then only the best
# starts go on, and the last number says how many.
EXPLORED, ENOUGH, PURSUED = 15, 3e-4, 2
MOST_STEPS = 80
# The shares of the margin (cost, gamma) or of the rate that are kept free, one after the other. The
# larger share comes first because it keeps P well conditioned; the smaller one comes nearer to the
# optimum.
LEVELS = ((1e-6, 3e-2), (1e-6, 3e-3), (1e-7, 1e-4))
# Factors of the spread s that are tried, relative to the one that gave the best step.
SPREAD_FACTORS = (1.0, 3.0, 1.0 / 3.0)
# Relative gain of a cost or gamma with which no other spread is tried.  The largest decay rate is
# where eigenvalues coincide, and there a long first step often leads to a worse result.
GOOD = 1e-2
# How often a step is doubled.
DOUBLED = 3


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
        points: list[tuple[StructuredPoint, str]] = []
        for start in starts:
            spot = self.begun(start)
            if spot is not None:
                coarse = _at(self.search, LEVELS[0])
                spot = self._risen(coarse, spot, start.name, EXPLORED, ENOUGH)
                points.append((spot, start.name))
        sense = self.search.sense
        points.sort(key=lambda pair: -sense * pair[0].value)
        ends = []
        for spot, name in points[:PURSUED]:
            for level in LEVELS:
                finer = _at(self.search, level)
                spot = self._risen(finer, spot, name, MOST_STEPS, tolerance)
            ends.append(spot)
        return max(ends, key=lambda spot: sense * spot.value) if ends else None

    def reached(self) -> float:
        """Return the largest decay rate that any start reached; -inf if none was found."""
        rates = [step.value for step in self.steps if step.objective == "decay_rate"]
        return max(rates, default=-np.inf)

    def begun(self, start: LocalStart, enough: float = 0.0) -> StructuredPoint | None:
        """Return a stable point with a decay margin; the given gains need not be stable.

        ``enough`` : a decay rate [1/s] that ends the search; less is returned where it is not met.
        """
        search = self.search
        decay = _at(replace(search, objective="decay_rate"), LEVELS[0])
        spot = decay.assessed(decay.bounded(start.F), start.P)
        if spot is None:
            return None
        self.steps.append(LocalStep(start.name, "decay_rate", spot.value))
        spread, room = 1.0, WITH_ROOM if spot.value <= 0 else 0
        for count in range(TOWARDS_DECAY):
            if spot.value > enough and count >= room:
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
        self, search: StepSearch, spot: StructuredPoint, name: str, step_count: int, enough: float
    ) -> StructuredPoint:
        """Return the point after ``step_count`` steps, or where a step gains at most ``enough``."""
        spread = 1.0
        for _ in range(step_count):
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
        for factor in SPREAD_FACTORS:
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
    required_margin, fine = level
    return replace(search, required_margin=required_margin, fine=fine)


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


# How far above the norm the first function may be, relative; it only sets units.
ROOM = 1e-2


def descended(
    search: StepSearch, named_starts: Sequence[LocalStart], *, starts: int, seed: int
) -> list[LocalStart]:
    """Return starts of least norm, the best first: of the vertices' own loops, rule by rule.

    With one rule the norm is that of the loop.  With several it is the largest of the loops
    A_i - B_i K_i, a lower bound of what one function can show for all blends.
    """
    plant = search.plant
    r, n, q = plant.E.shape
    C = np.broadcast_to(search.structure.C, (r, len(search.structure.C), n))
    bound = search.gain_bound

    def allowed(F: Floats) -> bool:
        if bound is None:
            return True
        return bool(np.linalg.norm(F @ search.structure.C, 2, axis=(1, 2)).max() <= bound)

    loops = GainLoops(
        A=plant.A,
        B1=plant.E,
        B2=-plant.B,
        C1=plant.C,
        C2=np.array(C),
        D11=plant.D11,
        D12=-plant.D12,
        D21=np.zeros((r, C.shape[1], q)),
        pattern=search.structure.pattern,
        group=search.structure.group,
        discrete=plant.sample_time is not None,
        allowed=allowed,
    )
    ends = best_gains(
        loops,
        [(start.name, search.bounded(start.F)) for start in named_starts],
        starts=starts,
        seed=seed,
    )
    return [LocalStart(f"descent from {end.start}", end.F, _function(search, end)) for end in ends]


def shown(
    search: StepSearch, starts: Sequence[LocalStart]
) -> tuple[StructuredPoint | None, list[LocalStep]]:
    """Return the best point of given gains, with the function found for them, and a step of each.

    The gains stay as they are.
    """
    best: StructuredPoint | None = None
    steps = []
    for start in starts:
        spot = search.assessed(start.F, start.P)
        if spot is None:
            continue
        # In the states of this function the solver's numbers are near 1.
        spot = search.assessed(spot.F, spot.P, value=spot.value) or spot
        steps.append(LocalStep(start.name, search.objective, spot.value))
        if best is None or spot.value < best.value:
            best = spot
    return best, steps


def _function(search: StepSearch, end: Found) -> Floats:
    """Return P of about the right shape: of one loop by its Riccati or Lyapunov equation."""
    plant = search.plant
    K = search.structure.gains(end.F)
    A, C = plant.A - plant.B @ K, plant.C - plant.D12 @ K
    n = A.shape[1]
    step = plant.sample_time
    plain = np.diag(state_units(plant.A, None, step=step) ** -2.0)
    if len(A) > 1:
        return plain
    P = None
    if step is None:
        P = bounded_real(A[0], plant.E[0], C[0], plant.D11[0], tolerance=ROOM)
    if P is None:
        # A small multiple of I makes P definite where some states do not reach z.
        weight = C[0].T @ C[0] + 1e-6 * max(float(np.trace(C[0].T @ C[0])), 1e-300) * np.eye(n)
        P = lyapunov(A[0], weight, step)
    return P if P is not None and np.isfinite(P).all() and np.linalg.eigvalsh(P)[0] > 0 else plain
