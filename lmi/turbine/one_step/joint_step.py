r"""LMIs of one step that changes the quadratic function, the gains and the wind class together.

The loop's corners A, d are linearised in the logarithms u of the gains (``loop_of_gains``), with
d = fixed + s_k error, where s_k is the multiple of the wind error that cell k tolerates.  In
coordinates where the present function is |x|^2 and P = I + X, a corner of cell k with multiplier
alpha_k (1 + a_k) and multiple s_k (1 + c_k) satisfies the invariance inequality if

    [ He(P (A + dA(u))) + alpha (1 + a) P     P (d + dd(u) + s c error) ]
    [ .                                      -alpha (1 + a)             ]  < 0 .

Let W = [dA(u) + alpha a I / 2,  dd(u) + s c error] and E = [I, 0]'.  Except for the products u c,
the part that is not linear in the unknowns is He(E X W), and for any t > 0

    He(E X W) = |t X E' + W / t|^2 / 2 - |t X E' - W / t|^2 / 2  <=  |t X E' + W / t|^2 / 2 :

By the Schur complement the last expression is a block row [t X E' + W / t] with -2 I on the
diagonal.  A solution of these LMIs satisfies the inequality above.  The present function and gains
satisfy the LMIs, so within the linearisation a step never makes the objective worse.  The LMI for
the decay rate d of a function R is the same without the column of d, with alpha = 2 d for all
cells.

Source: derived here; Dinh, Gumussoy, Michiels, Diehl (2012), IEEE Trans. Automatic Control 57(6),
for the convex-concave decomposition of bilinear matrix inequalities; Boyd, El Ghaoui, Feron,
Balakrishnan (1994), section 6.1.3, for the invariant set.

The LMIs have few corners at first, and more as needed.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from takagi.lmi.condition.statements import lmi_of
from takagi.lmi.condition.term import LMI, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import He, added, block, identity, matrix, symmetric_block
from takagi.lmi.parameter_search.parameter_sweep import unknowns_near_least
from takagi.lmi.turbine.one_step.loop_of_gains import (
    LoopFunctions,
    MovingCorners,
    WindCellCorners,
    reached_by_function,
)
from takagi.models.arrays import Floats, Indices

ONE, EYE = np.ones((1, 1, 1)), np.eye(3)[None]


@dataclass(frozen=True, slots=True, eq=False)
class Around:
    """Corners in coordinates where the present function is |x|^2.

    Attributes
    ----------
    moving : corners and their secants; the secants are zero when the gains are fixed.
    speed : (N,) alpha of each corner, or 2 d [1/s].
    scale : (N,) s of each corner.
    pace : (N,) index of the unknown that is the relative change of a corner's ``speed``.
    disturbed : whether the LMI contains the disturbance column d.
    """

    moving: MovingCorners
    speed: Floats
    scale: Floats
    pace: Indices
    disturbed: bool

    @classmethod
    def of(
        cls,
        moving: MovingCorners,
        T: Floats,
        speed: Floats,
        scale: Floats,
        pace: Indices,
        *,
        disturbed: bool,
    ) -> Around:
        """Return corners for x = T xhat."""
        inverse, at = np.linalg.inv(T), moving.at
        posed = MovingCorners(
            WindCellCorners(
                inverse @ at.A @ T, at.fixed @ inverse.T, at.error @ inverse.T, at.cell
            ),
            moving.members,
            inverse @ moving.A @ T,
            moving.fixed @ inverse.T,
            moving.error @ inverse.T,
        )
        return cls(posed, speed, scale, pace, disturbed)

    @property
    def d(self) -> Floats:
        """Return (N, 3): the disturbance d at the present gains and multiples."""
        at = self.moving.at
        return np.asarray(at.fixed + self.scale[:, None] * at.error)

    @property
    def dd(self) -> Floats:
        """Return (N, 3, 3): the change of d per unit of each gain's logarithm."""
        return np.asarray(self.moving.fixed + self.scale[:, None, None] * self.moving.error)

    @property
    def spread(self) -> Floats:
        """Return t (N,): the square root of |dA| or alpha / 2, whichever is larger.

        The bound on He(E X W) holds for every t > 0 and is exact where t X E' = W / t; this t makes
        both sides equally large for steps X of order one.
        """
        speeds = np.linalg.norm(self.moving.A, axis=(2, 3)).max(axis=1)
        return np.asarray(np.sqrt(np.maximum(speeds, self.speed / 2)), dtype=np.float64)


