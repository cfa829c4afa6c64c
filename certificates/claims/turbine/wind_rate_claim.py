r"""The candidate of a claim of kind ``wind-rate``: admissible rates of the wind estimate.

From the wind class of a claim ``coherent-loop``, |v - v_s| <= delta_k and |v_s'| <= rho_k by wind
cell, and the law's filter tau_f: the largest allowed schedule rate

    phi = min(rho_k, (delta_k - eta) / tau_f)   at the law's nodes, the smaller of both cells'

linear between the nodes and a few further winds, nowhere steeper than STEEPEST / tau_f; and for
this phi the largest r that satisfies the claim's inequalities, by a linear program in r
(``certificates/checker/turbine/effort_sharing/wind_rate.py``).  Nothing is proved here.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.obligation import first_failure
from takagi.certificates.checker.turbine.effort_sharing.wind_rate import Range, filter_keeps_up
from takagi.models.arrays import Floats
from takagi.models.intervals.interval import exact

# tau_f times the slope of phi is the loss in r. A step of the class gets at most this slope. In
# wide cells the slope is at least GENTLE, so that only the edge of the cell has a lower rate.
STEEPEST, GENTLE = 0.3, 0.03
# The rate requested in full load [m/s^2], the fraction of the wind error that it may use, and the
# smallest error of the estimate for which a claim is made [m/s].
FULL_LOAD_RATE, RATE_SHARE, LEAST_ERROR = 2.0, 0.7, 0.001
DIGITS, CLOSE = 5, 1e-9


@dataclass(frozen=True, slots=True, eq=False)
class RateRange:
    """One range of winds of a claim.

    Attributes
    ----------
    wind : (n,) nodes [m/s];  estimate_rate : r, schedule_rate : phi [m/s^2], linear between them.
    estimate_error : eta, the bound of the estimate's error [m/s].
    """

    wind: Floats
    estimate_rate: Floats
    schedule_rate: Floats
    estimate_error: float

    def data(self) -> dict[str, Any]:
        """Return the range as plain data of the claim."""
        return {
            "wind": self.wind.tolist(),
            "estimate_rate": self.estimate_rate.tolist(),
            "schedule_rate": self.schedule_rate.tolist(),
            "estimate_error": self.estimate_error,
        }


def wind_rate_claim(loop: Mapping[str, Any], wind_filter: float) -> dict[str, Any] | None:
    """Return the claim as plain data, or None if nothing can be claimed.

    The first range covers all winds, for an exact estimate.  A second one covers the winds in full
    load at a rate of 2 m/s^2 (or the largest at cut-out, if that is less), for an estimate with the
    largest error that remains. The filter's lag turns this rate into a wind error; if that exceeds
    RATE_SHARE of the class, the rate is reduced to the one at which both are equal.

    ``loop`` : a claim of kind ``coherent-loop``, the first of the file.   wind_filter : tau_f [s].
    """
    if wind_filter <= 0:
        return None
    cells = loop["cells"]
    all_winds = rate_range(cells, wind_filter)
    if float(all_winds.estimate_rate.max()) <= 0:
        return None
    ranges = filter(None, (all_winds, _full_load(cells, wind_filter)))
    low, high = cells[0]["wind"][0], cells[-1]["wind"][1]
    return {
        "name": f"wind rate, {low:g} to {high:g} m/s",
        "kind": "wind-rate",
        "loop": 0,
        "ranges": [one_range.data() for one_range in ranges],
    }


def rate_range(
    cells: Sequence[Mapping[str, Any]], wind_filter: float, *, estimate_error: float = 0.0
) -> RateRange:
    """Return the largest rates over the winds of some adjacent cells.

    Parameters
    ----------
    cells : as the claim of the loop states them.
    estimate_error : eta [m/s]; where it exceeds a cell's wind error, the rate is 0 and the claim
        cannot be proved.
    """
    edges = np.array([cells[0]["wind"][0], *(cell["wind"][1] for cell in cells)], dtype=np.float64)
    caps = _caps(cells, wind_filter, estimate_error)
    nodes = np.array([_cone(s, edges, caps, STEEPEST / wind_filter) for s in edges])
    wind, phi = _with_bends(edges, caps, nodes, GENTLE / wind_filter)
    phi = _down(phi)
    rows, bounds = _conditions(wind, phi, wind_filter)
    rate = _down((1 - 1e-9) * _largest(rows, bounds, phi))
    # The linear program may return slightly less than phi; phi itself is used if it is feasible.
    nearest = np.where(rate > phi - 2 * 10.0**-DIGITS, phi, rate)
    nearest = np.where((rows[rows @ nearest > bounds + 1e-12] != 0).any(axis=0), rate, nearest)
    stated = _exact(wind, nearest, phi, estimate_error)
    fits = not first_failure(filter_keeps_up(stated, exact(wind_filter)))
    return RateRange(wind, nearest if fits else rate, phi, estimate_error)


def _exact(wind: Floats, rate: Floats, phi: Floats, error: float) -> Range:
    nodes, r, limit = ([exact(value) for value in column.tolist()] for column in (wind, rate, phi))
    return Range(nodes, r, limit, exact(error))


def _caps(cells: Sequence[Mapping[str, Any]], wind_filter: float, error: float) -> Floats:
    rates = np.array([cell["wind_error"] - error for cell in cells]) / wind_filter
    return np.maximum(np.minimum([cell["wind_rate"] for cell in cells], rates), 0.0)


def _cone(s: float, edges: Floats, caps: Floats, slope: float) -> float:
    """Return min_k cap_k + slope dist(s, cell k)."""
    away = np.maximum(np.maximum(edges[:-1] - s, s - edges[1:]), 0.0)
    return float(np.min(caps + slope * away))


def _with_bends(edges: Floats, caps: Floats, nodes: Floats, slope: float) -> tuple[Floats, Floats]:
    """Return winds and phi: at the nodes, and where the gentle slope reaches a wide cell's cap."""
    phi_at = dict(zip(edges.tolist(), nodes.tolist(), strict=True))
    for k, cap in enumerate(caps.tolist()):
        low, high = float(edges[k]), float(edges[k + 1])
        rise_low, rise_high = (cap - phi_at[end] for end in (low, high))
        if 0 <= rise_low and 0 <= rise_high and rise_low + rise_high < slope * (high - low):
            if rise_low > 0:
                phi_at[round(low + rise_low / slope, 4)] = cap
            if rise_high > 0:
                phi_at[round(high - rise_high / slope, 4)] = cap
    wind = sorted(phi_at)
    return np.array(wind), np.array([phi_at[s] for s in wind])


