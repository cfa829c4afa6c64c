r"""The least H2 norm of one rule, from the regulator's Riccati equation instead of a program.

With one rule the least mean of |z|^2 under white noise is the regulator's cost: gains K from the
Riccati equation with the weights of |z|^2, and a little on every state and input where z leaves
them free.  No program is solved, but the result has the form of one:

    unknowns      Q = P^-1, M = K Q, where P solves A_K' P + P A_K + C_K' C_K + delta R = 0
    multipliers   Y = [P; C_K] W [P; C_K]' of -Theta > 0, and [I; -P E] [I; -P E]' of the noise's,
                  where W solves A_K W + W A_K' + E E' = 0

with A_K = A - B K, C_K = C - D K.  They are stationary in Q by the two Lyapunov equations, and in M
where (B' P + D' C_K) W P = 0, which is the regulator's own condition.  The LMIs are evaluated at
the unknowns and the bound at the multipliers as after any solver.  The dual of the program is that
of Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.4; of its solution Balakrishnan and
Vandenberghe (2003), IEEE Trans. Automatic Control 48(1).

A bound on the least H2 norm of one rule from below, by the other of its two programs.

The least mean of |z|^2 is also the least trace of V with

    -He(A X - B L) - E E' >= 0        [ V   C X - D L ]
                                      [ .   X         ]  >= 0,

X the controllability Gramian, L = K X.  Where the infimum is approached by ever larger gains,
these unknowns stay bounded while those of ``output_variance`` do not: the multipliers of this
program are good there.  Its gains are not taken: a design needs the unknowns of the other one.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.4.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import islice

import numpy as np

from takagi.lmi.answer import Try
from takagi.lmi.condition.evaluate import holds, margin
from takagi.lmi.condition.statements import pose
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import state_units
from takagi.lmi.cone.cone_program import (
    Assembled,
    ConeProgram,
    Raw,
    assemble,
    cone_program,
    least_objective_bound,
    pack,
)
from takagi.lmi.decision.outcome import Outcome, promised
from takagi.lmi.expressions.expression import He, block, matrix, trace
from takagi.lmi.gains.disturbance.disturbed_plant import DisturbedPlant
from takagi.lmi.gains.disturbance.request import (
    DisturbanceCoordinates,
    DisturbanceRequest,
    guessed_regulator,
    is_definite,
)
from takagi.lmi.solver.solve import attempts, rescaled
from takagi.models.arrays import Floats

# Solvers that are asked, and how often each is asked again where its own solution is of order one.
SOLVERS, RESCALED = 4, 2


def least_variance(plant: DisturbedPlant, enough: float) -> float:
    """Return the highest bound that any multipliers give, or the first that is enough.

    For one rule in continuous time without a direct path; in the square of z's unit over w's.
    In balanced states and in the plant's own: which are better is not known before.
    """
    best = -np.inf
    n, m = plant.A.shape[1], plant.B.shape[2]
    balanced = state_units(plant.A, None)
    for s in (balanced, np.ones(n)):
        A, B, E, C = (
            plant.A[0] * s / s[:, None],
            plant.B[0] / s[:, None],
            plant.E[0] / s[:, None],
            plant.C[0] * s,
        )
        size = float(np.linalg.norm(C, 2)) or 1.0
        pushed = np.linalg.norm(B, axis=0) / (np.linalg.norm(A, 2) or 1.0)
        output_sizes = np.linalg.norm(plant.D12[0], axis=0) / size
        tau = 1.0 / np.maximum(pushed, output_sizes) if s is balanced else np.ones(m)
        condition = _gramian_condition(A, B * tau, E, C / size, plant.D12[0] * tau / size)
        data = assemble(condition)
        program = cone_program(data, data.objective, (), margin=0.0)
        for raw in _answers(program):
            best = max(best, size**2 * least_objective_bound(program, raw))
            if best >= enough:
                return best
    return best


def _answers(program: ConeProgram) -> Iterator[Raw]:
    """Yield one solver's answer after another, the first also in units of its own solution."""
    for number, raw in enumerate(islice(attempts(program), SOLVERS)):
        yield raw
        next_raw: Raw | None = raw
        for _ in range(RESCALED if number == 0 else 0):
            next_raw = None if next_raw is None else rescaled(program, next_raw)
            if next_raw is not None:
                yield next_raw


