r"""``no-common-decay``: no P > 0 satisfies the inequalities of ``decay`` at this rate.

Either by multipliers Z_k = L_k L_k', not all zero, for some of the blends G_k,

    continuous   sum_k (G_k Z_k + Z_k G_k' + 2 alpha Z_k) >= 0
    discrete     sum_k (G_k Z_k G_k' - rho^2 Z_k) >= 0,        rho^2 >= e^(-2 alpha T),

for the trace of P times the sum would be negative by the inequalities and is not; or by one blend
G alone, with a symmetric P that decreases along it as ``decay`` asks for, with the larger rho^2,
and is not positive definite: then G has an eigenvalue with real part >= -alpha, or of size >= rho
(Lyapunov's and Stein's theorems), and no other P serves.

What is disproved is the function, not the loop: blends of different rules are means of loops, which
the loop may reach or not, and another kind of function may exist.

Evidence: ``decay_rate``, and ``multipliers`` [{blend, factor}] or ``blend`` and ``P``; blends are
counted from 0 in the family's order.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 2.2; Ostrowski and Schneider (1962) on
the inertia, recalled.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.family import Blend, Family
from takagi.certificates.checker.kernel.matrices import Matrix, read_matrix
from takagi.certificates.checker.kernel.reader import integer, member, number, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Verdict
from takagi.certificates.checker.kinds.decay import decrease
from takagi.certificates.checker.kinds.exponential import exp_above
from takagi.certificates.checker.words.shown import at_most

__all__ = ["check_no_common_decay"]


def check_no_common_decay(claim: Any, family: Family, where: str) -> Claim:
    """Return DISPROVED when the evidence excludes a common P, else UNDECIDED."""
    name = text(claim, "name", where)
    alpha = number(claim, "decay_rate", where)
    if alpha < 0:
        return Claim(name, Verdict.UNDECIDED, "the decay rate is negative")
    blends = family.blends()
    if "multipliers" in claim:
        shown = _multipliers_exclude(claim, family, alpha, blends, where)
        reason = "multipliers"
    else:
        blend = _blend(claim, blends, where)
        P = read_matrix(claim, "P", where, (family.order, family.order))
        falls = decrease(family, P, blend.A, _factor(family, alpha)).is_positive_definite
        shown = P.is_symmetric and falls and not P.is_positive_definite
        reason = f"{blend.label} alone"
    if not shown:
        return Claim(name, Verdict.UNDECIDED, "the evidence does not exclude a common P")
    return Claim(
        name,
        Verdict.DISPROVED,
        f"no common quadratic function with decay rate {at_most(alpha, 6)} 1/s satisfies the "
        f"inequalities of {family.about}: {len(blends)} in all, excluded by {reason}",
    )


def _factor(family: Family, alpha: Fraction) -> Fraction:
    """Return 2 alpha in continuous time, rho^2 >= e^(-2 alpha T) in discrete time."""
    if family.sample_time is None:
        return 2 * alpha
    return exp_above(2 * alpha * family.sample_time) if alpha else Fraction(1)


def _multipliers_exclude(
    claim: Any, family: Family, alpha: Fraction, blends: list[Blend], where: str
) -> bool:
    listed = member(claim, "multipliers", where)
    if not isinstance(listed, list) or not 0 < len(listed) <= len(blends):
        raise CertificateError(f"{where}.multipliers: 1 to {len(blends)} are needed")
    factor = _factor(family, alpha)
    total, size = None, Fraction(0)
    for i, entry in enumerate(listed):
        place = f"{where}.multipliers[{i}]"
        G = _blend(entry, blends, place).A
        L = read_matrix(entry, "factor", place)
        Z = L @ L.T
        size += sum(Z[k, k] for k in range(len(Z.rows)))
        part = _dual(family, G, Z, factor)
        total = part if total is None else (total + part).reduced()
    return size > 0 and total is not None and total.is_positive_semidefinite


def _dual(family: Family, G: Matrix, Z: Matrix, factor: Fraction) -> Matrix:
    GZ = G @ Z
    if family.is_discrete:
        return GZ @ G.T - factor * Z
    return GZ + GZ.T + factor * Z


def _blend(owner: Any, blends: list[Blend], where: str) -> Blend:
    k = integer(owner, "blend", where)
    if not 0 <= k < len(blends):
        raise CertificateError(f"{where}.blend: 0 to {len(blends) - 1} is needed")
    return blends[k]
