r"""``wind-rate``: the schedule wind keeps the rate and error of a loop claim while the wind moves.

The law's filter is v_s' = (w - v_s) / T, with w the wind estimate and |w'| <= r(w).  phi and r are
piecewise linear between the nodes of a range.  y = w - v_s never crosses the curves
y = +- T phi(v_s) if y moves inward on them.  There v_s' = +- phi, so that y' = w' -+ phi, while the
curve moves at T phi' phi on both sides.  The conditions, with s = v_s, are

    at +    r(s + T phi) - phi <= T phi' phi
    at -    phi - r(s - T phi) >= T phi' phi

wherever the estimate s +- T phi lies in the range.  Both sides are affine in s between the winds
collected in ``_turned_back``, so that these winds suffice.  Derived in docs/effort-sharing-loop.md,
Wind rate.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from flint import fmpq

from takagi.certificates.cross_check.kernel.obligation import Fact, Obligations
from takagi.certificates.cross_check.kernel.reading import (
    Refusal,
    entry,
    rational,
    rationals,
    whole,
)

ZERO = fmpq(0)


@dataclass(frozen=True)
class Lines:
    """A function that is piecewise linear between its nodes, and constant outside them."""

    x: list[fmpq]
    y: list[fmpq]

    def __call__(self, at: fmpq) -> fmpq:
        if at <= self.x[0]:
            return self.y[0]
        for (a, b), (p, q) in zip(pairwise(self.x), pairwise(self.y), strict=True):
            if at <= b:
                return (p * (b - at) + q * (at - a)) / (b - a)
        return self.y[-1]


def loop_rested_on(claim: Any, document: Any) -> tuple[Any, int]:
    """Return the loop claim on which a claim depends, and its place among all claims."""
    return rested_on(claim, document, "loop", "coherent-loop")


def rested_on(claim: Any, document: Any, name: str, kind: str) -> tuple[Any, int]:
    """Return the earlier claim of this kind whose place is ``claim[name]``, and the place."""
    place, claims = whole(claim, name), entry(document, "claims")
    if place < 0 or place >= len(claims) or entry(claims[place], "kind") != kind:
        raise Refusal(f"{name}: the place of a claim of kind {kind} is needed")
    if claims[place] is claim or not any(other is claim for other in claims[place:]):
        raise Refusal(f"{name}: the claim rested on must come first")
    return claims[place], place


def turns(claim: Any, lag: fmpq, low: fmpq, high: fmpq) -> fmpq:
    """Return a bound of |v_s''| <= (|w'| + |v_s'|) / lag for v_s from low to high."""
    found = [ZERO]
    for stated in entry(claim, "ranges"):
        x = rationals(stated, "wind")
        a, b = max(low, x[0]), min(high, x[-1])
        if a > b:
            continue
        phi, r = (
            Lines(x, rationals(stated, f"{of}_rate", len(x))) for of in ("schedule", "estimate")
        )
        own = _top(phi, a, b)
        found.append((own + _top(r, a - lag * own, b + lag * own)) / lag)
    return max(found)


def _top(lines: Lines, a: fmpq, b: fmpq) -> fmpq:
    return max(lines(s) for s in (a, b, *(s for s in lines.x if a < s < b)))


def wind_rate(claim: Any, document: Any) -> Obligations:
    """Yield the inequalities of the module's text, range by range."""
    loop, _ = loop_rested_on(claim, document)
    gains = entry(document, "gains")
    lag, law = rational(gains, "wind_filter"), rationals(gains, "wind")
    yield Fact("the law has a wind filter", lag > 0)
    ranges = entry(claim, "ranges")
    if not isinstance(ranges, list) or not ranges:
        raise Refusal("ranges: one or more are needed")
    for number, stated in enumerate(ranges, start=1):
        label = f"range {number}"
        x = rationals(stated, "wind")
        if len(x) < 2 or any(a >= b for a, b in pairwise(x)):
            raise Refusal(f"{label}: winds that increase are needed")
        r = Lines(x, rationals(stated, "estimate_rate", len(x)))
        phi = Lines(x, rationals(stated, "schedule_rate", len(x)))
        off = rational(stated, "estimate_error")
        if min(off, *r.y, *phi.y) < 0:
            raise Refusal(f"{label}: nothing may be negative")
        yield Fact(f"{label} lies in the law's winds", law[0] <= x[0] and x[-1] <= law[-1])
        yield from _in_class(phi, off, lag, entry(loop, "cells"), label)
        yield from _turned_back(phi, r, lag, label)


def _in_class(phi: Lines, off: fmpq, lag: fmpq, cells: Any, label: str) -> Obligations:
    """Yield that rate and error of the schedule wind are at most those of each cell of the loop."""
    for k, cell in enumerate(cells):
        low, high = rationals(cell, "wind", 2)
        first, last = max(low, phi.x[0]), min(high, phi.x[-1])
        if first > last or high == phi.x[0]:
            continue
        most = max(phi(s) for s in (first, last, *(s for s in phi.x if first < s < last)))
        yield Fact(f"{label}: rate in cell {k + 1}", most <= rational(cell, "wind_rate"))
        yield Fact(
            f"{label}: error in cell {k + 1}", off + lag * most <= rational(cell, "wind_error")
        )


def _turned_back(phi: Lines, r: Lines, lag: fmpq, label: str) -> Obligations:
    for i, (a, b) in enumerate(pairwise(phi.x)):
        steep = (phi.y[i + 1] - phi.y[i]) / (b - a)
        for side in (lag, -lag):
            # The estimate on the curve, w = s + side phi(s), is a line in s: w = p + q s.
            q = 1 + side * steep
            p = side * (phi.y[i] - steep * a)
            bends = [a, b] if q == 0 else [a, b, *((w - p) / q for w in r.x)]
            inside = [s for s in bends if a <= s <= b and r.x[0] <= p + q * s <= r.x[-1]]
            slack = min((phi(s) * q - r(p + q * s) for s in inside), default=ZERO)
            yield Fact(f"{label}: piece {i + 1} turns back", slack >= 0)
