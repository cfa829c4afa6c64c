r"""Proves that the stated ranges of the loop's coefficients enclose the turbine.

With c = torque_constant / J, J the inertia on the low-speed side, m = n_g E / J, the efforts U
between the least and the largest q* + gamma s, |s| <= box, and pitch

    beta - beta_min  in  [max(psi(U_low) - zeta, 0), psi(U_high) + zeta] / b                 (band)

each cell of the law's winds has, with lambda = R omega / v (``loop_claim`` has the matrices),

    a = kappa p c R v c_Q,lambda                             omega* -+ box, band
    S = kappa s,  s = -p c v^2 c_Q,beta / b up to b_fw / b    omega*, band
    G = kappa gamma (m - F (m - s)),  F = psi'(U)            along beta = beta_min + psi(U) / b
    wind gain  p c v (2 c_Q - lambda c_Q,lambda)             omega* -+ box, band, v -+ its share
    residual   max |r(v_k)| + w^2 / 8 sup |r''|,  r = c v^2 c_Q + m psi(-q*) - n_g T_rated / J,
               and |p - 1| of the trim's torque

p is the true power coefficient divided by the tabulated one.  All ranges are products of intervals,
for G with the range of U in parts.  Derived in
docs/effort-sharing-loop.md, sections Speed, Effort lag, Family and Residual.

The effect of a schedule wind with rate up to rho in one cell, after the feed-forward.

Let N = F(U) (q*' + gamma' s) - psi(U) b'/b, |s| <= box, and theta the lead divided by the pitch
drive's tau.  The stated numbers of a cell must enclose:

    T    in [h, 1] / tau,  h = min(1, (limit - theta rho |N / b|) b tau / zeta)
    |b'/b|,  |omega*' - kappa m mu f|  with mu from min(1, g / |f| rho, psi(-U_high) / |f| rho)
    |w_zeta| <= max(|1 - theta| rho |N|, sup(rho |N| - psi(U) / tau))

Torque must stay above 0, and the pitch command below the largest pitch.  Derived in
docs/effort-sharing-loop.md, sections Speed, Effort lag and Invariance.
"""

from __future__ import annotations

from typing import Any

from flint import fmpq

from takagi.certificates.cross_check.kernel.exact import Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import rational, rationals
from takagi.certificates.cross_check.turbine.numbers import (
    TurbineNumbers,
    WindCell,
    ramp,
    ramp_slope,
)
from takagi.certificates.cross_check.turbine.surface import NumberRange, Outside

# The ramp is cut into so many parts: F and s both depend on U, and their ranges over the whole
# ramp, taken independently, would enclose too much.
PARTS = 8


def enclosed(turbine: TurbineNumbers, cell: Any, k: int) -> Obligations:
    """Yield that every stated range and size of one cell encloses that of the plant."""
    label = f"cell {k + 1}"
    at = turbine.cell(k)
    try:
        for name, span in _ranges(at):
            low, high = rationals(cell, name, 2)
            yield Fact(f"{label}: range of {name}", low <= span.low and span.high <= high)
        for name, size in _sizes(at):
            yield Fact(f"{label}: size of {name}", size <= rational(cell, name))
        most = turbine.pitch_min + (at.owed / at.b).high
        yield Fact(f"{label}: pitch below its limit", most <= turbine.pitch_max)
        yield from schedule(at, cell, label)
    except Outside as reason:
        yield Fact(f"{label}: enclosure ({reason})", False)


def _ranges(at: WindCell) -> list[tuple[str, NumberRange]]:
    turbine = at.turbine
    ratio = at.ratio(turbine.speed_error, ZERO)
    steep = turbine.surface.over(ratio, at.band, 1, 0) * at.wind
    return [
        ("stiffness", at.kappa * turbine.power * steep.times(turbine.c * turbine.radius)),
        ("loop_gain", at.kappa * at.gamma * _held(at)),
        ("lag_gain", at.kappa * _pitch_gain(at, at.band)),
        ("share_gain", NumberRange(at.share.low * at.gamma.low, at.share.high * at.gamma.high)),
    ]


def _pitch_gain(at: WindCell, pitch: NumberRange) -> NumberRange:
    """Return the range of s = -dT/dbeta / (J b) over a pitch range at the reference speed."""
    turbine = at.turbine
    slope = turbine.surface.over(at.ratio(ZERO, ZERO), pitch, 0, 1)
    found = -(at.wind.squared() * slope * turbine.power).times(turbine.c) / at.b
    if not turbine.frozen:
        return found
    return NumberRange(found.low, max(found.high, (at.frozen / at.b).high))


