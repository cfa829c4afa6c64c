r"""The claims about a turbine's effort-sharing loop, and the claims that depend on it.

A dependent claim is kept only if the checker proves it, assuming the claim about the loop. So a
consequence that a design does not have cannot make the file UNDECIDED. The reason why a claim was
left out is recorded in the file's provenance.  The claim about the loop with its observer is by
itself: of it those winds are claimed at which a function was found.

The bounds of a claim ``bumpless`` are the checker's, rounded up; B is computed here in floating
point.

The candidate of a claim of kind ``wind-rate``: admissible rates of the wind estimate.

From the wind class of a claim ``coherent-loop``, |v - v_s| <= delta_k and |v_s'| <= rho_k by wind
cell, and the law's filter tau_f: the largest allowed schedule rate

    phi = min(rho_k, (delta_k - eta) / tau_f)   at the law's nodes, the smaller of both cells'

linear between the nodes and a few further winds, nowhere steeper than STEEPEST / tau_f; and for
this phi the largest r that satisfies the claim's inequalities, by a linear program in r
(``certificates/checker/turbine/effort_sharing/wind_rate.py``).  Nothing is proved here.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from takagi.certificates.checker.kernel.claim_kind import ClaimKind, Outcome
from takagi.certificates.checker.kernel.obligation import Obligations, first_failure
from takagi.certificates.checker.kernel.reader import number
from takagi.certificates.checker.kernel.refusal import Refused
from takagi.certificates.checker.replay.claim_kinds import replay
from takagi.certificates.checker.turbine.effort_sharing.bumpless import NAME, cell_rates
from takagi.certificates.checker.turbine.effort_sharing.inputs import Subject
from takagi.certificates.checker.turbine.effort_sharing.wind_rate import Range, filter_keeps_up
from takagi.certificates.checker.turbine.published.bumpless import NAME as PUBLISHED_NAME
from takagi.certificates.checker.turbine.published.bumpless import RATES, command_rates
from takagi.certificates.checker.turbine.published.loop_claim import PublishedLoop
from takagi.certificates.claims.turbine.cell_loop import EffortSharingCandidate
from takagi.certificates.claims.turbine.effort_sharing import effort_sharing_claim
from takagi.certificates.document.certificate_file import (
    certificate_document,
    effort_sharing_law_data,
    provenance,
    turbine_data,
)
from takagi.certificates.document.model_data import as_read
from takagi.models.arrays import Floats
from takagi.models.intervals.interval import exact
from takagi.models.laws.effort_sharing.law import EffortSharingLaw
from takagi.models.turbine.data import Turbine

# tau_f times the slope of phi is the loss in r. A step of the class gets at most this slope. In
# wide cells the slope is at least GENTLE, so that only the edge of the cell has a lower rate.
STEEPEST, GENTLE = 0.3, 0.03
# The rate requested in full load [m/s^2], the fraction of the wind error that it may use, and the
# smallest error of the estimate for which a claim is made [m/s].
FULL_LOAD_RATE, RATE_SHARE, LEAST_ERROR = 2.0, 0.7, 0.001
RATE_DIGITS, CLOSE = 5, 1e-9


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
            member.name: np.asarray(getattr(self, member.name)).tolist() for member in fields(self)
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
    """Return the largest rates over the winds of some adjacent cells of the loop's claim.

    Where ``estimate_error``, eta [m/s], exceeds a cell's wind error, the rate is 0: not provable.
    """
    edges = np.array([cells[0]["wind"][0], *(cell["wind"][1] for cell in cells)], dtype=np.float64)
    filtered = np.array([cell["wind_error"] - estimate_error for cell in cells]) / wind_filter
    caps = np.maximum(np.minimum([cell["wind_rate"] for cell in cells], filtered), 0.0)
    # min_k cap_k + slope dist(s, cell k) at every node s.
    away = np.maximum(np.maximum(edges[:-1] - edges[:, None], edges[:, None] - edges[1:]), 0.0)
    nodes = np.min(caps + STEEPEST / wind_filter * away, axis=1)
    wind, phi = _with_bends(edges, caps, nodes, GENTLE / wind_filter)
    phi = _down(phi)
    rows, bounds = _conditions(wind, phi, wind_filter)
    rate = _down((1 - 1e-9) * _largest(rows, bounds, phi))
    # The linear program may return slightly less than phi; phi itself is used if it is feasible.
    nearest = np.where(rate > phi - 2 * 10.0**-RATE_DIGITS, phi, rate)
    nearest = np.where((rows[rows @ nearest > bounds + 1e-12] != 0).any(axis=0), rate, nearest)
    columns = [[*map(exact, column.tolist())] for column in (wind, nearest, phi)]
    stated = Range(columns[0], columns[1], columns[2], exact(estimate_error))
    fits = not first_failure(filter_keeps_up(stated, exact(wind_filter)))
    return RateRange(wind, nearest if fits else rate, phi, estimate_error)


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
            # The piece's ends, and the winds that the filter's lead shifts to a node.
            first, last = low + ahead * phi[i], high + ahead * phi[i + 1]
            nodes = wind[(wind > min(first, last)) & (wind < max(first, last))].tolist()
            shifted = (low + (high - low) * (node - first) / (last - first) for node in nodes)
            for s in (low, high, *shifted):
                here = phi[i] + slope * (s - low)
                estimate = s + ahead * here
                if wind[0] - CLOSE <= estimate <= wind[-1] + CLOSE:
                    rows.append([np.interp(estimate, wind, unit) for unit in np.eye(len(wind))])
                    bounds.append(here * (1 + ahead * slope))
    return np.array(rows), np.array(bounds)


def _largest(rows: Floats, bounds: Floats, phi: Floats) -> Floats:
    """Return r with rows r <= bounds, 0 <= r <= phi, and the largest sum of r / phi."""
    from scipy.optimize import linprog

    scale = np.maximum(phi, 10.0**-RATE_DIGITS)
    result = linprog(-np.ones(len(phi)), rows * scale, bounds, bounds=[(0, 1)] * len(phi))
    return np.asarray(result.x * scale if result.status == 0 else np.zeros(len(phi)))


def _down(values: Floats) -> Floats:
    """Round down to the emitted decimals; a value that is such a decimal is unchanged."""
    # The added share keeps a value that is such a decimal from losing its last unit by rounding.
    lowered: Floats = np.floor(values * 10**RATE_DIGITS + 1e-6) / 10**RATE_DIGITS
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


def loop_document(
    turbine: Turbine,
    law: EffortSharingLaw,
    candidate: EffortSharingCandidate,
    configuration: object,
    *,
    files: Sequence[Path] = (),
    controller: Mapping[str, Any] | None = None,
    tell: Callable[[str], None] | None = None,
) -> dict[str, Any]:
    """Return the certificate of an effort-sharing loop, with every claim that holds.

    Parameters
    ----------
    configuration : as recorded in the provenance.
    controller : the gain file's observer and filters; None makes no claim about the loop with them.
    tell : called with a word before the search for each of these claims.
    files : the turbine's data files; the certificate records what they say.

    Raises
    ------
    ModelError : the candidate has no P.
    """
    model, gains = turbine_data(turbine, files), effort_sharing_law_data(law)
    claims, left_out = loop_claims(model, gains, effort_sharing_claim(candidate))
    say = tell or (lambda words: None)
    if law.setpoints is not None:
        say("loop at constant set-points")
        # Imported here: it loads a solver.  The user asked for set-points, so that a claim that is
        # not proved stays in the file.
        from takagi.certificates.claims.turbine.set_points_claim import set_points_claim

        claims.append(set_points_claim(turbine, law, model, gains))
    if controller is not None:
        say("loop with its observer, at constant winds")
        # Imported here: it loads a solver.
        from takagi.certificates.claims.turbine.running_loop_claim import running_loop_claim

        filters, inertia = controller, claims[0]["uncertainty"]["inertia"]
        claim, why = _unless_open(
            lambda: running_loop_claim(model, gains, filters, inertia), model, gains, []
        )
        claims += [claim] if claim else []
        left_out |= {} if claim else {"running-loop": f"not claimed: {why}"}
    return certificate_document(
        model=model,
        gains=gains,
        claims=claims,
        provenance=provenance(configuration, {"joint analysis": candidate.words, **left_out}),
        files=files,
    )


def loop_claims(
    model: Mapping[str, Any], gains: Mapping[str, Any], loop: Mapping[str, Any]
) -> tuple[list[dict[str, Any]], dict[str, str]]:
    """Return the claims beside the stated one, in file order; by kind why one was left out."""
    claims, left_out = [dict(loop)], dict[str, str]()
    for kind, make in (
        ("wind-rate", lambda: wind_rate_claim(loop, float(gains["wind_filter"]))),
        ("bumpless", lambda: bumpless_claim(model, gains, loop)),
    ):
        claim, why = _unless_open(make, model, gains, claims)
        claims += [claim] if claim else []
        left_out |= {kind: f"not claimed: {why}"} if why else {}
    return claims, left_out


def _unless_open(
    make: Callable[[], dict[str, Any] | None],
    model: Mapping[str, Any],
    gains: Mapping[str, Any],
    earlier: Sequence[Mapping[str, Any]],
) -> tuple[dict[str, Any] | None, str]:
    """Return the claim if the checker proves it after the earlier ones, or why there is none."""
    try:
        claim = make()
        if claim is None:
            return None, "nothing to claim"
        members = {"model": model, "gains": gains, "claims": [*earlier, claim]}
        data, index = as_read(members), len(earlier)
        below = [Outcome(_TakenAsProved()) for _ in earlier]
        why = replay(data["claims"][index], data, None, below, f"claims[{index}]").failure
    except Refused as reason:
        # Without a proof of the loop nothing can follow; the loop's verdict gives the reason.
        return None, str(reason)
    return (None, why) if why else (claim, "")


class _TakenAsProved(ClaimKind):
    name = "taken as proved"

    def obligations(self) -> Obligations:
        return iter(())

    def sentence(self) -> str:
        return self.name


# Factor on B, which is found in floating point.
RESERVE = 1 + 1e-6
DIGITS = 7


def bumpless_claim(
    model: Mapping[str, Any], gains: Mapping[str, Any], loop: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the claim as plain data; a cell's rates are the least bounds that hold."""
    members = {"model": dict(model), "gains": dict(gains), "loop": dict(loop)}
    data = as_read(members)
    subject = Subject.read(data["loop"], data["model"], data["gains"], "loop")
    P = np.linalg.inv(np.array(loop["P"], dtype=np.float64))
    pitch_limit = number(data["model"], "pitch_rate_limit", "model")
    cells = []
    for bound in cell_rates(subject, data["loop"], "loop"):
        # max sqrt(h P^-1 h') over the corners, rounded up.
        rows = np.array([[*map(float, h)] for h in bound.corners])
        largest = float(np.sqrt(np.einsum("ci,ij,cj->c", rows, P, rows).max()))
        signal = _up(Fraction(largest * RESERVE))
        cells.append(
            {
                "pitch_rate": float(min(pitch_limit, _up(bound.pitch))),
                "signal_rate": float(signal),
                "torque_rate": float(_up(bound.torque_rate(signal))),
            }
        )
    return {"name": NAME, "kind": "bumpless", "loop": 0, "cells": cells}


def published_bumpless_claim(
    model: Mapping[str, Any], gains: Mapping[str, Any], loop: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the same claim for Schulte's law.

    ``loop`` : the claim of kind ``paper-loop``, the first of the file.
    """
    members = {"model": dict(model), "gains": dict(gains), "claims": [dict(loop)]}
    data = as_read(members)
    stated = PublishedLoop.read(data["claims"][0], data, (), "claims[0]")
    cells = [
        {name: float(_up(rate)) for name, rate in zip(RATES, command_rates(stated, c), strict=True)}
        for c in stated.cells
    ]
    return {"name": PUBLISHED_NAME, "kind": "bumpless", "loop": 0, "cells": cells}


def _up(value: Fraction) -> Fraction:
    return Fraction(math.ceil(value * 10**DIGITS), 10**DIGITS)
