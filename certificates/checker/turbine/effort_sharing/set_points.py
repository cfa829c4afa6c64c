r"""``set-points``: the effort-sharing loop settles at every constant wind and set-point of a range.

For a constant wind v = v_s, a speed set-point w_s and a torque set-point T_s the law has the
reference speed omega*(v) + r with r = min(w_s - omega*(v), 0), e = omega - omega*(v) - r, and

    U      = q*(v) + s(v) r + (T_rated - T_s)/E + gamma (e - x)
    e'     = T_r(omega, beta, v)/J - (n_g/J) (T_s - E psi(-U))
    beta'  = (beta_min + psi(U)/b - beta)/tau,                        x' = -nu e

A cell is a box of (v, r, T_s); an inner node at its upper end is the next cell's, as nu jumps.
It states w_1 < w_2.  With w in the place of gamma (e - x) it is shown that

    T_r/J > (n_g/J) T at the steady state of w_1,  < at that of w_2          (enclosures)

so an equilibrium (0, beta*, x*) with -gamma x* between both exists.  A cell also states P and
bounds.  With y = (e, beta - beta*, x - x*) the set {y'Py <= 1} lies in |e| <= r_e,
|e - x + x*| <= r_s and |beta - beta*| <= r_b; there neither torque, nor the pitch rate, nor the
integral reaches its limit.  In these ranges the loop's matrix between any state and the equilibrium
lies in the hull of

    [[a - m (1 - F) gamma, -sigma, m (1 - F) gamma], [F gamma/(b tau), -1/tau, -F gamma/(b tau)],
     [-nu, 0, 0]],      a = dT_r/domega / J, sigma = -dT_r/dbeta / J, F = psi'(U), m = n_g E / J

at the ends of a, sigma, F, gamma and b, since it is affine in each of a, sigma, F, gamma and 1/b.
-(A'P + PA + 2 rho P) > 0 at these corners shows that y'Py decays as exp(-2 rho t).  So there is one
equilibrium in the set, and the rotor turns at the reference speed there.

Not promised: set-points or winds that move; a wind estimate that differs from the wind; another
inertia or wake than the model's.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations, product
from math import isqrt, prod
from typing import Any, ClassVar, Self

from takagi.certificates.checker.arithmetic.dual import Dual, chained
from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.interval import (
    ONE,
    UNIT,
    ZERO,
    Interval,
    enclose,
    point,
)
from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import (
    Obligations,
    never,
    nonnegative,
    positive,
)
from takagi.certificates.checker.kernel.reader import (
    listed,
    number,
    numbers,
    read_matrix,
)
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, SetpointRange
from takagi.certificates.checker.turbine.effort_sharing.wind_cell import WindCell
from takagi.certificates.checker.turbine.members import Members, plain
from takagi.certificates.checker.turbine.rotor import Plant, Span
from takagi.certificates.checker.turbine.turbine_claim import (
    DRIVES,
    PROGRAM,
    RIGID,
    TurbineClaim,
    row_bound,
)
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rounded import at_least, range_within

NAME = "effort-sharing loop at constant set-points"
MOST_CELLS = 5000
# In one interval of the law's tables: all pairs of them are compared.
MOST_BESIDE = 200
# Decimals of the corners of the loop's matrix, which are rounded outward.
DIGITS = 10**9
Box = tuple[Span, Span, Span]


@dataclass(frozen=True)
class Cell:
    """A box of winds, reductions of the reference speed and torque set-points, and its evidence.

    Attributes
    ----------
    box : [m/s], [rad/s], [N m].   shifts : w_1, w_2 [rad/s^2].
    bounds : r_e, r_s [rad/s], r_b [rad].
    rate : rho [1/s].
    """

    box: Box
    shifts: Span
    bounds: tuple[Fraction, Fraction, Fraction]
    P: Matrix
    rate: Fraction

    @classmethod
    def read(cls, cell: Any, where: str) -> Self:
        """Return the cell; refuses ranges that are not in order, and sizes that are not above 0."""
        spans = [numbers(cell, name, where, 2) for name in ("wind", "reduction", "torque", "shift")]
        wind, reduction, torque, shift = ((low, high) for low, high in spans)
        error, signal, pitch = numbers(cell, "bounds", where, 3)
        rate = number(cell, "decay_rate", where)
        ordered = all(low <= high for low, high in (wind, reduction, torque, shift))
        if not ordered or not 0 < wind[0] < wind[1] or min(error, signal, pitch, rate) <= 0:
            raise CertificateError(f"{where}: ranges in order and sizes above 0 are needed")
        P = read_matrix(cell, "P", where, (3, 3))
        return cls((wind, reduction, torque), shift, (error, signal, pitch), P, rate)


class CellLoop:
    """The enclosures of the loop in one cell.

    Raises
    ------
    Refused : winds that are not inside one interval of the law's tables.
    """

    def __init__(self, plant: Plant, law: Law, setpoints: SetpointRange, cell: Cell) -> None:
        self.plant, self.law, self.setpoints, self.cell = plant, law, setpoints, cell
        self.winds = WindCell(plant, law, cell.box[0])
        self.gamma = self.winds.over(law.gamma)
        self.b = self.winds.over(law.effectiveness)
        ends = [self._effort(shift, cell.box).value for shift in cell.shifts]
        # U at the equilibrium, and on the set.
        self.at_rest = Fraction(ends[0].low, ONE), Fraction(ends[1].high, ONE)
        reach = self.gamma[1] * cell.bounds[1]
        self.reached = self.at_rest[0] - reach, self.at_rest[1] + reach
        self.share = tuple(share(U, law.overlap) for U in self.reached)
        self.signal_gain = (
            self.share[0] * self.gamma[0] / self.b[1],
            self.share[1] * self.gamma[1] / self.b[0],
        )

    def excess(self, shift: Fraction) -> Interval:
        """Return T_r/J - (n_g/J) T at the steady state of U = q* + shift + ... [rad/s^2].

        From its value at the middle of the box and its slopes over the box: wind, set-points and
        effort move together, so that its range by values alone would be far wider.
        """
        middle = tuple((m, m) for m in ((low + high) / 2 for low, high in self.cell.box))
        at_middle = self._excess(shift, middle)  # type: ignore[arg-type]
        apart = sum(slope.magnitude() for slope in self._excess(shift, self.cell.box).slopes)
        return at_middle.value + Interval(-apart, apart)

    def _parameters(self, box: Box) -> list[Dual]:
        """Return wind, reduction and torque set-point, with slopes per half width of the box."""
        parameters = []
        for i, (low, high) in enumerate(box):
            slopes = [point((high - low) / 2) if i == j else ZERO for j in range(len(box))]
            parameters.append(Dual(enclose(low, high), tuple(slopes)))
        return parameters

    def _over(self, column: list[Fraction], box: Box) -> Dual:
        ends = [self.winds.at(column, v) for v in box[0]]
        wind, slope = self._parameters(box)[0], point(self.winds.slope(column))
        return wind.through(enclose(min(ends), max(ends)), slope)

    def _effort(self, shift: Fraction, box: Box) -> Dual:
        law, (_, reduction, torque) = self.law, self._parameters(box)
        lowered = (-torque).plus(point(law.rated_torque)).by(point(1 / law.effort_torque))
        speed_effort = self._over(self.setpoints.speed_effort, box)
        return (self._over(law.effort, box) + speed_effort * reduction + lowered).plus(point(shift))

    def _excess(self, shift: Fraction, box: Box) -> Dual:
        plant, law, (wind, reduction, torque) = self.plant, self.law, self._parameters(box)
        effort = self._effort(shift, box)
        efforts = Fraction(effort.value.low, ONE), Fraction(effort.value.high, ONE)
        of_pitch = self.winds.share(efforts)
        shed = effort.through(self.winds.psi(efforts), of_pitch)
        reserve = self.winds.psi((-efforts[1], -efforts[0]))
        braking = torque - effort.through(reserve, of_pitch - UNIT).by(point(law.effort_torque))
        pitch = (shed / self._over(law.effectiveness, box)).plus(point(law.pitch_min))
        speed = self._over(law.speed, box) + reduction
        ratio, v, beta = self.ratio(Fraction(0), box), wind.value, pitch.value
        rotor = chained(
            plant.torque(ratio, beta, v),
            (plant.torque_by_speed(ratio, beta, v), speed),
            (plant.torque_by_pitch(ratio, beta, v), pitch),
            (plant.torque_by_wind(ratio, beta, v), wind),
        )
        return rotor - braking.by(point(plant.gear_per_inertia))

    def ratio(self, error: Fraction, box: Box) -> Interval:
        """Return R (omega* + r + e)/v for |e| up to a bound; it is monotone in each variable."""
        corners = [
            self.plant.radius * (self.winds.at(self.law.speed, v) + r) / v
            for v in box[0]
            for r in (box[1][0] - error, box[1][1] + error)
        ]
        return enclose(min(corners), max(corners))

    def least_torque(self) -> Fraction:
        """Return a lower bound of T_s - E psi(-U) on the set [N m]; it grows with U and T_s."""
        law, (wind, reduction, torque) = self.law, self.cell.box
        effort = self._effort(self.cell.shifts[0], (wind, reduction, (torque[0], torque[0])))
        lowest = Fraction(effort.value.low, ONE) - self.gamma[1] * self.cell.bounds[1]
        return torque[0] - law.effort_torque * psi(-lowest, law.overlap)

    def pitches(self) -> Span:
        """Return the pitch angles that are reached [rad]."""
        low, high = (psi(U, self.law.overlap) for U in self.at_rest)
        lowest = max(low / self.b[1] - self.cell.bounds[2], Fraction(0))
        return self.law.pitch_min + lowest, (
            self.law.pitch_min + high / self.b[0] + self.cell.bounds[2]
        )

    def slopes(self) -> tuple[Span, Span]:
        """Return the ranges of a [1/s] and sigma [rad/s^2 per rad], rounded outward."""
        ratio = self.ratio(self.cell.bounds[0], self.cell.box)
        pitch = enclose(*self.pitches())
        wind = self.winds.wind
        by_speed = self.plant.torque_by_speed(ratio, pitch, wind)
        return _outward(by_speed), _outward(-self.plant.torque_by_pitch(ratio, pitch, wind))

    def corners(self) -> Iterator[Matrix]:
        """Yield the matrices in whose hull the loop's lies; equal ones are yielded once."""
        m, lag, zero = self.winds.effort_unit, self.plant.lag, Fraction(0)
        nu = self.law.nu[self.winds.k]
        ends = (*self.slopes(), self.share, self.gamma, self.b)
        for a, sigma, F, gamma, b in product(*(sorted(set(pair)) for pair in ends)):
            torque, pitch = m * (1 - F) * gamma, F * gamma / (b * lag)
            yield Matrix.of(
                [[a - torque, -sigma, torque], [pitch, -1 / lag, -pitch], [-nu, zero, zero]]
            )

    def integral(self) -> Fraction:
        """Return a bound of |x*| = |w*|/gamma [rad/s]."""
        return max(map(abs, self.cell.shifts)) / self.gamma[0]


