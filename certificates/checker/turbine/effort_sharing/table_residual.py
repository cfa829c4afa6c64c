r"""The trim error r(v) of the law's tables between their nodes, enclosed over one interval.

    r(v) = c v^2 c_Q(lambda(v), beta(v)) - (n_g / J) (T_rated - E psi(-q*(v)))

with lambda = R omega* / v, beta = beta_min + psi(q*) / b, and omega*, q*, b linear in v.  r' is
Lipschitz, so |r| <= max(|r(v_1)|, |r(v_2)|) + (width^2 / 8) sup |r''|.

If the true power coefficient is s times the table's, the trim error is r + (s - 1) T_r* / J, with
T_r* / J = r + (n_g / J) (T_rated - E psi(-q*)).
"""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.arithmetic.effort_ramp import psi
from takagi.certificates.checker.arithmetic.interval import ZERO, Interval, enclose, point
from takagi.certificates.checker.turbine.effort_sharing.moving_schedule import Moving

Jet = tuple[Interval, Interval, Interval]


def residual(cell: Moving, power: tuple[Fraction, Fraction]) -> int:
    """Return a bound of |r + (s - 1) T_r* / J| over the cell, as an integer over 10^36."""
    nodes, wind = (cell.k, cell.k + 1), cell.ends(cell.law.wind)
    bent = Interval(0, _curvature(cell).magnitude()) * point((wind[1] - wind[0]) ** 2 / 8)
    left = max(_at_node(cell, i).magnitude() for i in nodes) + bent.high
    wrong = max(1 - power[0], power[1] - 1)
    # psi is monotone, so the demanded torque lies between its values at the ends.
    trim = max(abs(_demanded(cell, i)) for i in nodes)
    return (Interval(0, left) * point(1 + wrong)).high + point(wrong * trim).high


def _at_node(cell: Moving, i: int) -> Interval:
    plant, law = cell.plant, cell.law
    ratio = point(plant.radius * law.speed[i] / law.wind[i])
    pitch = point(law.pitch_min + psi(law.effort[i], law.overlap) / law.effectiveness[i])
    scale = cell.c * point(law.wind[i] ** 2)
    return plant.surface.bounds(ratio, pitch) * scale - point(_demanded(cell, i))


def _demanded(cell: Moving, i: int) -> Fraction:
    """Return (n_g / J) (T_rated - E psi(-q*)), the deceleration by the law's torque at node i."""
    law = cell.law
    reserve = psi(-law.effort[i], law.overlap)
    return (law.rated_torque - law.effort_torque * reserve) * cell.plant.gear_per_inertia


def _curvature(cell: Moving) -> Interval:
    """Return r'' over the interval, from the jets of lambda, beta and c_Q."""
    law, v = cell.law, cell.wind
    c0, c1, c2 = _coefficient(cell, _ratio(cell), _pitch(cell))
    # (v^2 c_Q)'' = 2 c_Q + 4 v c_Q' + v^2 c_Q''.
    two, four = point(Fraction(2)), point(Fraction(4))
    torque = two * c0 + (four * v * c1 + v.square() * c2)
    low, high = cell.ends(law.effort)
    reserve = _bend(-high, -low, law.overlap) * point(cell.slope(law.effort)).square()
    return cell.c * torque + point(law.effort_torque * cell.plant.gear_per_inertia) * reserve


def _ratio(cell: Moving) -> Jet:
    """Return the jet of lambda = R (w_0 / v + w_1): its slope is -R w_0 / v^2."""
    law, k, v, radius = cell.law, cell.k, cell.wind, cell.plant.radius
    first = point(radius * (law.speed[k] - cell.slope(law.speed) * law.wind[k]))
    ends = [radius * law.speed[i] / law.wind[i] for i in (k, k + 1)]
    second = (first + first) / (v.square() * v)
    return enclose(min(ends), max(ends)), -first / v.square(), second


def _pitch(cell: Moving) -> Jet:
    """Return the jet of beta_min + psi(q) / b."""
    law, b = cell.law, cell.b
    low, high = cell.ends(law.effort)
    b1, q1 = (point(cell.slope(column)) for column in (law.effectiveness, law.effort))
    shed = cell.psi(low, high)
    shed1, shed2 = cell.share(low, high) * q1, _bend(low, high, law.overlap) * q1.square()
    beta1 = (shed1 - shed / b * b1) / b
    bent = beta1 * b1
    return cell.pitch(shed), beta1, (shed2 - (bent + bent)) / b


def _coefficient(cell: Moving, ratio: Jet, pitch: Jet) -> Jet:
    """Return the jet of c_Q(lambda(v), beta(v)) by the chain rule."""
    (x0, x1, x2), (y0, y1, y2) = ratio, pitch
    orders = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
    c = {order: cell.plant.surface.bounds(x0, y0, *order) for order in orders}
    cross = c[1, 1] * x1 * y1
    bent = c[2, 0] * x1.square() + c[0, 2] * y1.square() + (cross + cross)
    bent = bent + (c[1, 0] * x2 + c[0, 1] * y2)
    return c[0, 0], c[1, 0] * x1 + c[0, 1] * y1, bent


def _bend(low: Fraction, high: Fraction, eps: Fraction) -> Interval:
    """Return the range of psi'': 1 / (2 eps) inside the ramp, 0 outside."""
    if high <= -eps or low >= eps:
        return ZERO
    return Interval(0, point(1 / (2 * eps)).high)
