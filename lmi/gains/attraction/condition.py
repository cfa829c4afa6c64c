r"""The LMIs of a region of attraction: an ellipsoid {x' P x <= 1} that no trajectory leaves.

With Q = P^-1: the double sums of the loop (one without saturation, 2^m with), limits on inputs and
states on the ellipsoid, and a measure of its size to be made as large as possible.  Inside the
ellipsoid the limits hold, so the loop is what the double sums say, V' <= -2 alpha V, and a
trajectory that starts in it stays in it.  A model that equals its plant only on a box is valid only
while the ellipsoid lies in the box.

Saturating actuators, u = -sat(K(h) x) at |u_k| <= ubar_k: where |H(h) x|_k <= ubar_k, sat(v)_k lies
between (H x)_k and v_k = (K x)_k, so that with E the 2^m diagonal matrices of zeros and ones and
M_j = K_j Q, Z_j = H_j Q,

    Theta_ij = He(A_i Q - B_i (E M_j + (I - E) Z_j)) + 2 alpha Q        for every E,

alpha smaller where an input saturates than where none does.  It has to be, for saturation to buy
anything when K is sought: with one alpha for all, K = H serves as well and never saturates.
Discrete time: the same with Theta_ij of ``closed_loop`` there.

What "as large as possible" means for {x' P x <= 1}: objectives as LMIs.

    volume      det Q largest: see ``condition.log_det``.
    trace       sum_k Q_kk / w_k^2 largest: the sum of the squared semi-axes in units w_k.
    points      the largest beta with beta x_k in the ellipsoid for every given point: gamma =
                1 / beta^2 least, [[gamma, x_k'], [x_k, Q]] >= 0.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.2.2, for the aims; Hu and Lin
(2001), Control Systems with Actuator Saturation, of one rule, for saturation.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from takagi.lmi.analysis.decay_rate import vertex_weight
from takagi.lmi.analysis.gain_pairs import pairs_of
from takagi.lmi.argument_checks import decay_parameter
from takagi.lmi.condition.log_det import root_of_determinant
from takagi.lmi.condition.statements import pose, positive_definite, scale_bound
from takagi.lmi.condition.term import LMI, Array, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import (
    Expression,
    He,
    Inequality,
    Parameter,
    block,
    matrix,
    trace,
)
from takagi.lmi.gains.attraction.request import AttractionRequest
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.gains.requirements.limits import input_lmis, row_lmis, state_lmis
from takagi.lmi.sums.double_sum import DoubleSum, double_sum_of
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.errors import ModelError

# Size of Q, in the states at hand, beyond which an ellipsoid is taken to be unbounded.
LARGEST = 1e3
# Inputs whose corners, 2^m double sums, are still listed.
MOST_INPUTS = 6
# The parameter that is the rate where an input saturates.
SATURATED = "saturated_rate"


def attraction_condition(task: AttractionRequest) -> Condition:
    """Pose the module's LMIs, with Q <= 1000 I in the coordinates of the task.

    The objective is the measure.  Nothing is solved.
    """
    n, r = task.A.shape[1], len(task.A)
    Q = Unknown("Q", n, n, symmetric=True)
    gain: Unknown | Array | None = task.gains
    unknowns: tuple[Unknown, ...] = ()
    if task.sought:
        gain = gain_unknown(r, task.B.shape[2], n, task.relaxation)
        unknowns = (gain,)
    loop = _Loop(task, Q)
    sums, loop_unknowns, lmis = _loops(task, Q, gain)
    unknowns += loop_unknowns
    single = task.relaxation == "common-gain" or gain is None
    alike = task.saturation is None and isinstance(gain, np.ndarray) and len(gain) == 1
    relaxed = relaxation_named("common-gain" if single or alike or r == 1 else task.relaxation)
    for double_sum in sums:
        slack, posed = relaxed(double_sum)
        unknowns += slack
        lmis += posed
    if task.state_box is not None:
        lmis += state_lmis(Q, task.state_box)
    minimise, measure_unknowns, epigraph = _measure(task, Q)
    return pose(
        positive_definite(Q),
        scale_bound(Q, LARGEST),
        *lmis,
        *epigraph,
        minimise=minimise,
        unknowns=(Q, *unknowns, *measure_unknowns),
        parameters=(loop.rate,) if task.saturation is None else (loop.rate, loop.saturated_rate),
        name="region of attraction",
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 5.2 and 7.2.3",
    )


def _measure(
    task: AttractionRequest, Q: Unknown
) -> tuple[Expression, tuple[Unknown, ...], tuple[Inequality, ...]]:
    """Return what to minimise, with its unknowns and LMIs, which are not claims."""
    if isinstance(task.measure, str):
        if task.measure == "trace":
            return -trace(np.diag(task.units**-2.0) @ Q), (), ()
        volume, unknowns, inequalities = root_of_determinant(Q.as_expression())
        return -volume, unknowns, inequalities
    gamma = Unknown("gamma", 1, 1, latex=r"\gamma")
    inside = block([[gamma, matrix(task.measure[:, None, :], r"x_k^\top")], [None, Q]]) >= 0
    index = rf"k = 1, \dots, {len(task.measure)}"
    return +gamma, (gamma,), (inside.named("multiple of the points", index),)


def _loops(
    task: AttractionRequest, Q: Unknown, gain: Unknown | Array | None
) -> tuple[tuple[DoubleSum, ...], tuple[Unknown, ...], tuple[LMI, ...]]:
    """Return the double sums, their unknowns other than Q and M, and the input's limits."""
    loop = _Loop(task, Q)
    m = task.B.shape[2]
    if gain is None:
        idle = np.zeros((1, m or 1, Q.rows))
        without = replace(task, B=np.zeros((len(task.A), Q.rows, m or 1)))
        loop = _Loop(without, Q)
        return (loop.double_sum(loop.fed(idle, np.ones(m or 1)), loop.rate, ""),), (), ()
    if task.saturation is None:
        plain = loop.double_sum(loop.fed(gain, np.ones(m)), loop.rate, "")
        return (plain,), (), _commanded(task, Q, gain, 1.0)
    if m > MOST_INPUTS:
        raise ModelError(
            f"{m} inputs saturate, with {2**m} corners; at most {MOST_INPUTS} are listed: take "
            "saturation=None"
        )
    Z = Unknown("Z", m, Q.rows, count=1 if task.relaxation == "common-gain" else len(task.A))
    assert task.input_limit is not None
    lmis = input_lmis(Q, Z, task.input_limit, name="input saturation limit")
    if isinstance(gain, Unknown):
        lmis += _commanded(task, Q, gain, task.overdrive)
    return loop.saturated(gain, Z), (Z,), lmis