@dataclass(frozen=True)
class SetPoints(TurbineClaim):
    """At every constant wind and set-point the loop settles at the reference; see the module."""

    plant: Plant
    law: Law
    setpoints: SetpointRange
    cells: list[Cell]

    at_rated: ClassVar[bool] = False
    assumes: ClassVar[tuple[str, ...]] = (
        "start inside the set of wind and set-points, pitch at or above its lower limit",
        "constant wind that the law knows",
        "constant set-points",
        *DRIVES,
        *RIGID,
        *PROGRAM,
    )
    members: ClassVar[dict[str, Members | None]] = {
        **plain("state"),
        "cells": plain("wind reduction torque shift bounds P decay_rate"),
    }

    @classmethod
    def read(cls, claim: Any, data: Any, earlier: Sequence[Outcome], where: str) -> Self:
        """Return the claim.

        Raises
        ------
        CertificateError : a law without set-points, or a part that is not what it has to be.
        """
        plant, law = Plant.read(data["model"]), Law.read(data.get("gains"))
        if law.setpoints is None:
            raise CertificateError("gains.setpoints: a claim about set-points needs it")
        if (plant.pitch_min, plant.pitch_max) != (law.pitch_min, law.pitch_max):
            raise CertificateError("gains: pitch limits differ from the model's")
        cells = [
            Cell.read(cell, f"{where}.cells[{k}]")
            for k, cell in enumerate(listed(claim, "cells", where, 0, MOST_CELLS))
        ]
        return cls(claim, data, where, NAME, plant, law, law.setpoints, cells)

    def parts(self) -> Iterator[tuple[str, Obligations]]:
        for cell in self.cells:
            yield f"wind {range_within(*cell.box[0])} m/s: ", self._cell(cell)
        yield "", self._covered()

    def not_proved(self) -> str:
        return f"not proved, of {len(self.cells)} cells: "

    def figures(self) -> Iterator[Figure | WindProfile]:
        setpoints = self.setpoints
        yield Figure("lowest speed set-point", "rad/s", setpoints.lowest_speed, larger=False)
        yield Figure("lowest torque set-point", "N m", setpoints.lowest_torque, larger=False)
        yield Figure("lowest power set-point", "W", self._power(), larger=False)
        yield Figure("decay rate", "1/s", min(cell.rate for cell in self.cells))

    def sentence(self) -> str:
        law, setpoints = self.law, self.setpoints
        rated = setpoints.power_per_torque * law.speed[-1] * law.rated_torque
        rate = min(cell.rate for cell in self.cells)
        return (
            f"winds {range_within(law.wind[0], law.wind[-1])} m/s, speed set-points "
            f"{range_within(setpoints.lowest_speed, law.speed[-1])} rad/s, torque set-points "
            f"{range_within(setpoints.lowest_torque, law.rated_torque)} N m (power set-points "
            f"{range_within(self._power(), rated)} W by the law's factor), each constant, in "
            f"{len(self.cells)} cells: "
            f"the loop has one equilibrium in each stated set, where the rotor turns at the lower "
            f"one of reference speed and the speed that both set-points allow, and settles there "
            f"at no less than {at_least(rate, 3)} 1/s, from a speed error alone of up to "
            f"{at_least(self._least_reach(), 3)} rad/s or more, by cell; nominal inertia and "
            "equilibrium wake"
        )

    def _least_reach(self) -> Fraction:
        """Return the least of the speed errors from which, alone, every set is entered [rad/s]."""
        scale = 10**6
        squares = (1 / cell.P[0, 0] for cell in self.cells)
        return min(Fraction(isqrt(int(square * scale**2)), scale) for square in squares)

    def _power(self) -> Fraction:
        setpoints = self.setpoints
        return setpoints.power_per_torque * setpoints.lowest_speed * setpoints.lowest_torque

    def _cell(self, cell: Cell) -> Obligations:
        """Yield what must hold in one cell.

        Raises
        ------
        Refused : an enclosure that is refused.
        """
        loop, law = CellLoop(self.plant, self.law, self.setpoints, cell), self.law
        low, high = cell.shifts
        failure = "the stated efforts do not enclose an equilibrium"
        yield positive(loop.excess(low).low, failure)
        yield positive(-loop.excess(high).high, failure)
        yield nonnegative(loop.least_torque(), "torque may reach zero")
        asked = loop.winds.pitch(point(psi(loop.reached[1], law.overlap))).high
        highest = max(Fraction(asked, ONE), loop.pitches()[1])
        yield nonnegative(law.pitch_max - highest, "pitch may reach its upper limit")
        P = cell.P
        yield positive(P, "P is not symmetric positive definite")
        rows: list[tuple[str, list[Fraction | int], Fraction]] = [
            ("the speed error", [1, 0, 0], cell.bounds[0]),
            ("the speed signal", [1, 0, -1], cell.bounds[1]),
            ("pitch", [0, 1, 0], cell.bounds[2]),
        ]
        turning = self.plant.rate_limit * self.plant.lag
        rows += [("the pitch rate limit", [g, -1, -g], turning) for g in loop.signal_gain]
        room = law.integral_limit - loop.integral()
        yield positive(room, "the integral may reach its limit at the equilibrium")
        rows.append(("the integral's limit", [0, 0, 1], room))
        for words, row, bound in rows:
            h = Matrix.of([[Fraction(entry) for entry in row]])
            yield positive(row_bound(P, h, bound), f"the set is not inside the bound of {words}")
        for A in loop.corners():
            decay = -(A.T @ P + P @ A + 2 * cell.rate * P)
            yield positive(decay, "the decay inequality fails at a corner")

    def _covered(self) -> Obligations:
        """Yield that the cells cover every wind of the tables and every set-point."""
        law, setpoints = self.law, self.setpoints
        torque = setpoints.lowest_torque, law.rated_torque
        for k in range(len(law.wind) - 1):
            fastest = max(law.speed[k : k + 2])
            reduction = min(setpoints.lowest_speed - fastest, Fraction(0)), Fraction(0)
            winds = law.wind[k], law.wind[k + 1]
            # Those of the intervals beside it meet this one in a wind alone.
            boxes = [cell.box for cell in self.cells if _overlap(cell.box[0], winds)]
            if not covers(boxes, (winds, reduction, torque)):
                yield never(
                    f"wind {range_within(*winds)} m/s: not covered, or by cells that overlap"
                )


