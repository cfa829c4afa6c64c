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

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TypedDict

import numpy as np

from takagi.lmi.analysis.actuator_rates import pairs_of
from takagi.lmi.analysis.decay_rate import vertex_weight
from takagi.lmi.argument_checks import rate_parameter
from takagi.lmi.condition.term import LMI, Array, Condition, Constant, Term, bounded, positive
from takagi.lmi.condition.unknown import Unknown, triangle
from takagi.lmi.gains.attraction.request import AttractionRequest
from takagi.lmi.gains.attraction.saturation import dead_zone_sum, polytope_sums, secant_sums
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.gains.requirements.limits import input_lmis, row_lmis, state_lmis
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.relaxations import relaxation_named
from takagi.models.arrays import Indices


@dataclass(frozen=True, slots=True, eq=False)
class Measure:
    """An objective for Q, with what it needs: its LMIs are not claims, only an epigraph."""

    objective: Mapping[str, Array]
    unknowns: tuple[Unknown, ...] = ()
    lmis: tuple[LMI, ...] = field(default=())

    def put_on(self, condition: Condition) -> Condition:
        """Return the condition with this objective in the place of its own."""
        return Condition(
            name=condition.name,
            unknowns=condition.unknowns + self.unknowns,
            lmis=condition.lmis + self.lmis,
            objective=self.objective,
            parameters=condition.parameters,
            source=condition.source,
        )


def trace_measure(Q: Unknown, units: Array) -> Measure:
    """Return: sum_k Q_kk / units_k^2 largest; units (n,)."""
    return Measure({Q.name: -np.diag(units**-2.0)[None]})


def points_measure(Q: Unknown, points: Array) -> Measure:
    """Return: the largest multiple of the given points, (k, n), in the ellipsoid.

    The multiple is gamma^(-1/2).
    """
    gamma = Unknown("gamma", 1, 1, latex=r"\gamma")
    eye = np.eye(Q.rows)[None]
    inside = LMI(
        name="multiple of the points",
        blocks=(1, Q.rows),
        terms=(
            Term(unknown=gamma, left=np.ones((1, 1, 1))),
            Term(unknown=Q, left=eye, right=eye, at=(1, 1)),
        ),
        constants=(Constant(value=points[:, None, :], at=(0, 1), latex=r"x_k^\top"),),
        count=len(points),
        strict=False,
        index=rf"k = 1, \dots, {len(points)}",
    )
    return Measure({"gamma": np.ones((1, 1, 1))}, (gamma,), (inside,))


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
    root = LMI(
        name="volume",
        blocks=(1,),
        terms=(
            Term(unknown=c, left=np.ones((1, 1, 1)), symbol="c_1"),
            Term(unknown=v, left=-np.ones((1, 1, 1)), latex=("-", "")),
        ),
        strict=False,
    )
    return Measure(
        {"volume": -np.ones((1, 1, 1))}, (v, c, T), (_factor_lmi(Q, T, c), _mean_lmi(c, n), root)
    )


def _factor_lmi(Q: Unknown, T: Unknown, c: Unknown) -> LMI:
    """Pose [[Q, T], [T', z]] >= 0: T lower triangular, z its diagonal, the leaves of the tree."""
    n = Q.rows
    eye = np.eye(n)
    single = eye[:, :, None] * eye[:, None, :]
    row, column = np.tril_indices(n, -1)
    below = eye[row][:, :, None] * eye[column][:, None, :]
    leaves = np.arange(c.count - n, c.count)
    dots = ", " if n == 2 else r", \dots, "
    here, there = np.zeros(n, dtype=np.intp), np.zeros(len(row), dtype=np.intp)
    return LMI(
        name="factor of Q",
        blocks=(n, n),
        terms=(
            Term(unknown=Q, left=eye[None], right=eye[None]),
            Term(
                unknown=T,
                left=below,
                at=(0, 1),
                items=there,
                members=np.arange(len(row)),
                symbol=r"T_{\text{lower}}",
            ),
            *(
                Term(
                    unknown=c,
                    left=single,
                    at=(side, 1),
                    items=here,
                    members=leaves,
                    symbol=r"\mathrm{diag}(z)",
                )
                for side in (0, 1)
            ),
        ),
        strict=False,
        index=rf"z = (c_{{{c.count - n + 1}}}{dots}c_{{{c.count}}})",
    )


def _mean_lmi(c: Unknown, n: int) -> LMI:
    """Pose [[c_2k, c_k], [c_k, c_2k+1]] >= 0 at every node; the root again for missing leaves."""
    nodes = c.count - n
    k = np.arange(1, nodes + 1)
    terms = [
        Term(
            unknown=c,
            left=np.ones((1, 1, 1)),
            at=at,
            items=np.arange(nodes),
            members=np.where(index <= c.count, index, 1) - 1,
            symbol=symbol,
        )
        for index, at, symbol in (
            (2 * k, (0, 0), "c_{2k}"),
            (2 * k + 1, (1, 1), "c_{2k+1}"),
            (k, (0, 1), "c_k"),
        )
    ]
    missing = "" if nodes + 1 == n else rf",\; c_l = c_1 \text{{ for }} l > {c.count}"
    return LMI(
        name="geometric mean",
        blocks=(1, 1),
        terms=tuple(terms),
        count=nodes,
        strict=False,
        index=rf"k = 1, \dots, {nodes}{missing}",
    )


