r"""``transient``: a bound of the overshoot of the state, and of its settling time.

V = x'Px decays as in ``decay`` at the rate alpha.  With weights S = diag(scales) > 0 and a number
p > 0,

    P - p S^-2 >= 0,      kappa^2 p S^-2 - P >= 0

give |S^-1 x(t)| <= kappa e^(-alpha t) |S^-1 x(0)|: the overshoot is at most kappa - 1, in the norm
of the states divided by their scales.  With a share e of the start and a time t_s in s (in discrete
time a whole number of samples),

    kappa e^(-alpha t_s) <= e:     the state has settled to that share after t_s.

In discrete time ``decay`` uses rho^2 <= e^(-2 alpha T), so that the same bound holds at every
sample.

Evidence: ``P``, ``decay_rate`` > 0, ``scales`` (n,), ``lower`` = p, ``overshoot`` = kappa,
``settled_share`` = e, ``settling_time`` = t_s.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1 (condition number of P).
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.arithmetic.exponential import exp_above
from takagi.certificates.checker.kernel.matrices import Matrix, read_matrix
from takagi.certificates.checker.kernel.reader import number, numbers, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.kinds.decay import decrease, decrease_factor
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop


def check_transient(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return the verdict on a claim with the module's evidence."""
    name, n = text(claim, "name", where), loop.order
    P = read_matrix(claim, "P", where, (n, n))
    scales = numbers(claim, "scales", where, n)
    keys = ("decay_rate", "lower", "overshoot", "settled_share", "settling_time")
    alpha, lower, kappa, share, time = (number(claim, key, where) for key in keys)
    if min(alpha, lower, kappa, share, time, *scales) <= 0:
        raise CertificateError(f"{where}: {', '.join(keys)} and scales are positive numbers")
    if loop.sample_time is not None and (time / loop.sample_time).denominator != 1:
        raise CertificateError(f"{where}.settling_time: a whole number of samples is needed")
    if not P.is_positive_definite:
        return Claim(name, Verdict.UNDECIDED, "P is not symmetric positive definite")
    why = _why_not(loop, P, scales, lower, kappa)
    if why:
        return Claim(name, Verdict.UNDECIDED, why)
    factor = decrease_factor(loop, alpha)
    for blend in blends_of(loop, claim, where):
        if not decrease(loop, P, blend.A, factor).is_positive_definite:
            return Claim(name, Verdict.UNDECIDED, f"the inequality fails at {blend.label}")
    # e^(-alpha t_s) is rounded up, which makes the test stronger.
    if kappa * exp_above(alpha * time) > share:
        return Claim(name, Verdict.UNDECIDED, "the state may not have settled by then")
    said = {"name": name, "loop": loop, "alpha": alpha, "scales": scales}
    return Found(Verdict.PROVED, "transient", said | {"kappa": kappa, "share": share, "time": time})


def _why_not(
    loop: PolytopicLoop, P: Matrix, scales: list[Fraction], lower: Fraction, kappa: Fraction
) -> str:
    weight = Matrix.of(
        [[1 / s**2 if i == j else Fraction(0) for j in range(loop.order)]
         for i, s in enumerate(scales)]
    )  # fmt: skip
    if not (P - lower * weight).is_positive_semidefinite:
        return "P is not above p S^-2"
    if not (kappa**2 * lower * weight - P).is_positive_semidefinite:
        return "P is not below kappa^2 p S^-2"
    return ""
