r"""The linear-quadratic regulator of a Takagi-Sugeno model: the least guaranteed cost, by PDC.

The LMIs are solved in states in which a first guess of the cost is |x|^2, and again in those of
what was found where that was far off.

With S = P^-1, M_j = K_j S, u = -sum_j h_j K_j x, weights Q = F' F and R = G' G,

    Theta_ij = [ He(A_i S - B_i M_j)   S F'   M_j' G' ]
               [ F S                   -I     0       ],     sum_ij h_i h_j Theta_ij < 0,
               [ G M_j                 0      -I      ]

gives V' <= -(x' Q x + u' R u) for V = x' P x, so the cost is at most x(0)' P x(0); and
[[W, L'], [L, S]] > 0 gives trace W > trace L' P L, its mean where x(0) has the covariance L L'.

In discrete time, x+ = x + (N x + B u), N = A - I, the cost being the sum of x' Q x + u' R u,

    Theta_ij = [ He(N_i S - B_i M_j) / e   *    *    *  ]
               [ (N_i S - B_i M_j) / r     -S   0    0  ]
               [ F S / r                   0    -I   0  ],     r^2 = e > 0 any number,
               [ G M_j / r                 0    0    -I ]

gives V+ - V <= -(x' Q x + u' R u).  It is a congruence, with [I / r, I / r; 0, I] in the first two
rows, of the form with -S and A_i S - B_i M_j.  With e about the size of N, what happens in one
step, a model sampled ever faster gives the LMI of continuous time, not that of N = 0.

Source: Tanaka and Wang (2001), chapter 6; Boyd, El Ghaoui, Feron, Balakrishnan (1994), section
7.4.1, for one gain.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.decay_rate import vertex_weight
from takagi.lmi.answer import Design, ObjectiveUnit, Status
from takagi.lmi.argument_checks import (
    corners_of,
    input_stack,
    positive_vector,
    sample_time_of,
    symmetric,
    vertex_stack,
)
from takagi.lmi.condition.statements import lmi_of, pose, scale_bound
from takagi.lmi.condition.term import LMI, Array, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion, state_units
from takagi.lmi.decision.decide import optimise
from takagi.lmi.decision.outcome import Outcome, not_least
from takagi.lmi.expressions.expression import Expression, He, block, identity, matrix, trace
from takagi.lmi.gains.decay.condition import Controlled
from takagi.lmi.gains.decay.pdc import pdc
from takagi.lmi.gains.requirements.closed_loop import gain_unknown, without_rounding
from takagi.lmi.gains.zero_gains import warns_of_zero_gains
from takagi.lmi.sums.double_sum import double_sum_of
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.model import TSModel
from takagi.models.ts.premise import Premise

# Largest S in states where P is about 1: keeps S finite where a state costs nothing, at a cost of
# this much of the cost.
LARGEST_S = 1e6


def _cost_loop(A: Array, B: Array, F: Array, G: Array, S: Unknown, M: Unknown) -> Expression:
    """Return the module's Theta_ij: the closed loop, with the cost's factors below it."""
    M_j = M.over("j")
    loop = matrix(A, "A_{i}", over="i") @ S - matrix(B, "B_{i}", over="i") @ M_j
    states, inputs = -identity(len(F)), -identity(M.rows)
    return block(
        [
            [He(loop), None, None],
            [matrix(F, "F") @ S, states, 0],
            [matrix(G, "G") @ M_j, 0, inputs],
        ]
    )


def _sampled_cost_loop(
    A: Array, B: Array, F: Array, G: Array, S: Unknown, M: Unknown, span: float
) -> Expression:
    """Return the module's Theta_ij in discrete time; ``span`` is e."""
    M_j, root = M.over("j"), float(np.sqrt(span))

    def loop(over: float, name: str) -> Expression:
        N_i = matrix(motion(A, 1.0) / over, rf"\tfrac{{1}}{{{name}}}N_{{i}}", over="i")
        return N_i @ S - matrix(B / over, rf"\tfrac{{1}}{{{name}}}B_{{i}}", over="i") @ M_j

    states, inputs = -identity(len(F)), -identity(M.rows)
    spent = [
        matrix(factor / root, rf"\tfrac{{1}}{{\sqrt{{e}}}}{name}")
        for factor, name in ((F, "F"), (G, "G"))
    ]
    return block(
        [
            [He(loop(span, "e")), None, None, None],
            [loop(root, r"\sqrt{e}"), -S, 0, 0],
            [spent[0] @ S, 0, states, 0],
            [spent[1] @ M_j, 0, 0, inputs],
        ]
    )


