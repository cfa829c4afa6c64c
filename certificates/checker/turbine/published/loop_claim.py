r"""Replays a claim about the loop with a published law, at constant winds, v_hat = v.

Per wind cell a centre z_0(v), linear in v, a box |z_i - z_0i(v)| <= r_i (pitch no less than the
smallest) and P are stated.  With y = (z - z_0)/r the loop is y' = A y + d, A in the hull of the
Jacobian over box and cell, d the field at the centre.  Both are enclosed here from plant and law
and compared with the stated ranges. Then it is proved exactly for all plants of the stated ranges:

    {y'Py <= 1} lies in the box and is invariant, so that it holds an equilibrium (Brouwer);
    any two motions in it approach each other as exp(-rho t) in the norm of P, so that there is
    exactly one, and every motion from the set tends to it.

The claim is PROVED when such cells cover the winds that it names; otherwise the covered winds are
listed.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.arithmetic.interval import Interval, point
from takagi.certificates.checker.kernel.reader import listed, matrix, number, numbers
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.kernel.result import Found, Verdict
from takagi.certificates.checker.turbine.effort_sharing.inputs import Plant
from takagi.certificates.checker.turbine.published.inputs import Overlaps, PublishedLaw
from takagi.certificates.checker.turbine.published.interval_matrices import contraction_failure
from takagi.certificates.checker.turbine.published.loop import Ends, Loop
from takagi.certificates.checker.turbine.wind_intervals import Span, gaps, merged

MOST_CELLS = 5000
MOST_CORNERS = 8
Rows = list[list[Fraction]]


@dataclass(frozen=True)
class Cell:
    """One cell as stated."""

    ends: Ends
    P: Rows
    corners: list[tuple[Rows, Rows]]
    disturbance: list[Fraction]
    rate: Fraction
    multiplier: Fraction

    @classmethod
    def read(cls, cell: Any, law: PublishedLaw, where: str) -> Cell:
        """Return the cell; refuses sizes that do not fit and a centre outside the pitch range."""
        n = law.states
        wind = numbers(cell, "wind", where, 2)
        centre, box = matrix(cell, "centre", where), numbers(cell, "box", where, n)
        if not 0 < wind[0] < wind[1] or len(centre) != 2 or len(centre[0]) != n or min(box) <= 0:
            raise CertificateError(f"{where}: increasing winds, two centres and a box are needed")
        if any(not law.pitch_min <= z[1] <= law.pitch_max for z in centre):
            raise CertificateError(f"{where}.centre: pitch outside its range")
        stated = listed(cell, "corners", where, 1, MOST_CORNERS)
        corners = [
            tuple(_square(corner, name, f"{where}.corners[{k}]", n) for name in ("low", "high"))
            for k, corner in enumerate(stated)
        ]
        disturbance = numbers(cell, "disturbance", where, n)
        rate, multiplier = (number(cell, k, where) for k in ("decay_rate", "multiplier"))
        if min(*disturbance, rate, multiplier) < 0 or 0 in (rate, multiplier):
            raise CertificateError(f"{where}: bounds, rate and multiplier must not be negative")
        P = _square(cell, "P", where, n)
        if any(P[i][j] != P[j][i] for i in range(n) for j in range(i)):
            raise CertificateError(f"{where}.P: must be symmetric")
        ends = Ends((wind[0], wind[1]), (centre[0], centre[1]), box)
        return cls(ends, P, corners, disturbance, rate, multiplier)  # type: ignore[arg-type]


def _square(owner: Any, key: str, where: str, n: int) -> Rows:
    rows = matrix(owner, key, where)
    if len(rows) != n or len(rows[0]) != n:
        raise CertificateError(f"{where}.{key}: {n} rows of {n} numbers are needed")
    return rows


def check_published(claim: Any, model: Any, gains: Any, where: str) -> Found:
    """Return the verdict on one claim of kind ``paper-loop``, with the winds for which it holds.

    Raises
    ------
    CertificateError : a part is missing or is not what it has to be.
    """
    plant, law = Plant.read(model), PublishedLaw.read(gains)
    if (plant.pitch_min, plant.pitch_max) != (law.pitch_min, law.pitch_max):
        raise CertificateError("gains: pitch limits differ from the model's")
    overlaps = Overlaps.read(claim, where, law.rated_torque)
    if law.rated_torque + overlaps.torque / 2 > law.top_torque:
        # Only then does the filter command rated torque everywhere beyond the rounded corner.
        raise CertificateError("gains.coupling.top_torque: the rounded corner goes beyond it")
    winds = _spans(matrix(claim, "winds", where), f"{where}.winds")
    cells = listed(claim, "cells", where, 0, MOST_CELLS)
    proved: list[Cell] = []
    failures: list[tuple[Span, str]] = []
    for k, stated in enumerate(cells):
        place = f"{where}.cells[{k}]"
        cell = Cell.read(stated, law, place)
        reason = _failure(plant, law, overlaps, cell, place)
        if reason:
            failures.append((cell.ends.wind, reason))
        else:
            proved.append(cell)
    covered = merged([cell.ends.wind for cell in proved])
    missing = [gap for span in winds for gap in gaps(span, covered)]
    verdict = Verdict.UNDECIDED if missing or failures else Verdict.PROVED
    said = {"plant": plant, "law": law, "overlaps": overlaps, "winds": winds, "proved": proved}
    said |= {"covered": covered, "missing": missing, "failures": failures}
    return Found(verdict, "published", said | {"left": _left_out(claim, winds, where)})


def _left_out(claim: Any, winds: list[Span], where: str) -> list[Span]:
    """Return the winds that the file lists as not proved and does not claim."""
    stated = listed(claim, "unproved", where, 0, MOST_CELLS)
    rows = [numbers(gap, "wind", f"{where}.unproved[{k}]", 2) for k, gap in enumerate(stated)]
    spans = _spans(rows, f"{where}.unproved") if rows else []
    claimed = merged(winds)
    return merged([gap for span in spans for gap in gaps(span, claimed)])


def _spans(rows: Rows, where: str) -> list[Span]:
    if len(rows[0]) != 2 or any(not 0 < low < high for low, high in rows):
        raise CertificateError(f"{where}: pairs of increasing winds are needed")
    return [(low, high) for low, high in rows]


def _failure(plant: Plant, law: PublishedLaw, overlaps: Overlaps, cell: Cell, where: str) -> str:
    """Return what is not proved about one cell, or nothing."""
    try:
        loop = Loop(plant, law, overlaps, cell.ends, "states")
        for torque_end, free in loop.choices():
            rates = loop.rates(torque_end, free)
            rows = [
                [slope * point(1 / r) for slope in rate.slopes]
                for rate, r in zip(rates, cell.ends.widths, strict=True)
            ]
            if not any(_holds(rows, low, high) for low, high in cell.corners):
                return "the loop's matrix leaves the stated ranges"
        size = _disturbance(plant, law, overlaps, cell.ends)
    except Refused as reason:
        return str(reason)
    for found, r, bound in zip(size, cell.ends.widths, cell.disturbance, strict=True):
        if not Interval(0, found).within(Fraction(0), r * bound):
            return "the field at the centre exceeds the stated bound"
    return contraction_failure(
        cell.P, cell.corners, cell.disturbance, cell.rate, cell.multiplier, where
    )


def _holds(rows: list[list[Interval]], low: Rows, high: Rows) -> bool:
    return all(
        entry.within(least, most)
        for row, lows, highs in zip(rows, low, high, strict=True)
        for entry, least, most in zip(row, lows, highs, strict=True)
    )


def _disturbance(plant: Plant, law: PublishedLaw, overlaps: Overlaps, ends: Ends) -> list[int]:
    """Return bounds of |f_i(z_0(v), v)|, over 10^36: at the middle, and slope times half width."""
    (v1, v2), zero = ends.wind, [Fraction(0)] * law.states
    middle = [(a + b) / 2 for a, b in zip(*ends.states, strict=True)]
    halfway = (v1 + v2) / 2
    at_middle = Loop(plant, law, overlaps, Ends((halfway, halfway), (middle, middle), zero), "none")
    along = Loop(plant, law, overlaps, Ends((v1, v2), ends.states, zero), "line")
    half = point((v2 - v1) / 2)
    return [
        here.value.magnitude() + (Interval(0, line.slopes[0].magnitude()) * half).high
        for here, line in zip(at_middle.rates(), along.rates(), strict=True)
    ]
