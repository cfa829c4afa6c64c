r"""``decay``: V = x'Px decays along every blend of the loop, with one P > 0 for all.

    continuous   -(P G + G'P + 2 alpha P) > 0     then V(t) <= e^(-2 alpha t) V(0)
    discrete     rho^2 P - G'P G > 0              then V(k) <= e^(-2 alpha T k) V(0)

for the closed loop G of every blend, with a rational rho^2 <= e^(-2 alpha T) in discrete time.
alpha = 0 [1/s] claims stability without a rate: V decreases strictly.

Evidence: ``P``, ``decay_rate``.

It is enough to test the blends, because the conditions are affine in G.  The second is equivalent,
by a Schur complement, to [[rho^2 P, G'P], [PG, P]] > 0.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1; Tanaka and Wang (2001), chapter 3,
recalled.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix, read_matrix
from takagi.certificates.checker.kernel.reader import number, text
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop


def check_decay(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return PROVED when every inequality holds, else UNDECIDED with the first that fails."""
    name = text(claim, "name", where)
    alpha = number(claim, "decay_rate", where)
    P = read_matrix(claim, "P", where, (loop.order, loop.order))
    if alpha < 0:
        return Claim(name, Verdict.UNDECIDED, "the decay rate is negative")
    if not P.is_positive_definite:
        return Claim(name, Verdict.UNDECIDED, "P is not symmetric positive definite")
    factor = decrease_factor(loop, alpha)
    blends = blends_of(loop, claim, where)
    for blend in blends:
        if not decrease(loop, P, blend.A, factor).is_positive_definite:
            return Claim(name, Verdict.UNDECIDED, f"the inequality fails at {blend.label}")
    said = {"name": name, "loop": loop, "alpha": alpha, "blends": len(blends)}
    return Found(Verdict.PROVED, "decay", said)


def decrease_factor(loop: PolytopicLoop, alpha: Fraction) -> Fraction:
    """Return 2 alpha in continuous time, rho^2 <= e^(-2 alpha T) in discrete time."""
    if loop.sample_time is None:
        return 2 * alpha
    if not alpha:
        # e^0 = 1 is exact; a rounded value below 1 would claim more than stability.
        return Fraction(1)
    # Imported here: continuous time needs no exponential.
    from takagi.certificates.checker.arithmetic.exponential import exp_below

    # Rounded down: a smaller rho^2 makes the inequality stronger.
    return exp_below(2 * alpha * loop.sample_time)


def decrease(loop: PolytopicLoop, P: Matrix, G: Matrix, factor: Fraction) -> Matrix:
    """Return the matrix of the module's formula that must be positive definite."""
    PG = P @ G
    if loop.is_discrete:
        return factor * P - G.T @ PG
    return -(PG + PG.T + factor * P)
