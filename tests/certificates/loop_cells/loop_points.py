"""The nonlinear loop at random points, and how far it is from an interval family.

The loop is the plant's torque, the law's own ``command`` and the limited first-order pitch drive;
its derivative in (e, zeta, x) is taken by differences along the vector field, so that no formula
of the embedding is used.  The family is a box of coefficients: membership is decided exactly by
two intervals.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from takagi.certificates.claims.turbine.cell_loop import cell_loops
from takagi.models import Interval, Turbine
from takagi.models.laws.effort_sharing.law import (
    EffortSharingLaw,
    LoopBox,
    LoopCell,
    LoopUncertainty,
)
from takagi.models.laws.effort_sharing.schedule import EffortSchedule
from takagi.models.laws.protocol import Command, Measurement
from takagi.models.ramps import effort_ramp
from takagi.models.turbine.data import rotor_torque, rotor_torque_gradient

Floats = NDArray[np.float64]

BOX = LoopBox(Fraction("0.045"), Fraction("0.015"), Fraction("0.04"), Fraction("0.03"))
WIDE = LoopUncertainty(Interval.of("0.9", "1.1"), frozen_wake=True)
# The true power coefficient differs from the table's by up to 2 %.
WRONG = 0.02
WIDER = replace(WIDE, power_coefficient=Interval.of("0.98", "1.02"))
# A lag that asks for several times the pitch rate limit.
FAST = LoopBox(Fraction("0.045"), Fraction("0.04"), Fraction("0.04"), Fraction("0.03"))
# Of the differences along the vector field.  Exactly, the loop lies in its family.
ROUNDING = 2e-8
# Wind rates [m/s^2].
RATES_OVER = ((3.0, 10.6, 11.5, 12.5, 13.0, 25.0), (0.1, 0.2, 0.3, 1.0, 1.5, 2.0))


@dataclass(frozen=True)
class Point:
    k: int
    e: float
    zeta: float
    x: float
    schedule_wind: float
    schedule_rate: float
    wind: float
    kappa: float
    wake: float
    power: float


def plain_gains(turbine: Turbine, schedule: EffortSchedule) -> tuple[Floats, Floats]:
    full = turbine.gear_ratio * turbine.rated_torque / turbine.inertia
    reserve = full - effort_ramp(-schedule.trim_effort, schedule.overlap)
    gamma = np.asarray(np.round(np.minimum(0.5, 0.6 * reserve / 0.04), 5), dtype=np.float64)
    nu = np.asarray(np.round(0.05 * np.minimum(gamma[:-1], gamma[1:]), 6), dtype=np.float64)
    return gamma, nu


def effort_sharing_cells(
    turbine: Turbine,
    law: EffortSharingLaw,
    box: LoopBox,
    uncertainty: LoopUncertainty,
    rates: Sequence[float],
) -> list[LoopCell]:
    loops = cell_loops(turbine, law, box, uncertainty)
    return [loop.enclosed(rate) for loop, rate in zip(loops, rates, strict=True)]


def rates_of(law: EffortSharingLaw) -> list[float]:
    nodes = law.schedule.wind
    middle = (nodes[1:] + nodes[:-1]) / 2
    return [round(float(rate), 3) for rate in np.interp(middle, *RATES_OVER)]


def column(law: EffortSharingLaw, name: str, wind: float) -> float:
    table = law.gains.proportional if name == "gamma" else getattr(law.schedule, name)
    return float(np.interp(wind, law.schedule.wind, table))


def points(
    law: EffortSharingLaw, box: LoopBox, count: int, seed: int, *, wrong: float = 0.0
) -> Iterator[Point]:
    """Yield points of the box, half of them on faces and corners; pitch is not below its limit.

    The power coefficient is ``wrong`` by up to this share of the table's.
    """
    rng = np.random.default_rng(seed)

    def draw() -> float:
        return float(rng.choice([-1.0, 1.0]) if rng.random() < 0.5 else rng.uniform(-1, 1))

    rates, held = rates_of(law), law.schedule.wind[[0, -1]]
    e_max, zeta_max, y_max, share = (float(getattr(box, f.name)) for f in fields(box))
    found = 0
    while found < count:
        k = int(rng.integers(len(law.schedule.wind) - 1))
        low, high = law.schedule.wind[k : k + 2]
        v = float(low + (high - low) * (0.5 + 0.4999 * draw()))
        e, y, zeta = e_max * draw(), y_max * draw(), zeta_max * draw()
        effort = column(law, "trim_effort", v) + column(law, "gamma", v) * y
        if zeta > float(effort_ramp(effort, law.schedule.overlap)):
            continue
        found += 1
        kappa = 1 / (1 + 0.1 * draw())
        wind = v + share * float(low) * draw()
        # The law holds the estimate inside its table, and with it the rate.
        seen = np.clip(v + law.wind_filter * rates[k] * draw(), *held)
        rate = float(seen - v) / (law.wind_filter or 1.0)
        power = 1 + wrong * draw() if wrong else 1.0
        yield Point(k, e, zeta, e - y, v, rate, wind, kappa, 0.5 + 0.5 * draw(), power)


def wake_torque(turbine: Turbine, law: EffortSharingLaw, p: Point, pitch: float) -> float:
    """Return what a wake between equilibrium and frozen adds: zero at the trim, steeper in pitch.

    -d/dbeta of it is the share ``wake`` of what the frozen wake's effectiveness has over the
    surface's own slope at omega*, where it has more.
    """
    omega, v = column(law, "rotor_speed", p.schedule_wind), p.schedule_wind
    trim = law.schedule.pitch(v, turbine)
    beta = trim + (pitch - trim) * (np.arange(64) + 0.5) / 64
    own = -p.power * rotor_torque_gradient(turbine, omega, beta, v)[1]
    frozen = turbine.inertia * column(law, "effectiveness_limit", v)
    return float(-p.wake * np.mean(np.maximum(frozen - own, 0.0)) * (pitch - trim))


def physical(law: EffortSharingLaw, p: Point) -> tuple[float, float, float]:
    v = p.schedule_wind
    omega = column(law, "rotor_speed", v) + p.e
    effort = column(law, "trim_effort", v) + column(law, "gamma", v) * (p.e - p.x)
    owed = float(effort_ramp(effort, law.schedule.overlap)) - p.zeta
    return omega, law.pitch_min + owed / column(law, "effectiveness", v), effort


def lag(law: EffortSharingLaw, omega: float, beta: float, x: float, v: float) -> float:
    """Return zeta = b (beta_ref - beta), with the law's own command in a wind that rests."""
    command = law.command([x, v], Measurement(omega, beta, v))
    return column(law, "effectiveness", v) * (command.pitch - beta)


