r"""``gain-rounding``: the claim ``decay`` for all gains near those of the gain file.

Every K_j may be replaced by K_j + D_j, |D_j,kl| <= delta_j,kl = absolute_kl + relative |K_j,kl|.
The entries may differ independently, and change while the loop runs.  Let b_ik = P B_i e_k, let
tau_k > 0 be any numbers, and

    S_j,k = (sum_l delta_j,kl) diag_l(delta_j,kl) >= d_j,k d_j,k',   d_j,k' row k of D_j.

Then -He(P B_i D_j) <= sum_k (tau_k b_ik b_ik' + S_j,k / tau_k).  With means over the pairs (i, j)
of every blend it is therefore enough that

    continuous   -(P G + G'P + 2 alpha P) - mean sum_k (tau_k b_ik b_ik' + S_j,k / tau_k) > 0
    discrete     [ rho^2 P - mean sum_k S_j,k / tau_k      G'P                           ]
                 [ P G                                     P - mean sum_k tau_k b_ik b_ik' ]  > 0.

The bound by S follows from (d'x)^2 <= (sum |d_l| |x_l|)^2 <= (sum delta_l) (sum delta_l x_l^2), by
Cauchy and Schwarz.

Evidence: ``P``, ``decay_rate``, ``absolute`` (inputs by states), ``relative``, ``tau`` (inputs).

Source: derived here; the first bound is Young's inequality.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix, read_matrix
from takagi.certificates.checker.kernel.reader import number, numbers, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.kinds.decay import decrease_factor
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, bounded


def check_gain_rounding(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return PROVED when every inequality holds, else UNDECIDED with the first that fails."""
    name = text(claim, "name", where)
    if not loop.K:
        raise CertificateError(f"{where}: there are no gains that could be rounded")
    m, n = loop.K[0].shape
    alpha, relative = (number(claim, key, where) for key in ("decay_rate", "relative"))
    P, absolute = (
        read_matrix(claim, key, where, shape)
        for key, shape in (("P", (n, n)), ("absolute", (m, n)))
    )
    tau = numbers(claim, "tau", where, m)
    if alpha < 0 or relative < 0 or min(tau) <= 0 or _least(absolute) < 0:
        return Claim(name, Verdict.UNDECIDED, "rate and steps must be >= 0, and every tau > 0")
    if not P.is_positive_definite:
        return Claim(name, Verdict.UNDECIDED, "P is not symmetric positive definite")
    factor = decrease_factor(loop, alpha)
    effects = [_effect(P @ B, tau) for B in loop.B]
    steps = [_step(absolute, relative, K, tau) for K in loop.K]
    # Effect and step are convex in B and K: on a piece of the weights the means of their values at
    # the rules are upper bounds.
    blends = blends_of(replace(loop, more=(tuple(effects), tuple(steps))), claim, where)
    bounded(len(blends), 2 * n if loop.is_discrete else n)
    for blend in blends:
        effect, step = (blend.of(blend.loop.more[side], side) for side in (0, 1))
        if not _left_side(loop, P, blend.A, factor, effect, step).is_positive_definite:
            return Claim(name, Verdict.UNDECIDED, f"the inequality fails at {blend.label}")
    said = {"name": name, "loop": loop, "alpha": alpha}
    said |= {"absolute": absolute, "relative": relative}
    return Found(Verdict.PROVED, "gain_rounding", said)


def _left_side(
    loop: PolytopicLoop, P: Matrix, G: Matrix, factor: Fraction, effect: Matrix, step: Matrix
) -> Matrix:
    PG = P @ G
    if loop.is_discrete:
        return Matrix.blocks([[factor * P - step, PG.T], [PG, P - effect]])
    return -(PG + PG.T + factor * P + effect + step)


def _effect(PB: Matrix, tau: Sequence[Fraction]) -> Matrix:
    """Return sum_k tau_k b_k b_k', where b_k are the columns of P B."""
    weights = Matrix.of([[t if i == k else Fraction(0) for k in range(len(tau))]
                         for i, t in enumerate(tau)])  # fmt: skip
    return PB @ weights @ PB.T


def _step(absolute: Matrix, relative: Fraction, K: Matrix, tau: Sequence[Fraction]) -> Matrix:
    """Return sum_k S_k / tau_k."""
    m, n = K.shape
    delta = [
        [absolute[k, l] + relative * abs(K[k, l]) for l in range(n)]  # noqa: E741
        for k in range(m)
    ]
    diagonal = [
        sum((sum(row, Fraction(0)) * row[i] / t for row, t in zip(delta, tau, strict=True)),
            Fraction(0))
        for i in range(n)
    ]  # fmt: skip
    return Matrix.of([[d if i == j else Fraction(0) for j in range(n)]
                      for i, d in enumerate(diagonal)])  # fmt: skip


def _least(matrix: Matrix) -> int:
    return min(min(row) for row in matrix.rows)
