r"""One cell of constant winds: tables, torque surface, equilibrium and factors over its box.

At a rest omega_m = omega = omegahat, v_s = vhat (within the tables) and omega_m = omega*(v_s).
Rotor and observer give T_r(omega, beta, v) = n_g T = T_r(omega, beta, vhat), which vhat = v solves.
So the trim's speed omega*(v) with the effort that balances torque is a rest.  That effort U_rest is
a zero of

    g(U) = c v^2 c_Q(R omega* / v, beta_min + psi(U) / b) + m_E psi(-U) - n_g T_rated / J

whose value at q* is the tables' residual r, and -g' = F sigma + (1 - F) m_E.  Where that is at
least G > 0 over |U - q*| <= side, and |r| / G <= side, there is one zero, and
|U_rest - q*| <= |r| / G.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cached_property

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.interval import ONE, Interval, enclose, point
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.effort_sharing.wind_cell import FULL, NIL, WindCell
from takagi.certificates.checker.turbine.rotor import Plant
from takagi.certificates.checker.turbine.running_loop.inputs import Machine, Sides, Span

DECIMALS = 10**7
# The effort's range is divided into parts over which the share of pitch changes by about this much.
SHARE_STEP = Fraction(1, 10)


class Cell(WindCell):
    """Constant winds from low to high, inside one interval of the law's tables.

    Raises
    ------
    Refused : winds that are not inside one interval, an estimate that may reach its limit, a range
        that leaves the coefficient table, or no equilibrium that is shown to lie near the trim.
    """

    def __init__(self, plant: Plant, law: Law, machine: Machine, winds: Span, sides: Sides) -> None:
        super().__init__(plant, law, winds)
        self.machine, self.sides = machine, sides
        (low, high), nodes = winds, law.wind
        lowest, highest = low - sides.estimate, high + sides.estimate
        if not machine.wind_limits[0] < lowest < highest < machine.wind_limits[1]:
            raise Refused("the wind estimate may reach its limit")
        if not 0 < low - sides.schedule:
            raise Refused("the schedule wind may reach zero")
        self.estimate_is_free = nodes[0] <= lowest and highest <= nodes[-1]
        # The law limits the estimate to the winds of its tables, and so the schedule wind.
        self.reach = (max(low - sides.schedule, nodes[0]), min(high + sides.schedule, nodes[-1]))
        self.near = [
            j
            for j in range(len(nodes) - 1)
            if nodes[j] < self.reach[1] and nodes[j + 1] > self.reach[0]
        ]
        self.b_reach = self.over(law.effectiveness, self.reach)
        # The unit of the pitch states; any positive number is possible.
        self.b0 = Fraction(round(sum(self.over(law.effectiveness)) * 500), 1000)
        if self.b0 <= 0:
            raise Refused("an assumed pitch effectiveness below 0.0005")
        self.q = self.over(law.effort)
        self.rest = self._rest()
        self.rest_integral = self.rest / self.over(law.gamma)[0]
        reach = sides.effort + self.rest
        self.efforts = (self.q[0] - reach, self.q[1] + reach)
        self.efforts_at_rest = (self.q[0] - self.rest, self.q[1] + self.rest)

    def slopes(self, column: list[Fraction]) -> Span:
        """Return the range of a column's slope over all schedule winds of the set.

        A secant between two of these winds is a mean of slopes, so it lies in this range.
        """
        slopes = [self.law.slope(column, j) for j in self.near]
        return min(slopes), max(slopes)

    def steps(self, column: list[Fraction]) -> Span:
        """Return the range of a column that is constant between two nodes."""
        values = [column[j] for j in self.near]
        return min(values), max(values)

    @cached_property
    def pitches(self) -> Interval:
        """The pitch range on the set, not below the lower limit."""
        rest = self.pitch(self.psi(self.efforts_at_rest))
        away = point(self.sides.pitch / self.b0)
        least = max((rest - away).low, point(self.plant.pitch_min).low)
        return Interval(least, (rest + away).high)

    def speed_gain(self, error: Fraction) -> Interval:
        """Return dT_r/domega / J over speeds within ``error`` of the reference."""
        return self.plant.torque_by_speed(self.tip_speed(error), self.pitches, self.wind)

    def pitch_gain(self, pitch: Interval) -> Interval:
        """Return sigma = -dT_r/dbeta / (J b0) at the reference speed."""
        steep = self.plant.torque_by_pitch(self.tip_speed(), pitch, self.wind)
        return -steep / point(self.b0)

    def wind_gain(self) -> Interval:
        """Return dT_r/dv / J over the observer's winds."""
        away = self.sides.estimate
        seen = enclose(self.winds[0] - away, self.winds[1] + away)
        ratio = self.tip_speed(self.sides.measured, away)
        return self.plant.torque_by_wind(ratio, self.pitches, seen)

    def _rest(self) -> Fraction:
        """Return a bound of |U_rest - q*|; see the module's text."""
        imbalance = Fraction(self.residual(), ONE)
        efforts = (self.q[0] - self.sides.effort, self.q[1] + self.sides.effort)
        cuts = set(efforts)
        if (ramp := self.on_ramp(efforts)) is not None:
            start, stop = ramp
            shares = (share(U, self.law.overlap) for U in (stop, start))
            parts = ((next(shares) - next(shares)) / SHARE_STEP).__ceil__()
            cuts |= {start + (stop - start) * i / parts for i in range(parts + 1)}
        # sigma is scaled by b0; the law's b at the wind itself turns effort into pitch.
        to_law = point(self.b0) / self.b
        gain = self.effort_gain(cuts, lambda pitch: self.pitch_gain(pitch) * to_law)
        least = Fraction(gain.low, ONE)
        if least <= 0 or imbalance > least * self.sides.effort:
            raise Refused("no rest is known to lie near the trim")
        return up(imbalance / least)

    @cached_property
    def ramp_share(self) -> Span:
        """The range of psi's secants: of its slope over all efforts of the set."""
        low, high = (share(U, self.law.overlap) for U in self.efforts)
        return low, high

    @cached_property
    def shed(self) -> Span:
        """The range of psi(U)."""
        low, high = (psi(U, self.law.overlap) for U in self.efforts)
        return low, high

    @cached_property
    def schedule_rate(self) -> Fraction:
        """A bound of |v_s'| [m/s^2]; the limit of the estimate does not increase it."""
        return (self.sides.estimate + self.sides.schedule) / self.machine.wind_filter