def lqr_pdc_condition(
    model: Controlled,
    Q: ArrayLike,
    R: ArrayLike,
    *,
    relaxation: str = "wang-tanaka-griffin",
    deviations: ArrayLike = 1.0,
    sample_time: float | None = None,
    span: float = 1.0,
) -> Condition:
    """Pose the module's LMIs; the objective is trace W, the mean cost from random x(0).

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    Q, R : (n, n) positive semidefinite and (m, m) positive definite, symmetric.
    relaxation : how the double sum is made LMIs; see ``relaxations``.
    deviations : standard deviation of each state of x(0), (n,) or one number; or L, (n, n), where
        they are correlated with covariance L L'.
    sample_time : T in s of x+ = A x + B u; None takes the model's own, continuous where it has
        none.
    span : e in discrete time; changes the numbers, not what is feasible.

    Returns the condition in the model's coordinates as they are, with the unknowns ``S``, ``M``,
    ``W`` and those of the relaxation.  Nothing is solved.

    Raises ModelError: shapes, entries that are not finite, weights that are not symmetric or not
    definite, an unknown relaxation.
    """
    relaxed = relaxation_named(relaxation)
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    r, n, m = B.shape
    F = weight_factor(symmetric("Q", Q, n, definite=False))
    G = weight_factor(symmetric("R", R, m, definite=True))
    S = Unknown("S", n, n, symmetric=True)
    M = gain_unknown(r, m, n, relaxation)
    W = Unknown("W", n, n, symmetric=True)
    if sample_time_of(model, sample_time) is None:
        theta = _cost_loop(A, B, F, G, S, M)
    else:
        theta = _sampled_cost_loop(A, B, F, G, S, M, span)
    # Without a decay rate: the cost says how fast.
    slack, double_sum = relaxed(double_sum_of(theta << 0, rules=r, corners=corners_of(model)))
    bound = block([[W, matrix(initial_factor(deviations, n).T, r"L^\top")], [None, S]])
    return pose(
        # S > 0 and W > L' S^-1 L
        (bound >> 0).named("bound of the cost"),
        *double_sum,
        minimise=trace(W),
        unknowns=(S, M, W, *slack),
        name=f"guaranteed quadratic cost, {relaxation}",
        source="Tanaka and Wang (2001), chapter 6",
    )


def largest_lmi(S: Unknown) -> LMI:
    """Pose S <= 1e6 I, in states where P is about 1: keeps S finite where a state costs nothing."""
    return lmi_of(scale_bound(S, LARGEST_S))


def initial_factor(deviations: ArrayLike, size: int) -> Array:
    """Return L, (size, size): the covariance of x(0) is L L'.

    Raises
    ------
    ModelError : a shape, or an entry, that makes no sense.
    """
    if np.ndim(deviations) < 2:
        return np.diag(positive_vector("deviations", deviations, size))
    factor = np.asarray(deviations, dtype=np.float64)
    if factor.shape != (size, size) or not np.isfinite(factor).all() or not factor.any():
        raise ModelError(
            f"deviations has shape {factor.shape}; ({size},) standard deviations are needed, or "
            f"({size}, {size}) L, finite and not zero, with the covariance L L'"
        )
    return factor


def weight_factor(weight: Array) -> Array:
    """Return F, (rank, size), with F' F = weight."""
    eigenvalues, vectors = np.linalg.eigh(weight)
    # Smaller eigenvalues of a singular weight are rounding, and may be negative.
    keep = eigenvalues > 1e-14 * np.abs(eigenvalues).max()
    return np.asarray((vectors[:, keep] * np.sqrt(eigenvalues[keep])).T)


