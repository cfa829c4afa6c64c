r"""The plant's equations and the loop with a law, compiled: rates, limits, loads, time steps.

Rotor and disc flow, all with the flow at the disc u = v_h - w - share_f f', v_h = v_r - share_y y':

    v_r  = v (1 + r cos 3 theta)                    the wind, with the ripple of three blades
    v_e  : v_e (1 - k_a a(lambda_e, beta)) = u      the wind whose steady flow at the disc is u
    T_r  = k v_e^2 c_Q(lambda_e, beta),     F = (k / R) v_e^2 c_T(lambda_e, beta)
    w'   = (k_a a(lambda_h, beta) v_h - w) / t_w,   t_w = share_t 1.1 / (1 - 1.3 a) R / v_h

with lambda_e = omega R / v_e, lambda_h = omega R / v_h, and a(c_T(lambda, beta)) of ``induction``.
Without a wake v_e = u.  Then the parts that move:

    flap     f'' = w_f^2 (C_f F - f) - 2 d_f w_f f'
    tower    m y'' = share_y F - c y' - k y
    shaft    J_r omega' = T_r - S,   n_g^2 J_g omega_g' = S - n_g T,   S = k_s phi + c_s phi',
             phi' = omega - omega_g
    drive    beta'' = w_b^2 (beta_ref - beta) - 2 d_b w_b beta',  or  t_b beta' = beta_ref - beta
    torque   t_g T' = T_sent - T
    filter   a' = w (measured speed - a),  b' = w (a - b),  w_m' = c (z - w_m),
             z = measured speed - 2 (1 - p) (a - b)      without a band-stop z is the speed

A part whose place is -1 is absent.  A law is a program of a few hundred instructions that a small
machine runs, so that another law needs nothing compiled anew.

All functions are in this file because numba stores what it compiled by the file's own date: a
function of another file could change unnoticed.

Sources: docs/validation-plant.md.
"""

from __future__ import annotations

from math import (
    acos,
    acosh,
    asin,
    asinh,
    atan,
    atanh,
    cos,
    cosh,
    erf,
    exp,
    isfinite,
    log,
    sin,
    sinh,
    sqrt,
    tan,
    tanh,
)
from typing import NamedTuple

import numpy as np

from takagi.models.arrays import Floats, Places, compiled

# A wind below this is no wind for a rotor; the tip-speed ratio is clipped long before [m/s].
SMALLEST_WIND = 0.1
# Momentum theory ends here; beyond it a(c_T) goes on along its tangent.  Glauert's empirical
# relation does about the same up to c_T = 1.2.
LAST_MOMENTUM = 8.0 / 9.0
# The flow at the disc keeps this share of the wind at least.
LEAST_FLOW = 0.1
# Of the wake's time, as Oye's formula has it.
LARGEST_INDUCTION = 0.5
# Newton's steps for v_e, and when it is found [-].
MOST_STEPS, CLOSE = 60, 1e-13


class Constants(NamedTuple):
    """What the equations know of a plant: places of states (-1: not there), figures, tables."""

    pitch_rate: int
    tower: int
    flap: int
    generator: int
    wake: int
    torque: int
    azimuth: int
    stopped: int
    filtered: int
    rotor_radius: float
    torque_constant: float
    rotor_inertia: float
    generator_inertia: float
    gear_ratio: float
    shaft_stiffness: float
    shaft_damping: float
    tower_mass: float
    tower_damping: float
    tower_stiffness: float
    tower_share: float
    flap_frequency: float
    flap_damping: float
    flap_compliance: float
    flap_share: float
    disc_induction: float
    wake_share: float
    torque_lag: float
    pitch_time_constant: float
    pitch_drive_frequency: float
    pitch_drive_damping: float
    pitch_min: float
    pitch_max: float
    pitch_rate_limit: float
    ripple: float
    filter_corner: float
    stop_frequency: float
    stop_passed: float
    torque_x: Floats
    torque_y: Floats
    torque_patches: Floats
    thrust_x: Floats
    thrust_y: Floats
    thrust_patches: Floats


