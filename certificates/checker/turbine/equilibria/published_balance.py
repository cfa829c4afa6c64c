r"""Enclosures of possible equilibria of a loop with a published law; see ``published``."""

from __future__ import annotations

from fractions import Fraction

from takagi.certificates.checker.arithmetic.dual import Dual
from takagi.certificates.checker.arithmetic.interval import (
    UNIT,
    ZERO,
    Interval,
    enclose,
    hull,
    point,
)
from takagi.certificates.checker.turbine.effort_sharing.inputs import Plant
from takagi.certificates.checker.turbine.equilibria.zero_count import Span
from takagi.certificates.checker.turbine.published.inputs import PublishedLaw, Region
from takagi.certificates.checker.turbine.published.loop import Ends, Loop, blended

# The table's ends are rounded in fixed point, so the range stays slightly inside.
EDGE = Fraction(1, 10**20)


class RestPlace(Loop):
    """The loop's pieces over a rectangle: speed and pitch with slopes along any directions."""

    def __init__(
        self,
        rests: PublishedBalance,
        winds: Span,
        speeds: tuple[Fraction, Fraction, Fraction],
        speed: Dual,
        pitch: Dual,
        wind: Dual,
    ) -> None:
        first, last, width = speeds
        self.plant, self.law, self.overlaps = rests.plant, rests.law, rests.law.overlaps
        self.ends = Ends(winds, ([first], [last]), [width])
        self.wind, self.speed, self.pitch, self.sharp = wind, speed, pitch, True

    def _ratio(self, region: Region | None, of_state: bool, of_trim: bool) -> Interval:
        """Return the range of tip-speed ratios; the state's end where the table does.

        For the wind itself, or a larger one, the ratio is at most that of the state. A trim beyond
        the table is not cut, because the table does not define a premise there.
        """
        parts = []
        if of_trim and region is not None:
            parts.append(super()._ratio(region, False, True))
        if of_state:
            low, high = super()._ratio(region, True, False)
            if region is None or self.ends.wind[1] <= region.wind[-1]:
                high = min(high, point(self.plant.surface.x.breaks[-1] - EDGE)[1])
            parts.append(Interval(low, high))
        return hull(*parts)

    def gain(self, full: bool, kind: int) -> Dual:
        """Return a gain of full or partial load: kind 0 speed, 1 pitch, 2 integral."""
        if full:
            return blended(self.law.full, kind, self.full_weights)
        return blended(self.law.partial, kind, self.partial_weights)

    def passed(self, u: Dual) -> Dual:
        """Return max(phi(u), 0) n_g / J."""
        self.__dict__["torque_command"] = u
        torque, _ = self._torque(None)
        return torque.by(point(self.plant.gear_per_inertia))


class PublishedBalance:
    """Common parts of the balances of both laws: table ends, reference speed, coupling factor."""

    def __init__(self, plant: Plant, law: PublishedLaw) -> None:
        self.plant, self.law = plant, law
        self.top = min(law.pitch_max, plant.surface.y.breaks[-1] - EDGE)
        self.longest = plant.surface.x.breaks[-1] - EDGE
        self.shortest = plant.surface.x.breaks[0] + EDGE
        self.passing = law.rated_torque - law.overlaps.torque / 2

    def place(self, winds: Span, pitch: Dual) -> RestPlace:
        """Return the place at the reference speed with a pitch."""
        first, last = (self.reference(v) for v in winds)
        wind = Dual(enclose(*winds), (UNIT, ZERO))
        return RestPlace(self, winds, (first, last, Fraction(0)), self.speed(winds), pitch, wind)

    def reference(self, wind: Fraction) -> Fraction:
        """Return omega_ref."""
        law, radius = self.law, self.plant.radius
        floor = min(law.minimum_speed, law.largest_ratio * wind / radius)
        return min(max(law.optimal_ratio * wind / radius, floor), law.setpoint)

    def share(self, speed: Fraction) -> Fraction:
        """Return f_1."""
        over = self.law.overlaps
        s = min(max((speed - over.start) / over.width, Fraction(0)), Fraction(1))
        return s * s * (3 - 2 * s) if self.law.smooth else s

    def reference_range(self, winds: Span) -> Span:
        """Return the range of omega_ref over winds in which it is linear."""
        ends = [self.reference(v) for v in winds]
        return min(ends), max(ends)

    def speed(self, winds: Span) -> Dual:
        """Return omega_ref, with its slope unless the wind is a single point."""
        ends, width = [self.reference(v) for v in winds], winds[1] - winds[0]
        pace = point((ends[1] - ends[0]) / width) if width else ZERO
        return Dual(enclose(min(ends), max(ends)), (pace, ZERO))

    def share_of(self, speed: Dual, span: Span) -> Dual:
        """Return f_1 with its slopes, for speeds in a span."""
        over, (low, high) = self.law.overlaps, span
        value = enclose(self.share(low), self.share(high))
        a, b = ((w - over.start) / over.width for w in (low, high))
        if b <= 0 or a >= 1:
            return speed.through(value, ZERO)
        if not self.law.smooth:
            least = Fraction(int(a >= 0 and b <= 1))
            return speed.through(value, enclose(least / over.width, 1 / over.width))
        steep = [6 * s * (1 - s) for s in (max(a, Fraction(0)), min(b, Fraction(1)))]
        most = Fraction(3, 2) if 2 * a < 1 < 2 * b else max(steep)
        return speed.through(value, enclose(min(steep) / over.width, most / over.width))