# Share of the largest cost that a state is taken to have where it has none.
LEAST_COST = 1e-8
ROUNDS = 4
UNSETTLED = (
    "the weights or the vertices differ too much in size, or these rules can hardly be stabilised; "
    "weigh every state a little, give scales, or take a richer relaxation"
)


@warns_of_zero_gains
def lqr_pdc(
    model: Controlled,
    Q: ArrayLike,
    R: ArrayLike,
    *,
    relaxation: str = "wang-tanaka-griffin",
    deviations: ArrayLike = 1.0,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
) -> Design:
    """Return gains K_i for u = -sum_i h_i K_i x with the least bound on the quadratic cost.

    The integral of x' Q x + u' R u is at most x(0)' P x(0) for every blend of the vertices, however
    fast it varies; the mean of that, over x(0) of the given deviations, is least.  In discrete
    time the cost is the sum of x' Q x + u' R u over the steps; times T it is near the integral.
    Of one rule it is the linear-quadratic regulator.

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    Q : (n, n) symmetric, positive semidefinite.
    R : (m, m) symmetric, positive definite.
    relaxation : as for ``pdc``.
    deviations : standard deviation of each state of x(0) in its unit, (n,) or one number; or L,
        (n, n), where they are correlated with covariance L L'.
    scales : (n,) engineering range of each state; None balances.
    sample_time : T in s of x+ = A x + B u; None takes the model's own.

    Returns a ``Design``; ``cost`` is sum_k deviations_k^2 P_kk, or trace L' P L.  Without gains its
    answer says which rules bind and what to relax.  The answer's condition is posed in states in
    which the mean vertex costs |x|^2, so it has no ``coordinates``.  Nothing is proved here.

    Not promised: with one relaxation there may be no gains, or a larger cost, where a richer one
    does better.  A state that costs nothing is charged 1e-6 of the cost.

    Raises ModelError: shapes, numbers, an unknown relaxation, weights that are not symmetric or not
    definite, inputs that are dependent or do nothing, a vertex with an unstable mode that no input
    moves.

    Source: Tanaka and Wang (2001), chapter 6.
    """
    relaxation_named(relaxation)
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    r, n, m = B.shape
    weight = symmetric("Q", Q, n, definite=False)
    R = symmetric("R", R, m, definite=True)
    step = sample_time_of(model, sample_time)
    task = _Task(
        A,
        B,
        weight,
        R,
        initial_factor(deviations, n),
        step,
        tuple(getattr(model, "premises", ())),
        tuple(getattr(model, "rules", ())),
    )
    plain = pdc(model, relaxation=relaxation, scales=scales, sample_time=sample_time)
    if plain.gains is None or plain.P is None:
        return _without_gains(plain)
    guess = _mean_cost(task, state_units(A, scales, step=step))
    condition, outcome, units = _solved(task, guess, relaxation)
    if outcome.status != "candidate":
        guess = _cost_of(task, plain.gains, plain.P)
        condition, outcome, units = _solved(task, guess, relaxation)
    return _cost_design(condition, outcome, task, units, relaxation)


def _solved(task: _Task, P: Floats, relaxation: str) -> tuple[Condition, Outcome, _CostUnits]:
    """Pose and solve in states where P is the identity; again where it ends, if that was far."""
    for _ in range(ROUNDS):
        units = _CostUnits.of(task, P)
        posed = task.in_units(units)
        condition = lqr_pdc_condition(
            posed, posed.Q, posed.R, relaxation=relaxation, deviations=posed.factor, span=units.rate
        )
        condition = condition.with_lmis(largest_lmi(condition.unknowns[0]))
        outcome = optimise(condition)
        if outcome.status == "candidate" or not outcome.feasible:
            break
        P = units.quadratic(outcome.feasible["S"][0])
    return condition, outcome, units


