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

``actuator-rates``: bounds of the rates of pitch and torque while xi'P xi <= 1.

b beta' = T zeta + theta mu v_s' N     so  |beta'| <= zeta_max / (b tau) + theta rho |N / b|
U' = q*' v_s' + gamma' v_s' s + gamma s',   s = e - x,   s' = h xi + w_e,
     h = (a - G + nu, S, G),   |h xi| <= B  where  B^2 P - h'h > 0
T_g = T_rated - E (psi(-U) + held(f v_s', g))

|T_g'| <= E (F(-U) |U'| + |f| |v_s''|) inside a cell.  At a node of the law's winds f and g step,
and T_g steps with them.  If the claim names a claim on the wind's rate, that claim's rates bound
|v_s''| = |w' - v_s'| / tau_f.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise, product
from typing import Any

from flint import fmpq, fmpq_mat

from takagi.certificates.cross_check.kernel.exact import (
    Definite,
    Fact,
    Obligations,
    scaled,
    transposed,
)
from takagi.certificates.cross_check.kernel.reading import (
    Refusal,
    entry,
    rational,
    rationals,
    table,
    whole,
)
from takagi.certificates.cross_check.turbine.numbers import TurbineNumbers, WindCell, ramp_slope
from takagi.certificates.cross_check.turbine.ranges import asked_slope

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


def actuator_rates(claim: Any, document: Any) -> Obligations:
    """Yield the inequalities of the module's text, cell by cell."""
    loop, _ = loop_rested_on(claim, document)
    turbine = TurbineNumbers(loop, entry(document, "model"), entry(document, "gains"))
    P, peaks = table(loop, "P", (3, 3)), entry(loop, "peaks")
    stated, cells = entry(claim, "cells"), entry(loop, "cells")
    if not isinstance(stated, list) or not len(stated) == len(cells) == len(turbine.wind) - 1:
        raise Refusal("cells: one for each cell of the loop is needed")
    for k, (rates, cell) in enumerate(zip(stated, cells, strict=True)):
        yield from _cell(rates, cell, turbine.cell(k), P, peaks, f"cell {k + 1}")
    if "wind_rate" in claim:
        rate, _ = rested_on(claim, document, "wind_rate", "wind-rate")
        yield Fact("one loop for both", entry(rate, "loop") == entry(claim, "loop"))
        lag = rational(entry(document, "gains"), "wind_filter")
        for k, rates in enumerate(stated):
            if turbine.ahead_limit[k] > 0:
                most = turns(rate, lag, *turbine.wind[k : k + 2])
                kept = most <= rational(rates, "schedule_bend")
                yield Fact(f"cell {k + 1}: rate of the wind's rate", kept)
    yield Fact("step of torque", turbine.per_effort * _step(turbine, cells) <= rational(
        claim, "torque_step"
    ))  # fmt: skip


def _cell(rates: Any, cell: Any, at: WindCell, P: fmpq_mat, peaks: Any, label: str) -> Obligations:
    turbine, rho = at.turbine, rational(cell, "wind_rate")
    owed, signal = rational(peaks, "effort_lag"), rational(peaks, "speed_signal")
    B, bend = rational(rates, "signal_rate"), rational(rates, "schedule_bend")
    yield Fact(f"{label}: signs", min(B, bend) >= 0)

    led = turbine.lead / turbine.drive * rho * (asked_slope(at) / at.b).size
    fastest = min(turbine.rate_limit, owed / at.b.low / turbine.drive + led)
    yield Fact(f"{label}: pitch", fastest <= rational(rates, "pitch_rate"))

    nu = rational(cell, "integral_rate")
    ends = (rationals(cell, name, 2) for name in ("stiffness", "loop_gain", "lag_gain"))
    for a, G, S in product(*ends):
        h = fmpq_mat([[a - G + nu, S, G]])
        yield Definite(f"{label}: signal", scaled(B**2, P) - transposed(h) * h)

    pushed = rational(cell, "residual") + rational(cell, "wind_gain") * rational(cell, "wind_error")
    pushed = rational(cell, "inertia_gain") * pushed + rational(cell, "reference_slope") * rho
    moved = abs(at.slope(turbine.effort)) + abs(at.slope(turbine.proportional)) * signal
    effort = at.gamma.high * (B + pushed) + rho * moved
    torque = ramp_slope(-at.efforts.low, turbine.overlap) * effort
    if turbine.ahead_limit[at.k] > 0:
        torque += abs(turbine.ahead[at.k]) * bend
    yield Fact(f"{label}: torque", turbine.per_effort * torque <= rational(rates, "torque_rate"))


def _step(turbine: TurbineNumbers, cells: Any) -> fmpq:
    """Return the largest step of the feed-forward at a node, over both cells' rates [rad/s^2]."""
    sides = [
        (f, g, rational(cell, "wind_rate"))
        for f, g, cell in zip(turbine.ahead, turbine.ahead_limit, cells, strict=True)
    ]
    found = [ZERO]
    # The difference of two limited lines is piecewise linear and odd in the rate: it is largest at
    # an end of the rates or where one of both reaches its limit.
    for one, two in pairwise(sides):
        reach = min(one[2], two[2])
        corners = [reach] + [g / abs(f) for f, g, _ in (one, two) if f != 0 and g < abs(f) * reach]
        found += [abs(_fed(one, s) - _fed(two, s)) for s in corners]
    return max(found)


def _fed(side: tuple[fmpq, fmpq, fmpq], rate: fmpq) -> fmpq:
    """Return f v_s' limited to [-g, g]."""
    f, g, _ = side
    return max(-g, min(g, f * rate))