def _gramian_condition(A: Floats, B: Floats, E: Floats, C: Floats, D: Floats) -> Condition:
    n, m, p = len(A), B.shape[1], len(C)
    X, L = Unknown("X", n, n, symmetric=True), Unknown("L", m, n)
    V = Unknown("V", p, p, symmetric=True)
    loop = He(matrix(B, "B") @ L - matrix(A, "A") @ X)
    output = block([[V, matrix(C, "C") @ X - matrix(D, "D") @ L], [None, X]])
    return pose(
        (loop >= matrix(E @ E.T, r"E E^\top")).named("Gramian"),
        (output >= 0).named("output"),
        minimise=trace(V),
        unknowns=(X, L, V),
        name="controllability Gramian",
    )


# Weights of states and inputs that z leaves free, shares of the largest in z: none where z leaves
# none free; else the largest that does leaves the smallest gains.
LADDER = (0.0, 1e-8, 1e-10, 1e-12, 1e-14, 1e-16)
# The share of the tolerance that is given for a margin of the LMIs, for that of W and of nu.
SHARES = (0.25, 0.05, 0.05)
# Weight at which a regulator's cost has the natural size of a plant's, and the share of that which
# cannot be distinguished from zero.
ALL, NOTHING = 1.0, 1e-9


def regulated(task: DisturbanceRequest) -> tuple[DisturbanceCoordinates, Condition, Outcome] | None:
    """Return gains within the tolerance of the least objective, or of nothing where that is zero.

    None where the task is another one (several rules, discrete time, limits, a rate or region), or
    where no weight leads there: the infimum of singular plants is reached by no gains.
    """
    plant = task.plant
    alone = len(plant.A) == 1 and plant.sample_time is None and plant.region is None
    if not alone or task.limits is not None or task.decay_rate > 0:
        return None
    natural = guessed_regulator(plant, ALL)
    size = 0.0 if natural is None else _entering(plant, natural.P)
    lower_bound = -np.inf
    results: list[_Found] = []
    for weight in LADDER:
        attempt = _at(task, weight)
        if attempt is None:
            continue
        results.append(attempt)
        lower_bound = max(lower_bound, attempt.least)
        for candidate in results:
            zero = candidate.holds and candidate.objective <= NOTHING * size
            if zero or candidate.near(lower_bound, task.tolerance):
                return candidate.settled(max(lower_bound, 0.0))
    objectives = [candidate.objective for candidate in results if candidate.holds]
    if not objectives:
        return None
    lower_bound = max(
        lower_bound, least_variance(plant, min(objectives) / (1 + task.tolerance / 2))
    )
    # The objective is the square of what a thousandth is promised of.
    for tolerance in (task.tolerance, 2 * promised(task.tolerance / 2)):
        for candidate in results:
            if candidate.near(lower_bound, tolerance):
                return candidate.settled(max(lower_bound, 0.0))
    return None


@dataclass(frozen=True, slots=True, eq=False)
class _Found:
    """Coordinates in which P is I, the condition in them and its outcome; seconds it took."""

    units: DisturbanceCoordinates
    condition: Condition
    outcome: Outcome
    seconds: float

    @property
    def unit(self) -> float:
        """Return that of the mean of |z|^2."""
        return self.units.rate * (self.units.output / self.units.disturbance) ** 2

    @property
    def objective(self) -> float:
        return self.outcome.objective * self.unit

    @property
    def least(self) -> float:
        return self.outcome.lower_bound * self.unit

    @property
    def holds(self) -> bool:
        return holds(self.condition, self.outcome.margin)

    def near(self, lower_bound: float, tolerance: float) -> bool:
        return self.holds and self.objective - lower_bound <= tolerance * abs(lower_bound)

    def settled(self, lower_bound: float) -> tuple[DisturbanceCoordinates, Condition, Outcome]:
        attempt = Try("regulator", "solved", self.outcome.margin, 0, self.seconds)
        outcome = replace(self.outcome, status="candidate", settled=True, tries=(attempt,))
        return self.units, self.condition, replace(outcome, lower_bound=lower_bound / self.unit)


