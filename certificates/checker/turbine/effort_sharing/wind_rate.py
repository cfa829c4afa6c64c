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
all times: the wind class of the claim of kind ``coherent-loop`` that ``loop`` names.  Derived in
docs/effort-sharing-loop.md, Wind rate.  Both sides of each inequality are lines between finitely
many winds, and are compared there.

Not promised: that an observer keeps |v - w| <= eta; a law that is sampled.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any

from takagi.certificates.checker.kernel.reader import increasing, listed, member, number, numbers
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Found, Outcome, Verdict
from takagi.certificates.checker.turbine.effort_sharing.inputs import Law
from takagi.certificates.checker.turbine.effort_sharing.prerequisite import prerequisite_claim

MOST_RANGES, MOST_NODES = 20, 5000
# The property that is not proved, with {} for its wind.
Place = tuple[str, Fraction | None]


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

    def at(self, column: list[Fraction], wind: Fraction) -> Fraction:
        """Return a column, linear between the nodes and constant beyond them."""
        if wind <= self.wind[0]:
            return column[0]
        if wind >= self.wind[-1]:
            return column[-1]
        i = bisect_right(self.wind, wind) - 1
        share = (wind - self.wind[i]) / (self.wind[i + 1] - self.wind[i])
        return column[i] + (column[i + 1] - column[i]) * share

    def largest(self, column: list[Fraction], low: Fraction, high: Fraction) -> Fraction:
        """Return a column's largest value from low to high: at an end, or at a node between."""
        inside = [value for s, value in zip(self.wind, column, strict=True) if low < s < high]
        return max(self.at(column, low), self.at(column, high), *inside)

    def bend(self, low: Fraction, high: Fraction, wind_filter: Fraction) -> Fraction:
        """Return a bound of |v_s''| = |w' - v_s'| / tau_f [m/s^3] while v_s is from low to high.

        (max phi + max r) / tau_f, r over the estimates that are then within tau_f phi of v_s; 0
        where the range has no such winds.
        """
        low, high = max(low, self.wind[0]), min(high, self.wind[-1])
        if low > high:
            return Fraction(0)
        fastest = self.largest(self.schedule, low, high)
        ahead = wind_filter * fastest
        return (fastest + self.largest(self.estimate, low - ahead, high + ahead)) / wind_filter


def read_ranges(claim: Any, where: str) -> list[Range]:
    """Return the ranges of a claim ``wind-rate``."""
    stated = listed(claim, "ranges", where, 1, MOST_RANGES)
    return [Range.read(one, f"{where}.ranges[{i}]") for i, one in enumerate(stated)]


def check_wind_rate(claim: Any, data: Any, found: list[Outcome], where: str) -> Found:
    """Return the verdict on one claim; ``found`` are the verdicts on the claims before it.

    Raises
    ------
    CertificateError : a part is missing or is not what it has to be.
    """
    loop, unproved = prerequisite_claim(claim, data, found, where, "loop", "coherent-loop")
    gains = member(data, "gains", "certificate")
    law, filter_ = Law.read(gains), number(gains, "wind_filter", "gains")
    ranges = read_ranges(claim, where)
    said = {"ranges": ranges, "wind_filter": filter_}
    if unproved or filter_ <= 0:
        return Found(Verdict.UNDECIDED, "wind_rate", said | {"unproved": unproved})
    failures = []
    for one in ranges:
        if reason := _outside_class(one, law, loop["cells"], filter_) or left_behind(one, filter_):
            failures.append((one, *reason))
    if failures:
        return Found(Verdict.UNDECIDED, "wind_rate", said | {"failures": failures})
    proved = {"loop": loop, "data": data, "law": law, "where": where}
    return Found(Verdict.PROVED, "wind_rate", said | proved)


def _outside_class(one: Range, law: Law, cells: list[Any], filter_: Fraction) -> Place | None:
    """Return where phi leaves the loop's wind class, or nothing."""
    if not law.wind[0] <= one.wind[0] < one.wind[-1] <= law.wind[-1]:
        return "the range leaves the winds of the law", None
    # The claim about the loop is proved, so it has one cell per interval of the law.
    for (low, high), cell in zip(pairwise(law.wind), cells, strict=True):
        if high <= one.wind[0]:  # The cell's upper end belongs to the next one.
            continue
        error, rate = (number(cell, f"wind_{name}", "cell") for name in ("error", "rate"))
        inside = [s for s in one.wind if low < s < high]
        ends = [s for s in (low, high) if one.wind[0] <= s <= one.wind[-1]]
        for s in (*inside, *ends):
            phi = one.at(one.schedule, s)
            if phi > rate:
                return "the schedule wind may move faster than the loop's claim allows at {}", s
            if one.error + filter_ * phi > error:
                return "the schedule wind may lag further than the loop's claim allows at {}", s
    return None


def left_behind(one: Range, filter_: Fraction) -> Place | None:
    """Return where the filter may exceed phi although the estimate keeps to r, or nothing."""
    for i, (low, high) in enumerate(pairwise(one.wind)):
        slope = (one.schedule[i + 1] - one.schedule[i]) / (high - low)
        for sign in (1, -1):
            ahead = 1 + sign * filter_ * slope
            for s in _bends(one, i, sign * filter_):
                phi = one.schedule[i] + slope * (s - low)
                seen = s + sign * filter_ * phi
                # The estimate stays in the range, so its end limits how far it can be ahead.
                if one.wind[0] <= seen <= one.wind[-1] and one.at(one.estimate, seen) > phi * ahead:
                    way = "rising" if sign > 0 else "falling"
                    return f"the rates do not fit at {{}} m/s with wind {way}", s
    return None


def _bends(one: Range, i: int, ahead: Fraction) -> Iterator[Fraction]:
    """Yield the winds s between which r(s + ahead phi(s)) is a line, on piece i of phi."""
    low, high = one.wind[i : i + 2]
    first, last = low + ahead * one.schedule[i], high + ahead * one.schedule[i + 1]
    yield from (low, high)
    for node in one.wind:
        if min(first, last) < node < max(first, last):
            yield low + (high - low) * (node - first) / (last - first)
