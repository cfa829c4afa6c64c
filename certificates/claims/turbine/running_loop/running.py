r"""The running loop at the constant winds of one cell: its factors enclosed, and its equations.

States, each as its distance from the rest at the wind v:

    e = omega - omega*(v)         p = b0 (beta - beta_rest)      x  the law's integral
    s = v_s - v                   m = omega_m - omega*(v)        o = omegahat - omega*(v)
    z = vhat - v                  eta = b0 (the wake's pitch - beta_rest)

with kappa nominal over true inertia, and all of [.] a factor from a range:

    u    = [q*'] s + [gamma] (m - x - [omega*'] s)
    g    = [f] u                                             psi(U) - psi(U_rest)
    rate = ([1 at a table's end] z - s) / tau_f
    E    = m_E (u - g - [feed-forward] rate)                 the generator's torque over J
    A    = [a] e - [sigma] p                                 the table's torque over J
    e'   = [kappa] (A - [h] (p - eta) - E)
    p'   = [drive] ([b0 / b] g - [psi b0 b'/ b^2] s + [lead] rate - p) / tau
    x'   = -[nu] (m - [omega*'] s),   s' = rate,   m' = c (e - m)
    o'   = A + [a2] (m - e) + [d] z - E + l_1 (m - o),   z' = l_2 (m - o)
    eta' = [wake's rate] (p - eta)

The factors are secants between the state and the rest, so they lie in the ranges of the derivatives
over the box.  Derived in docs/running-loop.md.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Any

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.interval import (
    ONE,
    ZERO,
    Interval,
    enclose,
    hull,
    point,
)
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Box, Subject
from takagi.certificates.checker.turbine.effort_sharing.moving_schedule import Moving
from takagi.certificates.checker.turbine.effort_sharing.table_residual import residual
from takagi.certificates.claims.turbine.running_loop.signals import Signal, Signals, Span, combined

STATES = 8
(E, P, X, S, M, _, Z, _) = range(STATES)
PIECES, DECIMALS = 8, 10**7
NIL, FULL = Fraction(0), Fraction(1)


@dataclass(frozen=True)
class Sides:
    """The box of one cell: bounds of the deviations from the equilibrium."""

    speed: Fraction
    measured: Fraction
    pitch: Fraction
    signal: Fraction
    effort: Fraction
    schedule: Fraction
    estimate: Fraction
    integral: Fraction


@dataclass(frozen=True)
class Machine:
    """Data that the coherent claim does not use: observer, filters, and the wake's delay.

    Attributes
    ----------
    l1, l2 : the observer's gains;  wind_limits : of its estimate.
    corner : of the low-pass on the measured speed [1/s];  wind_filter : tau_f [s].
    wake_length : wind over the wake's rate [m], from the least to the greatest.
    """

    l1: Fraction
    l2: Fraction
    wind_limits: Span
    corner: Fraction
    wind_filter: Fraction
    wake_length: Span


class Running:
    """One cell: constant winds from low to high inside interval k of the law's tables."""

    def __init__(self, subject: Subject, machine: Machine, k: int, winds: Span, sides: Sides):
        self.plant, self.law = subject.plant, subject.law
        self.machine, self.k, self.winds, self.sides = machine, k, winds, sides
        self.kappa = subject.uncertainty.kappa
        low, high = winds
        nodes = self.law.wind
        if not nodes[k] <= low < high <= nodes[k + 1]:
            raise Refused("winds that are not inside their interval of the tables")
        if not (
            machine.wind_limits[0] < low - sides.estimate
            and high + sides.estimate < machine.wind_limits[1]
        ):
            raise Refused("an estimate at its limit")
        # The schedule winds on the set; the law limits them to its tables.
        self.reach = (max(low - sides.schedule, nodes[0]), min(high + sides.schedule, nodes[-1]))
        self.inside = nodes[0] <= low - sides.estimate and high + sides.estimate <= nodes[-1]
        self.near = [
            j
            for j in range(len(nodes) - 1)
            if nodes[j] < self.reach[1] and nodes[j + 1] > self.reach[0]
        ]
        self.c = point(self.plant.torque_per_inertia)
        self.wind = enclose(*winds)
        self.m = self.law.effort_torque * self.plant.gear_per_inertia
        self.b = self.over(self.law.effectiveness, winds)
        self.b_reach = self.over(self.law.effectiveness, self.reach)
        self.b0 = _short((self.b[0] + self.b[1]) / 2)
        self.q = self.over(self.law.effort, winds)
        self.rest = self._rest(subject)
        reach = sides.effort + self.rest
        self.efforts = (self.q[0] - reach, self.q[1] + reach)
        self.efforts_at_rest = (self.q[0] - self.rest, self.q[1] + self.rest)

    # The law's tables.

    def at(self, column: Sequence[Fraction], wind: Fraction) -> Fraction:
        nodes = self.law.wind
        j = next((i for i in range(len(nodes) - 1) if wind <= nodes[i + 1]), len(nodes) - 2)
        slope = (column[j + 1] - column[j]) / (nodes[j + 1] - nodes[j])
        return column[j] + slope * (wind - nodes[j])

    def over(self, column: Sequence[Fraction], winds: Span) -> Span:
        """Return a column's range over winds: from its values at the ends and at the nodes."""
        inner = [
            value
            for node, value in zip(self.law.wind, column, strict=True)
            if winds[0] < node < winds[1]
        ]
        found = [self.at(column, winds[0]), self.at(column, winds[1]), *inner]
        return min(found), max(found)

    def slopes(self, column: list[Fraction]) -> Span:
        """Return the range of a column's slope over all reachable schedule winds."""
        found = [self.law.slope(column, j) for j in self.near]
        return min(found), max(found)

    def steps(self, column: list[Fraction]) -> Span:
        found = [column[j] for j in self.near]
        return min(found), max(found)

    # The surface.

    def ratio(self, error: Fraction, wind_error: Fraction = NIL) -> Interval:
        """Return R (omega* + e) / (v + d); it is monotone in each variable, so corners suffice."""
        ends = [
            self.plant.radius * (self.at(self.law.speed, v) + e) / (v + d)
            for v in self.winds
            for e in {-error, error}
            for d in {-wind_error, wind_error}
        ]
        return enclose(min(ends), max(ends))

    def pitch_at(self, efforts: Span) -> Interval:
        """Return beta_min + psi(U) / b(v)."""
        eps = self.law.overlap
        shed = enclose(psi(efforts[0], eps), psi(efforts[1], eps))
        return shed / enclose(*self.b) + point(self.plant.pitch_min)

    @property
    def pitches(self) -> Interval:
        """Return the pitch range on the set, not below the lower limit."""
        rest, away = self.pitch_at(self.efforts_at_rest), point(self.sides.pitch / self.b0)
        least = max((rest - away).low, point(self.plant.pitch_min).low)
        return Interval(least, (rest + away).high)

    def sigma(self, ratio: Interval, pitch: Interval) -> Interval:
        """Return -dT_r/dbeta / (J b0)."""
        steep = self.plant.surface.bounds(ratio, pitch, 0, 1) * self.wind.square() * self.c
        return -steep / point(self.b0)

    def by_speed(self, error: Fraction) -> Interval:
        steep = self.plant.surface.bounds(self.ratio(error), self.pitches, 1, 0) * self.wind
        return steep * (self.c * point(self.plant.radius))

    def by_wind(self) -> Interval:
        """Return dT_r/dv / J = c v (2 c_Q - lambda c_Q,lambda)."""
        away, bounds = self.sides.estimate, self.plant.surface.bounds
        ratio, pitch = self.ratio(self.sides.measured, away), self.pitches
        value = bounds(ratio, pitch)
        inner = value + value - ratio * bounds(ratio, pitch, 1, 0)
        return inner * enclose(self.winds[0] - away, self.winds[1] + away) * self.c

    def _rest(self, subject: Subject) -> Fraction:
        """Return a bound of |U_rest - q*|, from the tables' residual over the loop's least gain."""
        box = Box(self.sides.speed, self.sides.pitch, self.sides.signal, FULL / 100)
        # The same tables with nodes at the cell's ends, so that they are linear over the cell.
        law, columns = self.law, ("speed", "effort", "effectiveness", "limit", "gamma")
        ends: Any = {name: [self.at(getattr(law, name), v) for v in self.winds] for name in columns}
        short = replace(law, wind=list(self.winds), **ends)
        within = Subject(self.plant, short, box, subject.uncertainty)
        left = Fraction(residual(Moving(within, 0, NIL), (FULL, FULL)), ONE)
        efforts = (self.q[0] - self.sides.effort, self.q[1] + self.sides.effort)
        least = Fraction(self._gain(efforts).low, ONE)
        if least <= 0 or left > least * self.sides.effort:
            raise Refused("no rest is known to lie near the trim")
        return _up(left / least)

    def _gain(self, efforts: Span) -> Interval:
        """Return the range of F sigma + (1 - F) m_E along beta = beta_min + psi(U) / b."""
        eps, cuts = self.law.overlap, set(efforts)
        start, stop = max(efforts[0], -eps), min(efforts[1], eps)
        if start < stop:
            cuts |= {start + (stop - start) * i / PIECES for i in range(PIECES + 1)}
        found, ratio, m = [], self.ratio(NIL), point(self.m)
        for low, high in pairwise(sorted(cuts)):
            held = enclose(share(low, eps), share(high, eps))
            if held.high <= 0:
                found.append(m)
                continue
            # sigma is scaled by b0; the law's b at the wind itself turns effort into pitch.
            scaled = self.sigma(ratio, self.pitch_at((low, high))) * (
                point(self.b0) / enclose(*self.b)
            )
            found.append(m - held * (m - scaled))
        return hull(*found)

    # The factors.

    def secant_share(self) -> Span:
        """Return the range of f: of psi's slope over all efforts."""
        eps = self.law.overlap
        return share(self.efforts[0], eps), share(self.efforts[1], eps)

    @cached_property
    def factors(self) -> dict[str, Span]:
        """Return the range of every factor except f, rounded outward to seven decimals."""
        law, eps = self.law, self.law.overlap
        gamma = self.over(law.gamma, self.reach)
        rest = self.rest / self.over(law.gamma, self.winds)[0]
        bent = self.slopes(law.gamma)
        # gamma(v_s) (signal - x_rest) + gamma(v) x_rest: the second part depends on s.
        steep = max(abs(bent[0]), abs(bent[1])) * rest
        q = self.slopes(law.effort)
        b, b_law, b0 = enclose(*self.b), enclose(*self.b_reach), point(self.b0)
        bend = enclose(*self.slopes(law.effectiveness))
        shed_rest = enclose(*(psi(U, eps) for U in self.efforts_at_rest))
        ratio = self.ratio(NIL)
        sigma = self.sigma(ratio, self.pitches)
        limit = self.over(law.limit, self.winds)[1]
        late = max(limit / self.b0 - Fraction(sigma.low, ONE), NIL)
        fed = [law.inertia[j] for j in self.near]
        length = self.machine.wake_length
        unit = (FULL, FULL)
        return {
            "speed slope": self.slopes(law.speed),
            "effort slope": (_down(q[0] - steep), _up(q[1] + steep)),
            "gamma": (_down(gamma[0]), _up(gamma[1])),
            "held estimate": unit if self.inside else (NIL, FULL),
            "feed-forward": (min(NIL, *fed), max(NIL, *fed)),
            "pitch per effort": _span(b0 / b_law),
            "pitch by schedule": _span(shed_rest * bend * b0 / (b_law * b)),
            "lead": self._lead(bend, b_law, b0, rest),
            "integral rate": self.steps(law.nu),
            "stiffness": _span(self.by_speed(self.sides.speed)),
            "pitch gain": _span(sigma),
            "late pitch gain": (NIL, _up(late)),
            "inertia": (_down(self.kappa[0]), _up(self.kappa[1])),
            "observed stiffness": _span(self.by_speed(max(self.sides.speed, self.sides.measured))),
            "wind gain": _span(self.by_wind()),
            "wake rate": (_down(self.winds[0] / length[1]), _up(self.winds[1] / length[0])),
            "drive": self._drive(),
        }

    def _lead(self, bend: Interval, b_law: Interval, b0: Interval, rest: Fraction) -> Span:
        """Return b0 lead (F (q*' + gamma' signal) - psi b'/b) / b, and 0: the lower pitch limit."""
        law, eps = self.law, self.law.overlap
        signal = self.sides.signal + rest
        moved = enclose(*self.slopes(law.effort))
        moved += enclose(-signal, signal) * enclose(*self.slopes(law.gamma))
        held = enclose(*self.secant_share())
        shed = enclose(psi(self.efforts[0], eps), psi(self.efforts[1], eps))
        found = (held * moved - shed * (bend / b_law)) * b0 / b_law * point(law.lead)
        return _span(hull(found, ZERO))

    def _drive(self) -> Span:
        """Return h from the least secant of the pitch rate limit to 1."""
        f = self.secant_share()[1]
        b_least = self.b_reach[0]
        shed = max(psi(U, self.law.overlap) for U in self.efforts_at_rest)
        bend = max(abs(slope) for slope in self.slopes(self.law.effectiveness))
        moved = f * self.sides.effort + shed * bend / self.b[0] * self.sides.schedule
        rate = (self.sides.estimate + self.sides.schedule) / self.machine.wind_filter
        lead = max(abs(end) for end in self._lead(
            enclose(*self.slopes(self.law.effectiveness)), enclose(*self.b_reach), point(self.b0),
            self.rest / self.over(self.law.gamma, self.winds)[0],
        )) / self.b0  # fmt: skip
        most = moved / b_least + lead * rate + self.sides.pitch / self.b0
        return _down(min(FULL, self.plant.rate_limit * self.plant.lag / most)), FULL

    def limits_failure(self) -> str:
        """Return why torque, pitch or integral may reach a limit that the equations omit."""
        law = self.law
        if self.winds[0] - self.sides.schedule <= 0:
            return "a wind of zero"
        reserve = psi(-self.efforts[0], law.overlap)
        rate = (self.sides.estimate + self.sides.schedule) / self.machine.wind_filter
        taken = max(min(abs(law.inertia[j]) * rate, law.inertia_limit[j]) for j in self.near)
        if law.effort_torque * (reserve + taken) > law.rated_torque:
            return "negative torque may be demanded"
        asked = psi(self.efforts[1], law.overlap) / self.b_reach[0] + law.pitch_min
        lead = self.factors["lead"]
        asked += max(abs(lead[0]), abs(lead[1])) * rate / self.b0
        if asked > law.pitch_max or self.pitches.high > point(law.pitch_max).low:
            return "pitch beyond its limit may be demanded"
        rest = self.rest / self.over(law.gamma, self.winds)[0]
        if self.sides.integral + rest > law.integral_limit:
            return "the integral may reach its limit"
        return ""

    # The box, from the states.

    def rows(self) -> dict[str, tuple[list[Fraction], Fraction]]:
        """Return, by name, the row h and the bound of |h xi| that must hold on the set."""
        factors, sides = self.factors, self.sides
        w, gamma, q = (factors[name] for name in ("speed slope", "gamma", "effort slope"))
        mid, off = (
            [(x[0] + x[1]) / 2 for x in (w, gamma, q)],
            [(x[1] - x[0]) / 2 for x in (w, gamma, q)],
        )
        signal = combined((1, {M: FULL}), (-1, {X: FULL}), (-mid[0], {S: FULL}))
        effort = combined((mid[2], {S: FULL}), (mid[1], signal))
        away = off[0] * sides.schedule
        spread = off[2] * sides.schedule + off[1] * sides.signal + mid[1] * away
        wanted = {
            "speed": ({E: FULL}, sides.speed),
            "measured": ({M: FULL}, sides.measured),
            "pitch": ({P: FULL}, sides.pitch),
            "signal": (signal, sides.signal - away),
            "effort": (effort, sides.effort - spread),
            "schedule": ({S: FULL}, sides.schedule),
            "estimate": ({Z: FULL}, sides.estimate),
            "integral": ({X: FULL}, sides.integral),
        }
        return {
            name: ([row.get(i, NIL) for i in range(STATES)], bound)
            for name, (row, bound) in wanted.items()
        }

    def equations(self, f: Span, kappa: Span) -> tuple[Signals, list[Signal]]:
        """Return the signals and the states' rates for factors f and kappa of one piece."""
        signals, span = Signals(STATES), self.factors
        machine = self.machine

        def times(name: str, signal: Signal) -> Signal:
            return signals.times(name, span[name], signal)

        e, p, x, s, m, o, z, eta = (signals.state(i) for i in range(STATES))
        error = combined((1, m), (-1, times("speed slope", s)))
        u = combined(
            (1, times("effort slope", s)), (1, times("gamma", combined((1, error), (-1, x))))
        )
        g = signals.times("share", f, u)
        seen = times("held estimate", z)
        rate = combined((1 / machine.wind_filter, seen), (-1 / machine.wind_filter, s))
        braking = combined((self.m, u), (-self.m, g), (-self.m, times("feed-forward", rate)))
        table = combined((1, times("stiffness", e)), (-1, times("pitch gain", p)))
        late = times("late pitch gain", combined((1, p), (-1, eta)))
        turning = combined((1, table), (-1, late), (-1, braking))
        owed = combined(
            (1, times("pitch per effort", g)),
            (-1, times("pitch by schedule", s)),
            (1, times("lead", rate)),
            (-1, p),
        )
        apart = combined((1, m), (-1, o))
        found = [
            signals.times("inertia", kappa, turning),
            combined((1 / self.plant.lag, times("drive", owed))),
            combined((-1, times("integral rate", error))),
            rate,
            combined((machine.corner, e), (-machine.corner, m)),
            combined(
                (1, table),
                (1, times("observed stiffness", combined((1, m), (-1, e)))),
                (1, times("wind gain", z)),
                (-1, braking),
                (machine.l1, apart),
            ),
            combined((machine.l2, apart)),
            times("wake rate", combined((1, p), (-1, eta))),
        ]
        return signals, found


def cut(span: Span, parts: int) -> list[Span]:
    """Return the interval in equal parts."""
    width = (span[1] - span[0]) / parts
    return [(span[0] + width * i, span[0] + width * (i + 1)) for i in range(parts)]


def _down(value: Fraction) -> Fraction:
    return Fraction((value * DECIMALS).__floor__(), DECIMALS)


def _up(value: Fraction) -> Fraction:
    return -_down(-value)


def _short(value: Fraction) -> Fraction:
    return Fraction(round(value * 1000), 1000)


def _span(value: Interval) -> Span:
    return _down(Fraction(value.low, ONE)), _up(Fraction(value.high, ONE))
