r"""The torque balance of a turbine at equilibrium with the effort-sharing law, over rectangles.

    f = c v^2 c_Q(lambda, beta) - (T_rated n_g / J - m psi(-U))_+,     U = q* + gamma (e - x),
    beta = min(beta_min + psi(U) / b, beta_max),      lambda = R (omega* + e) / v

    inside   e = 0,    x in [-X, X]
    upper    x = X,    e <= 0:  lambda from the table's lower end to lambda* = R omega* / v
    lower    x = -X,   e >= 0:  lambda from lambda* to the table's upper end

Let F = psi'(U) and s = -c v^2 c_Q,beta / b.  Where beta is held at its limit s is 0, and where
torque is held at 0 m is 0.  Let

    D = m (1 - F) + F s,            linear in each of F, m and s: its range is that of its corners.

A dash is a slope of the law's tables over v, and U_v = q*' + gamma' (e - x) + gamma e_v.  Then

    inside      df/dx = gamma D:  where that is positive, a part of [-X, X] has at most one zero
    at a limit  df/dlambda = c v^2 c_Q,lambda - gamma (v / R) D,      e_v = lambda / R - omega*',
                df/dv = 2 c v c_Q - U_v D + s psi(U) b' / b

and f lies in f(middle) + (df/dlambda) (lambda - middle) + (df/dv) (v - middle).
"""

from __future__ import annotations

from dataclasses import dataclass

from flint import fmpq

from takagi.certificates.cross_check.kernel.reading import NotReplayed
from takagi.certificates.cross_check.turbine.effort_ramp import ramp, ramp_slope
from takagi.certificates.cross_check.turbine.numbers import Rotor
from takagi.certificates.cross_check.turbine.surface import NumberRange

MOST_LOOKS = 60_000
ZERO, FULL = fmpq(0), fmpq(1)


class Looks:
    """A counter of the enclosures that are still allowed, for all cells of a claim together."""

    def __init__(self) -> None:
        self.left = MOST_LOOKS

    def count(self) -> None:
        self.left -= 1
        if self.left < 0:
            raise NotReplayed(f"more than {MOST_LOOKS} enclosures")


@dataclass(frozen=True, slots=True)
class BalanceSign:
    """What is known of f over a rectangle of winds and a part of a curve.

    ``sign`` : 1 or -1 where f has this sign everywhere inside the table, else 0.
    ``rises`` : f increases along the curve.
    ``whole`` : all of the rectangle lies in the coefficient table; ``empty`` : no part of it does.
    """

    sign: int = 0
    rises: bool = False
    whole: bool = True
    empty: bool = False


def settled(x: NumberRange, sign: int) -> bool:
    """Return whether no wake changes the sign of f on a part of [-X, X]."""
    return (sign < 0 and x.high <= 0) or (sign > 0 and x.low >= 0)


class Balance:
    """f for winds between two nodes of the law's tables."""

    def __init__(self, rotor: Rotor, k: int, winds: NumberRange, looks: Looks) -> None:
        self.rotor, self.k, self.winds, self.looks = rotor, k, winds, looks
        # Numerator and denominator are affine in v, hence the quotient is monotone.
        ends = [rotor.radius * self._at(rotor.speed, v) / v for v in (winds.low, winds.high)]
        self.trim_ratio = NumberRange.of(*ends)

    def inside(self, x: NumberRange) -> BalanceSign:
        efforts = [
            self._at(self.rotor.effort, v) - self._at(self.rotor.proportional, v) * integral
            for v in (self.winds.low, self.winds.high)
            for integral in (x.low, x.high)
        ]
        at = self._state(self.winds, self.trim_ratio, NumberRange.of(*efforts))
        if at is None:
            return BalanceSign(whole=False, empty=True)
        rises = at.whole and not settled(x, _sign(at.f)) and at.demand().low > 0
        return BalanceSign(_sign(at.f), rises, at.whole)

    def upper(self, ratio: NumberRange) -> BalanceSign:
        return self._at_limit(ratio, self.rotor.integral_limit)

    def lower(self, ratio: NumberRange) -> BalanceSign:
        return self._at_limit(ratio, -self.rotor.integral_limit)

    def _at_limit(self, ratio: NumberRange, x: fmpq) -> BalanceSign:
        winds = self.winds
        signal, efforts = self._limited(winds, ratio, x)
        at = self._state(winds, ratio, efforts)
        if at is None:
            return BalanceSign(whole=False, empty=True)
        sign = _sign(at.f)
        if sign or not at.whole:
            return BalanceSign(sign, whole=at.whole)
        v, tip = middle(winds), middle(ratio)
        central = self._state(v, tip, self._limited(v, tip, x)[1])
        if central is None or not central.whole:
            return BalanceSign()
        by_wind, by_ratio = self.slopes(at, winds, signal)
        return BalanceSign(_sign(central.f + by_ratio * (ratio - tip) + by_wind * (winds - v)))

    def slopes(
        self, at: _State, winds: NumberRange, signal: NumberRange
    ) -> tuple[NumberRange, NumberRange]:
        """Return df/dv and df/dlambda at a limit; ``signal`` is e - x."""
        rotor, ratio = self.rotor, at.ratio
        demand, gamma = at.demand(), self._over(rotor.proportional, winds)
        by_ratio = at.push * at.slope(1, 0) - gamma * winds.times(1 / rotor.radius) * demand
        turn = ratio.times(1 / rotor.radius) - self._slope(rotor.speed)
        moved = self._slope(rotor.effort) + self._slope(rotor.proportional) * signal
        by_wind = winds.times(2 * rotor.c) * at.quotient - (moved + gamma * turn) * demand
        by_wind += at.pitching * at.shed * self._slope(rotor.effectiveness) / at.b
        return by_wind, by_ratio

    def _limited(
        self, winds: NumberRange, ratio: NumberRange, x: fmpq
    ) -> tuple[NumberRange, NumberRange]:
        """Return e - x and U; e = lambda v / R - omega* is affine in v and in lambda."""
        errors = [
            tip * v / self.rotor.radius - self._at(self.rotor.speed, v)
            for v in (winds.low, winds.high)
            for tip in (ratio.low, ratio.high)
        ]
        signal = NumberRange(min(errors) - x, max(errors) - x)
        gamma = self._over(self.rotor.proportional, winds)
        return signal, self._over(self.rotor.effort, winds) + gamma * signal

    def _state(self, winds: NumberRange, ratio: NumberRange, efforts: NumberRange) -> _State | None:
        """Return the rotor's state; None where every pitch of it lies outside the table."""
        self.looks.count()
        b = self._over(self.rotor.effectiveness, winds)
        return _State.of(self.rotor, winds, ratio, efforts, b)

    def _over(self, column: list[fmpq], winds: NumberRange) -> NumberRange:
        return NumberRange.of(*(self._at(column, v) for v in (winds.low, winds.high)))

    def _slope(self, column: list[fmpq]) -> NumberRange:
        nodes, k = self.rotor.wind, self.k
        slope = (column[k + 1] - column[k]) / (nodes[k + 1] - nodes[k])
        return NumberRange(slope, slope)

    def _at(self, column: list[fmpq], wind: fmpq) -> fmpq:
        return column[self.k] + self._slope(column).low * (wind - self.rotor.wind[self.k])