# Size of Q, in the states at hand, beyond which an ellipsoid is taken to be unbounded.
LARGEST = 1e3
# The parameter that is the rate where an input saturates.
SATURATED = "saturated_rate"


class _Options(TypedDict):
    weight: float
    discrete: bool
    corners: Indices | None


def attraction_condition(task: AttractionRequest) -> Condition:
    """Pose the module's LMIs, with Q <= 1000 I in the coordinates of the task.

    The objective is the measure.  Nothing is solved.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 5.2 and 7.2.3; the sources of
    ``saturation``.
    """
    n, r = task.A.shape[1], len(task.A)
    Q = Unknown("Q", n, n, symmetric=True)
    gain, unknowns = _gain(task, Q)
    sums, loop_unknowns, lmis = _loops(task, Q, gain)
    unknowns += loop_unknowns
    single = task.relaxation == "common-gain" or gain is None
    alike = task.saturation is None and isinstance(gain, np.ndarray) and len(gain) == 1
    pose = relaxation_named("common-gain" if single or alike or r == 1 else task.relaxation)
    for loop in sums:
        slack, posed = pose(loop)
        unknowns += slack
        lmis += posed
    if task.state_box is not None:
        lmis += state_lmis(Q, task.state_box)
    if task.rate_rows is not None and task.rate_limit is not None:
        lmis += row_lmis(Q, task.rate_rows, task.rate_limit, name="input rate limit")
    plain = Condition(
        name="region of attraction",
        unknowns=(Q, *unknowns),
        lmis=(positive(Q), bounded(Q, LARGEST), *lmis),
        parameters=_parameters(task),
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 5.2 and 7.2.3",
    )
    return _measure(task, Q).put_on(plain)


def _gain(
    task: AttractionRequest, Q: Unknown
) -> tuple[Unknown | Array | None, tuple[Unknown, ...]]:
    if not task.sought:
        return task.gains, ()
    M = gain_unknown(len(task.A), task.B.shape[2], Q.rows, task.relaxation)
    return M, (M,)


def _loops(
    task: AttractionRequest, Q: Unknown, gain: Unknown | Array | None
) -> tuple[tuple[DoubleSum, ...], tuple[Unknown, ...], tuple[LMI, ...]]:
    """Return the double sums, their unknowns other than Q and M, and the input's limits."""
    A, B = task.A, task.B
    r, m = len(A), B.shape[2]
    options = _Options(weight=_weight(task), discrete=task.step is not None, corners=task.corners)
    if gain is None:
        idle = np.zeros((1, m or 1, Q.rows))
        (loop,) = secant_sums(A, np.zeros((r, Q.rows, m or 1)), Q, idle, np.ones(1), **options)
        return (replace(loop, name=""),), (), ()
    if task.saturation in (None, "secant"):
        reach = 1.0 if task.saturation is None else task.overdrive
        sums = secant_sums(A, B, Q, gain, np.full(m, 1 / reach), saturated=SATURATED, **options)
        if task.saturation is None:
            sums = tuple(replace(loop, name="") for loop in sums)
        return sums, (), _commanded(task, Q, gain, reach)
    count = 1 if task.relaxation == "common-gain" else r
    Z = Unknown("Z", m, Q.rows, count=count)
    assert task.input_limit is not None
    lmis = input_lmis(Q, Z, task.input_limit, name="input saturation limit")
    if isinstance(gain, Unknown):
        lmis += _commanded(task, Q, gain, task.overdrive)
    if task.saturation == "polytope":
        return polytope_sums(A, B, Q, gain, Z, saturated=SATURATED, **options), (Z,), lmis
    (plain,) = secant_sums(A, B, Q, gain, np.ones(m), **options)
    loop, S = dead_zone_sum(A, B, Q, gain, Z, saturated=SATURATED, **options)
    return (replace(plain, name="unsaturated"), loop), (Z, *S), lmis


def _parameters(task: AttractionRequest) -> dict[str, float]:
    parameters = rate_parameter(task.decay_rate, task.step)
    if task.saturation is not None:
        (parameters[SATURATED],) = rate_parameter(task.saturated_decay_rate, task.step).values()
    return parameters


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


def _measure(task: AttractionRequest, Q: Unknown) -> Measure:
    if not isinstance(task.measure, str):
        return points_measure(Q, task.measure)
    return trace_measure(Q, task.units) if task.measure == "trace" else volume_measure(Q)
