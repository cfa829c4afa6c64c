r"""``h2-norm``: the mean of E|y|^2 over time is at most nu = norm^2 for unit white noise w.

Let V = x'Px with P > 0, and V' (or V(x+) - V) = -x'Fx without noise.  The conditions, for every
blend, are

    F - C'C > 0,      tr(B'PB) <= nu      (tr(B'PB + D'D) <= nu in discrete time),

and D = 0 in continuous time: white noise must not reach the output directly.  Both are convex in
the blend, so that they hold along the loop: E V' <= nu - E|y|^2.  Weights may depend on the state
and on time, but not on future noise.  For impulses at one instant: let an impulse in w_k alone
start the loop from rest; the energies of y in these responses, summed over k, are at most nu.

If B differs between the rules, it may depend on the state.  In continuous time the stochastic
integral is then that of Ito (B is evaluated before the step).  Smooth noise of a wide band tends to
the integral of Stratonovich, which has an additional drift if the noise moves the state on which B
depends.  For example, x1' = -x1 + w, x2' = -x2/5 + tanh(5 x1) w has a mean of x2^2 of at most 2.52
by this claim, and of 7.96 in a simulation with noise of 500 rad/s.

E|y|^2 at one instant is not bounded.  Noise is unbounded, so that it drives a plant out of any box
at some time.  For a plant the claim holds as long as its state stays in the model's box.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.2.1 (output energy).
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix, read_matrix
from takagi.certificates.checker.kernel.reader import number, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.kinds.disturbance_channel import (
    disturbance_channels,
    entrance,
    quadratic_change,
)
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop


def check_h2_norm(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return the verdict on a claim with ``P``, ``norm`` and a ``disturbance_channel``."""
    name = text(claim, "name", where)
    norm, n = number(claim, "norm", where), loop.order
    P = read_matrix(claim, "P", where, (n, n))
    if norm <= 0:
        raise CertificateError(f"{where}.norm: a positive number is needed")
    if not P.is_positive_definite:
        return Claim(name, Verdict.UNDECIDED, "P is not symmetric positive definite")
    for path in disturbance_channels(claim, loop, where):
        F, _, _ = quadratic_change(path.A, path.B, P, discrete=loop.is_discrete)
        if not (F - path.C.T @ path.C).is_positive_definite:
            return Claim(name, Verdict.UNDECIDED, f"the inequality fails at {path.label}")
        through = _trace(path.through.T @ path.through)
        if through and not loop.is_discrete:
            return Claim(
                name, Verdict.UNDECIDED, f"white noise reaches the output directly at {path.label}"
            )
        if _trace(path.B.T @ P @ path.B) + through > norm**2:
            return Claim(name, Verdict.UNDECIDED, f"the variance exceeds norm^2 at {path.label}")
    if known := _of_the_noise(claim, loop):
        return Claim(name, Verdict.UNDECIDED, f"premises depend on {known}, which is the noise")
    said = {"name": name, "claim": claim, "loop": loop, "norm": norm}
    entering = entrance(claim, loop, where)[1]
    return Found(Verdict.PROVED, "h2_norm", said | {"entering": entering})


def _of_the_noise(claim: Any, loop: PolytopicLoop) -> str:
    """Return the premise variables that contain noise of the same instant; empty if none."""
    noisy = loop.disturbances if claim["disturbance"] == "disturbances" else loop.inputs
    return ", ".join(name for name in loop.scheduled_by or () if name in noisy)


def _trace(matrix: Matrix) -> Fraction:
    return sum((matrix[k, k] for k in range(len(matrix.rows))), Fraction(0))
