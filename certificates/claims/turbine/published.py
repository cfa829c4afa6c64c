"""The claim about a published law, and the cells it is made of.

Nothing is proved here.  The result is a candidate; ``takagi.certificates.checker`` decides.

Search of cells: a centre, a box and a P with which the loop of a published law contracts.

Ranges of the loop are the checker's; P is sought in floating point.  The checker decides.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeVar

import numpy as np

from takagi.certificates.checker.arithmetic.interval import ONE
from takagi.certificates.checker.kernel.refusal import CertificateError, Refused
from takagi.certificates.checker.turbine.published.inputs import PublishedLaw as CheckedLaw
from takagi.certificates.checker.turbine.published.loop import Ends, field_at_centre, jacobians
from takagi.certificates.checker.turbine.rotor import Plant
from takagi.certificates.document.certificate_file import published_law_data, turbine_data
from takagi.certificates.document.model_data import as_read
from takagi.lmi.analysis.invariant_ellipsoid import contraction, lyapunov_candidates
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.intervals.interval import exact
from takagi.models.laws.protocol import law_words
from takagi.models.laws.published.law import Equilibrium, PublishedLaw, equilibrium
from takagi.models.laws.published.regional_schedule import CouplingFilter
from takagi.models.ramps import Ramp
from takagi.models.turbine.data import Turbine

Span = tuple[float, float]
End = TypeVar("End", float, Fraction)

# Half widths of the set in rotor speed [rad/s]: the starting value, and those to grow to.
STARTS = (0.001, 0.0005)
LARGER = (0.002, 0.005, 0.015)
# A proved decay rate suffices at this fraction of the slowest rate at the equilibrium.
BRISK = 0.1
# Scales that make the states comparable: rad/s, rad, rad, rad.
UNITS = np.array([0.01, 0.01, 0.1])
# Size of a tiny box, whose enclosure gives the matrix for which candidates of P are computed.
PROBE = 1e-6
NARROWEST = 0.002
# Without an equilibrium at either end, cells smaller than this are not examined [m/s].
HOPELESS = 0.1
WIDEST = 0.5
CENTRE_DIGITS = 9
BOX_DIGITS = 3
P_DIGITS = 6
RESERVE = 0.97
# Winds are decimals: their differences meet a width up to rounding alone.
ROUNDED = 1 - 1e-9


# Decimals of the stated ranges.
EMITTED_DIGITS = 7


@dataclass(frozen=True, slots=True, eq=False)
class PublishedCell:
    """Ranges of the loop over one cell, in units of the box.

    Attributes
    ----------
    wind : (v_1, v_2) [m/s].
    centre : (2, n) z_0 at both winds;  box : (n,) r.  Units rad/s, rad, rad.
    low, high : (corners, n, n) [1/s].
    disturbance : (n,) bound on |d_i| / r_i [1/s].
    """

    wind: Span
    centre: Floats
    box: Floats
    low: Floats
    high: Floats
    disturbance: Floats


@dataclass(frozen=True, slots=True, eq=False)
class FoundCell:
    """A candidate cell: enclosures, P in units of the box, rates, kind of equilibrium."""

    cell: PublishedCell
    P: Floats
    decay_rate: float
    multiplier: float
    rest: str


@dataclass(frozen=True, slots=True)
class Unproved:
    """A range of winds without a cell, the reason, and whether to skip narrower ranges."""

    wind: tuple[float, float]
    reason: str
    hopeless: bool = False


@dataclass(slots=True, eq=False)
class PublishedSearch:
    """The law, its numbers, and the equilibria found so far.

    ``ladder``: half widths in speed [rad/s] to try from the largest down, until one contracts at
    ``BRISK`` of the slowest rate of the loop at its equilibrium; empty takes the first of
    ``STARTS`` and enlarges it as far as possible.
    """

    law: PublishedLaw
    plant: Plant
    stated: CheckedLaw
    narrowest: float
    ladder: tuple[float, ...] = ()
    points: dict[float, Equilibrium] = field(default_factory=dict)

    @classmethod
    def of(
        cls, law: PublishedLaw, *, narrowest: float = NARROWEST, ladder: tuple[float, ...] = ()
    ) -> PublishedSearch:
        """Return the search; turbine and law are read as the checker reads them.

        Raises
        ------
        ModelError : a law that no claim covers.
        """
        limit, torque = law.turbine.rated_torque, law.coupling.rated_torque
        if torque != limit:
            raise ModelError(
                f"the filter holds torque at {torque:.6g} N m, the turbine's limit is {limit:.6g} "
                "N m; a claim needs them equal"
            )
        return cls(law, _plant(law.turbine), _stated(law), narrowest, ladder)

    def enclosed(self, wind: Span, centre: Floats, box: Floats, field: Floats) -> PublishedCell:
        """Return the loop's ranges over one cell, in short decimals; ``field`` is at the centre.

        Raises
        ------
        Refused : the box leaves the coefficient table or may demand more than the pitch rate
            limit, or an integral gain may vanish in it.
        """
        ends = _ends(wind, centre, box)
        matrices = jacobians(self.plant, self.stated, self.stated.overlaps, ends)
        scale = 10**EMITTED_DIGITS
        low = [[[e.low * scale // ONE for e in row] for row in rows] for rows in matrices]
        high = [[[-(-e.high * scale // ONE) for e in row] for row in rows] for rows in matrices]
        disturbance = np.ceil((field / box + 1e-6) * scale) / scale
        lowest, highest = np.array(low) / scale, np.array(high) / scale
        return PublishedCell(wind, centre, box, lowest, highest, disturbance)

    def field_at(self, wind: Span, centre: Floats) -> Floats:
        """Return (n,) bounds of |f_i(z_0(v), v)| over the cell, in SI units."""
        ends = _ends(wind, centre, np.zeros(centre.shape[1]))
        sizes = field_at_centre(self.plant, self.stated, self.stated.overlaps, ends)
        return np.array([size / ONE for size in sizes])

    def rest(self, wind: float) -> Equilibrium:
        """Return the equilibrium, computed once."""
        if wind not in self.points:
            self.points[wind] = equilibrium(self.law, wind)
        return self.points[wind]

    def cell(self, wind: tuple[float, float]) -> FoundCell | Unproved:
        """Return a cell with P, or why there is none."""
        ends = [self.rest(v) for v in wind]
        without = [point for point in ends if point.kind == "none"]
        if without:
            reason = f"no equilibrium at {without[0].wind:.6g} m/s"
            return Unproved(wind, reason, hopeless=len(without) == len(ends))
        centre = np.round(
            [[p.rotor_speed, max(p.pitch, self.law.turbine.pitch_min), p.integral] for p in ends],
            CENTRE_DIGITS,
        )
        kinds = {point.kind for point in ends}
        return self._around(wind, centre, kinds.pop() if len(kinds) == 1 else "shifted")

    def _around(self, wind: tuple[float, float], centre: Floats, kind: str) -> FoundCell | Unproved:
        try:
            bound = self.field_at(wind, centre)
            probe = self.enclosed(wind, centre, UNITS * PROBE, bound)
        except Refused as error:
            return Unproved(wind, str(error))
        # All units of the probe are scaled equally, which does not change A.
        middle = (probe.low + probe.high) / 2
        candidates = lyapunov_candidates(middle)
        if not candidates:
            return Unproved(wind, "the loop is not stable where it rests")

        def sized(size: float) -> FoundCell | None:
            for P in candidates:
                try:
                    contracting = self._with(wind, centre, UNITS, P, size, bound)
                except Refused:
                    # This box leaves the range that can be enclosed; another shape may stay inside.
                    continue
                if contracting is not None:
                    return FoundCell(*contracting, kind)
            return None

        if self.ladder:
            slowest = -max(np.linalg.eigvals(A).real.max() for A in middle)
            return self._laddered(wind, sized, slowest)
        best: FoundCell | None = None
        for size in STARTS:
            best = best or sized(size)
        if best is None:
            return Unproved(wind, "no quadratic function contracts on the boxes that were tried")
        for size in LARGER:
            larger = sized(size)
            if larger is None:
                return best
            best = larger
        return best

    def _laddered(
        self, wind: tuple[float, float], sized: Callable[[float], FoundCell | None], slowest: float
    ) -> FoundCell | Unproved:
        best: FoundCell | None = None
        for size in self.ladder:
            candidate = sized(size)
            if candidate is not None and (best is None or candidate.decay_rate > best.decay_rate):
                best = candidate
            if best is not None and best.decay_rate >= BRISK * slowest:
                break
        if best is not None:
            return best
        return Unproved(
            wind,
            f"stable where it rests (slowest at {slowest:.2g} 1/s), but no quadratic function "
            f"contracts on sets of {self.ladder[-1]:g} to {self.ladder[0]:g} rad/s in speed",
        )

    def _with(
        self,
        wind: tuple[float, float],
        centre: Floats,
        units: Floats,
        P: Floats,
        size: float,
        bound: Floats,
    ) -> tuple[PublishedCell, Floats, float, float] | None:
        extent = np.sqrt(np.diag(np.linalg.inv(P)))
        box = units * extent / (units[0] * extent[0]) * size
        box = np.array([float(f"{r:.{BOX_DIGITS}g}") for r in box])
        cell = self.enclosed(wind, centre, box, bound)
        scaled = P * np.outer(box / units, box / units)
        # The set touches the box in its tightest direction, up to a small margin for rounding.
        scaled *= np.diag(np.linalg.inv(scaled)).max() * (1 + 1e-5)
        scaled = np.round(scaled, P_DIGITS)
        if np.linalg.eigvalsh(scaled)[0] <= 0:
            return None
        proof = contraction(scaled, cell.low, cell.high, cell.disturbance)
        if proof is None:
            return None
        rate = np.floor(RESERVE * proof.decay_rate * 1e7) / 1e7
        alpha = np.round(proof.multiplier, 9)
        return (cell, scaled, float(rate), float(alpha)) if rate > 0 else None


def search_cells(
    search: PublishedSearch, winds: tuple[float, float]
) -> Iterator[FoundCell | Unproved]:
    """Yield cells over a range of winds, halved where they fail, down to the narrowest."""
    breaks = wind_breaks(search.stated, search.plant.radius, *winds)
    for low, high in zip(breaks, breaks[1:], strict=False):
        count = max(1, int(np.ceil((high - low) / WIDEST - 1e-9)))
        nodes = [float(v) for v in np.round(np.linspace(low, high, count + 1), 9)]
        for wind in zip(nodes, nodes[1:], strict=False):
            yield from _halved(search, wind)


def wind_breaks(law: CheckedLaw, radius: Fraction, low: float, high: float) -> list[float]:
    """Return the winds between which tables and reference speed are smooth, ends included.

    Where the reference speed bends is not a decimal: two breaks enclose such a wind.
    """
    nodes = {float(v) for v in (*law.partial.wind, *law.full.wind)}
    for speed, ratio in (
        (law.minimum_speed, law.optimal_ratio),
        (law.setpoint, law.optimal_ratio),
        (law.minimum_speed, law.largest_ratio),
    ):
        bend = float(speed * radius / ratio)
        nodes |= {math.floor(bend * 1e6) / 1e6, math.ceil(bend * 1e6) / 1e6}
    return sorted({low, high, *(v for v in nodes if low < v < high)})


@lru_cache(maxsize=4)
def _plant(turbine: Turbine) -> Plant:
    return Plant.read(as_read(turbine_data(turbine, ()), "model"))


@lru_cache(maxsize=1)
def _stated(law: PublishedLaw) -> CheckedLaw:
    try:
        return CheckedLaw.read(as_read(published_law_data(law), "gains"))
    except CertificateError as error:
        raise ModelError(f"no claim can be made of this law: {error}") from error


def _ends(wind: Span, centre: Floats, box: Floats) -> Ends:
    first, last = ([exact(z) for z in row] for row in centre.tolist())
    return Ends((exact(wind[0]), exact(wind[1])), (first, last), [exact(r) for r in box.tolist()])


def _halved(search: PublishedSearch, wind: tuple[float, float]) -> Iterator[FoundCell | Unproved]:
    result = search.cell(wind)
    low, high = wind
    narrowest = search.narrowest
    if isinstance(result, Unproved) and result.hopeless:
        narrowest = max(narrowest, HOPELESS / 2)
    if isinstance(result, FoundCell) or high - low < 2 * narrowest * ROUNDED:
        yield result
        return
    middle = round((low + high) / 2, 9)
    yield from _halved(search, (low, middle))
    yield from _halved(search, (middle, high))


def merged(spans: Sequence[tuple[End, End]]) -> list[tuple[End, End]]:
    """Return the union as disjoint ranges, in order."""
    union: list[tuple[End, End]] = []
    for low, high in sorted(spans):
        if union and low <= union[-1][1]:
            union[-1] = union[-1][0], max(high, union[-1][1])
        else:
            union.append((low, high))
    return union


def gaps(span: Span, covered: Sequence[Span]) -> list[Span]:
    """Return the parts of a range outside ``covered``, whose ranges are disjoint and ordered."""
    low, outside = span[0], []
    for start, stop in covered:
        if stop <= low or start >= span[1]:
            continue
        if start > low:
            outside.append((low, start))
        low = stop
    return [*outside, (low, span[1])] if low < span[1] else outside


@dataclass(frozen=True, slots=True, eq=False)
class PublishedCandidate:
    """The unproved results for a law over some winds.

    Attributes
    ----------
    winds : the ranges that were asked for [m/s].
    cells : those found;  unproved : ranges without a cell, each with a reason.
    rests : wind [m/s] -> the equilibrium, at the ends of all cells examined.
    """

    law: PublishedLaw
    winds: tuple[Span, ...]
    cells: tuple[FoundCell, ...]
    unproved: tuple[Unproved, ...]
    rests: Mapping[float, Equilibrium] = field(default_factory=dict)

    @property
    def covered(self) -> list[Span]:
        """The winds of the cells, as disjoint ranges [m/s]."""
        return merged([found_cell.cell.wind for found_cell in self.cells])


def published_candidate(
    law: PublishedLaw,
    *,
    winds: Sequence[Span] | None = None,
    narrowest: float = NARROWEST,
    ladder: tuple[float, ...] = (),
) -> PublishedCandidate:
    """Return cells in which the loop with a published law contracts, at constant winds.

    Parameters
    ----------
    winds : ranges [m/s]; None takes cut-in to cut-out.
    narrowest : a failing cell is halved down to this width [m/s].
    ladder : half widths in speed [rad/s] of the sets to try, from the largest down; empty takes a
        small one and grows it as far as it goes.

    Raises
    ------
    ModelError : a law that no claim covers (another filter, gains that depend on the premise d).
    """
    search = PublishedSearch.of(law, narrowest=narrowest, ladder=ladder)
    spans = tuple(winds) if winds else ((law.turbine.cut_in, law.turbine.cut_out),)
    results = [cell for span in spans for cell in search_cells(search, span)]
    return PublishedCandidate(
        law,
        spans,
        tuple(cell for cell in results if isinstance(cell, FoundCell)),
        tuple(cell for cell in results if isinstance(cell, Unproved)),
        search.points,
    )


def with_overlaps(
    law: PublishedLaw, *, speed_overlap: float, torque_overlap: float
) -> PublishedLaw:
    """Return the law with other overlaps [rad/s, N m]; the ramp keeps its placement."""
    old: CouplingFilter = law.coupling
    ramp = old.speed_ramp
    below = (law.speed_setpoint - ramp.start) / ramp.width
    start = float(f"{law.speed_setpoint - below * speed_overlap:.12g}")
    coupling = replace(
        old,
        speed_ramp=Ramp(start, speed_overlap, ramp.shape),
        torque_overlap=torque_overlap,
        minimum_torque=old.rated_torque - torque_overlap,
    )
    return replace(law, coupling=coupling)


def published_claim(candidate: PublishedCandidate) -> dict[str, Any]:
    """Return the claim as plain data; numbers are decimals, written as they are proved."""
    coupling = candidate.law.coupling
    return {
        "name": f"{law_words(candidate.law.name)}, "
        f"speed overlap {coupling.speed_ramp.width:g} rad/s, "
        f"torque overlap {coupling.torque_overlap:g} N m",
        "kind": "paper-loop",
        "state": ["rotor speed [rad/s]", "pitch [rad]", *candidate.law.state_names],
        "speed_ramp_start": coupling.speed_ramp.start,
        "speed_overlap": coupling.speed_ramp.width,
        "torque_overlap": coupling.torque_overlap,
        "winds": [list(span) for span in candidate.winds],
        "cells": [_cell(found_cell) for found_cell in candidate.cells],
        "unproved": [
            {"wind": list(gap.wind), "reason": gap.reason} for gap in _joined(candidate.unproved)
        ],
    }


def _cell(found_cell: FoundCell) -> dict[str, Any]:
    cell = found_cell.cell
    return {
        "wind": list(cell.wind),
        "rest": found_cell.rest,
        "centre": cell.centre.tolist(),
        "box": cell.box.tolist(),
        "P": found_cell.P.tolist(),
        "corners": [
            {"low": low.tolist(), "high": high.tolist()}
            for low, high in zip(cell.low, cell.high, strict=True)
        ],
        "disturbance": cell.disturbance.tolist(),
        "decay_rate": found_cell.decay_rate,
        "multiplier": found_cell.multiplier,
    }


def _joined(gaps: Sequence[Unproved]) -> list[Unproved]:
    """Return adjacent ranges joined, with the reason of the first."""
    joined: list[Unproved] = []
    for gap in sorted(gaps, key=lambda g: g.wind):
        if joined and gap.wind[0] <= joined[-1].wind[1]:
            joined[-1] = Unproved((joined[-1].wind[0], gap.wind[1]), joined[-1].reason)
        else:
            joined.append(gap)
    return joined
