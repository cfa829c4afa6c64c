"""One convex step of functions and gains together, with few corners at first and more as needed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from takagi.lmi.condition.term import LMI, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.parameter_search.parameter_sweep import unknowns_near_least
from takagi.lmi.turbine.one_step.condition import (
    Around,
    bent,
    bounded_below,
    inside_box,
    limits,
    mean_class,
    motion_lmi,
    reach_in_speed,
    shortfall,
)
from takagi.lmi.turbine.one_step.loop_of_gains import (
    LoopFunctions,
    MovingCorners,
    WindCellCorners,
    reached_by_function,
)
from takagi.models.arrays import Floats, Indices

ONE, EYE = np.ones((1, 1, 1)), np.eye(3)[None]
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
    floors : (K - 1,) lower limits of the multiples; None for no limits.
    """

    wind_class: Floats
    overspeed: float
    decay: float
    shares: Floats
    log_mean: float | None = None
    floors: Floats | None = None


@dataclass(frozen=True, slots=True, eq=False)
class RemainingRoom:
    """Limits of a step: (G,) low, high of u; (K - 1,) bends, largest |u_(k+1) - u_k| of gamma."""

    low: Floats
    high: Floats
    bends: Floats


@dataclass(frozen=True, slots=True, eq=False)
class JointStep:
    """Result of a step: u (G,), empty for fixed gains, and functions for the linearised loop."""

    u: Floats
    functions: LoopFunctions


def joint_step(
    windy: MovingCorners | WindCellCorners,
    calm: MovingCorners | WindCellCorners,
    functions: LoopFunctions,
    directions: Floats,
    weights: Weights,
    room: RemainingRoom | None = None,
) -> JointStep | None:
    """Return the best step of the convex condition; None if the solver finds none.

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
        fresh = [
            _worst_of_cells(around, cell_worst, old, VIOLATED if room is None else ROUGHLY)
            for around, cell_worst, old in zip(posed.arounds, worst, chosen, strict=True)
        ]
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
        room: RemainingRoom | None,
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
        self.u = None if room is None else Unknown("u", 1, 1, count=len(room.low))
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
            lmis += limits(self.u, self.room.low, self.room.high)
            lmis += bent(self.u, self.room.bends)
        return Condition(
            name="functions and gains of the effort loop together",
            unknowns=tuple(unknowns),
            lmis=tuple(lmis),
            objective=objective,
            source="derived in takagi.lmi.turbine.one_step.condition",
        )

    def _wider_ends(self) -> tuple[Floats, Floats]:
        low, high = _ends(self.wider.count, PACE)
        if self.weights.floors is None:
            return low, high
        # A cell below its floor is raised by at most RAISED in one step: the whole rise at once may
        # make the LMIs infeasible.
        needed = self.weights.floors / self.functions.scales - 1
        return np.maximum(low, np.minimum(needed, RAISED)), high

    def step(self, values: Mapping[str, Floats]) -> JointStep:
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
        return JointStep(u, LoopFunctions((P + P.T) / 2, alpha, scales, (R + R.T) / 2, decay))


def _ends(count: int, size: float) -> tuple[Floats, Floats]:
    return np.full(count, -size), np.full(count, size)


def _worst_of_cells(around: Around, worst: Floats, old: Indices, threshold: float) -> Indices:
    fresh = np.setdiff1d(np.nonzero(worst >= threshold)[0], old)
    return _by_cell(around.moving.at.cell, fresh, worst, ADDED)


def _by_cell(cell: Indices, among: Indices, worst: Floats, count: int) -> Indices:
    """Return, for each cell, the ``count`` corners with the largest values of ``worst``."""
    chosen = []
    for k in np.unique(cell[among]):
        mine = among[cell[among] == k]
        chosen.append(mine[np.argsort(-worst[mine])[:count]])
    return np.sort(np.concatenate(chosen)) if chosen else np.zeros(0, dtype=np.intp)
