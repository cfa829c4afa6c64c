r"""The LMIs of one region's gains: decay, and actuator bounds on an ellipsoid that holds a set.

In scaled states and input, with Q = P^-1 > 0 and M_i = K_i Q, u = -sum_i h_i K_i x:

    A_i Q - B M_i + (.)' + 2 alpha Q < 0                        decay of V = x' P x
    [[1, x_k'], [x_k, Q]] >= 0                                  the set's corners lie in V <= 1
    [[u_max^2, M_i], [M_i', Q]] >= 0                            |u| <= u_max on V <= 1
    [[mu, M_i + c Q], [(.)', Q]] >= 0,  mu <= r_max^2           |u - c x| <= r_max on V <= 1
    Q_ll <= b_l^2                                               |x_l| <= b_l: inside the box

with mu least: of all gains that meet the requirement, these need the least actuator effort.

B is the same in every rule, so sum_ij h_i h_j (A_i Q - B M_j) = sum_i h_i (A_i Q - B M_i): the
rules' own inequalities are the double sum, and no relaxation can add anything.  Bounds at the
rules hold for every blend, because u is a convex sum of the rules' commands.

Source: Tanaka and Wang (2001), Fuzzy Control Systems Design and Analysis, sections 3.3-3.4 (decay
rate, constraint on the input); Boyd et al. (1994), section 7.2.3.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from takagi.lmi.condition.statements import pose, scale_bound
from takagi.lmi.condition.term import LMI, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.expressions.expression import Expression, He, Inequality, Parameter, block, matrix
from takagi.lmi.gains.requirements.limits import initial_lmis, input_lmis, state_lmis
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.ts.model import TSModel
from takagi.models.turbine.data import Turbine
from takagi.models.turbine.region_models import PITCH_DEVIATION, SPEED_ERROR, WIND_ESTIMATE
from takagi.models.turbine.trim import TrimPoint, trim

# Largest eigenvalue of Q in scaled states: the ellipsoid reaches at most the root of this times the
# states' ranges. The bound only keeps the unknowns bounded.
LARGEST_Q = 1e3
# Margin of a bound for a margin 1 of decay: a small margin is enough for the bounds, so that decay
# gets most of it.
LIMIT_WEIGHT = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class ActuatorBound:
    """|u - c x| <= limit on the ellipsoid.

    Attributes
    ----------
    name : what is bounded, in words.
    limit : in the condition's coordinates, > 0.
    offset : c, (n,); zero for the command itself.
    minimised : whether the bound is made as small as it can be, instead of just kept.
    """

    name: str
    limit: float
    offset: Floats
    minimised: bool = False


def regional_gain_condition(
    A: Floats,
    B: Floats,
    *,
    decay_rate: float,
    corners: Floats,
    bounds: tuple[ActuatorBound, ...],
    box: Floats,
) -> Condition:
    """Pose decay at every rule, set inside ellipsoid inside box, and the actuator bounds.

    Parameters
    ----------
    A : (r, n, n);  B : (n, 1), the same in every rule; both in scaled coordinates.
    decay_rate : alpha [1/s].
    corners : (s, n), the operating set is their hull (and its mirror image).
    bounds : what must hold on the ellipsoid; one of them is made least.
    box : (n,) half widths of the model's box; inf where a state is free.

    Returns
    -------
    The condition in Q (n, n), M (r, 1, n) and mu.  Nothing is solved.

    Raises
    ------
    ModelError : shapes that do not fit, or a bound that is not positive.
    """
    rules, n = A.shape[:2]
    if A.shape != (rules, n, n) or B.shape != (n, 1) or corners.shape[1:] != (n,):
        raise ModelError(
            f"A {A.shape}, B {B.shape} and corners {corners.shape} were given; (r, n, n), (n, 1) "
            "and (s, n) are needed"
        )
    Q = Unknown("Q", n, n, symmetric=True)
    M = Unknown("M", 1, n, count=rules)
    mu = Unknown("mu", 1, 1, symmetric=True, latex=r"\mu")
    alpha = Parameter("alpha", decay_rate, r"\alpha")
    decay = He(matrix(A, "A_{i}") @ Q - matrix(B, "B") @ _each(M)) + 2 * alpha * Q << 0
    statements: list[LMI | Inequality] = [
        scale_bound(Q, LARGEST_Q, latex=r"\kappa I"),
        decay.named("decay of rule", rf"i = 1, \dots, {rules}"),
        *initial_lmis(Q, corners),
        *state_lmis(Q, box),
    ]
    for bound in bounds:
        _check_bound(bound, n)
        if bound.minimised or np.any(bound.offset):
            statements += _demand(Q, M, mu, bound)
        else:
            statements += input_lmis(Q, M, np.array([bound.limit]))
    minimised = any(bound.minimised for bound in bounds)
    return pose(
        *statements,
        minimise=mu if minimised else None,
        unknowns=(Q, M, mu) if minimised else (Q, M),
        name="regional gains with decay rate and actuator bounds",
        source="Tanaka and Wang (2001), sections 3.3-3.4",
    )


def _each(M: Unknown) -> Expression:
    return M.members(np.arange(M.count), "M_{i}")


def _check_bound(bound: ActuatorBound, n: int) -> None:
    if not bound.limit > 0 or bound.offset.shape != (n,):
        raise ModelError(
            f"{bound.name}: limit {bound.limit!r} and offset of shape {bound.offset.shape} were "
            f"given; a limit above 0 and one offset per state ({n}) are needed"
        )


def _demand(Q: Unknown, M: Unknown, mu: Unknown, bound: ActuatorBound) -> list[Inequality]:
    """Pose [[mu, M_i + c Q], [(.)', Q]] >= 0 and mu <= limit^2, or the limit itself for mu."""
    limit = matrix([[bound.limit**2]], r"\bar r^2")
    demanded = _each(M) + matrix(bound.offset[None], "c") @ Q
    demand = block([[mu if bound.minimised else limit, demanded], [None, Q]]) >> 0
    named = demand.named(
        bound.name,
        rf"i = 1, \dots, {M.count}",
        weight=LIMIT_WEIGHT,
        labels=tuple(f"{bound.name}, rule {i + 1}" for i in range(M.count)),
    )
    if not bound.minimised:
        return [named]
    return [named, (limit - mu >> 0).named(f"limit: {bound.name}", weight=LIMIT_WEIGHT)]


WIND_SAMPLES = 43


@dataclass(frozen=True, slots=True)
class Requirement:
    """The requirement on one region's gains.

    Attributes
    ----------
    decay_rate : alpha [1/s]; V' <= -2 alpha V.
    speed_error : rotor speed errors of the operating set, up to this [rad/s].
    pitch_error : its pitch deviations, up to this [rad]; unused in partial load.
    """

    decay_rate: float
    speed_error: float
    pitch_error: float = 0.0

    def __post_init__(self) -> None:
        if not (self.decay_rate > 0 and self.speed_error > 0 and self.pitch_error >= 0):
            raise ModelError(
                f"decay rate {self.decay_rate!r} 1/s, speed error {self.speed_error!r} rad/s, "
                f"pitch error {self.pitch_error!r} rad were given; the first two must exceed 0"
            )


# With one integrator for both regions, pitch at rest is f_1 k_I^c / k_I^b times the torque, divided
# by 1 + f_1 k_p^c. Pitch rests near its trim in partial load only if torque is integrated much
# faster than pitch, hence these rates.
PARTIAL_LOAD = Requirement(decay_rate=0.3, speed_error=0.01)
FULL_LOAD = Requirement(decay_rate=0.02, speed_error=0.02, pitch_error=0.0025)


@dataclass(frozen=True, slots=True, eq=False)
class RegionRequest:
    """One region in SI units, and the scales of its states and command."""

    region: str
    model: TSModel
    requirement: Requirement
    bounds: tuple[ActuatorBound, ...]
    box: Floats
    scales: Floats
    unit: float

    def condition(
        self, requirement: Requirement, *, bounded: bool = True, boxed: bool = True
    ) -> Condition:
        """Return the scaled condition, with or without actuator bounds and the model's box."""
        s, u = self.scales, self.unit
        scaled = tuple(
            replace(b, limit=b.limit / u, offset=b.offset * s / u) for b in self.bounds if bounded
        )
        return regional_gain_condition(
            self.model.A * s / s[:, None],
            self.model.B[0] * u / s[:, None],
            decay_rate=requirement.decay_rate,
            corners=_corners(requirement, len(s)) / s,
            bounds=scaled,
            box=self.box / s if boxed else np.full(len(s), np.inf),
        )


def region_request(
    turbine: Turbine, model: TSModel, requirement: Requirement, speed_setpoint: float | None
) -> RegionRequest:
    if model.B.shape[2] != 1 or np.ptp(model.B, axis=0).any() or SPEED_ERROR not in model.box:
        raise ModelError(
            f"model {model.name!r}: a regional model with one input, the same in all rules, and "
            f"a box in {SPEED_ERROR!r} is needed"
        )
    with_pitch = PITCH_DEVIATION in model.states
    box = np.array([_half_width(model, name) for name in model.states])
    corners = _corners(requirement, len(box))
    if np.any(np.abs(corners) > box):
        raise ModelError(
            f"{model.name}: the operating set reaches {np.abs(corners).max(axis=0)} in "
            f"{', '.join(model.states)}, the model is exact up to {box}; ask for smaller errors or "
            "make the model with wider bands"
        )
    points = [trim(turbine, v, speed_setpoint=speed_setpoint) for v in _winds(model)]
    bounds = (_pitch_bounds if with_pitch else _torque_bounds)(turbine, points)
    # The integral of an error that decays at the required rate has this size.
    ranges = np.where(np.isfinite(box), box, box[0] / requirement.decay_rate)
    return RegionRequest(
        "full load" if with_pitch else "partial load",
        model,
        requirement,
        bounds,
        box,
        nearest_power(ranges),
        float(nearest_power(np.array(bounds[0].limit))),
    )


def _half_width(model: TSModel, state: str) -> float:
    if state not in model.box:
        return np.inf
    low, high = model.box[state]
    return float(min(high, -low))


def _corners(requirement: Requirement, states: int) -> Floats:
    e, p = requirement.speed_error, requirement.pitch_error
    if states == 2:
        return np.array([[e, 0.0]])
    return np.array([[first, second, 0.0] for first, second in product((e,), (p, -p))])


def _winds(model: TSModel) -> tuple[float, ...]:
    low, high = (float(end) for end in model.box[WIND_ESTIMATE])
    return tuple(float(v) for v in np.linspace(low, high, WIND_SAMPLES))


def _torque_bounds(turbine: Turbine, points: list[TrimPoint]) -> tuple[ActuatorBound, ...]:
    """Return |dT| <= the least distance of the trim torque from 0 and from its maximum."""
    torques = [point.torque for point in points]
    limit = min(min(torques), turbine.maximum_torque - max(torques))
    return (ActuatorBound("torque within its limits", limit, np.zeros(2), True),)


def _pitch_bounds(turbine: Turbine, points: list[TrimPoint]) -> tuple[ActuatorBound, ...]:
    angles = [point.pitch for point in points]
    room = min(min(angles) - turbine.pitch_min, turbine.pitch_max - max(angles))
    if room <= 0:
        raise ModelError(
            f"{turbine.name}: the trim pitch is at a limit at {points[0].wind:.4g} m/s, so no "
            "pitch command has room on both sides; begin the wind range above rated wind"
        )
    drive = np.array([0.0, 1.0, 0.0])
    # The reference is made small, not the rate: the least rate would need a reference that follows
    # the pitch, and such a positive feedback makes the drive of the blended loop slow.
    return (
        ActuatorBound("pitch reference above the smallest pitch", room, np.zeros(3), True),
        # u = -K x, so |u - delta_beta| is |(K + (0, 1, 0)) x|.
        ActuatorBound(
            "demanded pitch rate (times the drive's time constant) within its limit",
            turbine.pitch_rate_limit * turbine.pitch_time_constant,
            drive,
        ),
    )