def _held(at: WindCell) -> NumberRange:
    """Return the range of m - F (m - s) over the efforts, part by part of the ramp."""
    turbine, eps = at.turbine, at.turbine.overlap
    m = NumberRange(turbine.m, turbine.m)
    start, stop = max(at.efforts.low, -eps), min(at.efforts.high, eps)
    ends = {at.efforts.low, at.efforts.high}
    if start < stop:
        ends |= {start + (stop - start) * i / PARTS for i in range(PARTS + 1)}
    cuts = sorted(ends)
    found = []
    for low, high in zip(cuts[:-1] or cuts, cuts[1:] or cuts, strict=True):
        share = NumberRange(ramp_slope(low, eps), ramp_slope(high, eps))
        if share.high == 0:
            found.append(m)
            continue
        curve = NumberRange(ramp(low, eps), ramp(high, eps)) / at.b
        pitch = curve + NumberRange(turbine.pitch_min, turbine.pitch_min)
        found.append(m - share * (m - _pitch_gain(at, pitch)))
    total = found[0]
    for one in found[1:]:
        total = total.hull(one)
    return total


def _sizes(at: WindCell) -> list[tuple[str, fmpq]]:
    turbine = at.turbine
    away = turbine.wind_share * turbine.wind[at.k]
    ratio = at.ratio(turbine.speed_error, away)
    value = turbine.surface.over(ratio, at.band)
    inner = value.times(fmpq(2)) - ratio * turbine.surface.over(ratio, at.band, 1, 0)
    wind = at.wind + NumberRange(-away, away)
    return [
        ("inertia_gain", at.kappa.high),
        ("wind_gain", (inner * wind * turbine.power).times(turbine.c).size),
        ("residual", residual(at)),
    ]


def residual(at: WindCell) -> fmpq:
    """Return a bound of the torque balance's error at the trim, over J [rad/s^2].

    A function with |r''| <= M on a cell of width w deviates from its chord by at most M w^2 / 8.
    """
    turbine, width = at.turbine, at.wind.high - at.wind.low
    r = max(_at_node(at, 0), _at_node(at, 1)) + width**2 / 8 * _bend(at).size
    # (s - 1) c v^2 c_Q at the trim, where c v^2 c_Q = r + rated - m psi(-q*), psi monotone.
    off = max(1 - turbine.power.low, turbine.power.high - 1)
    asked = [
        turbine.rated - turbine.m * ramp(-q, turbine.overlap)
        for q in (at.effort.low, at.effort.high)
    ]
    return r + off * (r + max(abs(each) for each in asked))


def _at_node(at: WindCell, side: int) -> fmpq:
    """Return |r| at one end of the cell."""
    turbine, i = at.turbine, at.k + side
    eps, q, v = turbine.overlap, turbine.effort[i], turbine.wind[i]
    x = turbine.radius * turbine.speed[i] / v
    y = turbine.pitch_min + ramp(q, eps) / turbine.effectiveness[i]
    torque = turbine.surface.over(NumberRange(x, x), NumberRange(y, y)).times(turbine.c * v**2)
    left = turbine.m * ramp(-q, eps) - turbine.rated
    return (torque + NumberRange(left, left)).size


def _bend(at: WindCell) -> NumberRange:
    """Return the range of r'' = c (v^2 C)'' + m psi''(-q*) q*'^2, C(v) = c_Q(lambda, beta)."""
    turbine, eps, v = at.turbine, at.turbine.overlap, at.wind
    # omega* = w_0 + w_1 v, so lambda = R (w_0 / v + w_1).
    w0 = turbine.radius * (turbine.speed[at.k] - at.slope(turbine.speed) * turbine.wind[at.k])
    cube = NumberRange(v.low**3, v.high**3)
    x = at.ratio(ZERO, ZERO)
    x1 = NumberRange(-w0, -w0) / v.squared()
    x2 = NumberRange(2 * w0, 2 * w0) / cube
    # p = psi(q*) / b:  p b = psi,  p' b + p b' = psi',  p'' b + 2 p' b' = psi''.
    q, q1, b1 = at.effort, at.slope(turbine.effort), at.slope(turbine.effectiveness)
    p = NumberRange(ramp(q.low, eps), ramp(q.high, eps)) / at.b
    gained = NumberRange(ramp_slope(q.low, eps), ramp_slope(q.high, eps)).times(q1)
    p1 = (gained - p.times(b1)) / at.b
    p2 = (_kink(q, eps).times(q1**2) - p1.times(2 * b1)) / at.b
    y = p + NumberRange(turbine.pitch_min, turbine.pitch_min)

    over = turbine.surface.over
    cx, cy = over(x, y, 1, 0), over(x, y, 0, 1)
    first = cx * x1 + cy * p1
    second = over(x, y, 2, 0) * x1.squared() + over(x, y, 0, 2) * p1.squared()
    second += (over(x, y, 1, 1) * x1 * p1).times(fmpq(2)) + cx * x2 + cy * p2
    torque = over(x, y).times(fmpq(2)) + (v * first).times(fmpq(4)) + v.squared() * second
    reserve = _kink(-q, eps).times(turbine.m * q1**2)
    return torque.times(turbine.c) + reserve


