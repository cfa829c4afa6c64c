r"""``paper-loop``: the loop with a published law settles at constant winds, v_hat = v.

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

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar, Self

from takagi.certificates.checker.arithmetic.interval import ONE, Interval
from takagi.certificates.checker.kernel.claim_kind import Outcome
from takagi.certificates.checker.kernel.obligation import (
    Decider,
    Obligations,
    never,
    nonnegative,
)
from takagi.certificates.checker.kernel.reader import listed, matrix, number, numbers
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.turbine.members import Members, plain
from takagi.certificates.checker.turbine.published.inputs import STATES, Overlaps, PublishedLaw
from takagi.certificates.checker.turbine.published.interval_matrices import contraction
from takagi.certificates.checker.turbine.published.loop import Ends, field_at_centre, jacobians
from takagi.certificates.checker.turbine.rotor import Plant, Span
from takagi.certificates.checker.turbine.turbine_claim import (
    DRIVES,
    PROGRAM,
    RIGID,
    TurbineClaim,
    gaps,
    merged,
)
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.published import loop_name, loop_sentence, winds_words

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
        n = STATES
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


@dataclass(frozen=True)
class PublishedLoop(TurbineClaim):
    """The loop with a published law settles at each of the winds; see the module.

    ``unproved`` : winds that the file names as not proved and does not claim.
    """

    plant: Plant
    law: PublishedLaw
    overlaps: Overlaps
    winds: list[Span]
    cells: list[Cell]
    unproved: list[Span]

    assumes: ClassVar[tuple[str, ...]] = (
        "start inside the set of the wind's cell",
        "constant wind that the law knows",
        *DRIVES,
        *RIGID,
        *PROGRAM,
    )
    # ``state`` and ``reason`` are words for the reader of the file.
    members: ClassVar[dict[str, Members | None]] = {
        **plain("state speed_ramp_start speed_overlap torque_overlap winds"),
        "unproved": plain("wind reason"),
        "cells": {
            **plain("wind rest centre box P disturbance decay_rate multiplier"),
            "corners": plain("low high"),
        },
    }

    @classmethod
    def read(cls, claim: Any, data: Any, earlier: Sequence[Outcome], where: str) -> Self:
        """Return the claim.

        Raises
        ------
        CertificateError : a part is missing or is not what it has to be.
        """
        plant, law = Plant.read(data["model"]), PublishedLaw.read(data.get("gains"))
        if (plant.pitch_min, plant.pitch_max) != (law.pitch_min, law.pitch_max):
            raise CertificateError("gains: pitch limits differ from the model's")
        overlaps = Overlaps.read(claim, where, law.rated_torque)
        if law.rated_torque + overlaps.torque / 2 > law.top_torque:
            # Only then does the filter command rated torque everywhere beyond the rounded corner.
            raise CertificateError("gains.coupling.top_torque: the rounded corner goes beyond it")
        winds = _spans(matrix(claim, "winds", where), f"{where}.winds")
        cells = [
            Cell.read(cell, law, f"{where}.cells[{k}]")
            for k, cell in enumerate(listed(claim, "cells", where, 0, MOST_CELLS))
        ]
        name, unproved = loop_name(law, overlaps, winds), _left_out(claim, winds, where)
        return cls(claim, data, where, name, plant, law, overlaps, winds, cells, unproved)

    def parts(self) -> Iterator[tuple[str, Obligations]]:
        for k, cell in enumerate(self.cells):
            place = f"{winds_words([cell.ends.wind])} m/s: "
            yield place, self._cell(cell, f"{self.where}.cells[{k}]")

    def obligations(self) -> Obligations:
        yield from super().obligations()
        for wind in self.missing(self.cells):
            yield never(f"not proved: {winds_words([wind])} m/s, where no stated cell holds")

    def parts_failure(self, holds: Decider) -> str:
        failures = self.failures(holds)
        proved = [cell for k, cell in enumerate(self.cells) if k not in failures]
        if failures or self.missing(proved):
            return self._words(proved, list(failures.values()))
        return ""

    def missing(self, proved: Sequence[Cell]) -> list[Span]:
        """Return the claim's winds that no cell covers of those that are proved."""
        covered = merged([cell.ends.wind for cell in proved])
        return [gap for wind in self.winds for gap in gaps(wind, covered)]

    def figures(self) -> Iterator[Figure | WindProfile]:
        yield Figure("speed overlap", "rad/s", self.overlaps.width)
        yield Figure("torque overlap", "N m", self.overlaps.torque)
        rates = sorted((*cell.ends.wind, cell.rate) for cell in self.cells)
        yield WindProfile("decay rate", "1/s", tuple(rates))

    def sentence(self) -> str:
        return self._words(self.cells, [])

    def _words(self, proved: Sequence[Cell], reasons: list[str]) -> str:
        missing, sets = self.missing(proved), [(cell.ends, cell.rate) for cell in proved]
        text = loop_sentence(self.plant, self.law, self.overlaps, sets, missing, reasons)
        if self.unproved:
            text += f"; looked at but not claimed: {winds_words(self.unproved)} m/s"
        return text

    def _cell(self, cell: Cell, where: str) -> Obligations:
        """Yield what must hold in one cell.

        Raises
        ------
        Refused : an enclosure that is refused.
        """
        system, ends = (self.plant, self.law, self.overlaps), cell.ends
        for rows in jacobians(*system, ends):
            if not any(_holds(rows, low, high) for low, high in cell.corners):
                yield never("the loop's matrix leaves the stated ranges")
        sizes = field_at_centre(*system, ends)
        for size, r, bound in zip(sizes, ends.widths, cell.disturbance, strict=True):
            failure = "the field at the centre exceeds the stated bound"
            yield nonnegative(r * bound - Fraction(size, ONE), failure)
        yield from contraction(
            cell.P, cell.corners, cell.disturbance, cell.rate, cell.multiplier, where
        )


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


def _holds(rows: list[list[Interval]], low: Rows, high: Rows) -> bool:
    return all(
        entry.within(least, most)
        for row, lows, highs in zip(rows, low, high, strict=True)
        for entry, least, most in zip(row, lows, highs, strict=True)
    )
