"""Search of cells: a centre, a box and a P with which the loop of a published law contracts.

The search uses floating point; its result is a candidate that the checker decides.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from takagi.certificates.claims.turbine.published_cells import (
    ExactLoop,
    PublishedCell,
    disturbance_bound,
    enclosed_cell,
    wind_breaks,
)
from takagi.lmi.analysis.invariant_ellipsoid import contraction, lyapunov_candidates
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError
from takagi.models.laws.published.law import Equilibrium, PublishedLaw, equilibrium

Span = tuple[float, float]

# Half widths of the set in rotor speed [rad/s]: the starting value, and those to grow to.
STARTS = (0.001, 0.0005)
LARGER = (0.002, 0.005, 0.015)
# A proved decay rate suffices at this fraction of the slowest rate at the equilibrium.
BRISK = 0.1
# Scales that make the states comparable: rad/s, rad, rad, rad.
UNITS = np.array([0.01, 0.01, 0.1, 0.1])
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
    """The law, its loop, and the equilibria found so far.

    ``ladder``: half widths in speed [rad/s] to try from the largest down, until one contracts at
    ``BRISK`` of the slowest rate of the loop at its equilibrium; empty takes the first of
    ``STARTS`` and enlarges it as far as possible.
    """

    law: PublishedLaw
    loop: ExactLoop
    narrowest: float
    ladder: tuple[float, ...] = ()
    points: dict[float, Equilibrium] = field(default_factory=dict)

    @classmethod
    def of(
        cls, law: PublishedLaw, *, narrowest: float = NARROWEST, ladder: tuple[float, ...] = ()
    ) -> PublishedSearch:
        return cls(law, ExactLoop.of(law), narrowest, ladder)

    def rest(self, wind: float) -> Equilibrium:
        """Return the equilibrium, computed once."""
        if wind not in self.points:
            self.points[wind] = equilibrium(self.law, wind)
        return self.points[wind]

    def cell(self, wind: tuple[float, float]) -> FoundCell | Unproved:
        """Return a cell with P, or why there is none."""
        ends = [self.rest(v) for v in wind]
        without = [point for point in ends if point.kind in ("none", "continuum")]
        if without:
            return Unproved(wind, _without(without[0]), hopeless=len(without) == len(ends))
        centre = np.round(
            [[p.rotor_speed, max(p.pitch, self.law.turbine.pitch_min), *p.integrals] for p in ends],
            CENTRE_DIGITS,
        )
        return self._around(wind, centre, _kind(ends))

    def _around(self, wind: tuple[float, float], centre: Floats, kind: str) -> FoundCell | Unproved:
        units = UNITS[: centre.shape[1]]
        try:
            bound = disturbance_bound(self.loop, wind, centre)
            probe = enclosed_cell(self.loop, wind, centre, units * PROBE, bound)
        except ModelError as error:
            return Unproved(wind, str(error))
        # All units of the probe are scaled equally, which does not change A.
        middle = (probe.low + probe.high) / 2
        candidates = lyapunov_candidates(middle)
        if not candidates:
            return Unproved(wind, "the loop is not stable where it rests")

        def sized(size: float) -> FoundCell | None:
            for P in candidates:
                try:
                    contracting = self._with(wind, centre, units, P, size, bound)
                except ModelError:
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
        self,
        wind: tuple[float, float],
        sized: Callable[[float], FoundCell | None],
        slowest: float,
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
        cell = enclosed_cell(self.loop, wind, centre, box, bound)
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
    breaks = wind_breaks(search.loop, *winds)
    for low, high in zip(breaks, breaks[1:], strict=False):
        count = max(1, int(np.ceil((high - low) / WIDEST - 1e-9)))
        nodes = [float(v) for v in np.round(np.linspace(low, high, count + 1), 9)]
        for wind in zip(nodes, nodes[1:], strict=False):
            yield from _halved(search, wind)


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


def _without(point: Equilibrium) -> str:
    if point.kind == "none":
        return f"no equilibrium at {point.wind:.6g} m/s"
    return f"a continuum of equilibria at {point.wind:.6g} m/s"


def _kind(ends: list[Equilibrium]) -> str:
    kinds = {point.kind for point in ends}
    return kinds.pop() if len(kinds) == 1 else "shifted"


def merged(spans: Sequence[Span], *, reach: float = 0.0) -> list[Span]:
    """Return the union as disjoint ranges, in order; those at most ``reach`` apart become one."""
    union: list[Span] = []
    for low, high in sorted(spans):
        if union and low <= union[-1][1] + reach:
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