def _at(task: DisturbanceRequest, weight: float) -> _Found | None:
    """Return the unknowns and the bound of the regulator with one weight; None without one."""
    began = time.perf_counter()
    regulator = guessed_regulator(task.plant, weight)
    if regulator is None:
        return None
    loop = task.plant.fed_back(regulator.gains)
    A, C = loop.A[0], loop.C[0]
    if np.linalg.eigvals(A).real.max() >= 0:
        return None
    P, extra = _gramian(A.T, C.T @ C), _gramian(A.T, regulator.P)
    P_room = _with_room(loop, P, extra, task.tolerance)
    if P_room is None:
        return None
    units = DisturbanceCoordinates.of(task.plant, P_room, feedback=regulator.gains, noise=True)
    condition = task.condition(units)
    data = assemble(condition)
    posed = units.scaled_plant(task.plant)
    values = _unknowns(condition, posed, task.tolerance)
    z = None if values is None else _multipliers(data, posed)
    if values is None or z is None:
        return None
    y = np.concatenate([unknown.numbers(values[unknown.name]) for unknown in condition.unknowns])
    raw = Raw("regulator", "solved", y, z, 0, 0.0)
    outcome = Outcome(
        "unknown",
        values,
        margin(condition, values),
        np.inf,
        data.multipliers(z),
        (),
        objective=float(values["nu"][0, 0, 0]),
        lower_bound=least_objective_bound(cone_program(data, data.objective, (), margin=0.0), raw),
    )
    return _Found(units, condition, outcome, time.perf_counter() - began)


def _unknowns(
    condition: Condition, loop: DisturbedPlant, tolerance: float
) -> dict[str, Floats] | None:
    """Return Q, about I but for its size, and M = 0 with the least W and nu, all with a margin."""
    if {unknown.name for unknown in condition.unknowns} != {"Q", "M", "W", "nu"}:
        return None
    A, E, C = loop.A[0], loop.E[0], loop.C[0]
    n, q = E.shape
    # From the numbers as they are posed: they are rounded where gains are large.
    P = _with_room(loop, _gramian(A.T, C.T @ C), _gramian(A.T, np.eye(n)), tolerance)
    if P is None:
        return None
    W = E.T @ P @ E
    cost = float(np.trace(W))
    W = W + SHARES[1] * tolerance * cost / q * np.eye(q)
    nu = float(np.trace(W)) + SHARES[2] * tolerance * cost
    M = np.zeros((1, loop.B.shape[2], n))
    return {"Q": np.linalg.inv(P)[None], "M": M, "W": W[None], "nu": np.full((1, 1, 1), nu)}


def _with_room(loop: DisturbedPlant, P: Floats, extra: Floats, tolerance: float) -> Floats | None:
    """Return P with as much of another as its share of the tolerance allows; None if indefinite."""
    cost, added = _entering(loop, P), _entering(loop, extra)
    if not (cost > 0 and added > 0):
        return None
    P = P + SHARES[0] * tolerance * cost / added * extra
    return P if is_definite(P) else None


def _multipliers(data: Assembled, loop: DisturbedPlant) -> Floats | None:
    """Return the multipliers of the module's formula, packed; None where LMIs are others."""
    A, E, C = loop.A[0], loop.E[0], loop.C[0]
    P, W = _gramian(A.T, C.T @ C), _gramian(A, E @ E.T)
    shown_states, noise = np.vstack([P, C]), np.vstack([np.eye(E.shape[1]), -P @ E])
    by_name = {
        "Q positive definite": np.zeros_like(A),
        "noise": noise @ noise.T,
        "variance": np.ones((1, 1)),
    }
    theta = shown_states @ W @ shown_states.T
    matrices = [by_name.get(lmi.name, theta) for lmi in data.condition.lmis]
    fits = all(
        lmi.count == 1 and len(matrix) == lmi.size
        for lmi, matrix in zip(data.condition.lmis, matrices, strict=True)
    )
    return (
        np.concatenate([pack(matrix) for matrix in matrices])
        if fits and len(matrices) == 4
        else None
    )


def _gramian(A: Floats, weight: Floats) -> Floats:
    """Return X of A X + X A' + weight = 0."""
    from scipy.linalg import solve_continuous_lyapunov

    X = np.asarray(solve_continuous_lyapunov(A, -weight))
    return (X + X.T) / 2


def _entering(plant: DisturbedPlant, P: Floats) -> float:
    """Return tr E' P E."""
    E = plant.E[0]
    return float(np.sum(E * (P @ E)))
