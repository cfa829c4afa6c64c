r"""``input-limits``: bounds of |u_k|, and of |u_k'| or |u_k(x+) - u_k(x)|, on an invariant set.

On an invariant set {x'Px <= c} of ``invariant_set``, for u = -sum_j g_j K_j x, every gain j and
every input k,

    [[P, k_j'], [k_j, ubar_k^2 / c]] >= 0,     k_j row k of K_j,     so |k_j x| <= ubar_k,

and by convexity the blend keeps the limit.  ``input_rate`` has the conditions of ``rate_limits``.

Evidence: that of ``invariant_set``; ``input_limits``, (m,); where rates are claimed ``rate_limits``
with the evidence of ``input_rate``.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.2.3.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.reader import numbers, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.kinds.input_rate import why_rate_fails
from takagi.certificates.checker.kinds.invariant_set import InvariantSet, read_invariant_set
from takagi.certificates.checker.loop.box_of_validity import reaches_at_most, row_of
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, bounded


def check_input_limits(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return the verdict on a claim with the module's evidence."""
    name = text(claim, "name", where)
    if not loop.K:
        raise CertificateError(f"{where}: limits are about u = -Kx, but there are no gains")
    limits = numbers(claim, "input_limits", where, loop.K[0].shape[0])
    held = read_invariant_set(claim, loop, where)
    why = held.why_not(loop)
    if why:
        return Claim(name, Verdict.UNDECIDED, why)
    bounded(len(loop.K) * len(limits), loop.order + 1)
    for j, gain in enumerate(loop.K):
        for k, limit in enumerate(limits):
            if not reaches_at_most(held.P, held.level, row_of(gain, k), limit):
                return Claim(
                    name, Verdict.UNDECIDED, f"gain {j + 1} may exceed the limit of input {k + 1}"
                )
    rates, moving, why = _rates(claim, loop, held, where)
    if why:
        return Claim(name, Verdict.UNDECIDED, why)
    said = {"name": name, "loop": loop, "held": held, "limits": limits}
    return Found(Verdict.PROVED, "input_limits", said | {"rates": rates, "moving": moving})


def _rates(
    claim: Any, loop: PolytopicLoop, held: InvariantSet, where: str
) -> tuple[list[Fraction] | None, list[Fraction], str]:
    """Return (rate limits, their assumptions, why they fail); None for no limits."""
    if "rate_limits" not in claim:
        return None, [], ""
    limits = numbers(claim, "rate_limits", where, loop.K[0].shape[0])
    return limits, *why_rate_fails(claim, loop, held, limits, where)