@compiled
def _cell(corners: Floats, x: float) -> int:
    """Return the cell of a coordinate that lies inside the table."""
    low, high = 0, len(corners) - 1
    while high - low > 1:
        middle = (low + high) // 2
        if x >= corners[middle]:
            low = middle
        else:
            high = middle
    return low


@compiled
def _along(patches: Floats, i: int, j: int, y: float) -> tuple[float, float, float, float]:
    """Return the cubic along x of a cell, at the distance y from the cell's corner."""
    c = patches[i, j]
    return (
        c[0, 0] + y * (c[0, 1] + y * (c[0, 2] + y * c[0, 3])),
        c[1, 0] + y * (c[1, 1] + y * (c[1, 2] + y * c[1, 3])),
        c[2, 0] + y * (c[2, 1] + y * (c[2, 2] + y * c[2, 3])),
        c[3, 0] + y * (c[3, 1] + y * (c[3, 2] + y * c[3, 3])),
    )


@compiled
def _surface(
    corners_x: Floats, corners_y: Floats, patches: Floats, x: float, y: float
) -> tuple[float, float]:
    """Return a coefficient and its slope along x; outside the table it is held at the edge."""
    inside = corners_x[0] < x < corners_x[-1]
    x = min(max(x, corners_x[0]), corners_x[-1])
    y = min(max(y, corners_y[0]), corners_y[-1])
    i, j = _cell(corners_x, x), _cell(corners_y, y)
    a0, a1, a2, a3 = _along(patches, i, j, y - corners_y[j])
    x -= corners_x[i]
    # Outside the table the value is constant, and so the slope is zero.
    slope = a1 + x * (2.0 * a2 + x * 3.0 * a3) if inside else 0.0
    return a0 + x * (a1 + x * (a2 + x * a3)), slope


@compiled
def _thrust_coefficient(p: Constants, ratio: float, pitch: float) -> tuple[float, float]:
    return _surface(p.thrust_x, p.thrust_y, p.thrust_patches, ratio, pitch)


@compiled
def induction(thrust_coefficient: float) -> tuple[float, float]:
    """Return a(c_T) = (1 - sqrt(1 - c_T)) / 2, its tangent beyond c_T = 8/9, and the slope."""
    if thrust_coefficient > LAST_MOMENTUM:
        return 1.0 / 3.0 + 0.75 * (thrust_coefficient - LAST_MOMENTUM), 0.75
    root = sqrt(1.0 - thrust_coefficient)
    return (1.0 - root) / 2.0, 0.25 / root


@compiled
def _disc_induction(k_a: float, coefficient: float, slope: float) -> tuple[float, float]:
    """Return k_a a of a thrust coefficient, and the slope of v (1 - k_a a) by v.

    ``slope`` is that of the coefficient by the tip-speed ratio, times the ratio.
    """
    a, by_coefficient = induction(coefficient)
    disc_share = k_a * a
    # A heavily loaded rotor would leave almost no flow; the limit keeps the equivalent wind finite.
    if disc_share > 1.0 - LEAST_FLOW:
        return 1.0 - LEAST_FLOW, LEAST_FLOW
    return disc_share, 1.0 - disc_share + k_a * by_coefficient * slope


