"""Whether a claim of kind ``wind-rate`` is false: the law's wind filter against the worst winds.

v_s' = (w - v_s) / tau_f is run from every edge of what is claimed, w - v_s = +- tau_f phi(v_s), and
from v_s = w where the law starts, with an estimate w that moves away as fast as it may,
w' = +- r(w), and with the wind v as far from w as it may be.  Counterexamples are

    |v_s'| > phi(v_s),   |v_s'| > wind_rate,   |v - v_s| > wind_error        in the cell of v_s.

The tables are looked up by ``numpy.interp``, the filter is stepped by Runge and Kutta's rule.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any

import numpy as np
from turbine_loop import Data, Floats, Loop, column
from turbine_search import MARGIN, drawn, overspeed_shown

STARTS, STEPS, PER_FILTER = 12, 120, 60  # starts on a piece; steps in all, and in one tau_f
# The rule's own error where a table bends, of the rate that is compared.
STEPPED = 1e-5


@dataclass
class Tube:
    """One range of a claim: winds, both rates at them, and how well the wind is known."""

    wind: Floats
    estimate: Floats
    schedule: Floats
    error: float
    filter: float

    def moved(self, x: Floats, away: Floats) -> Floats:
        """Return (w', v_s') at (w, v_s); w stops at the range's ends."""
        w, v_s = x
        free = np.where(away > 0, w < self.wind[-1], w > self.wind[0])
        rate = away * np.interp(w, self.wind, self.estimate) * free
        return np.stack([rate, (w - v_s) / self.filter])

    def step(self, x: Floats, away: Floats, size: float) -> Floats:
        """Return (w, v_s) a moment later, w within the range."""
        one = self.moved(x, away)
        two = self.moved(x + size / 2 * one, away)
        three = self.moved(x + size / 2 * two, away)
        four = self.moved(x + size * three, away)
        after = x + size / 6 * (one + 2 * two + 2 * three + four)
        after[0] = np.clip(after[0], self.wind[0], self.wind[-1])
        return np.asarray(after)


def why_wind_rate_false(loop: Loop, claim: Data, draw: np.random.Generator) -> str:
    """Return what is false in the claim, and at which wind; empty when nothing was seen."""
    for tube in _tubes(loop, claim):
        inside = loop.wind[0] <= tube.wind[0] < tube.wind[-1] <= loop.wind[-1]
        least = min(tube.error, *tube.estimate, *tube.schedule)
        if not inside or least < 0 or (np.diff(tube.wind) <= 0).any():
            return "the range is none of the law's winds, or a number is negative"
        if why := _left(loop, tube, draw):
            return why
    return ""


def _tubes(loop: Loop, claim: Data) -> list[Tube]:
    return [
        Tube(
            column(one["wind"]),
            column(one["estimate_rate"]),
            column(one["schedule_rate"]),
            float(one["estimate_error"]),
            loop.wind_filter,
        )
        for one in claim["ranges"]
    ]


def _left(loop: Loop, tube: Tube, draw: np.random.Generator) -> str:
    """Run the filter from the edges of the tube, and say where it is left."""
    pieces = np.repeat(np.arange(len(tube.wind) - 1), STARTS)
    place = drawn(draw, len(pieces), 1)[:, 0]
    s = tube.wind[pieces] + place * np.diff(tube.wind)[pieces]
    lag = tube.filter * np.interp(s, tube.wind, tube.schedule)
    w = np.concatenate([s + lag, s - lag, s, s])
    away, start = np.repeat([1.0, -1.0, 1.0, -1.0], len(s)), np.tile(s, 4)
    kept = (w >= tube.wind[0]) & (w <= tube.wind[-1])
    x, away = np.stack([w, start])[:, kept], away[kept]
    for _ in range(STEPS):
        if why := _exceeded(loop, tube, x):
            return why
        x = tube.step(x, away, tube.filter / PER_FILTER)
    return _exceeded(loop, tube, x)


def _exceeded(loop: Loop, tube: Tube, x: Floats) -> str:
    """Return the first limit that is passed at (w, v_s)."""
    w, v_s = x
    every = np.arange(len(loop.cells))
    k = np.clip(np.searchsorted(loop.wind, v_s, side="right") - 1, 0, every[-1])
    rate = abs(w - v_s) / tube.filter
    farthest = (np.clip(w + e, *tube.wind[[0, -1]]) for e in (tube.error, -tube.error))
    off = np.maximum(*(abs(v - v_s) for v in farthest))
    for found, limit, what in (
        (rate, np.interp(v_s, tube.wind, tube.schedule), "the schedule wind is faster than stated"),
        (rate, loop.stated("wind_rate", k), "the schedule wind is faster than the claim allows"),
        (
            off,
            loop.stated("wind_error", k),
            "the schedule wind is further off than the claim allows",
        ),
    ):
        # A point just beside a node may be a cell's neighbour by rounding.
        inner = np.minimum(v_s - loop.wind[k], loop.wind[k + 1] - v_s) > MARGIN
        wrong = (found > limit * (1 + STEPPED) + MARGIN) & inner
        if wrong.any():
            i = int(np.argmax(wrong))
            return f"{what} at v_s = {v_s[i]:.5f} m/s: {found[i]:.7g} for {limit[i]:.7g}"
    return ""


def why_wind_rate_misshown(loop: Loop, claim: Data, statement: str) -> str:
    """Return what is shown better than it is stated."""
    if not statement:
        return ""
    tubes = _tubes(loop, claim)
    if why := overspeed_shown(loop, statement):
        return why
    filter_ = re.search(r"wind filter of (\S+) s", statement)
    if filter_ and float(filter_[1]) < tubes[0].filter * (1 - MARGIN):
        return f"the filter is slower than shown: {filter_[0]}"
    words = re.findall(
        r"within (\S+) to (\S+) m/s, known (?:exactly|to (\S+) m/s): ([^;]*)", statement
    )
    for tube, (low, high, error, rates) in zip(tubes, words, strict=True):
        if why := _range_shown(tube, float(low), float(high), float(error or 0), rates):
            return why
    return ""


def _range_shown(tube: Tube, low: float, high: float, error: float, rates: str) -> str:
    if not tube.wind[0] - MARGIN <= low <= high <= tube.wind[-1] + MARGIN:
        return f"winds {low} to {high} m/s are shown, more than stated"
    if error > tube.error + MARGIN:
        return f"an error of {error} m/s is shown, more than stated"
    told: list[tuple[Any, Any]] = [
        *((rate, low) for rate in re.findall(r"(\S+) m/s\^2 everywhere", rates)),
        *re.findall(r"(\S+) m/s\^2 from (\S+) m/s on", rates),
    ]
    for rate, start in told:
        from_on = np.append(tube.wind[tube.wind > float(start)], float(start))
        slowest = np.interp(from_on, tube.wind, tube.estimate).min()
        if float(rate) > slowest + MARGIN:
            return f"{rate} m/s^2 is shown from {start} m/s on, where {slowest:.6g} is stated"
    return ""
