"""The closed loop as double sums: its motion, pole regions, uncertain models.

The closed loop u = -sum_j h_j K_j x as a double sum, with Q = P^-1 and M_j = K_j Q.

    continuous   Theta_ij = He(A_i Q - B_i M_j) + 2 alpha Q
    discrete     Theta_ij = [ -rho^2 Q         *  ]
                            [ A_i Q - B_i M_j  -Q ],     rho = e^(-alpha T)

sum_ij h_i h_j Theta_ij < 0 gives V' <= -2 alpha V, or V(x+) <= rho^2 V(x), for V = x' P x.

Source: Tanaka and Wang (2001), section 3.3 and theorem 12.

Regions of the complex plane for closed loops, as double sums: one for each part of a region.

With Q = P^-1, M_j = K_j Q and G_ij = A_i Q - B_i M_j, a part {z : L + z M + conj(z) M' < 0} asks

    Theta_ij = L (x) Q + M (x) G_ij + M' (x) G_ij',     sum_ij h_i h_j Theta_ij < 0,

which is I (x) Q times the analysis condition times I (x) Q.  For constant memberships,
every eigenvalue of sum_ij h_i h_j (A_i - B_i K_j) then lies in the region.  Where they move,
the part says what its quadratic function says: a half-plane Re z < -alpha that V' <= -2 alpha V;
in discrete time a disc |z| < rho that V(x+) <= rho^2 V(x).

Source: Chilali and Gahinet (1996), IEEE Trans. Automatic Control 41(3), for one rule.

A double sum made robust against norm-bounded uncertainty of the model.

A double sum in which the loop G_ij = A_i Q - B_i M_j stands as C (x) G_ij + C' (x) G_ij', with a
known matrix C over its blocks (the carrier), becomes that of the uncertain model

    A_i + D_i Delta E_i,   B_i + D_i Delta F_i,   |Delta| <= 1,

when He((C_L (x) D_i) (I (x) Delta) (C_R (x) W_ij)) is added, C = C_L C_R, W_ij = E_i Q - F_i M_j.
For every S > 0 of the size of C_L's columns, which commutes with the repeated Delta, that is at
most (C_L S C_L') (x) D D' + (C_R' S^-1 C_R) (x) W' W.  With all of it affine in the blend,

    [ Theta_ij              *            *         ]
    [ (S C_L') (x) D_i'     -S (x) I_p   *         ]     in the place of Theta_ij,
    [ C_R (x) W_ij          0            -S (x) I_q ]

and a multiplier S of its own for each block of the uncertainty.  For a carrier of rank one (decay,
a disc, discrete time) S is a number; for a sector it is 2 x 2.  Where D is the same in all rules S
may change with the vertex's rule, for sum_i h_i S_i then stands where S did; otherwise it is one.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), chapter 7, for one gain; Chilali, Gahinet and
Apkarian (1999), IEEE Trans. Automatic Control 44(12), for regions.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.pole_region import region_block, region_weight
from takagi.lmi.argument_checks import decay_parameter
from takagi.lmi.condition.region import (
    EigenvalueRegion,
    RegionPart,
    Uncertainty,
    UncertaintyBlock,
    blocks_of,
)
from takagi.lmi.condition.term import Array
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.expressions.expression import (
    Expression,
    He,
    block,
    identity,
    matrix,
    symmetric_block,
)
from takagi.lmi.sums.corner_rules import Corners
from takagi.lmi.sums.double_sum import DoubleSum, double_sum_of
from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError

# Of the input on x' P x <= 1, what a gain that moves no more of it is: rounding.
ROUNDING = 1e-9


def without_rounding(K: Floats, Q: Floats) -> Floats:
    """Return K_i (r, m, n) with zeros for entries that are rounding beside others of their row.

    Parameters
    ----------
    Q : P^-1; an entry moves the input by |K_ij| sqrt(Q_jj) on x' P x <= 1.
    """
    effects = np.abs(K) * np.sqrt(np.abs(np.diag(Q)))
    return np.where(effects < ROUNDING * effects.max(axis=-1, keepdims=True), 0.0, K)


def gain_unknown(r: int, m: int, n: int, relaxation: str) -> Unknown:
    """Return M: one member a rule, or a single one for the relaxation "common-gain"."""
    return Unknown("M", m, n, count=1 if relaxation == "common-gain" else r)


def closed_loop(
    A: Array,
    B: Array,
    Q: Unknown,
    M: Unknown,
    *,
    weight: float,
    discrete: bool = False,
    corners: Corners | None = None,
) -> DoubleSum:
    """Return the module's double sum; its rate is ``decay_parameter``, a condition's parameter.

    Parameters
    ----------
    A, B : (r, n, n), (r, n, m).
    Q, M : unknowns; M has r members, or one for a gain that all rules share.
    weight : margin of Theta for a margin 1 of Q.
    discrete : x+ = A x + B u in the place of x' = A x + B u.
    corners : as in ``DoubleSum``.
    """
    A_i, B_i = matrix(A, "A_{i}", over="i"), matrix(B, "B_{i}", over="i")
    G = A_i @ Q - B_i @ M.over("j")
    rate = decay_parameter(0.0, 1.0 if discrete else None)
    if discrete:
        theta = block([[-rate * Q, None], [G, -Q]])
    else:
        theta = He(G) + 2 * rate * Q
    return double_sum_of((theta << 0).named("", weight=weight), rules=len(A), corners=corners)


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
    L, C = (coefficients.astype(np.float64) for coefficients in part.matrices)
    A_i, B_i = matrix(A, "A_{i}", over="i"), matrix(B, "B_{i}", over="i")
    theta = region_block((L, C), Q, A_i @ Q - B_i @ M.over("j"))
    statement = (theta << 0).named(label, weight=region_weight(part, A))
    return double_sum_of(statement, rules=len(A), corners=corners)


def loop_carrier(loop: DoubleSum, *, discrete: bool = False) -> Array:
    """Return the carrier of ``closed_loop``, or of what has it in its first blocks.

    He(G_ij) in block (0, 0), or G_ij in block (1, 0) in discrete time.
    """
    carrier = np.zeros((len(loop.blocks),) * 2)
    carrier[(1, 0) if discrete else (0, 0)] = 1.0
    return carrier


def with_uncertainty(
    loop: DoubleSum,
    Q: Unknown,
    M: Unknown,
    uncertainty: Uncertainty,
    *,
    carrier: ArrayLike | None = None,
    discrete: bool = False,
) -> tuple[DoubleSum, tuple[Unknown, ...]]:
    """Return the module's double sum, for every |Delta_k| <= 1, and the multipliers it needs.

    Every relaxation applies to it.  The multipliers are positive by the LMI itself.

    Parameters
    ----------
    loop : a double sum that holds the loop as its carrier says.
    Q, M : its unknowns, u = -sum_j h_j M_j Q^-1 x.
    uncertainty : in the coordinates of the double sum.
    carrier : C, (blocks, blocks), nonzero only between blocks of n rows; None takes that of
        ``closed_loop``; a part of a region has its own M.
    discrete : for carrier None.

    Returns
    -------
    The double sum, and as unknowns of their own the entries on and above the diagonal of each
    block's S, named after the loop, with a member a rule where D is the same in all.  For more than
    one block or rule, or a carrier of a rank above one, it is sufficient only.

    Raises
    ------
    ModelError : uncertainty that does not fit the unknowns, a carrier that does not fit the loop.
    """
    C = loop_carrier(loop, discrete=discrete) if carrier is None else np.asarray(carrier, float)
    _check_carrier(C, loop, Q.rows)
    left, right = _factors(C)
    # The channels' rows are measured so that their multipliers weigh as much as the rest.
    unit = float(nearest_power(np.sqrt(loop.weight)))
    unknowns: tuple[Unknown, ...] = ()
    for k, channel in enumerate(blocks_of(uncertainty, loop.rules, Q.rows, M.rows), start=1):
        count = loop.rules if channel.enters_alike else 1
        entries = _multiplier(loop.name, k, left.shape[1], count)
        loop = _covered(
            loop=loop,
            Q=Q,
            M=M,
            channel=channel,
            entries=entries,
            left=left,
            right=right,
            unit=unit,
            k=k,
        )
        unknowns += tuple(S for (c, b), S in entries.items() if c <= b)
    return loop, unknowns


def _multiplier(loop: str, k: int, size: int, count: int) -> dict[tuple[int, int], Unknown]:
    """Return the entries of block k's S by row and column, (c, b) and (b, c) the same unknown."""
    prefix, where = (f"{loop}, ", rf"\text{{{loop}}}") if loop else ("", "")
    entries = {}
    for c in range(size):
        for b in range(c, size):
            entry_text = f"{c + 1}{b + 1}" if size > 1 else ""
            index = ",".join(word for word in (f"{k}", where, entry_text) if word)
            name = f"{prefix}sigma{k}" + (f"_{entry_text}" if entry_text else "")
            S = Unknown(name, 1, 1, count=count, latex=rf"\sigma^{{({index})}}")
            entries[c, b] = entries[b, c] = S
    return entries


