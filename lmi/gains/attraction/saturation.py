r"""Saturating actuators, u = -sat(K(h) x) at |u_k| <= ubar_k, as double sums: three ways.

With K_j = M_j Q^-1, on the set where |v_k| <= ubar_k / s_k, v = K(h) x, or |H(h) x|_k <= ubar_k:

    secant      sat(v)_k lies between s_k v_k and v_k, so sat(v) is a blend of the 2^m vectors
                theta v with theta_k in {s_k, 1}:
                    Theta_ij = He(A_i Q - B_i theta M_j) + 2 alpha Q        for every corner theta.
    polytope    sat(v)_k lies between (H x)_k and v_k for any H: with E the 2^m diagonal matrices
                of zeros and ones and Z_j = H_j Q,
                    Theta_ij = He(A_i Q - B_i (E M_j + (I - E) Z_j)) + 2 alpha Q      for every E.
                The secant is the case H = s K; here H is sought, and convexly.
    dead zone   psi = v - sat(v) has psi' T (psi - (K - H) x) <= 0 for every diagonal T = S^-1 > 0:
                    Theta_ij = [ He(A_i Q - B_i M_j) + 2 alpha Q   B_i S + (M_j - Z_j)' ]
                               [ *                                 -2 S                 ],
                one double sum whatever m.  For one input it is as good as the polytope.

In each case V' <= -2 alpha V on the ellipsoid {x' P x <= 1} when it lies in the set: ``input_lmis``
for M with ubar / s, or for Z with ubar.  alpha may be smaller where an input saturates than where
none does.  It has to be, for saturation to buy anything when K is sought: with one alpha for all,
K = H serves as well and never saturates (Hu and Lin); it buys a larger ellipsoid for
gains that are given, or that must be fast near 0.  Discrete time: the same with Theta_ij of
``closed_loop`` there, V(x+) <= e^(-2 alpha T) V(x).

Source: Hu and Lin (2001), Control Systems with Actuator Saturation (polytope); Gomes da Silva and
Tarbouriech (2005), IEEE Trans. Automatic Control 50(1) (dead zone), in each case for one rule; the
secant is the sector with slopes s and 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import product

import numpy as np

from takagi.lmi.condition.term import Array
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import nearest_power
from takagi.lmi.gains.requirements.closed_loop import closed_loop, gain_member, gain_symbol
from takagi.lmi.sums.double_sum import DoubleSum, SumPart
from takagi.models.arrays import Indices
from takagi.models.errors import ModelError

# Inputs whose corners, 2^m double sums, are still listed.
MOST_INPUTS = 6


def secant_sums(
    A: Array,
    B: Array,
    Q: Unknown,
    gain: Unknown | Array,
    smallest_secants: Array,
    *,
    weight: float,
    discrete: bool = False,
    corners: Indices | None = None,
    saturated: str | None = None,
) -> tuple[DoubleSum, ...]:
    """Return the 2^m double sums of the secants between s_k and 1, one for each corner.

    Parameters
    ----------
    A, B : (r, n, n), (r, n, m).
    gain : the unknown M, or known gains K, (r, m, n).
    smallest_secants : s, (m,), in (0, 1]; 1 for an input that does not saturate.
    weight, discrete, corners : as in ``closed_loop``.
    saturated : name of the parameter that is alpha, or e^(-2 alpha T), where an input saturates;
        None for ``alpha`` and ``contraction`` as everywhere.

    Raises
    ------
    ModelError : an s outside (0, 1], too many inputs.
    """
    smallest_secants = np.broadcast_to(np.asarray(smallest_secants, dtype=np.float64), B.shape[2:])
    if not np.all((smallest_secants > 0) & (smallest_secants <= 1)):
        raise ModelError(f"least secants are {smallest_secants}; each must lie in (0, 1]")
    choices = [(1.0,) if s == 1 else (1.0, float(s)) for s in smallest_secants]
    sums = []
    for theta in _corners(choices):
        rate = None if np.all(theta == 1) else saturated
        plain = _open_loop(A, B, Q, weight, discrete, corners, rate)
        fed = gain_part(-B * theta, gain, Q, at=_moved(discrete), before=_masked(theta))
        sums.append(replace(plain, parts=(*plain.parts, fed), name=_named("secants", theta)))
    return tuple(sums)


def polytope_sums(
    A: Array,
    B: Array,
    Q: Unknown,
    gain: Unknown | Array,
    auxiliary: Unknown,
    *,
    weight: float,
    discrete: bool = False,
    corners: Indices | None = None,
    saturated: str | None = None,
) -> tuple[DoubleSum, ...]:
    """Return the 2^m double sums with each input at (K x)_k or at (H x)_k.

    Parameters
    ----------
    auxiliary : the unknown Z_j = H_j Q, with as many members as there are gains.
    others : as for ``secant_sums``.

    Raises
    ------
    ModelError : too many inputs.
    """
    sums = []
    for linear in _corners([(1.0, 0.0)] * B.shape[2]):
        rate = None if linear.all() else saturated
        plain = _open_loop(A, B, Q, weight, discrete, corners, rate)
        at = _moved(discrete)
        parts = list(plain.parts)
        if linear.any():
            parts.append(gain_part(-B * linear, gain, Q, at=at, before=_masked(linear)))
        if not linear.all():
            parts.append(
                gain_part(-B * (1 - linear), auxiliary, Q, at=at, before=_masked(1 - linear))
            )
        sums.append(replace(plain, parts=tuple(parts), name=_named("unsaturated", linear)))
    return tuple(sums)


def dead_zone_sum(
    A: Array,
    B: Array,
    Q: Unknown,
    gain: Unknown | Array,
    auxiliary: Unknown,
    *,
    weight: float,
    discrete: bool = False,
    corners: Indices | None = None,
    saturated: str | None = None,
) -> tuple[DoubleSum, tuple[Unknown, ...]]:
    """Return the double sum of the dead zone, and diag S: m numbers, positive by the LMI itself.

    Parameters
    ----------
    others : as for ``polytope_sums``; ``saturated`` is then the rate of this double sum, and the
        loop that does not saturate, ``secant_sums`` with s = 1, is posed in addition.
    """
    m = B.shape[2]
    plain = _open_loop(A, B, Q, weight, discrete, corners, saturated)
    row, last = _moved(discrete)[0], len(plain.blocks)
    # Rows of psi measured so that S weighs as much as the rest.
    unit = float(nearest_power(np.array(np.abs(B).max())))
    eye = np.eye(m)
    S = tuple(Unknown(f"S{k}", 1, 1, latex=f"S_{{{k}}}") for k in range(1, m + 1))
    parts = [
        *plain.parts,
        gain_part(-B, gain, Q, at=_moved(discrete), before="-B_{i}"),
        gain_part(unit * eye[None], gain, Q, at=(last, 0), before=""),
        gain_part(-unit * eye[None], auxiliary, Q, at=(last, 0), before="-"),
    ]
    for k in range(m):
        single = np.outer(eye[k], eye[k])[None]
        parts += [
            SumPart(
                unknown=S[k],
                left=unit * B @ single,
                at=(row, last),
                latex=("", rf"B_{{i}} e_{{{k + 1}}} e_{{{k + 1}}}^\top"),
            ),
            SumPart(
                unknown=S[k],
                left=-2 * unit**2 * single,
                at=(last, last),
                latex=("-2", rf"e_{{{k + 1}}} e_{{{k + 1}}}^\top"),
            ),
        ]
    dead_zone = replace(plain, blocks=(*plain.blocks, m), parts=tuple(parts), name="dead zone")
    return dead_zone, S


def gain_part(
    left: Array, gain: Unknown | Array, Q: Unknown, *, at: tuple[int, int], before: str
) -> SumPart:
    """Return left_i M_j at a block, or left_i K_j Q for known gains, and on the diagonal He of it.

    Parameters
    ----------
    left : (1, p, m) or (r, p, m), by the vertex's rule.
    gain : M, or K (r, m, n), or (1, m, n) for a gain that all rules share.
    """
    eye = np.eye(Q.rows)[None]
    on_diagonal = at[0] == at[1]
    if isinstance(gain, Unknown):
        return SumPart(
            unknown=gain,
            left=left,
            right=eye,
            at=at,
            plus_transpose=on_diagonal,
            member=gain_member(gain),
            latex=(before, ""),
            symbol=gain_symbol(gain),
        )
    if len(gain) == 1:
        return SumPart(
            unknown=Q,
            left=left @ gain,
            right=eye,
            at=at,
            plus_transpose=on_diagonal,
            latex=(f"{before}K", ""),
        )
    r = len(gain)
    products = np.broadcast_to(left[:, None] @ gain[None], (r, r, left.shape[1], Q.rows))
    return SumPart(
        unknown=Q,
        left=products,
        right=eye,
        at=at,
        plus_transpose=on_diagonal,
        latex=(f"{before}K_{{j}}", ""),
    )


def _open_loop(
    A: Array,
    B: Array,
    Q: Unknown,
    weight: float,
    discrete: bool,
    corners: Indices | None,
    rate: str | None,
) -> DoubleSum:
    """Return ``closed_loop`` without its gains, its rate the parameter ``rate``."""
    M = Unknown("M", B.shape[2], Q.rows)
    loop = closed_loop(A, B, Q, M, weight=weight, discrete=discrete, corners=corners)
    loop_parts = [part for part in loop.parts if part.unknown is not M]
    if rate is not None:
        loop_parts = [_at_rate(part, rate) for part in loop_parts]
    return replace(loop, parts=tuple(loop_parts))


def _at_rate(part: SumPart, rate: str) -> SumPart:
    """Return a part of the rate's with another parameter, written with an index of its own."""
    if part.parameter is None:
        return part
    before, behind = part.latex
    for symbol in (r"\alpha", r"\rho"):
        before = before.replace(symbol, rf"{symbol}_{{s}}")
    return replace(part, parameter=rate, latex=(before, behind))


def _masked(share: Array) -> str:
    """Return -B_i diag(share) in LaTeX."""
    if np.all(share == 1):
        return "-B_{i}"
    if len(share) == 1:
        return f"-{share[0]:.4g} B_{{i}}"
    return rf"-B_{{i}} \mathrm{{diag}}({', '.join(f'{value:.4g}' for value in share)})"


def _moved(discrete: bool) -> tuple[int, int]:
    return (1, 0) if discrete else (0, 0)


def _corners(choices: Sequence[tuple[float, ...]]) -> list[Array]:
    free = sum(len(choice) > 1 for choice in choices)
    if free > MOST_INPUTS:
        raise ModelError(
            f"{free} inputs saturate, with {2**free} corners; at most {MOST_INPUTS} are listed: "
            "take the dead zone, which has no corners"
        )
    return [np.array(corner) for corner in product(*choices)]


def _named(name: str, corner: Array) -> str:
    return f"{name} ({', '.join(f'{value:.4g}' for value in corner)})"