@compiled
def _equivalent_wind(p: Constants, speed: float, pitch: float, flow: float, guess: float) -> float:
    """Return v_e with v_e (1 - k_a a(v_e)) = flow: Newton's method inside a bracket."""
    low, high, wind = 0.0, flow / LEAST_FLOW, guess
    if not low < wind < high:
        wind = flow
    # The row of the table is the same in all steps, and the cell in most.
    corners, rows, tip_speed = p.thrust_x, p.thrust_y, speed * p.rotor_radius
    y = min(max(pitch, rows[0]), rows[-1])
    j = _cell(rows, y)
    y -= rows[j]
    i = _cell(corners, min(max(tip_speed / wind, corners[0]), corners[-1]))
    a0, a1, a2, a3 = _along(p.thrust_patches, i, j, y)
    for _ in range(MOST_STEPS):
        ratio = tip_speed / wind
        inside = corners[0] < ratio < corners[-1]
        x = min(max(ratio, corners[0]), corners[-1])
        if not corners[i] <= x <= corners[i + 1]:
            i = _cell(corners, x)
            a0, a1, a2, a3 = _along(p.thrust_patches, i, j, y)
        x -= corners[i]
        by_ratio = a1 + x * (2.0 * a2 + x * 3.0 * a3) if inside else 0.0
        coefficient = a0 + x * (a1 + x * (a2 + x * a3))
        share, slope = _disc_induction(p.disc_induction, coefficient, by_ratio * ratio)
        over = wind * (1.0 - share) - flow
        if over > 0.0:
            high = wind
        else:
            low = wind
        # Where it has converged, rounding may put the next step on an end of the bracket.
        if slope > 0.0 and abs(over) <= CLOSE * wind * slope:
            return wind - over / slope
        next_wind = wind - over / slope if slope > 0.0 else low
        # Newton's method may leave the bracket where the slope is small; then the bracket is
        # halved.
        if not low < next_wind < high:
            next_wind = (low + high) / 2.0
        if abs(next_wind - wind) <= CLOSE * wind:
            return next_wind
        wind = next_wind
    return wind


@compiled
def wake_time(thrust_coefficient: float, radius: float, wind: float) -> float:
    """Return 1.1 / (1 - 1.3 a) R / v [s], a at most 0.5: Oye's first time constant."""
    a = min(induction(thrust_coefficient)[0], LARGEST_INDUCTION)
    return 1.1 / (1.0 - 1.3 * a) * radius / wind


@compiled
def loads(p: Constants, state: Floats, wind: float) -> tuple[float, float, float, float]:
    """Return T_r [N m], F [N], the tip-speed ratio of v_e, and v_h, the wind that the hub meets."""
    hub_wind = wind
    if p.azimuth >= 0:
        hub_wind *= 1.0 + p.ripple * cos(3.0 * state[p.azimuth])
    if p.tower >= 0:
        hub_wind -= p.tower_share * state[p.tower + 1]
    v = hub_wind
    if p.flap >= 0:
        v -= p.flap_share * state[p.flap + 1]
    if p.wake >= 0:
        # The wake comes last, because the flow at the disc depends on all other parts.
        flow = max(v - state[p.wake], SMALLEST_WIND)
        v = _equivalent_wind(p, state[0], state[1], flow, v)
    v = max(v, SMALLEST_WIND)
    ratio = state[0] * p.rotor_radius / v
    c_q, _ = _surface(p.torque_x, p.torque_y, p.torque_patches, ratio, state[1])
    c_t, _ = _thrust_coefficient(p, ratio, state[1])
    k = p.torque_constant * v * v
    return k * c_q, k / p.rotor_radius * c_t, ratio, hub_wind


@compiled
def pitch_speed(p: Constants, state: Floats, reference: float) -> float:
    """Return beta' [rad/s]: reference and rate held inside their limits."""
    limit = p.pitch_rate_limit
    if p.pitch_rate >= 0:
        moving: float = state[p.pitch_rate]
    else:
        moving = (min(max(reference, p.pitch_min), p.pitch_max) - state[1]) / p.pitch_time_constant
    return min(max(moving, -limit), limit)


@compiled
def _drive(p: Constants, state: Floats, reference: float, rates: Floats) -> None:
    """Write the pitch drive's rates."""
    rates[1] = pitch_speed(p, state, reference)
    if p.pitch_rate < 0:
        return
    speed, limit = state[p.pitch_rate], p.pitch_rate_limit
    target = min(max(reference, p.pitch_min), p.pitch_max)
    acceleration = p.pitch_drive_frequency**2 * (target - state[1])
    acceleration -= 2.0 * p.pitch_drive_damping * p.pitch_drive_frequency * speed
    if (speed >= limit and acceleration > 0.0) or (speed <= -limit and acceleration < 0.0):
        acceleration = 0.0
    rates[p.pitch_rate] = acceleration


