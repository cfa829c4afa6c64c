"""Claims that are impossible for a loop whose weights are averages along a segment.

The weights of a secant embedding belong to mean slopes between the equilibrium and the present
state. No observer, output or Lyapunov function that uses these weights can be evaluated. With the
slopes at the present state instead, the claim is false: an observer of x' = -x - x^3 + u that
measures y = x and uses the slope there keeps an error while x stays at 0.9.
"""

from __future__ import annotations

from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop

ADVICE = {
    "observer": (
        "an observer needs the weights",
        "claim it of a sector model whose premises are measured",
    ),
    "function": (
        "a function P(h) needs the weights",
        "claim decay with one P, or P(h) of a sector model",
    ),
    "output": (
        "an output with a matrix for each rule needs the weights",
        "give it one matrix, or take the output of the plant",
    ),
}


def why_averages_fail(loop: PolytopicLoop, quantity: str) -> str:
    """Return why a claim is impossible for this model, and what to do; empty if it is possible.

    Parameters
    ----------
    quantity : "observer", "function" or "output".
    """
    if not loop.averaged:
        return ""
    if quantity == "observer" and all(len(M) <= 1 for M in (loop.A, loop.B, loop.C, loop.D)):
        return ""
    need, advice = ADVICE[quantity]
    return (
        f"{need}, but the model is a secant embedding, whose weights are averages of slopes "
        f"between rest and the state: they cannot be evaluated; {advice}"
    )


def refuse_averages(loop: PolytopicLoop, quantity: str, where: str) -> None:
    """Raise CertificateError where ``why_averages_fail`` has a reason."""
    if why := why_averages_fail(loop, quantity):
        raise CertificateError(f"{where}: {why}")