def factors(cell: Cell) -> dict[str, Span]:
    """Return each factor's range by the names of ``equations``, without the share of pitch.

    A factor is a secant between a state of the set and the rest, so it lies in the range of the
    derivative over the box.
    """
    law, machine, sides = cell.law, cell.machine, cell.sides
    b0 = point(cell.b0)
    # gamma(v_s) (signal - x_rest) + gamma(v) x_rest: the second part depends on v_s - v.
    steep = size(cell.slopes(law.gamma)) * cell.rest_integral
    q = cell.slopes(law.effort)
    b, b_law = cell.b, enclose(*cell.b_reach)
    bend = enclose(*cell.slopes(law.effectiveness))
    shed_rest = cell.psi(cell.efforts_at_rest)
    sigma = cell.pitch_gain(cell.pitches)
    limit = cell.over(law.limit)[1]
    late = max(limit / cell.b0 - Fraction(sigma.low, ONE), NIL)
    observed, length = machine.observer_inertia, machine.wake_length
    return {
        "speed slope": cell.slopes(law.speed),
        "effort slope": (down(q[0] - steep), up(q[1] + steep)),
        "gamma": _outward(cell.over(law.gamma, cell.reach)),
        "held estimate": (FULL if cell.estimate_is_free else NIL, FULL),
        "pitch per effort": span(b0 / b_law),
        "pitch by schedule": span(shed_rest * bend * b0 / (b_law * b)),
        "integral rate": cell.steps(law.nu),
        "stiffness": span(cell.speed_gain(sides.speed)),
        "pitch gain": span(sigma),
        "late pitch gain": (NIL, up(late)),
        "inertia": _outward((1 / machine.inertia[1], 1 / machine.inertia[0])),
        "observed stiffness": span(cell.speed_gain(max(sides.speed, sides.measured))),
        "wind gain": span(cell.wind_gain()),
        "observer inertia": _outward((observed, observed)),
        "wake rate": _outward((cell.winds[0] / length[1], cell.winds[1] / length[0])),
        "drive": (_drive_secant(cell), FULL),
    }


def _drive_secant(cell: Cell) -> Fraction:
    """Return the least secant of the drive's rate limit: h tau |y| <= limit, |y| as below.

    tau |y| = |beta_ref - beta| is at most the deviation of the law's pitch from the rest, plus the
    deviation of the pitch from the rest.
    """
    law, sides, plant = cell.law, cell.sides, cell.plant
    shed = max(psi(U, law.overlap) for U in cell.efforts_at_rest)
    bend = size(cell.slopes(law.effectiveness))
    moved = (
        cell.ramp_share[1] * sides.effort
        + shed * bend / cell.over(law.effectiveness)[0] * sides.schedule
    )
    most = moved / cell.b_reach[0] + sides.pitch / cell.b0
    return down(min(FULL, plant.rate_limit * plant.lag / most))


def cut(ends: Span, parts: int) -> list[Span]:
    """Divide the interval into equal parts."""
    width = (ends[1] - ends[0]) / parts
    return [(ends[0] + width * i, ends[0] + width * (i + 1)) for i in range(parts)]


def _outward(ends: Span) -> Span:
    """Return seven decimals, rounded outward."""
    return down(ends[0]), up(ends[1])


def down(value: Fraction) -> Fraction:
    """Return the number rounded down to seven decimals."""
    return Fraction((value * DECIMALS).__floor__(), DECIMALS)


def up(value: Fraction) -> Fraction:
    """Return the number rounded up to seven decimals."""
    return -down(-value)


def span(value: Interval) -> Span:
    """Return an interval's ends, rounded outward to seven decimals."""
    return down(Fraction(value.low, ONE)), up(Fraction(value.high, ONE))


def size(ends: Span) -> Fraction:
    """Return the largest size of a number in a range."""
    return max(abs(ends[0]), abs(ends[1]))