@compiled
def _wake(p: Constants, state: Floats, hub_wind: float, rates: Floats) -> None:
    """Write w'."""
    v = max(hub_wind, SMALLEST_WIND)
    coefficient, _ = _thrust_coefficient(p, state[0] * p.rotor_radius / v, state[1])
    share, _ = _disc_induction(p.disc_induction, coefficient, 0.0)
    time = p.wake_share * wake_time(coefficient, p.rotor_radius, v)
    rates[p.wake] = (share * v - state[p.wake]) / time


@compiled
def _shaft(p: Constants, state: Floats, turning: float, torque: float, rates: Floats) -> float:
    """Write the rates of rotor, generator and twist; return the speed that is measured."""
    load, measured = p.gear_ratio * torque, float(state[0])
    if p.generator < 0:
        rates[0] = (turning - load) / (p.rotor_inertia + p.generator_inertia)
        return measured
    measured = float(state[p.generator])
    slip = state[0] - measured
    shaft = p.shaft_stiffness * state[p.generator + 1] + p.shaft_damping * slip
    rates[0] = (turning - shaft) / p.rotor_inertia
    rates[p.generator] = (shaft - load) / p.generator_inertia
    rates[p.generator + 1] = slip
    return measured


@compiled
def _stopped(p: Constants, state: Floats, measured: float, rates: Floats) -> float:
    """Write the rates of the band-stop's two poles; return the speed behind it."""
    if p.stopped < 0:
        return measured
    first, second = state[p.stopped], state[p.stopped + 1]
    rates[p.stopped] = p.stop_frequency * (measured - first)
    rates[p.stopped + 1] = p.stop_frequency * (first - second)
    behind: float = measured - 2.0 * (1.0 - p.stop_passed) * (first - second)
    return behind


@compiled
def rate(
    p: Constants, state: Floats, torque: float, reference: float, wind: float, rates: Floats
) -> None:
    """Write the states' rates: torque [N m] and pitch reference [rad] as sent, wind [m/s]."""
    turning, thrust, _, hub_wind = loads(p, state, wind)
    _drive(p, state, reference, rates)
    acting = torque
    if p.torque >= 0:
        acting = state[p.torque]
        rates[p.torque] = (torque - acting) / p.torque_lag
    measured = _shaft(p, state, turning, acting, rates)
    if p.tower >= 0:
        y, moving = state[p.tower], state[p.tower + 1]
        push = p.tower_share * thrust - p.tower_damping * moving - p.tower_stiffness * y
        rates[p.tower] = moving
        rates[p.tower + 1] = push / p.tower_mass
    if p.flap >= 0:
        f, moving = state[p.flap], state[p.flap + 1]
        rates[p.flap] = moving
        rates[p.flap + 1] = p.flap_frequency**2 * (p.flap_compliance * thrust - f)
        rates[p.flap + 1] -= 2.0 * p.flap_damping * p.flap_frequency * moving
    if p.wake >= 0:
        _wake(p, state, hub_wind, rates)
    if p.azimuth >= 0:
        rates[p.azimuth] = state[0]
    if p.filtered >= 0:
        behind = _stopped(p, state, measured, rates)
        rates[p.filtered] = p.filter_corner * (behind - state[p.filtered])


@compiled
def hold(p: Constants, state: Floats) -> None:
    """Move pitch and its rate back inside their limits."""
    low, high, limit, at = p.pitch_min, p.pitch_max, p.pitch_rate_limit, p.pitch_rate
    if at >= 0:
        state[at] = min(max(state[at], -limit), limit)
    if not low <= state[1] <= high:
        state[1] = min(max(state[1], low), high)
        if at >= 0:
            # A blade that meets its stop stands; it may only leave inwards.
            state[at] = max(state[at], 0.0) if state[1] == low else min(state[at], 0.0)


