r"""``wind-rate``: the wind rates at which the law's filter keeps the loop's wind class.

The law's schedule wind v_s is its own low-pass of the wind estimate w, v_s' = (w - v_s) / tau_f.
On a range of winds let phi (``schedule_rate``) and r (``estimate_rate``) be lines between nodes,
and eta (``estimate_error``) a number.  Checked, in rationals, are

    phi <= wind_rate,  eta + tau_f phi <= wind_error       in every wind cell that the range meets,
    r(s + tau_f phi(s)) <= phi(s) (1 + tau_f phi'(s)),
    r(s - tau_f phi(s)) <= phi(s) (1 - tau_f phi'(s))      on every piece of phi, where
                                                           s +- tau_f phi(s) is in the range.

Then, with v, w and v_s(0) in the range, |w'| <= r(w), |v - w| <= eta, and at the start
|w - v_s| <= tau_f phi(v_s), one has |v_s'| <= phi(v_s) and |v - v_s| <= eta + tau_f phi(v_s) for
all times: the wind class of the claim of kind ``coherent-loop`` that ``loop`` names.  Both sides of
each inequality are lines between finitely many winds, and are compared there.

Proof.  v_s is a weighted mean of v_s(0) and past values of w, so it stays in the range.  Let
y = w - v_s, so v_s' = y / tau_f, and h = y - tau_f phi(v_s).  phi is Lipschitz; where v_s passes a
node of phi at a point of a set of positive measure, v_s' = 0 = y almost everywhere there and
h <= 0.  Elsewhere h' = w' - (1 + tau_f phi'(v_s)) y / tau_f.  Suppose h > 0 on (t_0, t_1] and
h(t_0) = 0.  There v_s + tau_f phi(v_s) < w, which is in the range, and with L the Lipschitz
constant of r

    w' <= r(w) <= r(v_s + tau_f phi) + L h <= phi (1 + tau_f phi') + L h ,
    y / tau_f = phi + h / tau_f ,

so h' <= (L + |1 + tau_f phi'| / tau_f) h: by Gronwall h = 0, a contradiction.  The lower side is
the same with a minus.  Hence |y| <= tau_f phi(v_s), and |v - v_s| <= |v - w| + |y|.

The second and third inequality are also necessary: at an s where one fails, y = +- tau_f phi(s) and
|w'| = r violate |y| <= tau_f phi at once.  The law's limits of w do no harm: for a wind within the
tables the limited estimate is no further from it, and no faster.

Not promised: that an observer keeps |v - w| <= eta; a law that is sampled.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain, pairwise
from typing import Any, ClassVar, Self

from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.obligation import (
    Obligations,
    never,
    nonnegative,
    positive,
)
from takagi.certificates.checker.kernel.reader import increasing, listed, member, number, numbers
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.effort_sharing.loop_claim import IN_WIND_CLASS
from takagi.certificates.checker.turbine.members import Members, plain
from takagi.certificates.checker.turbine.turbine_claim import TurbineClaim, prerequisite_claim
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rates import range_sentence
from takagi.certificates.checker.words.rounded import at_least, at_most, range_within

MOST_RANGES, MOST_NODES = 20, 5000


@dataclass(frozen=True)
class Range:
    """The wind range of the estimate, and both rates at its nodes."""

    wind: list[Fraction]
    estimate: list[Fraction]
    schedule: list[Fraction]
    error: Fraction

    @classmethod
    def read(cls, stated: Any, where: str) -> Range:
        """Return a range; refuses winds that do not increase and anything negative."""
        wind = numbers(stated, "wind", where)
        increasing(wind, f"{where}.wind")
        if not 2 <= len(wind) <= MOST_NODES:
            raise CertificateError(f"{where}.wind: 2 to {MOST_NODES} winds are needed")
        names, error = ("estimate_rate", "schedule_rate"), number(stated, "estimate_error", where)
        estimate, schedule = (numbers(stated, name, where, len(wind)) for name in names)
        if min(error, *estimate, *schedule) < 0:
            raise CertificateError(f"{where}: rates and error must not be negative")
        return cls(wind, estimate, schedule, error)

    @property
    def words(self) -> str:
        """The winds, not wider than they are."""
        return f"{range_within(self.wind[0], self.wind[-1])} m/s"

    def at(self, column: list[Fraction], wind: Fraction) -> Fraction:
        """Return a column, linear between the nodes and constant beyond them."""
        if wind <= self.wind[0]:
            return column[0]
        if wind >= self.wind[-1]:
            return column[-1]
        i = bisect_right(self.wind, wind) - 1
        share = (wind - self.wind[i]) / (self.wind[i + 1] - self.wind[i])
        return column[i] + (column[i + 1] - column[i]) * share


def read_ranges(claim: Any, where: str) -> list[Range]:
    """Return the ranges of a claim ``wind-rate``."""
    stated = listed(claim, "ranges", where, 1, MOST_RANGES)
    return [Range.read(one, f"{where}.ranges[{i}]") for i, one in enumerate(stated)]


@dataclass(frozen=True)
class WindRate(TurbineClaim):
    """The law's filter keeps the wind class of the claim ``loop``; see the module."""

    loop: Any
    unproved: str
    law: Law
    wind_filter: Fraction
    ranges: list[Range]

    assumes: ClassVar[tuple[str, ...]] = (
        *IN_WIND_CLASS,
        "start of the wind filter at its estimate",
    )
    members: ClassVar[dict[str, Members | None]] = {
        "loop": {},
        "ranges": plain("wind estimate_rate schedule_rate estimate_error"),
    }

    @classmethod
    def read(cls, claim: Any, data: Any, earlier: Sequence[Outcome], where: str) -> Self:
        """Return the claim; ``earlier`` are the verdicts on the claims before it.

        Raises
        ------
        CertificateError : a part is missing or is not what it has to be.
        """
        loop, unproved = prerequisite_claim(claim, data, earlier, where, "loop", "coherent-loop")
        gains = member(data, "gains", "certificate")
        law, wind_filter = Law.read(gains), number(gains, "wind_filter", "gains")
        ranges = read_ranges(claim, where)
        name = f"wind rate, {ranges[0].words}"
        return cls(claim, data, where, name, loop, unproved, law, wind_filter, ranges)

    def premises(self) -> Obligations:
        if self.unproved:
            yield never(self.unproved)
        yield positive(self.wind_filter, "the law has no wind filter: no rate is bounded")

    def parts(self) -> Iterator[tuple[str, Obligations]]:
        for one in self.ranges:
            required = chain(self._in_class(one), filter_keeps_up(one, self.wind_filter))
            yield f"{one.words}: ", required

    def _in_class(self, one: Range) -> Obligations:
        """Yield that phi stays in the loop's wind class."""
        law, outside = self.law, "the range leaves the winds of the law"
        yield nonnegative(one.wind[0] - law.wind[0], outside)
        yield nonnegative(law.wind[-1] - one.wind[-1], outside)
        # The claim about the loop is proved, so it has one cell per interval of the law.
        for (low, high), cell in zip(pairwise(law.wind), self.loop["cells"], strict=True):
            if high <= one.wind[0]:  # The cell's upper end belongs to the next one.
                continue
            error, rate = (number(cell, f"wind_{name}", "cell") for name in ("error", "rate"))
            inside = [s for s in one.wind if low < s < high]
            ends = [s for s in (low, high) if one.wind[0] <= s <= one.wind[-1]]
            for s in (*inside, *ends):
                phi = one.at(one.schedule, s)
                allowed = f"than the loop's claim allows at {at_least(s, 6)}"
                yield nonnegative(rate - phi, f"the schedule wind may move faster {allowed}")
                lag = one.error + self.wind_filter * phi
                yield nonnegative(error - lag, f"the schedule wind may lag further {allowed}")

    def figures(self) -> Iterator[Figure | WindProfile]:
        for k, one in enumerate(self.ranges, start=1):
            slowest = map(min, one.estimate, one.estimate[1:])
            spans = zip(one.wind, one.wind[1:], slowest, strict=False)
            yield WindProfile(f"rate of the wind, range {k}", "m/s^2", tuple(spans))
            yield Figure(f"error of the estimate, range {k}", "m/s", one.error)

    def sentence(self) -> str:
        where = self.where
        peaks = member(self.loop, "peaks", where)
        peak = number(peaks, "speed_error", f"{where}.peaks")
        rated = number(member(self.data, "model", "certificate"), "rated_rotor_speed", "model")
        overspeed = 100 * ((max(self.law.speed) + peak) / rated - 1)
        listed_ranges = "; ".join(
            range_sentence(one.wind, one.estimate, one.error) for one in self.ranges
        )
        return (
            f"with the law's wind filter of {at_most(self.wind_filter, 6)} s, from any start with "
            "V <= 1 and the filter at its estimate, the loop stays in its proved "
            "wind limits, under "
            "what the claim of that assumes, so that V <= 1 and overspeed at most "
            f"{at_most(overspeed, 3)} %, for every wind whose estimate moves no faster than the "
            f"claim's rate: {listed_ranges}"
        )


