r"""The equilibria of the loop with law ``paper-two-integrators``; see ``published``."""

from __future__ import annotations

from fractions import Fraction
from math import isqrt

from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.interval import (
    ONE,
    UNIT,
    ZERO,
    Interval,
    enclose,
    hull,
    point,
)
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.turbine.equilibria.published_balance import (
    PublishedBalance,
    RestPlace,
)
from takagi.certificates.checker.turbine.equilibria.zero_count import (
    Count,
    Piece,
    Span,
    count_zeros,
    sign_over,
)

MOST_PARTS = 48
PITCH_PIECES = 64
# At f_1 = 0 the slope is infinite; a huge number replaces it.
STEEP = Interval(0, ONE << 60)


class TwoIntegrators(PublishedBalance):
    """The torque balance as a function of torque at e = 0, then of the speed error e > 0."""

    def count(self, winds: Span) -> Count:
        """Return the number of equilibria; refuses if e < 0 or a fast rotor cannot be excluded."""
        radius, zero = self.plant.radius, Fraction(0)
        speeds = [self.reference(v) for v in winds]
        ratios = [radius * w / v for w, v in zip(speeds, winds, strict=True)]
        slow = [Piece((self.shortest, max(ratios)))]
        if count_zeros(self._still, winds, slow, most_parts=MOST_PARTS).exact != 0:
            raise Refused("a rest below the reference speed cannot be excluded")
        over = self.law.overlaps
        room = min(self.longest * v / radius - w for v, w in zip(winds, speeds, strict=True))
        # Chosen so that f_1 = 1 beyond it, at each of the winds.
        full = (over.start + over.width) * winds[1] / winds[0] - min(speeds)
        last = min(full, room * Fraction(999, 1000))
        if last <= 0:
            raise Refused("a reference speed beyond the coefficient table")
        curve = [Piece((-self.passing, zero)), Piece((zero, last))]
        found = count_zeros(self._joined, winds, curve, most_parts=MOST_PARTS)
        if found.start != 1:
            raise Refused("no torque balances the rotor's")
        beyond = min((w + last) * radius / v for w, v in zip(speeds, winds, strict=True))
        fast = [Piece((beyond, self.longest))]
        if count_zeros(self._fast, winds, fast, most_parts=MOST_PARTS).exact != 0:
            raise Refused("a rest at a fast rotor cannot be excluded")
        return found

    def passes(self, winds: Span) -> int:
        """Return the sign of the balance at e = 0 with the largest torque that passes unchanged."""
        return sign_over(self._joined, winds, (Fraction(0), Fraction(0)))

    def continuum(self, winds: Span) -> Span | None:
        """Return an interval of pitch at rest with e = 0, f_1 = 1, for all the winds."""
        limit = self.passing * self.plant.gear_per_inertia
        step = (self.top - self.law.pitch_min) / PITCH_PIECES
        for k in range(PITCH_PIECES):
            span = self.law.pitch_min + k * step, self.law.pitch_min + (k + 1) * step

            def less(v: Span, s: Span) -> Dual:
                return self._rotor(v, s).plus(point(-limit))

            if sign_over(self._rotor, winds, span) == 1 and sign_over(less, winds, span) == -1:
                return span
        return None

    def _rotor(self, winds: Span, span: Span) -> Dual:
        return self.place(winds, Dual(enclose(*span), (ZERO, UNIT))).rotor

    def _still(self, winds: Span, ratio: Span) -> Dual:
        """Return c_Q at smallest pitch, s = lambda."""
        bounds, pitch = self.plant.surface.bounds, point(self.law.pitch_min)
        at = enclose(*ratio)
        return Dual(bounds(at, pitch), (ZERO, bounds(at, pitch, 1, 0)))

    def _joined(self, winds: Span, span: Span) -> Dual | None:
        if span[1] <= 0:
            rotor = self.place(winds, Dual(point(self.law.pitch_min), (ZERO, ZERO))).rotor
            torque = Dual(enclose(*span), (ZERO, UNIT)).plus(point(self.passing))
            return rotor - torque.by(point(self.plant.gear_per_inertia))
        ends = [self.reference(v) for v in winds]
        middle, half = (span[0] + span[1]) / 2, (span[1] - span[0]) / 2
        error = Dual(enclose(*span), (ZERO, UNIT))
        speed = self.speed(winds) + error
        speeds = (ends[0] + middle, ends[1] + middle, half)
        return self._overspeed(winds, speeds, speed, error, span)

    def _fast(self, winds: Span, ratio: Span) -> Dual | None:
        """Return the balance for e > 0, s = lambda; values alone."""
        radius = self.plant.radius
        corners = [[s * v / radius for s in ratio] for v in winds]
        middle = [(low + high) / 2 for low, high in corners]
        half = max((high - low) / 2 for low, high in corners)
        low, high = min(map(min, corners)), max(map(max, corners))
        refs = [self.reference(v) for v in winds]
        span = max(low - max(refs), Fraction(0)), high - min(refs)
        speed, error = Dual(enclose(low, high), (ZERO,) * 2), Dual(enclose(*span), (ZERO,) * 2)
        found = self._overspeed(winds, (middle[0], middle[1], half), speed, error, span)
        return None if found is None else Dual(found.value, ())

    def _overspeed(
        self,
        winds: Span,
        speeds: tuple[Fraction, Fraction, Fraction],
        speed: Dual,
        error: Dual,
        span: Span,
    ) -> Dual | None:
        low = min(speeds[0], speeds[1]) - speeds[2]
        high = max(speeds[0], speeds[1]) + speeds[2]
        pitch = self._carried_pitch(winds, speeds, speed, error, (low, high))
        if pitch is None:
            return None
        wind = Dual(enclose(*winds), (UNIT, ZERO))
        sloped = pitch if pitch.slopes else Dual(pitch.value, (ZERO, ZERO))
        # Tip-speed ratios beyond the table have no defined balance.
        at = RestPlace(self, winds, speeds, speed, sloped, wind)
        gain = -at.gain(False, 2)
        pace = point(self.law.tracking_time or Fraction(0))
        torque = self._carried_torque((gain * error).by(pace))
        excess = at.rotor - torque.by(point(self.plant.gear_per_inertia))
        return excess if pitch.slopes else Dual(excess.value, ())

    def _carried_torque(self, left: Dual) -> Dual:
        """Return T_rated - h (1 - sqrt(min(d, h)/h))^2; its slope is unbounded at d = 0."""
        h = self.law.overlaps.torque / 2
        low, high = (min(max(Fraction(x, ONE) / h, Fraction(0)), Fraction(1)) for x in left.value)
        a, b = _root_below(low), _root_above(high)
        value = enclose(
            self.law.rated_torque - h * (1 - a) ** 2, self.law.rated_torque - h * (1 - b) ** 2
        )
        steepest = STEEP[1] if a == 0 else point((1 - a) / a)[1]
        return left.through(value, Interval(point((1 - b) / b).low if b else 0, steepest))

    def _carried_pitch(
        self,
        winds: Span,
        speeds: tuple[Fraction, Fraction, Fraction],
        speed: Dual,
        error: Dual,
        ends: Span,
    ) -> Dual | None:
        """Return beta = f_1/(1 - f_1) tau |k_I^c(beta)| e; its slopes where f_1 < 1."""
        low, high = (self.share(w) for w in ends)
        law, bottom = self.law, point(self.law.pitch_min)
        if high == 0:
            return Dual(bottom, (ZERO, ZERO))
        if low == 1:
            return Dual(point(law.pitch_max), (ZERO, ZERO)) if law.pitch_max <= self.top else None
        pace = point(law.tracking_time or Fraction(0))
        share = self.share_of(speed, ends)
        if high == 1:
            lever = Dual(Interval(point(low / (1 - low)).low, STEEP.high), (ZERO, ZERO))
        else:
            rest = enclose(1 - high, 1 - low)
            value = enclose(low / (1 - low), high / (1 - high))
            lever = share.through(value, UNIT / rest.square())
        size = (lever * error).by(pace)
        wind = Dual(enclose(*winds), (UNIT, ZERO, ZERO))
        moving = Dual(speed.value, (*speed.slopes, ZERO))
        gains = law.full.gains[2].values()
        held, wanted = self._held_to(enclose(-max(gains), -min(gains)), size.value)
        if held is None:
            return None
        pitch = Dual(held, (ZERO, ZERO, UNIT))
        gain = -RestPlace(self, winds, speeds, moving, pitch, wind).gain(True, 2)
        held, wanted = self._held_to(gain.value, size.value, held)
        if held is None:
            return None
        if high == 1:  # Near f_1 = 1 any pitch may be commanded, even for a small error.
            return Dual(Interval(held.low, point(self.top).high), ())
        steady = UNIT - size.value * gain.slopes[2]
        if wanted[1] > point(self.top)[0] or steady[0] <= 0:
            return Dual(held, ())
        slopes = tuple(
            (m * gain.value + size.value * g) / steady
            for m, g in zip(size.slopes, gain.slopes[:2], strict=True)
        )
        if wanted[0] <= bottom[1]:
            slopes = tuple(hull(ZERO, s) for s in slopes)
        return Dual(held, slopes)

    def _held_to(
        self, gain: Interval, size: Interval, known: Interval | None = None
    ) -> tuple[Interval | None, Interval]:
        """Return the pitch limited to its range, and the unlimited command size times gain."""
        wanted, bottom = size * gain, point(self.law.pitch_min)
        known = known or enclose(self.law.pitch_min, self.top)
        if wanted[0] > point(self.top)[1]:
            return None, wanted
        low = max(known[0], wanted[0])
        high = max(low, min(known.high, max(wanted.high, bottom.high)))
        return Interval(low, high), wanted


def _root_below(x: Fraction) -> Fraction:
    """Return a rational at or below the square root, within 10^-36."""
    return Fraction(isqrt(x.numerator * ONE * ONE // x.denominator), ONE)


def _root_above(x: Fraction) -> Fraction:
    found = _root_below(x)
    return found if found * found == x else found + Fraction(1, ONE)
