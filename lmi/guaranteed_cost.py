r"""Guaranteed quadratic cost: one gain for all vertices, or one a rule, from LMIs.

``lqr_pdc`` gives each rule its gain; its LMIs are in ``cost_condition``.  For one gain,
with Y = P^-1, M = K Y, u = -K x and weights of one over the squares of the given ranges,

    [ He(A_i Y - B_i M)   Y    M' ]
    [ Y                  -I    0  ]  < 0,     [[W, I], [I, Y]] >= 0,     trace W least,
    [ M                   0   -I  ]

in states and inputs divided by their ranges, so that the integral of |x|^2 + |u|^2 is at most
x(0)' P x(0) for every blend of the vertices, and its mean over the unit sphere is least.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.4.1; the ranges are Bryson's rule.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from takagi.lmi.answer import Answer, Design
from takagi.lmi.balance import nearest_power, state_units
from takagi.lmi.channel import near_least
from takagi.lmi.compensation_condition import Controlled
from takagi.lmi.cost_condition import largest_lmi, lqr_pdc_condition
from takagi.lmi.diagnosis import binding_items
from takagi.lmi.intake import (
    check_stabilisable,
    input_stack,
    positive_vector,
    symmetric,
    vertex_stack,
)
from takagi.lmi.quadratic import vertex_weight
from takagi.lmi.relaxations import relaxation_named
from takagi.lmi.stages import Outcome, optimise
from takagi.lmi.term import LMI, Condition, Constant, Term, Unknown
from takagi.models.errors import ModelError

__all__ = ["guaranteed_cost_condition", "guaranteed_cost_gain", "lqr_pdc"]

Floats = NDArray[np.float64]


def guaranteed_cost_condition(A: Floats, B: Floats) -> Condition:
    """Pose the module's LMIs for vertices in states and inputs of order one.

    Parameters
    ----------
    A : (r, n, n);  B : (r, n, m).
    """
    r, n, m = B.shape
    Y = Unknown("Y", n, n, symmetric=True)
    M = Unknown("M", m, n)
    W = Unknown("W", n, n, symmetric=True)
    one, inputs = np.eye(n)[None], np.eye(m)[None]
    cost = LMI(
        name="guaranteed cost",
        blocks=(n, n, m),
        terms=(
            Term(unknown=Y, left=A, right=one, plus_transpose=True, latex=("A_{i}", "")),
            Term(unknown=M, left=-B, right=one, plus_transpose=True, latex=("-B_{i}", "")),
            Term(unknown=Y, left=one, right=one, at=(0, 1)),
            Term(unknown=M, left=inputs, right=one, at=(2, 0)),
        ),
        constants=(
            Constant(value=-one, at=(1, 1), latex="-I"),
            Constant(value=-inputs, at=(2, 2), latex="-I"),
        ),
        sign=-1,
        count=r,
        index=rf"i = 1, \dots, {r}",
    )
    bound = LMI(
        name="bound of the cost",
        blocks=(n, n),
        terms=(
            Term(unknown=W, left=one, right=one),
            Term(unknown=Y, left=one, right=one, at=(1, 1)),
        ),
        constants=(Constant(value=one, at=(0, 1), latex="I"),),
    )
    return Condition(
        name="guaranteed quadratic cost",
        unknowns=(Y, M, W),
        lmis=(cost, bound),
        objective={"W": one},
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.4.1",
    )


def guaranteed_cost_gain(
    A: ArrayLike, B: ArrayLike, *, state_ranges: ArrayLike, input_ranges: ArrayLike
) -> Floats | None:
    """Return K (m, n) for u = -K x, or None where no gain serves all vertices.

    Parameters
    ----------
    A : (r, n, n);  B : (r, n, m), one gain for all.
    state_ranges, input_ranges : (n,), (m,) engineering ranges; the cost is the sum of squares of
        states and inputs over these.

    Raises
    ------
    ModelError : shapes, or a range that is not positive.
    """
    vertices, inputs = np.asarray(A, dtype=np.float64), np.asarray(B, dtype=np.float64)
    x, u = np.asarray(state_ranges, dtype=np.float64), np.asarray(input_ranges, dtype=np.float64)
    if vertices.ndim != 3 or inputs.shape[:2] != vertices.shape[:2]:
        raise ModelError(
            f"A {vertices.shape} and B {inputs.shape} were given; (r, n, n), (r, n, m) are needed"
        )
    if x.shape != vertices.shape[2:] or u.shape != inputs.shape[2:] or min(x.min(), u.min()) <= 0:
        raise ModelError("one positive range per state and per input is needed")
    condition = guaranteed_cost_condition(vertices * x / x[:, None], inputs * u / x[:, None])
    outcome = optimise(condition, slack=1e-4)
    if outcome.status != "candidate":
        return None
    M, Y = outcome.values["M"][0], outcome.values["Y"][0]
    return np.asarray(u[:, None] * np.linalg.solve(Y, M.T).T / x, dtype=np.float64)


def lqr_pdc(
    model: Controlled,
    Q: ArrayLike,
    R: ArrayLike,
    *,
    relaxation: str = "wang-tanaka-griffin",
    deviations: ArrayLike = 1.0,
    scales: ArrayLike | None = None,
) -> Design:
    """Return gains K_i for u = -sum_i h_i K_i x with the least bound on the quadratic cost.

    The integral of x' Q x + u' R u is at most x(0)' P x(0) for every blend of the vertices, however
    fast it varies; the mean of that, for uncorrelated x_k(0) of the given deviations, is least.
    Of one rule it is the linear-quadratic regulator.

    Parameters
    ----------
    model : A (r, n, n) and B (r, n, m).
    Q : (n, n) symmetric, positive semidefinite.
    R : (m, m) symmetric, positive definite.
    relaxation : as for ``pdc``.
    deviations : (n,) or one number: standard deviation of each state of x(0), in its unit.
    scales : (n,) engineering range of each state; None takes those in which the cost of the mean
        vertex is about 1.

    Returns
    -------
    A ``Design``; ``cost`` is sum_k deviations_k^2 P_kk.  Without gains its answer says which rules
    bind and what to relax.  Nothing is proved here.

    Not promised: with one relaxation there may be no gains, or a larger cost, where a richer one
    does better.  A state that costs nothing is charged 1e-6 of the cost.

    Raises
    ------
    ModelError : shapes, numbers, an unknown relaxation, weights that are not symmetric or not
        definite, inputs that are dependent or do nothing, a vertex with an unstable mode that no
        input moves.

    Source: Tanaka and Wang (2001), chapter 6.
    """
    relaxation_named(relaxation)
    A = vertex_stack(model).astype(np.float64)
    B = input_stack(model, A).astype(np.float64)
    r, n, m = B.shape
    task = _Task(
        A,
        B,
        symmetric("Q", Q, n, definite=False),
        symmetric("R", R, m, definite=True),
        positive_vector("deviations", deviations, n),
    )
    s = state_units(A, scales)
    names = tuple(getattr(model, "states", ()))
    reach = B / s[:, None]
    check_stabilisable(
        A * s / s[:, None], reach / np.abs(reach).max(axis=(0, 1)), units=s, names=names
    )
    units = _CostUnits.of(task, s, fixed=scales is not None)
    scaled = task.scaled(units)
    condition = lqr_pdc_condition(
        scaled, scaled.Q, scaled.R, relaxation=relaxation, deviations=scaled.deviations
    )
    condition = condition.with_lmis(largest_lmi(condition.unknowns[0]))
    return _cost_design(condition, optimise(condition), task, units, relaxation)


@dataclass(frozen=True, slots=True, eq=False)
class _Task:
    """Vertices, weights and initial deviations in one set of units."""

    A: Floats
    B: Floats
    Q: Floats
    R: Floats
    deviations: Floats

    def scaled(self, units: _CostUnits) -> _Task:
        s, tau, rate, cost = units.states, units.inputs, units.rate, units.cost
        return _Task(
            self.A * s / s[:, None] / rate,
            self.B * tau / s[:, None] / rate,
            self.Q * s * s[:, None] / (rate * cost),
            self.R * tau * tau[:, None] / (rate * cost),
            self.deviations / s / np.max(self.deviations / s),
        )


@dataclass(frozen=True, slots=True, eq=False)
class _CostUnits:
    """x = states xhat, u = inputs uhat, time in 1 / rate, V = cost Vhat; powers of two."""

    states: Floats
    inputs: Floats
    rate: float
    cost: float

    @classmethod
    def of(cls, task: _Task, s: Floats, *, fixed: bool) -> _CostUnits:
        """Return units in which A, R and the cost matrix of the mean vertex are about 1."""
        P = np.diag(_mean_cost(task, s))
        if not fixed:
            s = s / nearest_power(np.sqrt(np.maximum(P, 1e-8 * P.max()) / P.max()))
            P = np.full(len(s), P.max())
        cost = float(nearest_power(np.float64(P.max())))
        rate = float(nearest_power(np.float64(vertex_weight(task.A * s / s[:, None]) / 2)))
        tau = nearest_power(np.sqrt(rate * cost / np.diag(task.R)))
        return cls(s, tau, rate, cost)


def _mean_cost(task: _Task, s: Floats) -> Floats:
    """Return the regulator's P at the mean vertex, in states x / s; the identity without one."""
    from scipy.linalg import solve_continuous_are

    A, B = task.A.mean(axis=0) * s / s[:, None], task.B.mean(axis=0) / s[:, None]
    try:
        P = solve_continuous_are(A, B, task.Q * s * s[:, None], task.R)
    except np.linalg.LinAlgError:
        return np.eye(len(s))
    usable = bool(np.isfinite(P).all()) and np.diag(P).max() > 0
    return np.asarray(P) if usable else np.eye(len(s))