def covers(boxes: Sequence[Box], region: Box) -> bool:
    """Return whether few boxes cover the region and do not overlap in it: by their volumes.

    A side of the region that is one number has no part in the volume.
    """
    sides = [i for i, (low, high) in enumerate(region) if low < high]
    parts = [
        [(max(box[i][0], region[i][0]), min(box[i][1], region[i][1])) for i in sides]
        for box in boxes
        if all(map(_meet, box, region))
    ]
    # What closed parts of the whole volume leave would be open and of no volume: nothing.
    if len(parts) > MOST_BESIDE:
        return False
    disjoint = not any(all(map(_overlap, a, b)) for a, b in combinations(parts, 2))
    return disjoint and sum(map(_volume, parts)) == _volume([region[i] for i in sides])


def _volume(sides: Sequence[Span]) -> Fraction:
    return prod((high - low for low, high in sides), start=Fraction(1))


def _meet(a: Span, b: Span) -> bool:
    return a[0] <= b[1] and b[0] <= a[1]


def _overlap(a: Span, b: Span) -> bool:
    return a[0] < b[1] and b[0] < a[1]


def _outward(value: Interval) -> Span:
    low, high = value.low * DIGITS // ONE, -(-value.high * DIGITS // ONE)
    return Fraction(low, DIGITS), Fraction(high, DIGITS)
