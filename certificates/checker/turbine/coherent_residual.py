r"""How far the law's tables leave the trim between their nodes: r(v), enclosed over one interval.

    r(v) = c v^2 c_Q(lambda(v), beta(v)) - (n_g / J) (T_rated - E psi(-q*(v)))

with lambda = R omega* / v, beta = beta_min + psi(q*) / b, and omega*, q*, b linear in v.  r' is
Lipschitz, so |r| <= max(|r(v_1)|, |r(v_2)|) + (width^2 / 8) sup |r''|.

With a true power coefficient s times the table's the trim is left by r + (s - 1) T_r* / J, where
T_r* / J = r + (n_g / J) (T_rated - E psi(-q*)).
"""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.interval import (
    ONE,
    Interval,
    add,
    div,
    enclose,
    magnitude,
    mul,
    point,
    square,
    sub,
)
from takagi.certificates.checker.turbine.coherent_inputs import Law, Plant

__all__ = ["residual", "slope"]

Jet = tuple[Interval, Interval, Interval]


def slope(column: list[Fraction], wind: list[Fraction], k: int) -> Fraction:
    """Return the slope of a column over wind in interval k."""
    return (column[k + 1] - column[k]) / (wind[k + 1] - wind[k])


def residual(plant: Plant, law: Law, k: int, power: tuple[Fraction, Fraction]) -> int:
    """Return a bound of |r + (s - 1) T_r* / J| over interval k, as an integer over 10^36."""
    width = law.wind[k + 1] - law.wind[k]
    ends = max(magnitude(_at_node(plant, law, i)) for i in (k, k + 1))
    bent = magnitude(_curvature(plant, law, k))
    left = ends + mul((0, bent), point(width**2 / 8))[1]
    wrong = max(1 - power[0], power[1] - 1)
    # psi is monotone, so the demanded torque lies between its values at the ends.
    trim = max(abs(_demanded(plant, law, i)) for i in (k, k + 1))
    return mul((0, left), point(1 + wrong))[1] + point(wrong * trim)[1]


def _at_node(plant: Plant, law: Law, i: int) -> Interval:
    ratio = point(plant.radius * law.speed[i] / law.wind[i])
    shed = psi(law.effort[i], law.overlap)
    pitch = point(law.pitch_min + shed / law.effectiveness[i])
    scale = mul(point(plant.torque_per_inertia), point(law.wind[i] ** 2))
    return sub(mul(plant.surface.bounds(ratio, pitch), scale), point(_demanded(plant, law, i)))


def _demanded(plant: Plant, law: Law, i: int) -> Fraction:
    """Return (n_g / J) (T_rated - E psi(-q*)), what the law's torque takes at node i."""
    reserve = psi(-law.effort[i], law.overlap)
    return (law.rated_torque - law.effort_torque * reserve) * plant.gear_per_inertia


def _curvature(plant: Plant, law: Law, k: int) -> Interval:
    """Return r'' over the interval, from the jets of lambda, beta and c_Q."""
    v = enclose(law.wind[k], law.wind[k + 1])
    c0, c1, c2 = _coefficient(plant, _ratio(plant, law, k, v), _pitch(law, k))
    # (v^2 c_Q)'' = 2 c_Q + 4 v c_Q' + v^2 c_Q''.
    two, four = (2 * ONE, 2 * ONE), (4 * ONE, 4 * ONE)
    torque = add(mul(two, c0), add(mul(mul(four, v), c1), mul(square(v), c2)))
    low, high = sorted(law.effort[k : k + 2])
    q1 = point(slope(law.effort, law.wind, k))
    reserve = mul(_bend(-high, -low, law.overlap), square(q1))
    gear = point(law.effort_torque * plant.gear_per_inertia)
    return add(mul(point(plant.torque_per_inertia), torque), mul(gear, reserve))


def _ratio(plant: Plant, law: Law, k: int, v: Interval) -> Jet:
    """Return the jet of lambda = R (w_0 / v + w_1): its slope is -R w_0 / v^2."""
    intercept = law.speed[k] - slope(law.speed, law.wind, k) * law.wind[k]
    first = point(plant.radius * intercept)
    ends = [plant.radius * law.speed[i] / law.wind[i] for i in (k, k + 1)]
    second = div(add(first, first), mul(square(v), v))
    return enclose(min(ends), max(ends)), div((-first[1], -first[0]), square(v)), second


def _pitch(law: Law, k: int) -> Jet:
    """Return the jet of beta_min + psi(q) / b."""
    low, high = sorted(law.effort[k : k + 2])
    eps = law.overlap
    b = enclose(min(law.effectiveness[k : k + 2]), max(law.effectiveness[k : k + 2]))
    b1, q1 = (point(slope(c, law.wind, k)) for c in (law.effectiveness, law.effort))
    shed0 = enclose(psi(low, eps), psi(high, eps))
    shed1 = mul(enclose(share(low, eps), share(high, eps)), q1)
    shed2 = mul(_bend(low, high, eps), square(q1))
    beta0 = div(shed0, b)
    beta1 = div(sub(shed1, mul(beta0, b1)), b)
    bent = mul(beta1, b1)
    return add(beta0, point(law.pitch_min)), beta1, div(sub(shed2, add(bent, bent)), b)


def _coefficient(plant: Plant, ratio: Jet, pitch: Jet) -> Jet:
    """Return the jet of c_Q(lambda(v), beta(v)) by the chain rule."""
    (x0, x1, x2), (y0, y1, y2) = ratio, pitch
    orders = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    c = {order: plant.surface.bounds(x0, y0, *order) for order in orders}
    cross = mul(mul(c[1, 1], x1), y1)
    bent = add(mul(c[2, 0], square(x1)), mul(c[0, 2], square(y1)))
    bent = add(bent, add(cross, cross))
    bent = add(bent, add(mul(c[1, 0], x2), mul(c[0, 1], y2)))
    return c[0, 0], add(mul(c[1, 0], x1), mul(c[0, 1], y1)), bent


def _bend(low: Fraction, high: Fraction, eps: Fraction) -> Interval:
    """Return the range of psi'': 1 / (2 eps) inside the ramp, 0 outside."""
    if high <= -eps or low >= eps:
        return (0, 0)
    return (0, point(1 / (2 * eps))[1])
