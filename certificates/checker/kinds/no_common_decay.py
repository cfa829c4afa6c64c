r"""``no-common-decay``: no P > 0 makes V = x'Px decay at this rate along every blend of the loop.

The evidence uses blends G_k = G(h^k) at weights h^k that the loop can attain.  There are two kinds.

Multipliers Z_k = L_k L_k', not all zero, with

    continuous   S = sum_k (G_k Z_k + Z_k G_k' + 2 alpha Z_k) >= 0
    discrete     S = sum_k (G_k Z_k G_k' - rho^2 Z_k) >= 0,        rho^2 >= e^(-2 alpha T),

and S != 0 where alpha > 0.  If V(t) <= e^(-2 alpha t) V(0) held along these blends, the trace of
P S would be <= 0; but it is > 0.  At alpha = 0 V would have to decrease strictly, the trace would
be negative, and S = 0 is already a contradiction.  (For alpha > 0 it is not: x' = -x with V = x^2
at alpha = 1 has S = 0, and V = e^(-2t) V(0) decays.)

Or a single blend G with a symmetric P that is not positive definite and decreases along G as in
``decay``, here with the larger rho^2.  Then G has an eigenvalue with real part > -alpha, or of size
> rho (Lyapunov's and Stein's theorems), so that no V decays at this rate along G.

A loop can attain the weights of a single rule, h = e_i, and the weights h that the file states as
shares; the checker computes G(h) = A(h) - B(h) K(h).  Where weights are products of the weights of
premises, the file states the shares of each premise, and h_i = prod_k w_k,c_ik.  The mean of G_ij
and G_ji is not such a blend, because h_i h_j never occurs without h_i^2 and h_j^2.  For a law with
its own weights it is not known which gains and which rules act together, so that nothing can be
disproved.

The claim disproves a common quadratic function, not stability: another kind of function may exist.
It is about all weights; a plant contained in the model need not attain all of them.

Evidence: ``decay_rate``, and ``multipliers`` [{blend, factor}] or ``blend`` and ``P``.  A ``blend``
is the number of a rule, from 0, or the shares: one row of numbers >= 0 for each premise, or for all
rules where weights are no products; a row is divided by its sum.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 2.2; Ostrowski and Schneider (1962) on
the inertia, recalled.
"""

from __future__ import annotations

from fractions import Fraction
from math import prod
from typing import Any

from takagi.certificates.checker.arithmetic.exponential import exp_above
from takagi.certificates.checker.kernel.matrices import Matrix, read_matrix
from takagi.certificates.checker.kernel.reader import Number, integer, member, number, numbers, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.kinds.decay import decrease
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, Stack, bounded

Weights = list[Fraction]


def check_no_common_decay(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return DISPROVED when the evidence excludes a common P, else UNDECIDED."""
    name = text(claim, "name", where)
    alpha = number(claim, "decay_rate", where)
    if alpha < 0:
        return Claim(name, Verdict.UNDECIDED, "the decay rate is negative")
    if len(loop.K) > 1 and not loop.shared_weights:
        words = "the law has weights of its own: which gain meets which rule is not known"
        return Claim(name, Verdict.UNDECIDED, words)
    factor = _factor(loop, alpha)
    if "multipliers" in claim:
        blends, shown = _multipliers_exclude(claim, loop, factor, alpha > 0, where)
    else:
        h, G = _blend(claim, loop, where)
        P = read_matrix(claim, "P", where, (loop.order, loop.order))
        falls = decrease(loop, P, G, factor).is_positive_definite
        blends, shown = [h], P.is_symmetric and falls and not P.is_positive_definite
    if not shown:
        return Claim(name, Verdict.UNDECIDED, "the evidence does not exclude a common P")
    said = {"name": name, "loop": loop, "alpha": alpha, "blends": blends}
    return Found(Verdict.DISPROVED, "no_common_decay", said)


def _factor(loop: PolytopicLoop, alpha: Fraction) -> Fraction:
    """Return 2 alpha in continuous time, rho^2 >= e^(-2 alpha T) in discrete time."""
    if loop.sample_time is None:
        return 2 * alpha
    # Rounded up: a larger rho^2 makes it harder to disprove a common P.
    return exp_above(2 * alpha * loop.sample_time) if alpha else Fraction(1)


def _multipliers_exclude(
    claim: Any, loop: PolytopicLoop, factor: Fraction, nonzero: bool, where: str
) -> tuple[list[Weights], bool]:
    """Return the blends' weights, and whether S >= 0 with multipliers that are not all zero.

    ``nonzero`` : S must not be zero either.
    """
    listed = member(claim, "multipliers", where)
    if not listed or not isinstance(listed, list):
        raise CertificateError(f"{where}.multipliers: a list of them is needed")
    bounded(len(listed), loop.order)
    total, size, blends = 0 * Matrix.identity(loop.order), Fraction(0), []
    for i, entry in enumerate(listed):
        place = f"{where}.multipliers[{i}]"
        h, G = _blend(entry, loop, place)
        L = read_matrix(entry, "factor", place)
        Z = L @ L.T
        blends.append(h)
        size += sum(Z[k, k] for k in range(len(Z.rows)))
        total = (total + _dual(loop, G, Z, factor)).reduced()
    # For alpha > 0 the claimed decay allows equality, so a zero sum would not contradict it.
    if nonzero and not any(any(row) for row in total.rows):
        return blends, False
    return blends, size > 0 and total.is_positive_semidefinite


def _dual(loop: PolytopicLoop, G: Matrix, Z: Matrix, factor: Fraction) -> Matrix:
    GZ = G @ Z
    if loop.is_discrete:
        return GZ @ G.T - factor * Z
    return GZ + GZ.T + factor * Z


def _blend(owner: Any, loop: PolytopicLoop, where: str) -> tuple[Weights, Matrix]:
    """Return the weights h of a blend, and G(h)."""
    h = _weights(owner, loop, where)
    A = _at(loop.A, h)
    return h, A - _at(loop.B, h) @ _at(loop.K, h) if loop.K and loop.B else A


def _weights(owner: Any, loop: PolytopicLoop, where: str) -> Weights:
    """Return h, (rules,)."""
    if isinstance(member(owner, "blend", where), Number):
        k = integer(owner, "blend", where)
        if not 0 <= k < loop.rules:
            raise CertificateError(f"{where}.blend: 0 to {loop.rules - 1} is needed")
        return [Fraction(i == k) for i in range(loop.rules)]
    corners = loop.corners or tuple((i,) for i in range(loop.rules))
    rows = owner["blend"]
    if not isinstance(rows, list) or len(rows) != len(corners[0]):
        raise CertificateError(f"{where}.blend: a rule, or {len(corners[0])} rows are needed")
    size = 2 if loop.corners else loop.rules
    w = [numbers({"blend": row}, "blend", where, size) for row in rows]
    if any(min(row) < 0 or sum(row) == 0 for row in w):
        raise CertificateError(f"{where}.blend: shares >= 0, not all 0, are needed")
    h = [
        prod((row[c] / sum(row) for row, c in zip(w, rule, strict=True)), start=Fraction(1))
        for rule in corners
    ]
    # Products of weights sum to 1 only if the rules cover every combination of corners.
    if sum(h) != 1:
        raise CertificateError(f"{where}.blend: the rules leave out a combination of corners")
    return h


def _at(stack: Stack, h: Weights) -> Matrix:
    """Return sum_i h_i X_i; a stack of one matrix is the same for all rules."""
    if len(stack) == 1:
        return stack[0]
    parts = [share * X for share, X in zip(h, stack, strict=True) if share]
    return sum(parts[1:], parts[0]).reduced()