def filter_keeps_up(one: Range, wind_filter: Fraction) -> Obligations:
    """Yield that the filter does not exceed phi while the estimate keeps to r."""
    for i, (low, high) in enumerate(pairwise(one.wind)):
        slope = (one.schedule[i + 1] - one.schedule[i]) / (high - low)
        for sign, way in ((1, "rising"), (-1, "falling")):
            ahead = 1 + sign * wind_filter * slope
            for s in _bends(one, i, sign * wind_filter):
                phi = one.schedule[i] + slope * (s - low)
                seen = s + sign * wind_filter * phi
                # The estimate stays in the range, so its end limits how far it can be ahead.
                if one.wind[0] <= seen <= one.wind[-1]:
                    spare = phi * ahead - one.at(one.estimate, seen)
                    failure = f"the rates do not fit at {at_least(s, 6)} m/s with wind {way}"
                    yield nonnegative(spare, failure)


def _bends(one: Range, i: int, ahead: Fraction) -> Iterator[Fraction]:
    """Yield the winds s between which r(s + ahead phi(s)) is a line, on piece i of phi."""
    low, high = one.wind[i : i + 2]
    first, last = low + ahead * one.schedule[i], high + ahead * one.schedule[i + 1]
    yield from (low, high)
    least, most = sorted((first, last))
    for node in one.wind[bisect_right(one.wind, least) : bisect_left(one.wind, most)]:
        yield low + (high - low) * (node - first) / (last - first)
