r"""One cell of schedule winds above rated wind: the law's numbers, and the torque's slopes.

In the cell the reference speed is constant, no feed-forward acts on the torque, and the effort is
beyond the ramp, so that torque is at its rated value and pitch has the whole effort.  Then the law
is beta_c = beta*(v_s) + G(v_s) (omega_m - omega* - x) + lead, with

    beta* = beta_min + q*/b,     G = gamma/b,
    beta*' = (q*' b - q* b')/b^2,     G' = (gamma' b - gamma b')/b^2,

whose numerators are constant over an interval of the tables.

With g the gradient of T_r/J in (omega, beta, v), H its Hessian, and x a state's distance (e, p, D)
from the trim at v_s, Taylor's formula is

    T_r/J - T_r*/J = g* x + x' [integral over t from 0 to 1 of (1 - t) H(t x)] x ,

For t from (k - 1)/n to k/n, t x lies in k/n times the box; the integral of 1 - t over it is
(2 (n - k) + 1)/(2 n^2).  So the torques' difference is c x with c_i within g*_i -+ the sum over k
of this times sum_j max |H_ij| side_j, H over k/n times the box.
Between two states of the box it is c (x1 - x2) with c_i within g*_i -+ sum_j max |H_ij| side_j, H
over the box.  With lambda = R omega / v and c_Q's partial derivatives by lambda and beta as
indices l and b,

    g = c (R v c_l, v^2 c_b, v (2 c_Q - lambda c_l)),
    H = c [ R^2 c_ll    R v c_lb    R (c_l - lambda c_ll)                  ]
          [ .           v^2 c_bb    v (2 c_b - lambda c_lb)                ]
          [ .           .           2 c_Q - 2 lambda c_l + lambda^2 c_ll ] .

Derived in docs/schedule-rate.md.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import Any

from takagi.certificates.checker.arithmetic.interval import ONE, Interval, enclose, hull, point
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import (
    Box,
    Law,
    Plant,
    Subject,
    Uncertainty,
)
from takagi.certificates.checker.turbine.effort_sharing.moving_schedule import Moving
from takagi.certificates.checker.turbine.effort_sharing.table_residual import residual
from takagi.certificates.checker.turbine.running_loop.cell import FULL, NIL, down, span, up
from takagi.certificates.checker.turbine.running_loop.inputs import Machine, Span
from takagi.certificates.checker.turbine.scheduled_loop.schedule_inputs import ScheduleSides

# The winds of the box, and those of the trim, are divided into this many parts, and the way from
# the trim to a state into this many steps.
PARTS, STEPS = 4, 3
Box3 = tuple[Fraction, Fraction, Fraction]
ORDERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))


class ScheduleCell:
    """Schedule winds from low to high, inside one interval of the law's tables.

    Raises
    ------
    Refused : winds that are not inside one interval; a reference speed that changes, or a
        feed-forward of the torque; an estimate that may reach its limit or the tables' end; an
        effort that may enter the ramp; a range that leaves the coefficient table.
    """

    def __init__(
        self, plant: Plant, law: Law, machine: Machine, winds: Span, sides: ScheduleSides
    ) -> None:
        self.plant, self.law, self.machine = plant, law, machine
        self.winds, self.sides = winds, sides
        low, high = winds
        nodes = law.wind
        self.k = k = min(max(bisect_right(nodes, low) - 1, 0), len(nodes) - 2)
        if not nodes[k] <= low < high <= nodes[k + 1]:
            raise Refused("winds that are not inside one interval of the law's tables")
        if law.speed[k] != law.speed[k + 1] or law.inertia[k] != 0:
            raise Refused("the reference speed changes with the wind, or torque is fed forward")
        lowest, highest = low - sides.estimate, high + sides.estimate
        if not machine.wind_limits[0] < lowest < highest < machine.wind_limits[1]:
            raise Refused("the wind estimate may reach its limit")
        if not nodes[0] <= lowest < highest <= nodes[-1]:
            raise Refused("the wind estimate may leave the law's tables")
        if not 0 < low - sides.wind:
            raise Refused("the wind may reach zero")
        self.speed = law.speed[k]
        # The ranges of lambda have the least speed over the greatest wind at their lower end.
        if not max(sides.speed, sides.measured) < self.speed:
            raise Refused("the rotor's speed may reach zero")
        self.b, self.gamma, self.q = (
            [self._at(column, v) for v in winds]
            for column in (law.effectiveness, law.gamma, law.effort)
        )
        if min(self.q) - max(self.gamma) * sides.signal < law.overlap:
            raise Refused("the effort may enter the ramp, where torque has a share of it")
        self.c = point(plant.torque_per_inertia)

    def _at(self, column: Sequence[Fraction], wind: Fraction) -> Fraction:
        return column[self.k] + self.law.slope(list(column), self.k) * (
            wind - self.law.wind[self.k]
        )

    # The law's numbers.

    @property
    def gain(self) -> Span:
        """The range of G; it is monotone in v_s, as a quotient of two linear functions."""
        return _sorted(g / b for g, b in zip(self.gamma, self.b, strict=True))

    @property
    def gain_slope(self) -> Span:
        """The range of G'."""
        return self._quotient_slope(self.law.gamma)

    @property
    def pitch_slope(self) -> Span:
        """The range of beta*'."""
        return self._quotient_slope(self.law.effort)

    def _quotient_slope(self, column: list[Fraction]) -> Span:
        """Return the range of the slope of column / b."""
        law, k = self.law, self.k
        top = law.slope(column, k) * law.effectiveness[k]
        top -= column[k] * law.slope(law.effectiveness, k)
        return _sorted(top / b**2 for b in self.b)

    @property
    def pitches_at_trim(self) -> Span:
        """The range of beta*."""
        return _sorted(self.law.pitch_min + q / b for q, b in zip(self.q, self.b, strict=True))

    @cached_property
    def lead(self) -> Span:
        """The range of the pitch lead per v_s' [s rad per m/s] on the box."""
        steep, (low, high) = self.gain_slope, self.pitch_slope
        away = max(map(abs, steep)) * self.sides.signal
        lead = self.law.lead
        return down(lead * (low - away)), up(lead * (high + away))

    @property
    def schedule_rate(self) -> Fraction:
        """A bound of |v_s'| [m/s^2]."""
        return self.sides.estimate / self.machine.wind_filter

    @cached_property
    def imbalance(self) -> Fraction:
        """A bound of the tables' residual over the cell [rad/s^2], the torques at the trim."""
        # The tables with nodes at the cell's ends, so that they are linear over the cell.
        law = self.law
        columns = ("speed", "effort", "effectiveness", "limit", "gamma")
        ends: Any = {
            name: [self._at(getattr(law, name), v) for v in self.winds] for name in columns
        }
        short = replace(law, wind=list(self.winds), **ends)
        # The residual does not depend on a box; one is needed to build its cell.
        box = Box(self.sides.speed, self.sides.drive, self.sides.signal, FULL / 100)
        exact = Uncertainty((FULL, FULL), False, (FULL, FULL))
        within = Subject(self.plant, short, box, exact)
        return Fraction(residual(Moving(within, 0, NIL), (FULL, FULL)), ONE)

    # The torque's slopes.

    @cached_property
    def slopes(self) -> tuple[Span, Span, Span]:
        """The ranges of the secants from the trim, in speed, pitch and wind; pitch's negated."""
        sides = self.sides
        box = sides.speed, sides.pitch, sides.wind
        found = self._at_trim
        for i in range(1, STEPS + 1):
            share, t = Fraction(2 * (STEPS - i) + 1, 2 * STEPS**2), Fraction(i, STEPS)
            bends = self._bends((t * box[0], t * box[1], t * box[2]))
            found = _widened(found, bends, box, share)
        return span(found[0]), span(-found[1]), span(found[2])

    @cached_property
    def observed(self) -> tuple[Span, Span]:
        """The ranges of the secants between the state and what the observer takes it to be."""
        sides = self.sides
        speed, wind = max(sides.speed, sides.measured), max(sides.wind, sides.estimate)
        box = speed, sides.pitch, wind
        found = _widened(self._at_trim, self._bends(box), box, FULL)
        return span(found[0]), span(found[2])

    @cached_property
    def _at_trim(self) -> list[Interval]:
        """The gradient at the trim, over the cell's schedule winds."""
        found = []
        for v in _parts(self.winds):
            shed = _sorted(self._trim_pitch(wind) for wind in v)
            found.append(self._derivatives(v, NIL, enclose(*shed))[0])
        return [hull(*entries) for entries in zip(*found, strict=True)]

    def _bends(self, box: Box3) -> list[list[Interval]]:
        """Return the Hessian over speeds, pitches and winds within these of the trim."""
        e, p, d = box
        low, high = self.pitches_at_trim
        pitch, found = enclose(low - p, high + p), []
        for v in _parts((self.winds[0] - d, self.winds[1] + d)):
            found.append(self._derivatives(v, e, pitch)[1])
        return [[hull(*(one[i][j] for one in found)) for j in range(3)] for i in range(3)]

    def _trim_pitch(self, wind: Fraction) -> Fraction:
        law = self.law
        return law.pitch_min + self._at(law.effort, wind) / self._at(law.effectiveness, wind)

    def _derivatives(
        self, winds: Span, e: Fraction, pitch: Interval
    ) -> tuple[list[Interval], list[list[Interval]]]:
        """Return gradient and Hessian of T_r/J over winds, pitches and speeds within e."""
        radius, v = point(self.plant.radius), enclose(*winds)
        fast, slow = self.speed + e, self.speed - e
        ratio = enclose(self.plant.radius * slow / winds[1], self.plant.radius * fast / winds[0])
        q, x, y, xx, xy, yy = (self.plant.surface.bounds(ratio, pitch, *n) for n in ORDERS)
        c, two = self.c, point(Fraction(2))
        curl = x - ratio * xx
        gradient = [radius * v * x, v.square() * y, v * (two * q - ratio * x)]
        by_wind = [radius * curl, v * (two * y - ratio * xy)]
        hessian = [
            [radius.square() * xx, radius * v * xy, by_wind[0]],
            [radius * v * xy, v.square() * yy, by_wind[1]],
            [*by_wind, two * q - two * (ratio * x) + ratio.square() * xx],
        ]
        return [c * one for one in gradient], [[c * one for one in row] for row in hessian]

    @cached_property
    def pitches(self) -> Interval:
        """The pitch range on the box."""
        low, high = self.pitches_at_trim
        return enclose(low - self.sides.pitch, high + self.sides.pitch)

    @cached_property
    def late(self) -> Fraction:
        """The largest h: by this the effectiveness of the trim at a wind of the box lies below the
        law's effectiveness_limit there."""
        law, sides, found = self.law, self.sides, [NIL]
        low, high = self.winds[0] - sides.wind, self.winds[1] + sides.wind
        if low < law.wind[0] or high > law.wind[-1]:
            raise Refused("the wind may leave the law's tables")
        inner = [node for node in law.wind if low < node < high]
        for part in pairwise([low, *inner, high]):
            for v in _parts(part):
                found.append(self._late(v))
        return up(max(found))

    def _late(self, winds: Span) -> Fraction:
        """Return it for winds inside one interval of the tables."""
        law, j = self.law, bisect_right(self.law.wind, winds[0]) - 1
        limit, effort, b, speed = (
            [column[j] + law.slope(column, j) * (v - law.wind[j]) for v in winds]
            for column in (law.limit, law.effort, law.effectiveness, law.speed)
        )
        if min(effort) < law.overlap:
            raise Refused("the wind may come where torque has a share of the trim's effort")
        shed = _sorted(q / width for q, width in zip(effort, b, strict=True))
        pitch = enclose(law.pitch_min + shed[0], law.pitch_min + shed[1])
        radius = self.plant.radius
        ratio = enclose(radius * min(speed) / winds[1], radius * max(speed) / winds[0])
        steep = self.plant.surface.bounds(ratio, pitch, 0, 1)
        return max(limit) - Fraction((-(steep * enclose(*winds).square() * self.c)).low, ONE)


def _parts(ends: Span) -> Iterator[Span]:
    """Yield equal parts of an interval."""
    width = (ends[1] - ends[0]) / PARTS
    for i in range(PARTS):
        yield ends[0] + width * i, ends[0] + width * (i + 1)


def _widened(
    slopes: Sequence[Interval], bends: Sequence[Sequence[Interval]], box: Box3, share: Fraction
) -> list[Interval]:
    """Return the slopes, widened by a share of what the Hessian adds over the box."""
    found = []
    for slope, row in zip(slopes, bends, strict=True):
        sizes = [Fraction(bend.magnitude(), ONE) for bend in row]
        away = share * sum((size * side for size, side in zip(sizes, box, strict=True)), NIL)
        found.append(slope + enclose(-away, away))
    return found


def _sorted(values: Any) -> Span:
    found = sorted(values)
    return found[0], found[-1]
