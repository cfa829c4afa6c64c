"""The closed loop as double sums, its motion and pole regions; modes that no input moves.

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
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from takagi.lmi.analysis.pole_region import region_block, region_weight
from takagi.lmi.argument_checks import decay_parameter, fixed_mode
from takagi.lmi.condition.region import EigenvalueRegion
from takagi.lmi.condition.term import Array
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import state_units
from takagi.lmi.expressions.expression import He, block, matrix
from takagi.lmi.sums.double_sum import DoubleSum, double_sum_of
from takagi.models.arrays import Floats, Indices
from takagi.models.errors import ModelError


def check_stabilisable(
    A: Array,
    B: Array,
    *,
    units: Array | float = 1.0,
    names: Sequence[str] = (),
    dual: bool = False,
    step: float | None = None,
) -> None:
    """Raise ModelError for a vertex with an undamped eigenvalue that no input can move.

    Undamped: Re >= 0, or |z| >= 1 in discrete time.

    Parameters
    ----------
    A, B : in states x = units xhat; they are balanced here, so that rounding means something.
    names : of the states; x1, x2, ... when empty.
    dual : write the message about outputs and observation instead.
    step : sample time T in s of a discrete-time model; None for continuous time.
    """
    A, B = A.astype(np.float64), B.astype(np.float64)
    s = state_units(A, None, step=step)
    A, B, units = A * s / s[:, None], B / s[:, None], units * s
    mode = fixed_mode(A, B / np.maximum(np.abs(B).max(axis=(0, 1)), 1e-300), 0.0, step=step)
    if mode is None:
        return
    vertex, eigenvalue, direction = mode
    labels = names or tuple(f"x{k}" for k in range(1, A.shape[1] + 1))
    state_shares = [
        f"{weight:+.3g} * {label}"
        for weight, label in zip(direction / units, labels, strict=True)
        # Smaller parts of the direction are rounding, and would only confuse the message.
        if abs(weight) > 1e-6 * np.abs(direction / units).max()
    ]
    verb, need = ("be seen in no output", "C") if dual else ("be moved by no input", "B")
    where = "" if step is None else ", not inside the unit circle,"
    raise ModelError(
        f"vertex {vertex + 1} of {len(A)}: the mode at {_number(eigenvalue)}{where} "
        f"({' '.join(state_shares)}) does not decay and can {verb}; change {need} or the box, so "
        "that it decays or can be reached"
    )


def _number(eigenvalue: complex) -> str:
    return f"{eigenvalue:.6g}" if eigenvalue.imag else f"{eigenvalue.real:.6g}"


# Of the input on x' P x <= 1, what a gain that moves no more of it is: rounding.
ROUNDING = 1e-9


def without_rounding(K: Floats, Q: Floats) -> Floats:
    """Return K_i (r, m, n) with zeros for entries that are rounding beside others of their row.

    ``Q`` : P^-1; an entry moves the input by |K_ij| sqrt(Q_jj) on x' P x <= 1.
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
    corners: Indices | None = None,
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

    Every relaxation applies to each of them.

    A, B : (r, n, n), (r, n, m).
    Q, M : unknowns as in ``closed_loop``.
    region : in 1/s for x' = A x; of the eigenvalues of A itself for x+ = A x.
    corners : as in ``DoubleSum``.
    """
    A_i, B_i = matrix(A, "A_{i}", over="i"), matrix(B, "B_{i}", over="i")
    loop, sums = A_i @ Q - B_i @ M.over("j"), []
    for part, label in zip(region.parts, region.labels, strict=True):
        L, C = (coefficients.astype(np.float64) for coefficients in part.matrices)
        theta = region_block((L, C), Q, loop)
        statement = (theta << 0).named(label, weight=region_weight(part, A))
        sums.append(double_sum_of(statement, rules=len(A), corners=corners))
    return tuple(sums)