def _kink(s: NumberRange, eps: fmpq) -> NumberRange:
    """Return the range of psi'' over a span of efforts."""
    inside = s.high > -eps and s.low < eps
    return NumberRange(ZERO, 1 / (2 * eps) if inside else ZERO)


ZERO, FULL = fmpq(0), fmpq(1)


def schedule(at: WindCell, cell: Any, label: str) -> Obligations:
    """Yield that the stated numbers of a cell enclose the effects of a moving schedule wind."""
    turbine, rho = at.turbine, rational(cell, "wind_rate")
    yield Fact(f"{label}: wind rate", rho >= 0)
    tau, theta = turbine.drive, turbine.lead / turbine.drive
    N = asked_slope(at)
    led = theta * rho * (N / at.b).size
    room = (turbine.rate_limit - led) * at.b.low * tau / turbine.effort_lag
    yield Fact(f"{label}: the lead is below the pitch rate limit", room > 0)
    low, high = rationals(cell, "lag_rate", 2)
    yield Fact(f"{label}: range of lag_rate", low <= min(FULL, room) / tau <= FULL / tau <= high)

    turning = abs(at.slope(turbine.effectiveness)) / at.b.low
    left = abs(FULL - theta) * rho * N.size
    if theta > 0:
        left = max(left, _cut(at, rho, turning))
    for name, size in (
        ("effectiveness_slope", turning),
        ("reference_slope", _left_of_reference(at, rho)),
        ("lag_disturbance", left),
    ):
        yield Fact(f"{label}: size of {name}", size <= rational(cell, name))

    reach = min(abs(turbine.ahead[at.k]) * rho, turbine.ahead_limit[at.k])
    relief = ramp(-at.efforts.low, turbine.overlap) + reach
    yield Fact(f"{label}: torque above 0", turbine.torque >= turbine.per_effort * relief)
    pitch = turbine.pitch_min + at.shed.high / at.b.low + tau * led
    yield Fact(f"{label}: pitch asked for below its limit", pitch <= turbine.pitch_max)


def asked_slope(at: WindCell) -> NumberRange:
    """Return the range of N."""
    turbine = at.turbine
    s = NumberRange(-turbine.speed_signal, turbine.speed_signal)
    q1, b1 = at.slope(turbine.effort), at.slope(turbine.effectiveness)
    moved = s.times(at.slope(turbine.proportional)) + NumberRange(q1, q1)
    return at.share * moved - at.shed * (NumberRange(b1, b1) / at.b)


def _left_of_reference(at: WindCell, rho: fmpq) -> fmpq:
    """Return the largest |omega*' - kappa m mu f|, at an end of kappa mu."""
    turbine = at.turbine
    f, mu = turbine.ahead[at.k], FULL
    if f != 0 and rho > 0:
        spare = ramp(-at.efforts.high, turbine.overlap)
        mu = min(FULL, turbine.ahead_limit[at.k] / abs(f * rho), spare / abs(f * rho))
    through = NumberRange(at.kappa.low * mu, at.kappa.high)
    w1 = at.slope(turbine.speed)
    return (NumberRange(w1, w1) - through.times(turbine.m * f)).size


def _cut(at: WindCell, rho: fmpq, turning: fmpq) -> fmpq:
    """Return the supremum over U of A F - c psi, or 0 where it is negative.

    c = 1/tau - rho |b'/b|; it bounds w_zeta where the lower pitch limit cuts off the lead.  On the
    ramp psi = eps F^2; beyond it F = 1 and psi = U.
    """
    turbine, eps = at.turbine, at.turbine.overlap
    moved = abs(at.slope(turbine.effort))
    moved += abs(at.slope(turbine.proportional)) * turbine.speed_signal
    A, c = rho * moved, 1 / turbine.drive - rho * turning
    F = at.share
    if c <= 0:
        return max(ZERO, A * F.high - c * at.shed.high)
    if at.efforts.low >= eps:
        return max(ZERO, A - c * at.shed.low)
    # A parabola in F that opens downward is largest at its top, or at the end next to the top.
    top = max(F.low, min(F.high, A / (2 * c * eps)))
    return max(ZERO, A * top - c * eps * top**2)