def motion_lmi(
    name: str,
    around: Around,
    chosen: Indices,
    P: Unknown,
    u: Unknown | None,
    pace: Unknown,
    wider: Unknown,
) -> LMI:
    """Return the module's LMI over the chosen corners, each divided by its alpha.

    The division gives all cells margins of the same order, although their alphas differ.

    ``u`` : scalars, one per gain; None if the gains are fixed.
    ``pace``, ``wider`` : scalars, the relative changes a of ``around.speed`` and c of
    ``around.scale``.
    """
    moving, index = around.moving, around.pace[chosen]
    speed = around.speed[chosen][:, None, None]
    root = np.sqrt(speed)
    s = around.spread[chosen][:, None, None]
    A, d = moving.at.A[chosen] / speed, around.d[chosen][:, :, None] / speed
    error_columns = (around.scale[:, None] * moving.at.error)[chosen][:, :, None]
    changes = around.dd[chosen][:, :, :, None]
    last = 2 if around.disturbed else 1
    P_A, a = P @ matrix(A, "A / \\alpha"), pace.members(index, "a")
    state = He(P_A) + P + a * identity(3)
    step = matrix(s / root * EYE, "t") @ P - matrix(s / root * EYE, "t")
    step = step + a * matrix(root / (2 * s) * EYE, r"\tfrac{1}{2t}")
    pushed, pushed_step = P @ matrix(d, "d"), None
    if around.disturbed:
        c = wider.members(index, "c")
        pushed = pushed + c * matrix(error_columns / speed, r"e / \alpha")
        pushed_step = c * matrix(error_columns / (s * root), "e / t")
    for j in range(3 if u is not None else 0):
        assert u is not None
        dA, dd = moving.A[chosen, j], changes[:, j]
        u_j = u.members(moving.members[chosen, j], f"u_{{{j + 1}}}")
        symmetrised = (dA + dA.transpose(0, 2, 1)) / speed
        state = state + u_j * matrix(symmetrised, rf"\mathrm{{He}}(dA_{{{j + 1}}}) / \alpha")
        step = step + u_j * matrix(dA / (s * root), f"dA_{{{j + 1}}} / t")
        if pushed_step is not None:
            pushed = pushed + u_j * matrix(dd / speed, rf"dd_{{{j + 1}}} / \alpha")
            pushed_step = pushed_step + u_j * matrix(dd / (s * root), f"dd_{{{j + 1}}} / t")
    cells = {(0, 0): state, (last, 0): step, (last, last): -2 * identity(3)}
    if pushed_step is not None:
        cells |= {(0, 1): pushed, (1, 1): -a - identity(1), (last, 1): pushed_step}
    sizes = (3, 1, 3) if around.disturbed else (3, 3)
    return lmi_of((symmetric_block(sizes, cells) << 0).named(name))


def limits(unknown: Unknown, low: Floats, high: Floats) -> tuple[LMI, LMI]:
    """Return low <= scalar <= high for each member."""
    each = unknown.members(np.arange(unknown.count), f"{unknown.symbol}_{{i}}")
    lowest, highest = matrix(low[:, None, None], "l_{i}"), matrix(high[:, None, None], "h_{i}")
    return (
        lmi_of((each >= lowest).named(f"{unknown.name} above")),
        lmi_of((each <= highest).named(f"{unknown.name} below")),
    )


def inside_box(P: Unknown, h: Floats) -> LMI:
    """Return P - h_i h_i' >= 0, which holds if and only if {x' P x <= 1} is inside |h_i' x| <= 1.

    The form with P instead of P^-1 keeps it linear in the unknown of this step.
    """
    squares = matrix(h[:, :, None] * h[:, None, :], r"h_{i} h_{i}^\top")
    return lmi_of((P >> squares).named("inside the box"))