def _check_carrier(C: Array, loop: DoubleSum, n: int) -> None:
    k = len(loop.blocks)
    if C.shape != (k, k) or not C.any():
        raise ModelError(
            f"the carrier has shape {C.shape}; ({k}, {k}) is needed, one row for each block of "
            "the double sum, and not zero"
        )
    bad = [b for b in {*np.nonzero(C)[0].tolist(), *np.nonzero(C)[1].tolist()}
           if loop.blocks[b] != n]  # fmt: skip
    if bad:
        raise ModelError(
            f"the carrier puts the loop in block {bad[0]}, which has {loop.blocks[bad[0]]} rows; "
            f"the loop has {n}"
        )


def _factors(C: Array) -> tuple[Array, Array]:
    """Return C_L and C_R with C = C_L C_R, one of them picking rows or columns: nothing rounds."""
    rows, columns = np.flatnonzero(C.any(axis=1)), np.flatnonzero(C.any(axis=0))
    eye = np.eye(len(C))
    if len(rows) <= len(columns):
        return eye[:, rows], C[rows]
    return C[:, columns], eye[columns]


def _covered(
    loop: DoubleSum,
    Q: Unknown,
    M: Unknown,
    channel: UncertaintyBlock,
    entries: dict[tuple[int, int], Unknown],
    left: Array,
    right: Array,
    unit: float,
    k: int,
) -> DoubleSum:
    """Return the double sum with the rows of one block of the uncertainty below it."""
    first, size = len(loop.blocks), left.shape[1]
    sizes = (*loop.blocks, *(channel.D.shape[2],) * size, *(channel.E.shape[1],) * size)
    D_i = matrix(channel.D, f"D_{{{k}{{i}}}}", over="i")
    W = matrix(channel.E, f"E_{{{k}{{i}}}}", over="i") @ Q
    if channel.F.any():
        W = W - matrix(channel.F, f"F_{{{k}{{i}}}}", over="i") @ M.over("j")
    S = {position: unknown.over("i") for position, unknown in entries.items()}
    cells: dict[tuple[int, int], Expression] = {}
    for a, b in np.ndindex(len(left), size):
        summands = [unit * float(left[a, c]) * (S[c, b] * D_i) for c in range(size) if left[a, c]]
        if summands:
            cells[a, first + b] = sum(summands[1:], summands[0])
    for c, b in np.argwhere(right).tolist():
        cells[first + size + c, b] = unit * float(right[c, b]) * W
    for c, b in ((c, b) for c, b in np.ndindex(size, size) if c <= b):
        for start in (first, first + size):
            cells[start + c, start + b] = -(unit**2) * (S[c, b] * identity(sizes[start]))
    added = double_sum_of(symmetric_block(sizes, cells) << 0, rules=loop.rules)
    return replace(loop, blocks=sizes, parts=(*loop.parts, *added.parts))
