"""The largest wind error of every cell of the effort-sharing loop with one quadratic function.

The result is a floating-point candidate, which the checker proves or refuses.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from takagi.certificates.claims.turbine.cell_loop import CellLoop
from takagi.certificates.claims.turbine.wind_class import RESERVE, cell_class
from takagi.lmi.analysis.decay_rate import fast_decay
from takagi.lmi.analysis.invariant_ellipsoid import decay_rates
from takagi.models.arrays import Floats
from takagi.models.laws.effort_sharing.loop_cell import (
    LoopBox,
    LoopCell,
    LoopUncertainty,
    LoopVertices,
    loop_vertices,
)

Tell = Callable[[str], None]

# P is increased by this factor, so that the set stays inside the box after rounding.
SHRINK = 1 + 1e-5


@dataclass(frozen=True, slots=True, eq=False)
class EffortSharingCandidate:
    """All data of a claim, in floating point except the enclosures.

    Attributes
    ----------
    cells : the enclosed loops.
    P : (3, 3) in (e, zeta, x), or None where no common P was found.
    multipliers, wind_error, wind_rate, decay_rate : one per cell; a cell without a candidate has
        wind class and decay 0.
    common_rate : the largest decay rate of one quadratic function over all cells [1/s], and
        settling_P : (3, 3) that function; both for constant wind.
    diagnosis : why there is no P, in words.
    words : the solver's.
    """

    box: LoopBox
    uncertainty: LoopUncertainty
    cells: tuple[LoopCell, ...]
    P: Floats | None
    multipliers: Floats
    wind_error: Floats
    wind_rate: Floats
    decay_rate: Floats
    settling_P: Floats
    common_rate: float
    diagnosis: str
    words: str

    @classmethod
    def without(
        cls,
        box: LoopBox,
        uncertainty: LoopUncertainty,
        cells: Sequence[LoopCell],
        *,
        diagnosis: str,
        words: str = "",
    ) -> EffortSharingCandidate:
        """Return a candidate without a P: nothing is claimed of any cell."""
        none = np.zeros(len(cells))
        return cls(
            box=box,
            uncertainty=uncertainty,
            cells=tuple(cells),
            P=None,
            multipliers=none,
            wind_error=none,
            wind_rate=none,
            decay_rate=none,
            settling_P=np.eye(3),
            common_rate=0.0,
            diagnosis=diagnosis,
            words=words,
        )


@dataclass(frozen=True, slots=True, eq=False)
class RequestedLoops:
    """The enclosures of all cells, and the requested wind class of each.

    Attributes
    ----------
    cells : one enclosure per wind cell.
    rates : |v_s'| to try [m/s^2];  error : (K - 1,) |v - v_s| to compare with [m/s].
    """

    box: LoopBox
    uncertainty: LoopUncertainty
    cells: Sequence[CellLoop]
    rates: Sequence[Fraction]
    error: Floats


def largest_wind_errors(
    P: Floats, loops: RequestedLoops, *, words: str = "", tell: Tell | None = None
) -> EffortSharingCandidate:
    """Return for every cell the largest wind error with P, and the decay rate at constant wind.

    Parameters
    ----------
    P : (3, 3), its set inside the box; its decimals are those that a claim states.
    words : the solver's, on P.
    tell : called with a word on progress.
    """
    stated = np.round(P * SHRINK, 4)
    classes = [
        cell_class(stated, *each)
        for each in zip(loops.cells, loops.rates, loops.error, strict=True)
    ]
    corners = [loop_vertices(each.cell) for each in classes]
    if tell is not None:
        tell("the largest common decay rate")
    settling, common = _settling(stated, corners)
    decay = [max(float(decay_rates(stated, v.at_rest).min()), 0.0) for v in corners]
    return EffortSharingCandidate(
        box=loops.box,
        uncertainty=loops.uncertainty,
        cells=tuple(each.cell for each in classes),
        P=stated,
        multipliers=np.array([round(each.multiplier, 7) for each in classes]),
        wind_error=np.array([each.wind_error for each in classes]),
        wind_rate=np.array([float(each.cell.wind_rate) for each in classes]),
        decay_rate=np.floor(RESERVE * np.array(decay) * 1e5) / 1e5,
        settling_P=settling,
        common_rate=common,
        diagnosis="",
        words=words,
    )


def _settling(P: Floats, corners: list[LoopVertices]) -> tuple[Floats, float]:
    """Return the quadratic function with the largest decay rate over all corners, and the rate.

    The largest rate is a generalised eigenvalue problem; if it fails, P itself is used.
    """
    A = np.concatenate([v.at_rest for v in corners])
    answer = fast_decay(A)
    candidate = P if answer.P is None else np.asarray(answer.P)
    # The smallest eigenvalue becomes 1000, so three decimals leave P definite and accurate.
    rounded = np.round(candidate * (1e3 / np.linalg.eigvalsh(candidate)[0]), 3)
    rate = RESERVE * float(decay_rates(rounded, A).min())
    return rounded, max(math.floor(rate * 1e6) / 1e6, 0.0)
