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
from numpy.typing import ArrayLike

from takagi.lmi.analysis.decay_rate import vertex_weight
from takagi.lmi.analysis.gain_pairs import pairs_of
from takagi.lmi.argument_checks import (
    corners_of,
    decay_parameter,
    number,
    positive_vector,
    sample_time_of,
)
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
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.gains.requirements.limits import input_lmis, limits_of, row_lmis, state_lmis
from takagi.lmi.sums.double_sum import DoubleSum, double_sum_of
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.arrays import Indices
from takagi.models.errors import ModelError, did_you_mean

MEASURES = ("volume", "trace")


def state_box_of(
    model: object, state_box: ArrayLike | None, n: int, input_limit: Array | None
) -> Array | None:
    """Return (n,) half-widths, inf for none: those given, within the model's own box.

    Raises
    ------
    ModelError : shapes, numbers, a model whose domain is not a box, a box of the model without 0
        inside, or with the range of an input that no limit keeps.
    """
    if getattr(model, "domain", None) is not None:
        raise ModelError(
            "the model equals its plant on a band or a union of cells only, and no box inside it "
            "is known; derive the model on a box (sector_model without domain)"
        )
    limits = limits_of(n, 1, state_box=state_box)
    model_box = np.full(n, np.inf)
    inputs = tuple(getattr(model, "inputs", ()))
    for variable, (lower, upper) in getattr(model, "box", {}).items():
        half = min(-float(lower), float(upper))
        if variable in getattr(model, "states", ()):
            if half <= 0:
                raise ModelError(
                    f"the model's box of {variable} is {float(lower):g} ... {float(upper):g}; an "
                    "ellipsoid about 0 needs 0 inside it"
                )
            model_box[model.states.index(variable)] = half  # type: ignore[attr-defined]
        elif variable in inputs and (
            input_limit is None or input_limit[inputs.index(variable)] > half
        ):
            raise ModelError(
                f"the model equals its plant only for |{variable}| <= {half:g}; give an "
                "input_limit within that"
            )
    box = model_box if limits.states is None else np.minimum(model_box, limits.states)
    return box if np.isfinite(box).any() else None


def measure_of(measure: str | ArrayLike, n: int) -> str | Array:
    """Return "volume", "trace" or points, (k, n); half-widths (n,) become corners of the box.

    Raises
    ------
    ModelError : an unknown name, a shape, entries that are not finite, points that are all 0.
    """
    if isinstance(measure, str):
        if measure not in MEASURES:
            raise ModelError(
                f"measure {measure!r} is not known; there are volume, trace, or points (k, {n})"
                + did_you_mean(measure, list(MEASURES))
            )
        return measure
    try:
        points = np.asarray(measure, dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise ModelError(f"measure cannot be read as points ({error}); give (k, {n})") from error
    if points.ndim == 1:
        box = positive_vector("measure", points, n)
        limits = limits_of(n, 1, initial_box=box)
        assert limits.initial is not None
        return limits.initial
    if points.ndim != 2 or points.shape[1] != n or not np.isfinite(points).all():
        raise ModelError(
            f"measure has shape {points.shape}; points (k, {n}), half-widths ({n},), or a name "
            "are needed, all finite"
        )
    if not points.any():
        raise ModelError("the points of the measure are all 0, so any multiple of them is in")
    return points


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class AttractionRequest:
    """What is asked, in one set of coordinates.

    A, B : (r, n, n), (r, n, m); m = 0 without inputs.
    gains : K, (r, m, n) or (1, m, n); None where they are sought.
    sought : whether gains are sought; without gains and not sought, u = 0.
    input_limit : (m,) or None.
    saturation : None, |u| <= limit everywhere; or "polytope".
    overdrive : |v_k| <= overdrive input_limit_k for the command v of gains that are sought.
    state_box : (n,), inf for none; or None.
    decay_rate, saturated_decay_rate : alpha in 1/s where no input saturates, and where one does.
    step : sample time in s or None.
    relaxation : name; measure : "volume", "trace" or points (k, n).
    units : (n,), in which the trace is measured.
    corners : as in ``DoubleSum``.
    """

    A: Array
    B: Array
    gains: Array | None
    sought: bool
    input_limit: Array | None
    saturation: str | None
    overdrive: float
    state_box: Array | None
    decay_rate: float
    saturated_decay_rate: float
    step: float | None
    relaxation: str
    measure: str | Array
    units: Array
    corners: Indices | None

    @property
    def slowest(self) -> float:
        """Return the alpha that holds in the whole ellipsoid."""
        return self.decay_rate if self.saturation is None else self.saturated_decay_rate

    def scaled(self, s: Array, tau: Array) -> AttractionRequest:
        """Return the task in x = s xhat, u = tau uhat."""
        return replace(
            self,
            A=self.A * s / s[:, None],
            B=self.B * tau / s[:, None],
            gains=None if self.gains is None else self.gains * s / tau[:, None],
            input_limit=None if self.input_limit is None else self.input_limit / tau,
            state_box=None if self.state_box is None else self.state_box / s,
            units=self.units / s,
            measure=self.measure if isinstance(self.measure, str) else self.measure / s,
        )


def attraction_request(
    model: object,
    A: Array,
    B: Array,
    gains: Array | None,
    *,
    state_box: ArrayLike | None,
    input_limit: ArrayLike | None,
    saturation: str | None,
    overdrive: float,
    decay_rate: float,
    saturated_decay_rate: float,
    relaxation: str,
    measure: str | ArrayLike,
    sample_time: float | None,
) -> AttractionRequest:
    """Return the task in the model's own coordinates, for gains that are known.

    Parameters and errors are those of ``attraction_ellipsoid``.
    """
    relaxation_named(relaxation)
    n, m = B.shape[1:]
    if saturation not in (None, "polytope"):
        raise ModelError(f'saturation {saturation!r} is not known; there are None and "polytope"')
    limit = None if input_limit is None else positive_vector("input_limit", input_limit, m)
    if saturation is not None and limit is None:
        raise ModelError(f"saturation {saturation!r} needs input_limit, where the inputs saturate")
    step = sample_time_of(model, sample_time)
    fast = float(number("decay_rate", decay_rate, at_least=0.0))
    slow = float(number("saturated_decay_rate", saturated_decay_rate, at_least=0.0))
    if slow > fast:
        raise ModelError(
            f"saturated_decay_rate is {slow:g}, decay_rate only {fast:g} 1/s; saturation slows a "
            "loop down, so ask for no more where an input saturates"
        )
    # Without inputs u = 0, which every box of the inputs holds.
    input_bound = np.zeros(len(getattr(model, "inputs", ()))) if m == 0 else limit
    box = state_box_of(model, state_box, n, input_bound)
    return AttractionRequest(
        A=A,
        B=B,
        gains=gains,
        sought=False,
        input_limit=limit,
        saturation=saturation,
        overdrive=float(number("overdrive", overdrive, at_least=1.0)),
        state_box=box,
        decay_rate=fast,
        saturated_decay_rate=slow,
        step=step,
        relaxation=relaxation,
        measure=measure_of(measure, n),
        units=np.ones(n) if box is None else np.where(np.isfinite(box), box, 1.0),
        corners=corners_of(model),
    )


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