def reach_in_speed(P: Unknown, h: Floats, eta: Unknown) -> LMI:
    """Return [[P, h], [h', eta]] >= 0: by the Schur complement eta >= h' P^-1 h.

    h' P^-1 h is the square of the largest speed error on {x' P x <= 1}, relative to the box.
    """
    reach = block([[P, matrix(h[:, :, None], "h")], [None, eta]])
    return lmi_of((reach >> 0).named("reach in speed"))


def mean_class(wider: Unknown, shares: Floats, mean: float) -> LMI:
    """Return sum of share_k c_k >= least."""
    c = wider.members(np.arange(wider.count), "c_{k}")
    total = added(c * matrix(shares[:, None, None], "p_{k}"), latex=r"\sum_k")
    return lmi_of((total >= np.array([[mean]])).named("mean wind class"))


def bounded_below(R: Unknown) -> LMI:
    """Return R >= I / 16, which keeps R positive definite in coordinates where it was I.

    An upper bound is not needed: the block t X E' of the overbound limits X = R - I.
    """
    return lmi_of((R >= EYE[0] / 16).named("R positive definite"))


def bent(u: Unknown, bends: Floats) -> tuple[LMI, LMI]:
    """Return |u_(k+1) - u_k| <= bend for each cell, as two families of scalar inequalities."""
    k = np.arange(len(bends))
    here, there = u.members(k, "u_{k}"), u.members(k + 1, "u_{k+1}")
    bend = matrix(bends[:, None, None], "b_{k}")
    return (
        lmi_of((here - there + bend >= 0).named("bend +1")),
        lmi_of((there - here + bend >= 0).named("bend -1")),
    )


def shortfall(around: Around, P: Floats, u: Floats | None, pace: Floats, wider: Floats) -> Floats:
    """Return (N,): the largest eigenvalue of the bilinear inequality divided by its alpha.

    A corner satisfies its inequality if its value is negative.  The products of unknowns are
    included here, unlike in the convex LMI.
    """
    moving, at = around.moving, around.moving.at
    scale = around.scale * (1 + wider[at.cell]) if around.disturbed else around.scale
    A, d = at.A, at.fixed + scale[:, None] * at.error
    if u is not None:
        by = u[moving.members]
        A = A + np.einsum("nj,njab->nab", by, moving.A)
        d = d + np.einsum("nj,nja->na", by, moving.fixed + scale[:, None, None] * moving.error)
    speed = around.speed * (1 + pace[around.pace])
    n = 4 if around.disturbed else 3
    M = np.zeros((len(A), n, n))
    PA = P @ A
    M[:, :3, :3] = (PA + PA.transpose(0, 2, 1)) / speed[:, None, None] + P
    if around.disturbed:
        M[:, :3, 3] = d @ P / speed[:, None]
        M[:, 3, :3] = M[:, :3, 3]
        M[:, 3, 3] = -1.0
    return np.asarray(np.linalg.eigvalsh(M)[:, -1], dtype=np.float64)


# The margin with which the LMIs are solved, in units of order one.  A corner counts as violated
# above VIOLATED, which is nearer to zero, so that solver errors do not add corners.
REQUIRED_MARGIN, VIOLATED = 1e-6, -1e-7
# A step of the gains accepts larger violations: new enclosures decide about it anyway.
ROUGHLY = 5e-3
# Corners of each cell in the first solve, corners added to each cell after a solve, and the largest
# number of solves.  Most corners are never active, so the small problems are much cheaper.
FIRST, ADDED, ROUNDS = 2, 2, 15
# Largest relative change of a multiplier in a step.
PACE = 0.5
# Largest relative rise of a cell's multiple that a floor may enforce in one step.
RAISED = 0.03


@dataclass(frozen=True, slots=True, eq=False)
class Weights:
    """Weights of the relative changes whose sum one step minimises, and limits on the changes.

    Attributes
    ----------
    wind_class : (K - 1,) weights of 1 / multiple of the wind error in each cell.
    overspeed : weight of the largest speed error on {x' P x <= 1}.
    decay : weight of 1 / decay rate.
    shares : (K - 1,) shares of the cells in the mean over wind.
    log_mean : lower limit of the mean relative change of the multiples; None for no limit.
    floors : (K - 1,) lower limits of the multiples.
    """

    wind_class: Floats
    overspeed: float
    decay: float
    shares: Floats
    log_mean: float | None
    floors: Floats


