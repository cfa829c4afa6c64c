r"""The equilibria of the loop with the effort-sharing law at a constant wind, v_s = v.

An equilibrium requires beta = beta_ref and x' = 0: e = 0, or the integrator is at a limit X and the
speed error drives it outward. Each case leads to one torque balance,

    f = T_r(omega* + e, beta, v)/J - n_g T/J,        U    = q* + gamma (e - x)
    T = T_rated - E psi(-U) held at 0,               beta = beta_min + psi(U)/b held at beta_max

    inside      e = 0, s = x in [-X, X]
    upper       x = X,  e <= 0, s = lambda from the table's lower end to R omega*/v
    lower       x = -X, e >= 0, s = lambda from R omega*/v to the table's upper end

A pitch map Delta with Delta = 0 at the trim's pitch and dDelta/dbeta <= 0 (any wake from the
surface's own to a frozen one, and beyond) adds to f what is >= 0 for U < q*, <= 0 for U > q*, and
what rises with x.  So f > 0 may decide a piece with x >= 0 alone, f < 0 one with x <= 0 alone,
and what is counted then holds for every such map.  The inertia scales f, and does not matter.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

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
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law, Plant
from takagi.certificates.checker.turbine.equilibria.zero_count import (
    ANY_SIGN,
    Count,
    Piece,
    Span,
    count_zeros,
)

MOST_PARTS = 64
# The table's ends are rounded in fixed point, so the range stays slightly inside.
EDGE = Fraction(1, 10**20)


@dataclass(frozen=True)
class EffortSharingEquilibria:
    """The number of equilibria of each case at every wind of a cell."""

    inside: Count
    upper: Count
    lower: Count


def effort_sharing_equilibria(
    plant: Plant, law: Law, winds: Span, *, common: bool = False
) -> EffortSharingEquilibria:
    """Return the counts for winds inside one interval of the law's tables.

    Parameters
    ----------
    common : cut the cases at a limit to the tip-speed ratios that belong to them at every wind,
        so that each zero is a rest; otherwise they hold every rest, and perhaps more.

    Raises
    ------
    Refused : winds that reach over a node, or leave the tables.
    """
    rest = _Equilibrium(plant, law, winds)
    limit, zero = law.integral_limit, Fraction(0)
    at_trim = [plant.radius * rest.speed(v) / v for v in winds]
    least = plant.surface.x.breaks[0] + EDGE
    most = plant.surface.x.breaks[-1] - EDGE
    if not least < min(at_trim) <= max(at_trim) < most:
        raise Refused("a reference speed that leaves the coefficient table")
    nearest = (min(at_trim), max(at_trim)) if common else (max(at_trim), min(at_trim))
    negative, positive = frozenset({-1}), frozenset({1})
    inside = (Piece((-limit, zero), negative), Piece((zero, limit), positive))
    return EffortSharingEquilibria(
        count_zeros(rest.inside, winds, inside, most_parts=MOST_PARTS),
        count_zeros(
            rest.upper, winds, [Piece((least, nearest[0]), ANY_SIGN)], most_parts=MOST_PARTS
        ),
        count_zeros(
            rest.lower, winds, [Piece((nearest[1], most), ANY_SIGN)], most_parts=MOST_PARTS
        ),
    )


class _Equilibrium:
    """The balance of each case over rectangles of wind and parameter."""

    def __init__(self, plant: Plant, law: Law, winds: Span) -> None:
        self.plant, self.law = plant, law
        inside = [k for k, v in enumerate(law.wind[:-1]) if v <= winds[0] < law.wind[k + 1]]
        if not inside or not winds[0] < winds[1] <= law.wind[inside[0] + 1]:
            raise Refused("winds that are not inside one interval of the tables")
        self.k = inside[0]
        self.c = point(plant.torque_per_inertia)

    def inside(self, winds: Span, integral: Span) -> Dual | None:
        """e = 0, s = x."""
        speed, x = self._column(self.law.speed, winds), _parameter(integral)
        ratio = self._ratio(speed, winds)
        effort = self._column(self.law.effort, winds) - self._column(self.law.gamma, winds) * x
        return self._excess(winds, ratio, speed, effort)

    def upper(self, winds: Span, ratio: Span) -> Dual | None:
        """x = X, s = lambda."""
        return self._at_limit(winds, ratio, self.law.integral_limit)

    def lower(self, winds: Span, ratio: Span) -> Dual | None:
        """x = -X, s = lambda."""
        return self._at_limit(winds, ratio, -self.law.integral_limit)

    def speed(self, wind: Fraction) -> Fraction:
        """Return omega* at a wind."""
        return self._at(self.law.speed, wind)

    def _at_limit(self, winds: Span, ratio: Span, limit: Fraction) -> Dual | None:
        tip = _parameter(ratio)
        speed = (_wind(winds) * tip).by(point(1 / self.plant.radius))
        error = speed - self._column(self.law.speed, winds)
        signal = error.plus(point(-limit))
        effort = self._column(self.law.effort, winds)
        effort = effort + self._column(self.law.gamma, winds) * signal
        return self._excess(winds, tip.value, speed, effort)

    def _excess(self, winds: Span, ratio: Interval, speed: Dual, effort: Dual) -> Dual | None:
        """Return f; without slopes where the pitch may leave the table, None where it does."""
        pitch = self._pitch(winds, effort)
        if not isinstance(pitch, Dual):
            return None
        bounds, wind = self.plant.surface.bounds, _wind(winds)
        value, by_ratio = bounds(ratio, pitch.value), bounds(ratio, pitch.value, 1, 0)
        cv, cvv = self.c * wind.value, self.c * wind.value.square()
        by_wind = cv * (value + value - ratio * by_ratio)
        demanded = self._torque(effort)
        if not pitch.slopes:
            return Dual(cvv * value - demanded.value, ())
        rotor = chained(
            cvv * value,
            (cv * point(self.plant.radius) * by_ratio, speed),
            (cvv * bounds(ratio, pitch.value, 0, 1), pitch),
            (by_wind, wind),
        )
        return rotor - demanded

    def _pitch(self, winds: Span, effort: Dual) -> Dual | None:
        """Return beta_min + psi(U)/b within the table."""
        shed = self._ramp(effort) / self._column(self.law.effectiveness, winds)
        limit = point(self.law.pitch_max)
        pitch = shed.plus(point(self.law.pitch_min)).clamped(point(self.law.pitch_min), limit)
        table = self.plant.surface.y
        if self.law.pitch_max <= table.breaks[-1]:
            # A pitch at its limit is inside the table if both end together: the end is rounded down
            # by less than 10^-36, far below the widening of the brackets.
            end = table.breaks_fixed[-1]
            return Dual(Interval(*(min(value, end) for value in pitch.value)), pitch.slopes)
        last = point(table.breaks[-1] - EDGE)[0]
        if pitch.value[0] > last:
            return None
        if pitch.value[1] > last:
            return Dual(Interval(pitch.value.low, last), ())
        return pitch

    def _torque(self, effort: Dual) -> Dual:
        """Return n_g T / J."""
        law = self.law
        reserve = self._ramp(-effort).by(point(law.effort_torque))
        torque = (-reserve).plus(point(law.rated_torque)).clamped(ZERO, point(law.rated_torque))
        return torque.by(point(self.plant.gear_per_inertia))

    def _ramp(self, effort: Dual) -> Dual:
        low, high = (Fraction(x, ONE) for x in effort.value)
        eps = self.law.overlap
        value = enclose(psi(low, eps), psi(high, eps))
        return effort.through(value, enclose(share(low, eps), share(high, eps)))

    def _ratio(self, speed: Dual, winds: Span) -> Interval:
        """Return R omega*/v: a quotient of lines, monotone in v."""
        ends = [self.plant.radius * self.speed(v) / v for v in winds]
        return enclose(min(ends), max(ends))

    def _column(self, column: list[Fraction], winds: Span) -> Dual:
        ends = [self._at(column, v) for v in winds]
        pace = point(self.law.slope(column, self.k))
        return Dual(enclose(min(ends), max(ends)), (pace, ZERO))

    def _at(self, column: list[Fraction], wind: Fraction) -> Fraction:
        return column[self.k] + self.law.slope(column, self.k) * (wind - self.law.wind[self.k])


def _wind(winds: Span) -> Dual:
    return Dual(enclose(*winds), (UNIT, ZERO))


def _parameter(span: Span) -> Dual:
    return Dual(enclose(*span), (ZERO, UNIT))