def _cost_design(
    condition: Condition, outcome: Outcome, task: _Task, units: _CostUnits, relaxation: str
) -> Design:
    gains, P, cost = None, None, None
    status, s, tau = outcome.status, units.states, units.inputs
    if near_least(outcome):
        Y, M = outcome.values["Y"][0], outcome.values["M"]
        inverse = np.linalg.inv(Y)
        P = (inverse + inverse.T) / 2 * units.cost / s / s[:, None]
        K = np.linalg.solve(Y, M.transpose(0, 2, 1)).transpose(0, 2, 1)
        rules = len(task.A)
        gains = np.broadcast_to(K * tau[:, None] / s, (rules, len(tau), len(s))).copy()
        cost = float(np.diag(P) @ task.deviations**2)
    elif status == "candidate":
        status = "unknown"
    answer = Answer(
        status=status,
        P=P,
        margin=outcome.margin,
        bound=outcome.bound,
        values=outcome.values,
        multipliers=outcome.multipliers,
        coordinates=s,
        condition=condition,
        diagnosis="" if P is not None else _cost_diagnosis(condition, outcome, relaxation),
        tries=outcome.tries,
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


def _cost_diagnosis(condition: Condition, outcome: Outcome, relaxation: str) -> str:
    if outcome.status != "infeasible":
        return (
            f"no solver came near the least cost: the best margin was {outcome.margin:.2g}; the "
            "weights or the vertices differ too much in size: weigh every state a little, or "
            "give scales"
        )
    names = [lmi.name for lmi in condition.lmis if lmi.name not in ("scale of Y",)]
    richer = "" if relaxation == "liu-zhang" else 'take a richer relaxation ("liu-zhang"), or '
    binding = binding_items(condition, outcome.multipliers, *names[1:])
    return f"no gains by {relaxation}: {binding}; {richer}shrink the box that the rules span"