# Limits of a step: (G,) low and high of u; (K - 1,) bends, the largest |u_(k+1) - u_k| of gamma.
Room: TypeAlias = tuple[Floats, Floats, Floats]


def joint_step(
    windy: MovingCorners | WindCellCorners,
    calm: MovingCorners | WindCellCorners,
    functions: LoopFunctions,
    directions: Floats,
    weights: Weights,
    room: Room | None = None,
) -> tuple[Floats, LoopFunctions] | None:
    """Return u (G,), empty for fixed gains, and functions of the best step of the convex condition.

    None if the solver finds none.  The functions are those of the linearised loop.

    Parameters
    ----------
    windy, calm : corners under the wind class, and undisturbed; without secants if the gains are
        fixed.
    directions : (D, 3) rows h_i scaled so that the box is |h_i' x| <= 1; the first is speed.
    room : limits on the change of the gains; None if the gains are fixed.
    """
    posed = _StepCondition(windy, calm, functions, directions, weights, room)
    chosen = [posed.first(around) for around in posed.arounds]
    for _ in range(ROUNDS):
        values = unknowns_near_least(posed.condition(chosen), required_margin=REQUIRED_MARGIN)
        if not values or not all(np.all(np.isfinite(value)) for value in values.values()):
            return None
        worst = [posed.shortfall(i, values) for i in range(len(posed.arounds))]
        fresh = []
        for around, cell_worst, old in zip(posed.arounds, worst, chosen, strict=True):
            violated = np.nonzero(cell_worst >= (VIOLATED if room is None else ROUGHLY))[0]
            among = np.setdiff1d(violated, old)
            fresh.append(_by_cell(around.moving.at.cell, among, cell_worst, ADDED))
        if not any(len(cell_worst) for cell_worst in fresh):
            return posed.step(values)
        chosen = [np.union1d(old, new) for old, new in zip(chosen, fresh, strict=True)]
    return None