def _conditions(wind: Floats, phi: Floats, wind_filter: float) -> tuple[Floats, Floats]:
    """Return rows and bounds: if ``rows @ r <= bounds``, the filter's rate stays below phi."""
    rows, bounds = [], []
    for i, (low, high) in enumerate(pairwise(wind.tolist())):
        slope = (phi[i + 1] - phi[i]) / (high - low)
        for ahead in (wind_filter, -wind_filter):
            for s in _meetings(wind, low, high, low + ahead * phi[i], high + ahead * phi[i + 1]):
                here = phi[i] + slope * (s - low)
                estimate = s + ahead * here
                if wind[0] - CLOSE <= estimate <= wind[-1] + CLOSE:
                    rows.append(_weights(wind, estimate))
                    bounds.append(here * (1 + ahead * slope))
    return np.array(rows), np.array(bounds)


def _largest(rows: Floats, bounds: Floats, phi: Floats) -> Floats:
    """Return r with rows r <= bounds, 0 <= r <= phi, and the largest sum of r / phi."""
    from scipy.optimize import linprog

    scale = np.maximum(phi, 10.0**-DIGITS)
    result = linprog(-np.ones(len(phi)), rows * scale, bounds, bounds=[(0, 1)] * len(phi))
    return np.asarray(result.x * scale if result.status == 0 else np.zeros(len(phi)))


def _meetings(wind: Floats, low: float, high: float, first: float, last: float) -> Iterator[float]:
    """Yield a piece's ends, and the winds that the filter's lead shifts to a node."""
    yield low
    yield high
    for node in wind[(wind > min(first, last)) & (wind < max(first, last))]:
        yield low + (high - low) * (float(node) - first) / (last - first)


def _weights(wind: Floats, at: float) -> Floats:
    """Return the row that gives r at a wind from r at the nodes."""
    row = np.zeros(len(wind))
    inside = min(max(at, float(wind[0])), float(wind[-1]))
    i = min(int(np.searchsorted(wind, inside, side="right")) - 1, len(wind) - 2)
    share = (inside - wind[i]) / (wind[i + 1] - wind[i])
    row[i : i + 2] = 1 - share, share
    return row


def _down(values: Floats) -> Floats:
    """Round down to the emitted decimals; a value that is such a decimal is unchanged."""
    # The added share keeps a value that is such a decimal from losing its last unit by rounding.
    lowered: Floats = np.floor(values * 10**DIGITS + 1e-6) / 10**DIGITS
    return np.maximum(lowered, 0.0)


def _full_load(cells: Sequence[Mapping[str, Any]], wind_filter: float) -> RateRange | None:
    """Return the range up to the last wind with one constant rate, and with the largest error."""
    rate = min(FULL_LOAD_RATE, float(cells[-1]["wind_rate"]))
    first_cell = len(cells)
    # One rate has to hold in the whole range, so it ends at the first cell that encloses less.
    while first_cell and cells[first_cell - 1]["wind_rate"] >= rate:
        first_cell -= 1
    upper = cells[first_cell:]
    allowed = min(cell["wind_error"] for cell in upper)
    rate = min(rate, math.floor(RATE_SHARE * allowed / wind_filter * 1e4) / 1e4)
    # At this rate the filter lags by wind_filter * asked, and the admissible error covers that too.
    # The factor keeps a product that is such a decimal but for rounding from losing its last unit.
    error = math.floor((allowed - wind_filter * rate) * 1e4 * (1 + 1e-12)) / 1e4
    if rate <= 0 or error < LEAST_ERROR:
        return None
    ends = np.array([upper[0]["wind"][0], upper[-1]["wind"][1]], dtype=np.float64)
    rates = np.array([rate, rate])
    return RateRange(ends, rates, rates, error)