@dataclass(frozen=True, slots=True, eq=False)
class _Task:
    """Vertices, weights, and the covariance factor factor' of x(0), in one set of coordinates.

    ``premises`` and ``rules`` are the model's, for relaxations that know products of memberships.
    """

    A: Floats
    B: Floats
    Q: Floats
    R: Floats
    factor: Floats
    sample_time: float | None
    premises: tuple[Premise, ...] = ()
    rules: tuple[tuple[int, ...], ...] = ()

    def in_units(self, units: _CostUnits) -> _Task:
        """Return the task in the given coordinates."""
        T, U = units.states, units.inputs
        # Steps cannot be counted in other units than steps.
        rate = units.rate if self.sample_time is None else 1.0
        factor = np.linalg.solve(T, self.factor)
        weight = T.T @ self.Q @ T / rate
        return _Task(
            np.asarray(np.linalg.solve(T, self.A @ T) / rate, dtype=np.float64),
            np.asarray(np.linalg.solve(T, self.B @ U) / rate, dtype=np.float64),
            (weight + weight.T) / 2,
            np.eye(len(U)) * units.rate / rate,
            np.asarray(factor / np.linalg.norm(factor, 2), dtype=np.float64),
            self.sample_time,
            self.premises,
            self.rules,
        )


@dataclass(frozen=True, slots=True, eq=False)
class _CostUnits:
    """x = states xhat, u = inputs uhat, both square matrices, and time in 1 / rate.

    In discrete time the rate is what happens in one step, at most 1.
    """

    states: Floats
    inputs: Floats
    rate: float

    @classmethod
    def of(cls, task: _Task, P: Floats) -> _CostUnits:
        """Return coordinates where x' P x is |xhat|^2 and the weight R is I."""
        T = np.linalg.inv(np.linalg.cholesky(P)).T
        scaled_motion = motion(np.linalg.solve(T, task.A @ T), task.sample_time)
        rate = vertex_weight(scaled_motion) / 2
        rate = rate if task.sample_time is None else min(rate, 1.0)
        return cls(T, np.sqrt(rate) * np.linalg.inv(np.linalg.cholesky(task.R)).T, rate)

    def quadratic(self, S: Floats) -> Floats:
        """Return P in the model's states."""
        back = np.linalg.inv(self.states)
        P = back.T @ np.linalg.inv(S) @ back
        return np.asarray((P + P.T) / 2)


def _mean_cost(task: _Task, s: Floats) -> Floats:
    """Return about the regulator's P at the mean vertex, positive definite.

    Where that vertex has none: of the size of the weight Q in balanced states x / s.
    """
    from scipy.linalg import solve_continuous_are, solve_discrete_are

    riccati = solve_continuous_are if task.sample_time is None else solve_discrete_are
    A, B = task.A.mean(axis=0) * s / s[:, None], task.B.mean(axis=0) / s[:, None]
    weight = task.Q * s * s[:, None]
    regularisation = LEAST_COST * (np.abs(weight).max() or 1.0) * np.eye(len(s))
    try:
        P = np.asarray(riccati(A, B, weight + regularisation, task.R))
    except np.linalg.LinAlgError:
        P = weight
    P = weight if not np.isfinite(P).all() else (P + P.T) / 2
    values, vectors = np.linalg.eigh(P)
    values = np.maximum(values, max(LEAST_COST * values[-1], regularisation[0, 0]))
    return np.asarray((vectors * values) @ vectors.T / s / s[:, None])


def _cost_of(task: _Task, gains: Floats, P: Floats) -> Floats:
    """Return the multiple of P that bounds the cost of these gains at their own vertices."""
    loop = task.A - task.B @ gains
    closed = P @ loop
    if task.sample_time is None:
        lost = -closed - closed.transpose(0, 2, 1)
    else:
        lost = P - loop.transpose(0, 2, 1) @ closed
    rates, vectors = np.linalg.eigh(lost)
    # Positive by the design; rounding may have taken what little there was.
    root = vectors / np.sqrt(np.maximum(rates, 1e-14 * rates[:, -1:]))[:, None, :]
    spent = task.Q + gains.transpose(0, 2, 1) @ task.R @ gains
    size = np.linalg.eigvalsh(root.transpose(0, 2, 1) @ spent @ root)[:, -1].max()
    return np.asarray(P * size)