class _StepCondition:
    """The condition in coordinates where P and R are I."""

    def __init__(
        self,
        windy: MovingCorners | WindCellCorners,
        calm: MovingCorners | WindCellCorners,
        functions: LoopFunctions,
        directions: Floats,
        weights: Weights,
        room: Room | None,
    ) -> None:
        self.functions, self.weights, self.room = functions, weights, room
        moving = [
            corners if isinstance(corners, MovingCorners) else MovingCorners.still(corners)
            for corners in (windy, calm)
        ]
        self.T = [np.linalg.inv(np.linalg.cholesky(M)).T for M in (functions.P, functions.R)]
        wind, calm_moving = moving
        cell, count = wind.at.cell, len(functions.multipliers)
        alpha, scale = functions.multipliers[cell], functions.scales[cell]
        self.arounds = [Around.of(wind, self.T[0], alpha, scale, cell, disturbed=True)]
        if weights.decay > 0:
            size = len(calm_moving.at.A)
            speed, one = np.full(size, 2 * functions.decay_rate), np.zeros(size, dtype=np.intp)
            self.arounds.append(
                Around.of(calm_moving, self.T[1], speed, np.ones(size), one, disturbed=False)
            )
        self.h = directions @ self.T[0]
        self.speed_reach = float(reached_by_function(functions.P, directions)[0])
        self.wider = Unknown("c", 1, 1, count=count)
        self.u = None if room is None else Unknown("u", 1, 1, count=len(room[0]))
        self.shapes = [Unknown(name, 3, 3, symmetric=True) for name in ("P", "R")]
        self.paces = [Unknown("a", 1, 1, count=count), Unknown("r", 1, 1)]
        self.eta = Unknown("eta", 1, 1)

    def first(self, around: Around) -> Indices:
        pace = np.zeros(int(around.pace.max()) + 1)
        worst = shortfall(around, EYE[0], None, pace, np.zeros(self.wider.count))
        return _by_cell(around.moving.at.cell, np.arange(len(worst)), worst, FIRST)

    def shortfall(self, i: int, values: Mapping[str, Floats]) -> Floats:
        u = None if self.u is None else values["u"][:, 0, 0]
        pace = values[self.paces[i].name][:, 0, 0]
        wider = values["c"][:, 0, 0]
        return shortfall(self.arounds[i], values[self.shapes[i].name][0], u, pace, wider)

    def condition(self, chosen: list[Indices]) -> Condition:
        w = self.weights
        count = len(self.arounds)
        unknowns = [*self.shapes[:count], *self.paces[:count], self.wider, self.eta]
        lmis: list[LMI] = [
            motion_lmi(name, around, index, P, self.u, pace, self.wider)
            for name, around, index, P, pace in zip(
                ("invariance", "decay"),
                self.arounds,
                chosen,
                self.shapes[:count],
                self.paces[:count],
                strict=False,
            )
        ]
        lmis += [
            inside_box(self.shapes[0], self.h),
            reach_in_speed(self.shapes[0], self.h[:1], self.eta),
        ]
        lmis += limits(self.paces[0], *_ends(self.paces[0].count, PACE))
        lmis += limits(self.wider, *self._wider_ends())
        if w.log_mean is not None:
            lmis.append(mean_class(self.wider, w.shares, w.log_mean))
        # Without a requested bound on speed, a small weight keeps eta bounded above: otherwise the
        # optimal set is unbounded in eta.  The factor 0.5 is d log sqrt(eta) / d log eta.
        objective = {
            "c": -w.wind_class[:, None, None],
            "eta": 0.5 * (w.overspeed or 1e-4) / self.speed_reach * ONE,
        }
        if count > 1:
            lmis += limits(self.paces[1], *_ends(1, PACE))
            lmis.append(bounded_below(self.shapes[1]))
            objective["r"] = -w.decay * ONE
        if self.u is not None and self.room is not None:
            unknowns.append(self.u)
            low, high, bends = self.room
            lmis += limits(self.u, low, high)
            lmis += bent(self.u, bends)
        return Condition(
            name="functions and gains of the effort loop together",
            unknowns=tuple(unknowns),
            lmis=tuple(lmis),
            objective=objective,
            source="derived in takagi.lmi.turbine.one_step.joint_step",
        )

    def _wider_ends(self) -> tuple[Floats, Floats]:
        low, high = _ends(self.wider.count, PACE)
        # A cell below its floor is raised by at most RAISED in one step: the whole rise at once may
        # make the LMIs infeasible.
        needed = self.weights.floors / self.functions.scales - 1
        return np.maximum(low, np.minimum(needed, RAISED)), high

    def step(self, values: Mapping[str, Floats]) -> tuple[Floats, LoopFunctions]:
        f = self.functions
        # The solver worked in coordinates in which the functions before the step are the identity.
        back = [np.linalg.inv(T) for T in self.T]
        P = back[0].T @ values["P"][0] @ back[0]
        R, decay = f.R, f.decay_rate
        if len(self.arounds) > 1:
            R = back[1].T @ values["R"][0] @ back[1]
            decay = decay * (1 + float(values["r"][0, 0, 0]))
        alpha = f.multipliers * (1 + values["a"][:, 0, 0])
        u = np.zeros(0) if self.u is None else values["u"][:, 0, 0]
        scales = f.scales * (1 + values["c"][:, 0, 0])
        return u, LoopFunctions((P + P.T) / 2, alpha, scales, (R + R.T) / 2, decay)


def _ends(count: int, size: float) -> tuple[Floats, Floats]:
    return np.full(count, -size), np.full(count, size)


def _by_cell(cell: Indices, among: Indices, worst: Floats, count: int) -> Indices:
    """Return, for each cell, the ``count`` corners with the largest values of ``worst``."""
    chosen = []
    for k in np.unique(cell[among]):
        mine = among[cell[among] == k]
        chosen.append(mine[np.argsort(-worst[mine])[:count]])
    return np.sort(np.concatenate(chosen)) if chosen else np.zeros(0, dtype=np.intp)