def commanded(law: EffortSharingLaw, p: Point, omega: float, beta: float) -> Command:
    seen = p.schedule_wind + law.wind_filter * p.schedule_rate
    return law.command([p.x, p.schedule_wind], Measurement(omega, beta, seen))


def derivative(turbine: Turbine, law: EffortSharingLaw, p: Point) -> tuple[float, float, float]:
    """Return (e', zeta', x') of the nonlinear loop, e' and zeta' by differences along the field."""
    omega, beta, _ = physical(law, p)
    v = p.schedule_wind
    command = commanded(law, p, omega, beta)
    torque = p.power * float(rotor_torque(turbine, omega, beta, p.wind))
    torque += wake_torque(turbine, law, p, beta)
    speed = p.kappa / turbine.inertia * (torque - turbine.gear_ratio * command.torque)
    limit = turbine.pitch_rate_limit
    turn = float(np.clip((command.pitch - beta) / turbine.pitch_time_constant, -limit, limit))
    x_rate = float(law.state_rate([p.x, v], Measurement(omega, beta, v))[0])
    h = 1e-6
    ahead, behind = (
        lag(law, omega + s * speed, beta + s * turn, p.x + s * x_rate, v + s * p.schedule_rate)
        for s in (h, -h)
    )
    reference = (
        column(law, "rotor_speed", v + h * p.schedule_rate)
        - column(law, "rotor_speed", v - h * p.schedule_rate)
    ) / (2 * h)
    return speed - reference, (ahead - behind) / (2 * h), x_rate


def ends(interval: Interval) -> Floats:
    return np.array([float(interval.lower), float(interval.upper)])


def spread(factor: float, interval: Interval) -> Floats:
    return np.sort(factor * ends(interval))


def distance(cell: LoopCell, p: Point, rates: tuple[float, float, float]) -> float:
    """Return how far a derivative is outside {A xi + d}; exact, for e' enters zeta' as it is.

    e' = a e - G (e - x) + S zeta + w_e: independent coefficients, an interval.  Given e',
    zeta' = f (e' + nu e) - (T - (b'/b) v_s') zeta + w_zeta: an interval again.
    """
    e_rate, zeta_rate, x_rate = rates
    w = float(cell.inertia_gain) * (
        float(cell.residual) + float(cell.wind_gain) * abs(p.wind - p.schedule_wind)
    ) + float(cell.reference_slope) * abs(p.schedule_rate)
    speed = spread(p.e, cell.stiffness) + spread(p.x - p.e, cell.loop_gain)
    speed = speed + spread(p.zeta, cell.lag_gain) + w * np.array([-1, 1])
    nu = float(cell.integral_rate.lower)
    turning = float(cell.effectiveness_slope) * abs(p.schedule_rate * p.zeta)
    owed = spread(e_rate + nu * p.e, cell.share_gain) + spread(-p.zeta, cell.lag_rate)
    owed = owed + (turning + float(cell.lag_disturbance)) * np.array([-1, 1])
    return max(outside(e_rate, speed), outside(zeta_rate, owed), abs(x_rate + nu * p.e))


def outside(value: float, interval: Floats) -> float:
    return float(max(interval[0] - value, value - interval[1]))


def campaign(
    turbine: Turbine, law: EffortSharingLaw, cells: list[LoopCell], drawn: Iterator[Point]
) -> list[tuple[Point, float]]:
    return [(p, distance(cells[p.k], p, derivative(turbine, law, p))) for p in drawn]