def _without_gains(plain: Design) -> Design:
    """Return the no of ``pdc``: without gains that stabilise there is no finite cost."""
    diagnosis = plain.answer.diagnosis.replace("lower the decay rate, or ", "")
    answer = replace(
        plain.answer, diagnosis=diagnosis.replace("lower the decay rate a little, or ", "")
    )
    return replace(plain, answer=answer)


def _unit_of_cost(task: _Task, units: _CostUnits) -> float:
    """Return the cost that an objective of 1 stands for."""
    return float(np.linalg.norm(np.linalg.solve(units.states, task.factor), 2)) ** 2


def _unsettled(outcome: Outcome, task: _Task, units: _CostUnits) -> str:
    """Return why there is no least cost; the objective is the cost for deviations of norm 1."""
    size = _unit_of_cost(task, units)
    reason = not_least(size * outcome.objective, size * outcome.lower_bound)
    return f"gains exist, but {reason}; {UNSETTLED}"


def _cost_design(
    condition: Condition, outcome: Outcome, task: _Task, units: _CostUnits, relaxation: str
) -> Design:
    gains, P, cost = None, None, None
    status: Status = "unknown"
    if outcome.status == "candidate":
        status = "candidate"
        S, M = outcome.values["S"][0], outcome.values["M"]
        P, back = units.quadratic(S), np.linalg.inv(units.states)
        K = units.inputs @ np.linalg.solve(S, M.transpose(0, 2, 1)).transpose(0, 2, 1) @ back
        K = without_rounding(K, units.states @ S @ units.states.T)
        gains = np.broadcast_to(K, (len(task.A), *K.shape[1:])).copy()
        cost = float(np.trace(task.factor.T @ P @ task.factor))
    answer = replace(
        outcome.as_answer(condition, None),
        status=status,
        P=P,
        feasible=outcome.feasible,
        objective_unit=ObjectiveUnit("cost", _unit_of_cost(task, units)),
        diagnosis="" if P is not None else _unsettled(outcome, task, units),
    )
    return Design(
        gains=gains,
        P=P,
        decay_rate=0.0,
        margin=outcome.margin,
        relaxation=relaxation,
        answer=answer,
        cost=cost,
    )


# Of the least cost: the gain is the best conditioned one that costs no more than this above it.
SLACK = 1e-4


def guaranteed_cost_condition(A: Floats, B: Floats) -> Condition:
    """Return ``lqr_pdc_condition`` with one gain and unit weights.

    ``A``, ``B`` : (r, n, n), (r, n, m), in states and inputs of order one.
    """
    eye, inputs = np.eye(A.shape[2]), np.eye(B.shape[2])
    return lqr_pdc_condition(TSModel(A, B), eye, inputs, relaxation="common-gain")


def guaranteed_cost_gain(
    A: ArrayLike, B: ArrayLike, *, state_ranges: ArrayLike, input_ranges: ArrayLike
) -> Floats | None:
    """Return K (m, n) for u = -K x, or None where no gain serves all vertices.

    The integral of the squares of states and inputs over their ranges is at most x(0)' P x(0) for
    every blend of the vertices, and its mean over the ellipsoid of the ranges is least, to 1e-4.
    It is ``lqr_pdc`` of the relaxation "common-gain", solved in the ranges themselves, and
    centred a little farther from the least cost: for gains that are made by the dozen.

    ``A`` : (r, n, n);  B : (r, n, m), one gain for all.
    ``state_ranges``, ``input_ranges`` : (n,), (m,) engineering ranges.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.4.1; the ranges are Bryson's
    rule.
    """
    vertices, inputs = np.asarray(A, dtype=np.float64), np.asarray(B, dtype=np.float64)
    x, u = np.asarray(state_ranges, dtype=np.float64), np.asarray(input_ranges, dtype=np.float64)
    condition = guaranteed_cost_condition(vertices * x / x[:, None], inputs * u / x[:, None])
    outcome = optimise(condition, slack=SLACK)
    if outcome.status != "candidate":
        return None
    M, S = outcome.values["M"][0], outcome.values["S"][0]
    return np.asarray(u[:, None] * np.linalg.solve(S, M.T).T / x, dtype=np.float64)
