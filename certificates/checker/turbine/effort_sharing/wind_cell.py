r"""Winds in one interval of the effort-sharing law's tables: the enclosure that its claims read.

Reference speed, effort, pitch effectiveness and gain are lines over wind there.  Where a curve is
enclosed, the enclosure is kept as one function: lambda = R omega* / v, whose two parts move
together; m - F (m - sigma) along the ramp, in which a lower share F of pitch goes with a lower
pitch; and the residual of the tables,

    r(v) = c v^2 c_Q(lambda(v), beta(v)) - (n_g / J) (T_rated - E psi(-q*(v))) .

r' is Lipschitz, so |r| <= max(|r(v_1)|, |r(v_2)|) + (width^2 / 8) sup |r''|.  If the true power
coefficient is s times the table's, the residual is r + (s - 1) T_r* / J, with
T_r* / J = r + (n_g / J) (T_rated - E psi(-q*)).
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from itertools import pairwise

from takagi.certificates.checker.arithmetic.effort_ramp import psi, share
from takagi.certificates.checker.arithmetic.interval import ZERO, Interval, enclose, hull, point
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.rotor import Plant, Span

NIL, FULL = Fraction(0), Fraction(1)
# Value, first and second derivative over the winds of a cell.
Jet = tuple[Interval, Interval, Interval]


class WindCell:
    """Winds from low to high, inside one interval of the law's tables.

    Raises
    ------
    Refused : winds that are not inside one interval.
    """

    def __init__(self, plant: Plant, law: Law, winds: Span) -> None:
        self.plant, self.law, self.winds = plant, law, winds
        (low, high), nodes = winds, law.wind
        self.k = min(max(bisect_right(nodes, low) - 1, 0), len(nodes) - 2)
        if not nodes[self.k] <= low < high <= nodes[self.k + 1]:
            raise Refused("winds that are not inside one interval of the law's tables")
        self.wind, self.b = enclose(low, high), enclose(*self.over(law.effectiveness))
        self.effort_unit = law.effort_torque * plant.gear_per_inertia

    def at(self, column: Sequence[Fraction], wind: Fraction) -> Fraction:
        """Return a column at a wind within the tables."""
        nodes, j = self.law.wind, self.k
        if not nodes[j] <= wind <= nodes[j + 1]:
            j = min(max(bisect_right(nodes, wind) - 1, 0), len(nodes) - 2)
        rise = (column[j + 1] - column[j]) / (nodes[j + 1] - nodes[j])
        return column[j] + rise * (wind - nodes[j])

    def over(self, column: Sequence[Fraction], winds: Span | None = None) -> Span:
        """Return a column's least and greatest value over the cell's or other winds."""
        low, high = winds or self.winds
        values = [self.at(column, low), self.at(column, high)]
        if winds is not None:
            values += [y for v, y in zip(self.law.wind, column, strict=True) if low < v < high]
        return min(values), max(values)

    def slope(self, column: list[Fraction]) -> Fraction:
        """Return a column's slope over wind in the cell."""
        return self.law.slope(column, self.k)

    def psi(self, efforts: Span) -> Interval:
        """Return the range of the ramp for efforts from low to high."""
        return enclose(*(psi(U, self.law.overlap) for U in efforts))

    def share(self, efforts: Span) -> Interval:
        """Return the range of the ramp's slope."""
        return enclose(*(share(U, self.law.overlap) for U in efforts))

    def pitch(self, shed: Interval) -> Interval:
        """Return beta_min + shed / b."""
        return shed / self.b + point(self.plant.pitch_min)

    def tip_speed(self, speed_error: Fraction = NIL, wind_error: Fraction = NIL) -> Interval:
        """Return R (omega* + e) / (v + d); it is monotone in each variable, so corners suffice."""
        corners = [
            self.plant.radius * (self.at(self.law.speed, v) + e) / (v + d)
            for v in self.winds
            for e in {-speed_error, speed_error}
            for d in {-wind_error, wind_error}
        ]
        return enclose(min(corners), max(corners))

    def effort_gain(
        self, efforts: Iterable[Fraction], sigma: Callable[[Interval], Interval]
    ) -> Interval:
        """Return m - F (m - sigma(beta)) along beta = beta_min + psi(U) / b.

        Parameters
        ----------
        efforts : where the curve is cut.
        sigma : pitch's effect per effort, over a range of pitch.
        """
        gains, m = [], point(self.effort_unit)
        for part in pairwise(sorted(efforts)):
            of_pitch = self.share(part)
            if of_pitch.high <= 0:
                gains.append(m)
            else:
                gains.append(m - of_pitch * (m - sigma(self.pitch(self.psi(part)))))
        return hull(*gains)

    def on_ramp(self, efforts: Span) -> Span | None:
        """Return the part of the efforts where the ramp is curved."""
        eps = self.law.overlap
        start, stop = max(efforts[0], -eps), min(efforts[1], eps)
        return (start, stop) if start < stop else None

    def residual(self, power: Span = (FULL, FULL)) -> int:
        """Return a bound of |r + (s - 1) T_r* / J| over the cell, as an integer over 10^36."""
        bent = Interval(0, self._curvature().magnitude())
        bent = bent * point((self.winds[1] - self.winds[0]) ** 2 / 8)
        tables = max(self._residual_at(v).magnitude() for v in self.winds) + bent.high
        wrong = max(1 - power[0], power[1] - 1)
        # psi is monotone, so the demanded torque lies between its values at the ends.
        trim = max(abs(self._demanded(v)) for v in self.winds)
        return (Interval(0, tables) * point(1 + wrong)).high + point(wrong * trim).high

    def _residual_at(self, v: Fraction) -> Interval:
        law = self.law
        speed, effort, b = (self.at(c, v) for c in (law.speed, law.effort, law.effectiveness))
        ratio = point(self.plant.radius * speed / v)
        pitch = point(law.pitch_min + psi(effort, law.overlap) / b)
        return self.plant.torque(ratio, pitch, point(v)) - point(self._demanded(v))

    def _demanded(self, v: Fraction) -> Fraction:
        """Return (n_g / J) (T_rated - E psi(-q*)), the deceleration by the law's torque."""
        law = self.law
        reserve = psi(-self.at(law.effort, v), law.overlap)
        return (law.rated_torque - law.effort_torque * reserve) * self.plant.gear_per_inertia

    def _curvature(self) -> Interval:
        """Return r'', from the jets of lambda, beta and c_Q."""
        v, efforts = self.wind, self.over(self.law.effort)
        c0, c1, c2 = self._coefficient(self._ratio(), self._pitch(efforts))
        # (v^2 c_Q)'' = 2 c_Q + 4 v c_Q' + v^2 c_Q''.
        two, four = point(Fraction(2)), point(Fraction(4))
        torque = two * c0 + (four * v * c1 + v.square() * c2)
        reserve = (
            self._bend((-efforts[1], -efforts[0])) * point(self.slope(self.law.effort)).square()
        )
        return point(self.plant.torque_per_inertia) * torque + point(self.effort_unit) * reserve

    def _ratio(self) -> Jet:
        """Return the jet of lambda = R (w_0 / v + w_1): its slope is -R w_0 / v^2."""
        v, (low, _) = self.wind, self.winds
        at_zero = self.at(self.law.speed, low) - self.slope(self.law.speed) * low
        first = point(self.plant.radius * at_zero)
        return self.tip_speed(), -first / v.square(), (first + first) / (v.square() * v)

    def _pitch(self, efforts: Span) -> Jet:
        """Return the jet of beta_min + psi(q) / b."""
        law, b = self.law, self.b
        b1, q1 = (point(self.slope(column)) for column in (law.effectiveness, law.effort))
        shed = self.psi(efforts)
        shed1, shed2 = self.share(efforts) * q1, self._bend(efforts) * q1.square()
        beta1 = (shed1 - shed / b * b1) / b
        bent = beta1 * b1
        return self.pitch(shed), beta1, (shed2 - (bent + bent)) / b

    def _coefficient(self, ratio: Jet, pitch: Jet) -> Jet:
        """Return the jet of c_Q(lambda(v), beta(v)) by the chain rule."""
        (x0, x1, x2), (y0, y1, y2) = ratio, pitch
        orders = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))
        c = {order: self.plant.surface.bounds(x0, y0, *order) for order in orders}
        cross = c[1, 1] * x1 * y1
        bent = c[2, 0] * x1.square() + c[0, 2] * y1.square() + (cross + cross)
        bent = bent + (c[1, 0] * x2 + c[0, 1] * y2)
        return c[0, 0], c[1, 0] * x1 + c[0, 1] * y1, bent

    def _bend(self, efforts: Span) -> Interval:
        """Return the range of psi'': 1 / (2 eps) inside the ramp, 0 outside."""
        (low, high), eps = efforts, self.law.overlap
        if high <= -eps or low >= eps:
            return ZERO
        return Interval(0, point(1 / (2 * eps)).high)
