r"""The LMIs of a region of attraction: an ellipsoid {x' P x <= 1} that no trajectory leaves.

With Q = P^-1: the double sums of the loop (one without saturation, several with: ``saturation``),
limits on inputs and states on the ellipsoid (``limits``), and a measure of the ellipsoid's size to
be made as large as possible.  Inside the ellipsoid the limits hold, so inside it
the loop is what the double sums say, V' <= -2 alpha V, and a trajectory that starts in it stays in
it.  A model that equals its plant only on a box is valid only while the ellipsoid lies in the box.

What "as large as possible" means for the ellipsoid {x' P x <= 1}, Q = P^-1: objectives as LMIs.

    volume      det Q largest:  v <= (z_1 ... z_n)^(1/n),  [[Q, T], [T', diag(z)]] >= 0 with T lower
                triangular and z its diagonal; then det Q >= z_1 ... z_n, with equality attained.
                The geometric mean is a tree of [[a, c], [c, b]] >= 0, c^2 <= a b, whose leaves are
                z_1, ..., z_n and, up to a power of two, its root itself.
    trace       sum_k Q_kk / w_k^2 largest: the sum of the squared semi-axes in units w_k.
    points      the largest beta with beta x_k in the ellipsoid for every given point: gamma =
                1 / beta^2 least, [[gamma, x_k'], [x_k, Q]] >= 0.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.2.2, for the aims; Ben-Tal and
Nemirovski (2001), Lectures on Modern Convex Optimization, for the determinant.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from takagi.lmi.analysis.actuator_rates import pairs_of
from takagi.lmi.analysis.decay_rate import vertex_weight
from takagi.lmi.argument_checks import decay_parameter
from takagi.lmi.condition.statements import pose, positive_definite, scale_bound
from takagi.lmi.condition.term import LMI, Array, Condition
from takagi.lmi.condition.unknown import Unknown, triangle
from takagi.lmi.expressions.expression import (
    Expression,
    Inequality,
    Parameter,
    added,
    block,
    matrix,
    placement,
    trace,
)
from takagi.lmi.gains.attraction.request import AttractionRequest
from takagi.lmi.gains.attraction.saturation import SaturatedLoop
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.gains.requirements.limits import input_lmis, row_lmis, state_lmis
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.arrays import Indices


@dataclass(frozen=True, slots=True, eq=False)
class Measure:
    """What to minimise, with its unknowns and LMIs, which are not claims, only an epigraph."""

    minimise: Expression
    unknowns: tuple[Unknown, ...] = ()
    lmis: tuple[Inequality, ...] = ()


def trace_measure(Q: Unknown, units: Array) -> Measure:
    """Return: sum_k Q_kk / units_k^2 largest; units (n,)."""
    return Measure(-trace(np.diag(units**-2.0) @ Q))


def points_measure(Q: Unknown, points: Array) -> Measure:
    """Return: the largest multiple of the given points, (k, n), in the ellipsoid.

    The multiple is gamma^(-1/2).
    """
    gamma = Unknown("gamma", 1, 1, latex=r"\gamma")
    inside = block([[gamma, matrix(points[:, None, :], r"x_k^\top")], [None, Q]]) >= 0
    index = rf"k = 1, \dots, {len(points)}"
    return Measure(+gamma, (gamma,), (inside.named("multiple of the points", index),))


def volume_measure(Q: Unknown) -> Measure:
    """Return: det(Q)^(1/n) largest; v is the unknown ``volume``."""
    n = Q.rows
    if n == 1:
        return trace_measure(Q, np.ones(1))
    v = Unknown("volume", 1, 1, latex="v")
    # The tree's nodes, the root first, then its leaves: children of node k are 2 k and 2 k + 1.
    nodes = 2 ** int(np.ceil(np.log2(n))) - 1
    c = Unknown("means", 1, 1, count=nodes + n, latex="c")
    T = Unknown("factor", 1, 1, count=triangle(n - 1), latex="T")
    root = (c.member(0) - v >= 0).named("volume")
    return Measure(-v, (v, c, T), (_factor_lmi(Q, T, c), _mean_lmi(c, n), root))


def _factor_lmi(Q: Unknown, T: Unknown, c: Unknown) -> Inequality:
    """Pose [[Q, T], [T', z]] >= 0: T lower triangular, z its diagonal, the leaves of the tree."""
    n, eye = Q.rows, np.eye(Q.rows)
    row, column = np.tril_indices(n, -1)
    leaves = np.arange(c.count - n, c.count)
    entries = T.members(np.arange(len(row)), r"T_{\text{lower}}")
    lower = added(entries * placement(eye[row][:, :, None] * eye[column][:, None, :]), latex="")
    z_entries = c.members(leaves, r"\mathrm{diag}(z)")
    z = added(z_entries * placement(eye[:, :, None] * eye[:, None, :]), latex="")
    dots = ", " if n == 2 else r", \dots, "
    index = rf"z = (c_{{{c.count - n + 1}}}{dots}c_{{{c.count}}})"
    return (block([[Q, lower + z], [None, z]]) >= 0).named("factor of Q", index)


def _mean_lmi(c: Unknown, n: int) -> Inequality:
    """Pose [[c_2k, c_k], [c_k, c_2k+1]] >= 0 at every node; the root again for missing leaves."""
    nodes = c.count - n
    k = np.arange(1, nodes + 1)

    def means(index: Indices, symbol: str) -> Expression:
        return c.members(np.where(index <= c.count, index, 1) - 1, symbol)

    rows = block([[means(2 * k, "c_{2k}"), means(k, "c_k")], [None, means(2 * k + 1, "c_{2k+1}")]])
    missing = "" if nodes + 1 == n else rf",\; c_l = c_1 \text{{ for }} l > {c.count}"
    return (rows >= 0).named("geometric mean", rf"k = 1, \dots, {nodes}{missing}")


# Size of Q, in the states at hand, beyond which an ellipsoid is taken to be unbounded.
LARGEST = 1e3
# The parameter that is the rate where an input saturates.
SATURATED = "saturated_rate"


def attraction_condition(task: AttractionRequest) -> Condition:
    """Pose the module's LMIs, with Q <= 1000 I in the coordinates of the task.

    The objective is the measure.  Nothing is solved.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 5.2 and 7.2.3; the sources of
    ``saturation``.
    """
    n, r = task.A.shape[1], len(task.A)
    Q = Unknown("Q", n, n, symmetric=True)
    gain: Unknown | Array | None = task.gains
    unknowns: tuple[Unknown, ...] = ()
    if task.sought:
        gain = gain_unknown(r, task.B.shape[2], n, task.relaxation)
        unknowns = (gain,)
    sums, loop_unknowns, lmis = _loops(task, Q, gain)
    unknowns += loop_unknowns
    single = task.relaxation == "common-gain" or gain is None
    alike = task.saturation is None and isinstance(gain, np.ndarray) and len(gain) == 1
    relaxed = relaxation_named("common-gain" if single or alike or r == 1 else task.relaxation)
    for loop in sums:
        slack, posed = relaxed(loop)
        unknowns += slack
        lmis += posed
    if task.state_box is not None:
        lmis += state_lmis(Q, task.state_box)
    if task.rate_rows is not None and task.rate_limit is not None:
        lmis += row_lmis(Q, task.rate_rows, task.rate_limit, name="input rate limit")
    if not isinstance(task.measure, str):
        measure = points_measure(Q, task.measure)
    else:
        measure = trace_measure(Q, task.units) if task.measure == "trace" else volume_measure(Q)
    return pose(
        positive_definite(Q),
        scale_bound(Q, LARGEST),
        *lmis,
        *measure.lmis,
        minimise=measure.minimise,
        unknowns=(Q, *unknowns, *measure.unknowns),
        parameters=_rates(task) if task.saturation is not None else _rates(task)[:1],
        name="region of attraction",
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 5.2 and 7.2.3",
    )


def _loops(
    task: AttractionRequest, Q: Unknown, gain: Unknown | Array | None
) -> tuple[tuple[DoubleSum, ...], tuple[Unknown, ...], tuple[LMI, ...]]:
    """Return the double sums, their unknowns other than Q and M, and the input's limits."""
    A, B = task.A, task.B
    r, m = len(A), B.shape[2]
    rate, saturated_rate = _rates(task)
    loop = SaturatedLoop(
        A=A,
        B=B,
        Q=Q,
        gain=np.zeros((1, m, Q.rows)) if gain is None else gain,
        rate=rate,
        saturated_rate=saturated_rate,
        weight=_weight(task),
        discrete=task.step is not None,
        corners=task.corners,
    )
    if gain is None:
        idle = np.zeros((1, m or 1, Q.rows))
        loop = replace(loop, B=np.zeros((r, Q.rows, m or 1)), gain=idle)
        (plain,) = loop.secant_sums(np.ones(1))
        return (replace(plain, name=""),), (), ()
    if task.saturation in (None, "secant"):
        reach = 1.0 if task.saturation is None else task.overdrive
        sums = loop.secant_sums(np.full(m, 1 / reach))
        if task.saturation is None:
            sums = tuple(replace(double_sum, name="") for double_sum in sums)
        return sums, (), _commanded(task, Q, gain, reach)
    count = 1 if task.relaxation == "common-gain" else r
    Z = Unknown("Z", m, Q.rows, count=count)
    assert task.input_limit is not None
    lmis = input_lmis(Q, Z, task.input_limit, name="input saturation limit")
    if isinstance(gain, Unknown):
        lmis += _commanded(task, Q, gain, task.overdrive)
    if task.saturation == "polytope":
        return loop.polytope_sums(Z), (Z,), lmis
    (plain,) = loop.secant_sums(np.ones(m))
    dead_zone, S = loop.dead_zone_sum(Z)
    return (replace(plain, name="unsaturated"), dead_zone), (Z, *S), lmis


def _rates(task: AttractionRequest) -> tuple[Parameter, Parameter]:
    """Return the rate where no input saturates, and that where one does."""
    plain = decay_parameter(task.decay_rate, task.step)
    saturated = decay_parameter(task.saturated_decay_rate, task.step)
    latex = r"\alpha_{s}" if task.step is None else r"\rho_{s}^2"
    return plain, Parameter(SATURATED, saturated.value, latex)


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