@compiled
def _runge_kutta(
    p: Constants,
    x: Floats,
    rates: Floats,
    torque: float,
    reference: float,
    winds: Floats,
    at: int,
    step: float,
) -> None:
    """Take one classical step from the wind of place ``at``; ``rates`` is (5, size) of room."""
    size, half = len(x), step / 2.0
    k1, k2, k3, k4, y = rates[0], rates[1], rates[2], rates[3], rates[4]
    rate(p, x, torque, reference, winds[at], k1)
    for i in range(size):
        y[i] = x[i] + half * k1[i]
    rate(p, y, torque, reference, winds[at + 1], k2)
    for i in range(size):
        y[i] = x[i] + half * k2[i]
    rate(p, y, torque, reference, winds[at + 1], k3)
    for i in range(size):
        y[i] = x[i] + step * k3[i]
    rate(p, y, torque, reference, winds[at + 2], k4)
    for i in range(size):
        x[i] += step / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i])
    hold(p, x)


@compiled
def advance(
    p: Constants, state: Floats, sent: Floats, late: int, winds: Floats, step: float
) -> Floats:
    """Return the state after the classical Runge-Kutta steps of one sample.

    ``sent``: torque and pitch reference before, then those of this sample, which act from step
    ``late`` on; ``winds`` at half steps, (2 steps + 1,) [m/s].
    """
    x, rates = state.copy(), np.empty((5, len(state)))
    for number in range(len(winds) // 2):
        act = 0 if number < late else 2
        _runge_kutta(p, x, rates, sent[act], sent[act + 1], winds, 2 * number, step)
    return x


@compiled
def record(
    p: Constants, states: Floats, references: Floats, winds: Floats
) -> tuple[Floats, Floats, Floats, Floats]:
    """Return torque [N m], thrust [N], tip-speed ratio and pitch rate [rad/s] of many states."""
    size = len(states)
    turning, thrust = np.empty(size), np.empty(size)
    ratio, turned = np.empty(size), np.empty(size)
    for k in range(size):
        turning[k], thrust[k], ratio[k], _ = loads(p, states[k], winds[k])
        turned[k] = pitch_speed(p, states[k], references[k])
    return turning, thrust, ratio, turned


class Instructions(NamedTuple):
    """A law's program, as the machine of ``execute`` runs it.

    Attributes
    ----------
    outputs : (n, 6) from measurements to commands; ``following`` : (m, 6) from what was sent to the
        kept values of the next sample.  A row is the operation, the place of its result in the
        memory, and what it reads: places, or where a table begins in ``tables``.
    memory : (k,) constants at their places, room for everything else.
    tables : (t,) rows of nodes and values; a spline is the number of knots of each argument, the
        knots, then the coefficients.
    inputs : (5,) places of speed, pitch, wind, sample time, and torque that acts until the next
        sample.   commands : (3,) of torque, pitch reference, and the wind that the law sees.
    kept, after : (q,) of the kept values, and of what they become.
    """

    outputs: Places
    following: Places
    memory: Floats
    tables: Floats
    inputs: Places
    commands: Places
    kept: Places
    after: Places


# Operations of the machine, of which ``LINE`` to ``SURFACE`` read tables.
ADD, SUBTRACT, MULTIPLY, DIVIDE, POWER, NEGATIVE, MIN, MAX, LIMIT, CHOOSE, NEAR = range(11)
LINE, SLOPE, HOLD, SPLINE, SURFACE = range(11, 16)
ABS, SQRT, EXP, LOG, SIN, COS, TAN, ASIN, ACOS, ATAN = range(16, 26)
SINH, COSH, TANH, ASINH, ACOSH, ATANH, ERF = range(26, 33)


@compiled
def _interval(tables: Floats, begin: int, count: int, x: float, first: int) -> int:
    """Return the last k from ``first`` on with nodes[k] <= x, at most the last interval."""
    low, high = first, count - 1 - first
    while high - low > 1:
        middle = (low + high) // 2
        if tables[begin + middle] <= x:
            low = middle
        else:
            high = middle
    return low


@compiled
def _basis(t: Floats, k: int, x: float) -> tuple[float, float, float, float]:
    """Return the four cubic B-splines that are not 0 between the knots t[k] and t[k + 1].

    Source: Piegl and Tiller (1997), The NURBS Book, algorithm A2.2.
    """
    l1, l2, l3 = x - t[k], x - t[k - 1], x - t[k - 2]
    r1, r2, r3 = t[k + 1] - x, t[k + 2] - x, t[k + 3] - x
    a0, a1 = r1 / (r1 + l1), l1 / (r1 + l1)
    share = a0 / (r1 + l2)
    b0, more = r1 * share, l2 * share
    share = a1 / (r2 + l1)
    b1, b2 = more + r2 * share, l1 * share
    share = b0 / (r1 + l3)
    c0, more = r1 * share, l3 * share
    share = b1 / (r2 + l2)
    c1, more = more + r2 * share, l2 * share
    share = b2 / (r3 + l1)
    return c0, c1, more + r3 * share, l1 * share


@compiled
def _spline(tables: Floats, begin: int, x: float) -> float:
    count = int(tables[begin])
    knots = tables[begin + 1 : begin + 1 + count]
    x = min(max(x, knots[3]), knots[count - 4])
    k = _interval(tables, begin + 1, count, x, 3)
    w0, w1, w2, w3 = _basis(knots, k, x)
    c = begin + 1 + count + k - 3
    value: float = w0 * tables[c] + w1 * tables[c + 1] + w2 * tables[c + 2] + w3 * tables[c + 3]
    return value


@compiled
def _spline_surface(tables: Floats, begin: int, x: float, y: float) -> float:
    rows, columns = int(tables[begin]), int(tables[begin + 1])
    first, second = begin + 2, begin + 2 + rows
    t, u = tables[first : first + rows], tables[second : second + columns]
    x, y = min(max(x, t[3]), t[rows - 4]), min(max(y, u[3]), u[columns - 4])
    k, j = _interval(tables, first, rows, x, 3), _interval(tables, second, columns, y, 3)
    weights, (w0, w1, w2, w3) = _basis(t, k, x), _basis(u, j, y)
    total = 0.0
    for i in range(4):
        c = second + columns + (k - 3 + i) * (columns - 4) + j - 3
        inner = w0 * tables[c] + w1 * tables[c + 1] + w2 * tables[c + 2] + w3 * tables[c + 3]
        total += weights[i] * inner
    return total


@compiled
def _tabled(op: int, tables: Floats, x: float, nodes: int, values: int, count: int) -> float:
    """Return ``line``, ``slope`` or ``hold`` of the language."""
    k = _interval(tables, nodes, count, x, 0)
    if op == HOLD:
        return float(tables[values + k])
    low, high = tables[nodes + k], tables[nodes + k + 1]
    slope: float = (tables[values + k + 1] - tables[values + k]) / (high - low)
    if op == SLOPE:
        return slope
    inside = min(max(x, tables[nodes]), tables[nodes + count - 1])
    return float(tables[values + k] + slope * (inside - low))


@compiled
def _elementary(op: int, x: float) -> float:
    """Return a function of one number."""
    if op == ABS:
        return abs(x)
    if op == SQRT:
        return sqrt(x)
    if op == EXP:
        return exp(x)
    if op == LOG:
        return log(x)
    if op == SIN:
        return sin(x)
    if op == COS:
        return cos(x)
    if op == TAN:
        return tan(x)
    if op == ASIN:
        return asin(x)
    if op == ACOS:
        return acos(x)
    if op == ATAN:
        return atan(x)
    if op == SINH:
        return sinh(x)
    if op == COSH:
        return cosh(x)
    if op == TANH:
        return tanh(x)
    if op == ASINH:
        return asinh(x)
    if op == ACOSH:
        return acosh(x)
    if op == ATANH:
        return atanh(x)
    return erf(x)


@compiled
def execute(code: Places, m: Floats, tables: Floats) -> None:
    """Run rows of a program; the language is that of gain files (``LANGUAGE``)."""
    for row in range(len(code)):
        op, at = code[row, 0], code[row, 1]
        a, b, c, e = code[row, 2], code[row, 3], code[row, 4], code[row, 5]
        if op == ADD:
            m[at] = m[a] + m[b]
        elif op == SUBTRACT:
            m[at] = m[a] - m[b]
        elif op == MULTIPLY:
            m[at] = m[a] * m[b]
        elif op == DIVIDE:
            m[at] = m[a] / m[b]
        elif op == POWER:
            m[at] = m[a] ** m[b]
        elif op == NEGATIVE:
            m[at] = -m[a]
        elif op == MIN:
            m[at] = min(m[a], m[b])
        elif op == MAX:
            m[at] = max(m[a], m[b])
        elif op == LIMIT:
            m[at] = min(max(m[a], m[b]), m[c])
        elif op == CHOOSE:
            m[at] = m[b] if m[a] < 0.0 else m[c]
        elif op == NEAR:
            m[at] = m[c] if abs(m[a]) <= m[b] else m[e]
        elif op <= HOLD:
            m[at] = _tabled(op, tables, m[a], b, c, e)
        elif op == SPLINE:
            m[at] = _spline(tables, b, m[a])
        elif op == SURFACE:
            m[at] = _spline_surface(tables, c, m[a], m[b])
        else:
            m[at] = _elementary(op, m[a])


@compiled
def march(
    p: Constants,
    law: Instructions,
    state: Floats,
    kept: Floats,
    sent: Floats,
    winds: Floats,
    times: tuple[int, int, float],
    measured: int,
    limits: tuple[float, float],
    states: Floats,
    keeps: Floats,
    signals: Floats,
) -> int:
    """Run plant and law; return the sample at which the loop grew beyond all numbers, or -1.

    Parameters
    ----------
    state, kept, sent : at the start: of the plant, of the law's program, and the torque and pitch
        reference in force.
    winds : at half steps, (2 steps + 1,) [m/s].
    times : steps a sample, steps until a command acts, and the step [s].
    measured : the place of the measured speed.
    limits : the generator's largest torque [N m] and torque rate [N m/s].
    states, keeps : written, a row a sample.
    signals : written, a row a sample: the wind that the law sees, its two commands, the torque that
        is sent.
    """
    inner, late, step = times
    period, m, x = inner * step, law.memory.copy(), state.copy()
    rates, before, angle = np.empty((5, len(state))), sent[0], sent[1]
    for q in range(len(kept)):
        m[law.kept[q]] = kept[q]
    m[law.inputs[3]] = period
    for number in range(len(states)):
        total = 0.0
        for i in range(len(x)):
            total += x[i]
            states[number, i] = x[i]
        for q in range(len(kept)):
            total += m[law.kept[q]]
            keeps[number, q] = m[law.kept[q]]
        if not isfinite(total):
            return number
        first = 2 * inner * number
        m[law.inputs[0]], m[law.inputs[1]], m[law.inputs[2]] = x[measured], x[1], winds[first]
        execute(law.outputs, m, law.tables)
        wanted, pitch = m[law.commands[0]], m[law.commands[1]]
        torque, largest = min(max(wanted, 0.0), limits[0]), limits[1] * period
        if abs(torque - before) > largest:
            torque = before + (largest if torque > before else -largest)
        signals[number, 0], signals[number, 1] = m[law.commands[2]], wanted
        signals[number, 2], signals[number, 3] = pitch, torque
        # The observer reads the mean of what acts until the next sample.
        m[law.inputs[4]] = torque + late / inner * (before - torque)
        execute(law.following, m, law.tables)
        # All kept values take their next at once, and some of these are kept values themselves.
        for q in range(len(kept)):
            kept[q] = m[law.after[q]]
        for q in range(len(kept)):
            m[law.kept[q]] = kept[q]
        if number + 1 == len(states):
            break
        for turn in range(inner):
            if turn == late:
                before, angle = torque, pitch
            _runge_kutta(p, x, rates, before, angle, winds, first + 2 * turn, step)
        # With a whole sample of computing the command acts from the next sample on.
        before, angle = torque, pitch
    return -1
