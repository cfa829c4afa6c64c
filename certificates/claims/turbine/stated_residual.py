"""The trim error that a claim about the effort-sharing loop states, a little above the checker's.

The checker's ``table_residual`` takes the slope of lambda in closed form; here it follows from the
quotient rule, which is up to twice as wide at low wind.  It stays so that a design states the
numbers that it stated before: with the checker's bound they would move by up to 0.15 %.
"""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.arithmetic.effort_ramp import psi
from takagi.certificates.checker.arithmetic.interval import (
    ONE,
    UNIT,
    ZERO,
    Interval,
    enclose,
    point,
)
from takagi.certificates.checker.turbine.effort_sharing.loop import Loop

# Value, first and second derivative over the winds of a cell.
Jet = tuple[Interval, Interval, Interval]


def stated_residual(loop: Loop) -> Fraction:
    """Return a bound of |r + (s - 1) T_r* / J| over the cell; ``table_residual`` derives it."""
    plant, law = loop.plant, loop.law
    trims, at_nodes = [], []
    for i in (loop.k, loop.k + 1):
        wind, effort = law.wind[i], law.effort[i]
        held = law.rated_torque - law.effort_torque * psi(-effort, law.overlap)
        trims.append(held * plant.gear_per_inertia)
        pitch = law.pitch_min + psi(effort, law.overlap) / law.effectiveness[i]
        coefficient = plant.surface.bounds(point(plant.radius * law.speed[i] / wind), point(pitch))
        at_nodes.append(coefficient * loop.c * point(wind**2) - point(trims[-1]))
    bent = Fraction(_curvature(loop).magnitude(), ONE)
    width = law.wind[loop.k + 1] - law.wind[loop.k]
    tables = max(Fraction(r.magnitude(), ONE) for r in at_nodes) + width**2 / 8 * bent
    wrong = max(1 - loop.uncertainty.power[0], loop.uncertainty.power[1] - 1)
    return (1 + wrong) * tables + wrong * max(map(abs, trims))


def _curvature(loop: Loop) -> Interval:
    """Return r'' over the cell, from the jets of lambda, beta and c_Q."""
    law, nodes = loop.law, (loop.k, loop.k + 1)
    low, high = loop.ends(law.effort)
    steep = point(loop.slope(law.effort))
    speed = (loop.radius * loop.range(law.speed), loop.radius * point(loop.slope(law.speed)), ZERO)
    ratio = _quotient(speed, (loop.wind, UNIT, ZERO))
    shed = loop.psi(low, high)
    owed = (shed, loop.share(low, high) * steep, _bend(low, high, law.overlap) * steep.square())
    pitch = _quotient(owed, (loop.b, point(loop.slope(law.effectiveness)), ZERO))
    ratios = [loop.plant.radius * law.speed[i] / law.wind[i] for i in nodes]
    reached = enclose(min(ratios), max(ratios)), loop.pitch(shed)
    c, x1, y1 = loop.plant.surface.bounds, ratio[1], pitch[1]
    by_ratio, by_pitch = c(*reached, 1, 0), c(*reached, 0, 1)
    cross = c(*reached, 1, 1) * x1 * y1
    second = c(*reached, 2, 0) * x1.square() + c(*reached, 0, 2) * y1.square() + (cross + cross)
    second = second + (by_ratio * ratio[2] + by_pitch * pitch[2])
    first, v = by_ratio * x1 + by_pitch * y1, loop.wind
    two, four = point(Fraction(2)), point(Fraction(4))
    # (v^2 c_Q)'' = 2 c_Q + 4 v c_Q' + v^2 c_Q''.
    torque = two * c(*reached) + four * v * first + v.square() * second
    share = point(law.effort_torque * loop.plant.gear_per_inertia)
    return loop.c * torque + share * _bend(-high, -low, law.overlap) * steep.square()


def _quotient(f: Jet, g: Jet) -> Jet:
    """Return the jet of h = f / g: h' = (f' - h g') / g, h'' = (f'' - 2 h' g' - h g'') / g."""
    value = f[0] / g[0]
    slope = (f[1] - value * g[1]) / g[0]
    turned = slope * g[1]
    return value, slope, (f[2] - (turned + turned) - value * g[2]) / g[0]


def _bend(low: Fraction, high: Fraction, eps: Fraction) -> Interval:
    """Return the range of psi'': 1 / (2 eps) inside the ramp, 0 outside."""
    return ZERO if high <= -eps or low >= eps else enclose(Fraction(0), 1 / (2 * eps))
