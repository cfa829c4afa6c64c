r"""Regions of the complex plane for closed loops, as double sums: one for each part of a region.

With Q = P^-1, M_j = K_j Q and G_ij = A_i Q - B_i M_j, a part {z : L + z M + conj(z) M' < 0} asks

    Theta_ij = L (x) Q + M (x) G_ij + M' (x) G_ij',     sum_ij h_i h_j Theta_ij < 0,

which is I (x) Q times the analysis condition times I (x) Q.  For constant memberships,
every eigenvalue of sum_ij h_i h_j (A_i - B_i K_j) then lies in the region.  Where they move,
the part says what its quadratic function says: a half-plane Re z < -alpha that V' <= -2 alpha V;
in discrete time a disc |z| < rho that V(x+) <= rho^2 V(x).

Source: Chilali and Gahinet (1996), IEEE Trans. Automatic Control 41(3), for one rule.
"""

from __future__ import annotations

import numpy as np

from takagi.lmi.analysis.pole_region import coefficient_latex, region_weight
from takagi.lmi.condition.region import EigenvalueRegion, RegionPart
from takagi.lmi.condition.term import Array
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.gains.requirements.closed_loop import gain_member, gain_symbol
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.summands import SumPart
from takagi.models.arrays import Indices


def region_sums(
    A: Array,
    B: Array,
    Q: Unknown,
    M: Unknown,
    region: EigenvalueRegion,
    *,
    corners: Indices | None = None,
) -> tuple[DoubleSum, ...]:
    """Return the module's Theta_ij, one double sum for each part of the region, in its order.

    Every relaxation applies to each of them.  With uncertainty, give the part's M as the carrier:
    ``with_uncertainty(loop, Q, M, uncertainty, carrier=part.matrices[1])``.

    Parameters
    ----------
    A, B : (r, n, n), (r, n, m).
    Q, M : unknowns as in ``closed_loop``.
    region : in 1/s for x' = A x; of the eigenvalues of A itself for x+ = A x.
    corners : as in ``DoubleSum``.
    """
    return tuple(
        _region_sum(A, B, Q, M, part, label, corners)
        for part, label in zip(region.parts, region.labels, strict=True)
    )


def _region_sum(
    A: Array,
    B: Array,
    Q: Unknown,
    M: Unknown,
    part: RegionPart,
    label: str,
    corners: Indices | None,
) -> DoubleSum:
    L, C = (matrix.astype(np.float64) for matrix in part.matrices)
    k, n = len(L), A.shape[1]
    eye = np.eye(n)[None]
    parts = [
        SumPart(
            unknown=Q,
            left=L[a, b] * eye,
            right=eye,
            at=(a, b),
            latex=(coefficient_latex(L[a, b]), ""),
        )
        for a in range(k)
        for b in range(a, k)
        if L[a, b]
    ]
    for a, b in np.argwhere(C).tolist():
        parts += _moved(A, B, Q, M, float(C[a, b]), (a, b))
    return DoubleSum(
        rules=len(A),
        blocks=(n,) * k,
        parts=tuple(parts),
        weight=region_weight(part, A),
        name=label,
        corners=corners,
    )


def _moved(
    A: Array, B: Array, Q: Unknown, M: Unknown, factor: float, at: tuple[int, int]
) -> tuple[SumPart, SumPart]:
    """Return factor G_ij at a block; below the diagonal it stands for its transpose above."""
    scaled_eye = factor * np.eye(A.shape[1])[None]
    on_diagonal = at[0] == at[1]
    return (
        SumPart(
            unknown=Q,
            left=A,
            right=scaled_eye,
            at=at,
            plus_transpose=on_diagonal,
            latex=(f"{coefficient_latex(factor)}A_{{i}}", ""),
        ),
        SumPart(
            unknown=M,
            left=-B,
            right=scaled_eye,
            at=at,
            plus_transpose=on_diagonal,
            member=gain_member(M),
            latex=(f"{coefficient_latex(-factor)}B_{{i}}", ""),
            symbol=gain_symbol(M),
        ),
    )
