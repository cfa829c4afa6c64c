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

from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import (
    Obligations,
    never,
    nonnegative,
    positive,
)
from takagi.certificates.checker.kinds.disturbance_channel import (
    channel_stacks,
    disturbance_channels,
    quadratic_change,
)
from takagi.certificates.checker.kinds.loop_claim import NOT_DEFINITE, LoopClaim, matrix, number
from takagi.certificates.checker.words import loop_words as words
from takagi.certificates.checker.words.rounded import at_most


@dataclass(frozen=True)
class H2Norm(LoopClaim):
    """The mean of E|y|^2 over time is at most ``norm``^2; see the module."""

    asks: ClassVar[tuple[str, ...]] = ("disturbance", "entering", "output")
    P: Matrix = matrix("n", "n")
    norm: Fraction = number("-", better="smaller", positive=True)

    def obligations(self) -> Obligations:
        loop = self.loop
        yield positive(self.P, NOT_DEFINITE)
        for path in disturbance_channels(self.claim, loop, self.where):
            F, _, _ = quadratic_change(path.A, path.B, self.P, discrete=loop.is_discrete)
            yield positive(F - path.C.T @ path.C, f"the inequality fails at {path.label}")
            through = (path.through.T @ path.through).trace
            if not loop.is_discrete:
                yield nonnegative(
                    -through, f"white noise reaches the output directly at {path.label}"
                )
            variance = (path.B.T @ self.P @ path.B).trace + through
            yield nonnegative(
                self.norm**2 - variance, f"the variance exceeds norm^2 at {path.label}"
            )
        noisy = loop.disturbances if self.claim["disturbance"] == "disturbances" else loop.inputs
        # A premise with the noise of the same instant would be a weight that foresees it.
        if noisy_premises := ", ".join(name for name in loop.scheduled_by or () if name in noisy):
            yield never(f"premises depend on {noisy_premises}, which is the noise")

    def sentence(self) -> str:
        loop = self.loop
        noise = "unit covariance in each sample" if loop.is_discrete else "unit intensity"
        noise += words.in_which_sense(loop, channel_stacks(self.claim, loop, self.where)[1])
        return (
            f"the mean over time of E|y|^2 is at most {at_most(self.norm, 6)}^2 for white noise of "
            f"{noise}, along {words.about(loop)}{words.unforeseeing(loop)} "
            f"({words.rounded_channel(self.claim, loop)}){words.while_valid(loop)}"
            f"{words.channel_deviations(self.claim, loop)}"
        )