@dataclass(frozen=True, slots=True)
class _State:
    """The rotor over a rectangle of winds and tip-speed ratios, with the efforts of the law.

    ``f`` is the balance, ``push`` c v^2, ``quotient`` c_Q, ``shed`` psi(U).  ``whole`` : no pitch
    lies outside the table; otherwise ``f`` holds for the pitch angles inside the table.
    """

    rotor: Rotor
    ratio: NumberRange
    efforts: NumberRange
    pitch: NumberRange
    b: NumberRange
    shed: NumberRange
    push: NumberRange
    quotient: NumberRange
    f: NumberRange
    whole: bool

    @classmethod
    def of(
        cls,
        rotor: Rotor,
        winds: NumberRange,
        ratio: NumberRange,
        efforts: NumberRange,
        b: NumberRange,
    ) -> _State | None:
        eps, table = rotor.overlap, rotor.surface.y.breaks
        shed = NumberRange(ramp(efforts.low, eps), ramp(efforts.high, eps))
        asked = shed / b + NumberRange(rotor.pitch_min, rotor.pitch_min)
        pitch = NumberRange(min(asked.low, rotor.pitch_max), min(asked.high, rotor.pitch_max))
        if pitch.low > table[-1]:
            return None
        kept = NumberRange(pitch.low, min(pitch.high, table[-1]))
        push, quotient = winds.squared().times(rotor.c), rotor.surface.over(ratio, kept)
        left = [rotor.rated - rotor.m * ramp(-u, eps) for u in (efforts.low, efforts.high)]
        f = push * quotient - NumberRange(max(left[0], ZERO), max(left[1], ZERO))
        whole = pitch.high <= table[-1]
        return cls(
            rotor=rotor,
            ratio=ratio,
            efforts=efforts,
            pitch=kept,
            b=b,
            shed=shed,
            push=push,
            quotient=quotient,
            f=f,
            whole=whole,
        )

    def slope(self, dx: int, dy: int) -> NumberRange:
        """Return the range of a derivative of c_Q."""
        return self.rotor.surface.over(self.ratio, self.pitch, dx, dy)

    @property
    def pitching(self) -> NumberRange:
        """s, with 0 where pitch may be held at its largest."""
        s = -(self.push * self.slope(0, 1)) / self.b
        free = self.rotor.pitch_min + (self.shed / self.b).high <= self.rotor.pitch_max
        return s if free else s.hull(NumberRange(ZERO, ZERO))

    def demand(self) -> NumberRange:
        """Return the range of D."""
        rotor, eps, s = self.rotor, self.rotor.overlap, self.pitching
        free = rotor.m * ramp(-self.efforts.low, eps) <= rotor.rated
        corners = [
            m * (FULL - F) + F * pitching
            for m in (rotor.m if free else ZERO, rotor.m)
            for F in (ramp_slope(self.efforts.low, eps), ramp_slope(self.efforts.high, eps))
            for pitching in (s.low, s.high)
        ]
        return NumberRange.of(*corners)


def _sign(f: NumberRange) -> int:
    return 1 if f.low > 0 else -1 if f.high < 0 else 0


def middle(span: NumberRange) -> NumberRange:
    return NumberRange((span.low + span.high) / 2, (span.low + span.high) / 2)
