r"""The closed loop u = -sum_j h_j K_j x as a double sum, with Q = P^-1 and M_j = K_j Q.

    continuous   Theta_ij = He(A_i Q - B_i M_j) + 2 alpha Q
    discrete     Theta_ij = [ -rho^2 Q         *  ]
                            [ A_i Q - B_i M_j  -Q ],     rho = e^(-alpha T)

sum_ij h_i h_j Theta_ij < 0 gives V' <= -2 alpha V, or V(x+) <= rho^2 V(x), for V = x' P x.

Source: Tanaka and Wang (2001), section 3.3 and theorem 12.
"""

from __future__ import annotations

import numpy as np

from takagi.lmi.condition.term import Array
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.sums.corner_rules import Corners
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.lmi.sums.summands import Member, SumPart
from takagi.models.arrays import Floats

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


def gain_member(M: Unknown) -> Member:
    """Return which member of M appears in Theta_ij."""
    return "first" if M.count == 1 else "gain"


def gain_symbol(M: Unknown) -> str:
    """Return M or M_j, as LaTeX for a ``SumPart``."""
    return M.symbol if M.count == 1 else f"{M.symbol}_{{j}}"


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
    """Return the module's double sum; alpha is the parameter ``alpha``, rho^2 ``contraction``.

    Parameters
    ----------
    A, B : (r, n, n), (r, n, m).
    Q, M : unknowns; M has r members, or one for a gain that all rules share.
    weight : margin of Theta for a margin 1 of Q.
    discrete : x+ = A x + B u in the place of x' = A x + B u.
    corners : as in ``DoubleSum``.
    """
    r, n = A.shape[:2]
    eye = np.eye(n)[None]
    motion_block = (1, 0) if discrete else (0, 0)
    parts = [
        SumPart(
            unknown=Q,
            left=A,
            right=eye,
            at=motion_block,
            plus_transpose=not discrete,
            latex=("A_{i}", ""),
        ),
        SumPart(
            unknown=M,
            left=-B,
            right=eye,
            at=motion_block,
            plus_transpose=not discrete,
            member=gain_member(M),
            latex=("-B_{i}", ""),
            symbol=gain_symbol(M),
        ),
    ]
    if discrete:
        parts += [
            SumPart(
                unknown=Q, left=-eye, right=eye, parameter="contraction", latex=(r"-\rho^2", "")
            ),
            SumPart(unknown=Q, left=-eye, right=eye, at=(1, 1), latex=("-", "")),
        ]
    else:
        parts.append(
            SumPart(unknown=Q, left=2.0 * eye, right=eye, parameter="alpha", latex=(r"2\alpha", ""))
        )
    return DoubleSum(
        rules=r,
        blocks=(n, n) if discrete else (n,),
        parts=tuple(parts),
        weight=weight,
        corners=corners,
    )
