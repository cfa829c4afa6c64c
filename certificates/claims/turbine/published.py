"""The claim about a published law, and the cells it is made of.

Nothing is proved here.  The result is a candidate; ``takagi.certificates.checker`` decides.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from takagi.certificates.claims.turbine.published_search import (
    NARROWEST,
    FoundCell,
    PublishedSearch,
    Span,
    Unproved,
    merged,
    search_cells,
)
from takagi.models.laws.protocol import law_words
from takagi.models.laws.published.law import Equilibrium, PublishedLaw
from takagi.models.laws.published.regional_schedule import CouplingFilter
from takagi.models.ramps import Ramp


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
    narrowest: float | None = None,
    ladder: tuple[float, ...] = (),
) -> PublishedCandidate:
    """Return cells in which the loop with a published law contracts, at constant winds.

    Parameters
    ----------
    winds : ranges [m/s]; None takes cut-in to cut-out.
    narrowest : a failing cell is halved down to this width [m/s]; None takes the default.
    ladder : half widths in speed [rad/s] of the sets to try, from the largest down; empty takes a
        small one and grows it as far as it goes.

    Raises
    ------
    ModelError : a law that no claim covers (another filter, gains that depend on the premise d).
    """
    width = NARROWEST if narrowest is None else narrowest
    search = PublishedSearch.of(law, narrowest=width, ladder=ladder)
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
    start = _short(law.speed_setpoint - below * speed_overlap, 12)
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


def _short(value: float, digits: int = 9) -> float:
    return float(f"{value:.{digits}g}")
