"""Requirements on a design in addition to decay, and its plants and memberships: as double sums."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.condition.region import EigenvalueRegion, NormBounded, blocks_of
from takagi.lmi.condition.term import LMI, Array
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.gains.requirements.closed_loop import region_sums, with_uncertainty
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.membership_shape import with_overlap


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Requirements:
    """Each None where nothing is required or known.

    Attributes
    ----------
    region : of the closed loop's eigenvalues, in 1/s; of x+ = A x without unit.
    uncertainty : blocks D Delta [E, F] of the model, in the coordinates of the condition.
    overlap : (r, r), bounds on h_i h_j.
    active_rules : at most this many rules act at a time.
    """

    region: EigenvalueRegion | None = None
    uncertainty: tuple[NormBounded, ...] | None = None
    overlap: ArrayLike | None = None
    active_rules: int | None = None

    def scaled(self, r: int, s: Array, tau: Array) -> Requirements:
        """Return them in x = s xhat, u = tau uhat; regions are the same in all units."""
        if self.uncertainty is None:
            return self
        blocks = blocks_of(self.uncertainty, r, len(s), len(tau))
        scaled_blocks = tuple(
            NormBounded(c.D, c.E, c.F) for c in (block.scaled(s, tau) for block in blocks)
        )
        return replace(self, uncertainty=scaled_blocks)


def required_sums(
    loop: DoubleSum,
    A: Array,
    B: Array,
    Q: Unknown,
    M: Unknown,
    requirements: Requirements,
    *,
    discrete: bool,
) -> tuple[tuple[DoubleSum, ...], tuple[Unknown, ...], tuple[LMI, ...]]:
    """Return all double sums, for every uncertainty and the memberships that are possible.

    Parameters
    ----------
    loop : that of the decay rate.
    A, B : (r, n, n), (r, n, m).
    Q, M : unknowns as in ``closed_loop``.
    discrete : x+ = A x + B u.

    Returns
    -------
    The double sums, the first that of the decay rate; unknowns and LMIs that they need besides
    what a relaxation adds.
    """
    sums: list[DoubleSum] = []
    unknowns: tuple[Unknown, ...] = ()
    lmis: tuple[LMI, ...] = ()
    for plain, carrier in _with_carriers(loop, A, B, Q, M, requirements.region):
        double_sum = plain
        # A part of a region without the loop in it, L < 0, is the same for every plant.
        if requirements.uncertainty is not None and (carrier is None or carrier.any()):
            double_sum, new_unknowns = with_uncertainty(
                double_sum, Q, M, requirements.uncertainty, carrier=carrier, discrete=discrete
            )
            unknowns += new_unknowns
        if requirements.overlap is not None or requirements.active_rules is not None:
            double_sum, new_unknowns, bounds = with_overlap(
                double_sum, requirements.overlap, active_rules=requirements.active_rules
            )
            unknowns, lmis = unknowns + new_unknowns, lmis + bounds
        sums.append(double_sum)
    return tuple(sums), unknowns, lmis


def _with_carriers(
    loop: DoubleSum, A: Array, B: Array, Q: Unknown, M: Unknown, region: EigenvalueRegion | None
) -> Iterator[tuple[DoubleSum, Array | None]]:
    yield loop, None
    if region is not None:
        parts = region_sums(A, B, Q, M, region, corners=loop.corners)  # type: ignore[arg-type]
        for double_sum, part in zip(parts, region.parts, strict=True):
            yield double_sum, np.asarray(part.matrices[1], dtype=np.float64)