@dataclass(frozen=True, slots=True, eq=False)
class _Loop:
    """The loop of the module's double sums."""

    task: AttractionRequest
    Q: Unknown

    @property
    def rate(self) -> Parameter:
        """Return the rate where no input saturates."""
        return decay_parameter(self.task.decay_rate, self.task.step)

    @property
    def saturated_rate(self) -> Parameter:
        """Return the rate where one does."""
        rate = decay_parameter(self.task.saturated_decay_rate, self.task.step)
        return Parameter(
            SATURATED, rate.value, r"\alpha_{s}" if self.task.step is None else r"\rho_{s}^2"
        )

    def fed(self, gain: Unknown | Array, share: Array) -> Expression:
        """Return -B_i diag(share) M_j, M_j = K_j Q for known gains K, (r, m, n) or (1, m, n)."""
        name = "B_{i}"
        if not np.all(share == 1):
            values = [f"{value:.4g}" for value in share]
            factor = rf"\mathrm{{diag}}({', '.join(values)})"
            name = f"{values[0]} {name}" if len(values) == 1 else f"{name} {factor}"
        through = -matrix(self.task.B * share, name, over="i")
        if isinstance(gain, Unknown):
            return through @ gain.over("j")
        known = matrix(gain[0], "K") if len(gain) == 1 else matrix(gain, "K_{j}", over="j")
        return through @ (known @ self.Q)

    def double_sum(self, fed: Expression, rate: Parameter, name: str) -> DoubleSum:
        """Return the double sum with what the inputs add to A_i Q."""
        task, free = self.task, matrix(self.task.A, "A_{i}", over="i") @ self.Q
        if task.step is not None:
            theta = block([[-rate * self.Q, None], [free + fed, -self.Q]])
        else:
            theta = He(free) + 2 * rate * self.Q + He(fed)
        statement = (theta << 0).named(name, weight=_weight(task))
        return double_sum_of(statement, rules=len(task.A), corners=task.corners)

    def saturated(self, gain: Unknown | Array, Z: Unknown) -> tuple[DoubleSum, ...]:
        """Return the 2^m double sums with each input at (K x)_k or at (H x)_k."""
        sums = []
        for corner in product((1.0, 0.0), repeat=self.task.B.shape[2]):
            linear = np.array(corner)
            parts = [self.fed(gain, linear)] if linear.any() else []
            parts += [] if linear.all() else [self.fed(Z, 1 - linear)]
            rate = self.rate if linear.all() else self.saturated_rate
            words = f"unsaturated ({', '.join(f'{value:.4g}' for value in linear)})"
            sums.append(self.double_sum(sum(parts[1:], parts[0]), rate, words))
        return tuple(sums)


def _commanded(
    task: AttractionRequest, Q: Unknown, gain: Unknown | Array, reach: float
) -> tuple[LMI, ...]:
    """Return |K_j x|_k <= reach input_limit_k on the ellipsoid."""
    if task.input_limit is None:
        return ()
    bound = reach * task.input_limit
    if isinstance(gain, Unknown):
        if reach == 1:
            return input_lmis(Q, gain, bound)
        return input_lmis(Q, gain, bound, name="command limit", symbol=r"\bar v")
    rows = gain.reshape(-1, Q.rows)
    return row_lmis(Q, rows, np.tile(bound, len(gain)), name="input limit")


def _weight(task: AttractionRequest) -> float:
    if task.step is not None:
        return 1.0
    weight = vertex_weight(task.A)
    if task.gains is None:
        return weight
    K = np.broadcast_to(task.gains, (len(task.A), *task.gains.shape[1:]))
    return max(weight, vertex_weight(pairs_of(task.A, task.B, K)))
