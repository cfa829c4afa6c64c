r"""The equilibria of the loop with law ``paper``, along one curve; see ``published``."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.arithmetic.dual import Dual, greater, still
from takagi.certificates.checker.arithmetic.interval import (
    ONE,
    UNIT,
    ZERO,
    Interval,
    enclose,
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
# The curve is followed in s up to this multiple of the s of rated torque, then in pitch.
LONGEST = 4096
LOOKS = 14
# How often a range of s is halved to compare u on the whole range.
HALVINGS = 7


class OneIntegrator(PublishedBalance):
    """f(s) = T_r/J - n_g phi(u)/J along the curve."""

    def count(self, winds: Span) -> Count:
        """Return the number of equilibria, all of them with e = 0."""
        zero, shares = Fraction(0), [self.share(self.reference(v)) for v in winds]
        saturated = self._saturated(winds)
        last, open_end = saturated, max(shares) > 0
        if min(shares) > 0 and self.top / min(shares) <= LONGEST * saturated:
            last, open_end = max(saturated, self.top / min(shares)), False
        elif open_end:
            last = 4 * saturated
        found = count_zeros(self._excess, winds, [Piece((zero, last))], most_parts=MOST_PARTS)
        if found.start != 1:
            raise Refused("no torque balances the rotor's")
        if open_end:
            rest = [Piece((max(self.law.pitch_min, last * min(shares)), self.top))]
            if count_zeros(self._held, winds, rest, most_parts=MOST_PARTS).exact != 0:
                raise Refused("a rest far beyond rated torque cannot be excluded")
        elif max(shares) == 0 and not found.end:
            raise Refused("a rotor torque near rated torque")
        return found

    def at_trim(self, winds: Span) -> bool | None:
        """Return whether the equilibrium has rated torque or smallest pitch; None if unknown."""
        shares = [self.share(self.reference(v)) for v in winds]
        if max(shares) == 0:
            return True
        # From here on pitch leaves its smallest angle, which partial load would keep.
        leaves = self.law.pitch_min / min(shares) if min(shares) else None
        if leaves is None or sign_over(self._excess, winds, (leaves, leaves)) != 1:
            return None
        corner = self.law.rated_torque + self.law.overlaps.torque / 2
        saturated = self._saturated(winds)
        low, high = leaves, min(saturated, self.top / max(shares))
        for _ in range(LOOKS):
            s = (low + high) / 2
            sign = sign_over(self._excess, winds, (s, s))
            # u need not rise with s, as gains depend on pitch: compare wherever the equilibrium may
            # be.
            if sign == -1 and self._keeps(winds, (leaves, s), -1, corner):
                return False
            if sign == 1 and self._keeps(winds, (s, saturated), 1, corner):
                return True
            low, high = (low, s) if sign == -1 else (s, high)
        return None

    def _keeps(
        self, winds: Span, span: Span, side: int, corner: Fraction, left: int = HALVINGS
    ) -> bool:
        """Return whether u < corner (side -1) or u >= corner (side 1) on the whole span."""
        curve, at = self._curve(winds, span), point(corner)
        if curve is None:
            return True
        low, high = curve[1].value
        if (high < at[0]) if side < 0 else (low >= at[1]):
            return True
        if left == 0 or ((low >= at[1]) if side < 0 else (high < at[0])):
            return False
        middle = (span[0] + span[1]) / 2
        halves = ((middle, span[1]), (span[0], middle))
        return all(self._keeps(winds, half, side, corner, left - 1) for half in halves)

    def _excess(self, winds: Span, span: Span) -> Dual | None:
        """Return f over a range of s; values alone where pitch may leave the table."""
        curve = self._curve(winds, span)
        if curve is None:
            return None
        at, command, whole = curve
        excess = at.rotor - at.passed(command)
        return excess if whole else Dual(excess.value, ())

    def _curve(self, winds: Span, span: Span) -> tuple[RestPlace, Dual, bool] | None:
        """Return the place on the curve, u, and whether all of it lies inside the table."""
        parameter = Dual(enclose(*span), (ZERO, UNIT))
        share = self.share_of(self.speed(winds), self.reference_range(winds))
        pitch = greater(share * parameter, still(point(self.law.pitch_min), share))
        held = self._in_table(pitch)
        if held is None:
            return None
        at = self.place(winds, held)
        return at, parameter * self._factor(at, share), held is pitch

    def _factor(self, at: RestPlace, share: Dual) -> Dual:
        """Return u/s = (1 + f_1 k_p) k_I^b / k_I^c; refuses one that is not certainly positive."""
        factor = (share * at.gain(True, 1)).plus(UNIT)
        ratio = at.gain(False, 2) / at.gain(True, 2)
        if min(factor.value[0], ratio.value[0]) <= 0:
            raise Refused("gains whose signs are not known")
        return factor * ratio

    def _saturated(self, winds: Span) -> Fraction:
        """Return an s from which on u exceeds the torque's rounded corner, at any pitch."""
        at = self.place(winds, Dual(enclose(self.law.pitch_min, self.top), (ZERO, ZERO)))
        share = self.share_of(self.speed(winds), self.reference_range(winds))
        corner = self.law.rated_torque + self.law.overlaps.torque / 2
        least = self._factor(at, share).value[0]
        return (corner * ONE / least).limit_denominator(10**6) + 1

    def _held(self, winds: Span, span: Span) -> Dual | None:
        """Return the balance at rated torque, s = beta."""
        at = self.place(winds, Dual(enclose(*span), (ZERO, UNIT)))
        return at.rotor.plus(point(-self.law.rated_torque * self.plant.gear_per_inertia))

    def _in_table(self, pitch: Dual) -> Dual | None:
        """Return the pitch, or the part of it inside the table without slopes; None outside."""
        limit = point(self.top)[0]
        if pitch.value[0] > limit:
            return None
        if pitch.value[1] <= limit:
            return pitch
        return Dual(Interval(pitch.value.low, limit), (ZERO, ZERO))
