r"""``decay``: V = x'Px decays along every blend of the loop, with one P > 0 for all.

    continuous   -(P G + G'P + 2 alpha P) > 0     then V(t) <= e^(-2 alpha t) V(0)
    discrete     rho^2 P - G'P G > 0              then V(k) <= e^(-2 alpha T k) V(0)

for the closed loop G of every blend, with a rational rho^2 <= e^(-2 alpha T) in discrete time.
alpha = 0 [1/s] claims stability without a rate: V decreases strictly.

It is enough to test the blends, because the conditions are affine in G.  The second is equivalent,
by a Schur complement, to [[rho^2 P, G'P], [PG, P]] > 0.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1; Tanaka and Wang (2001), chapter 3,
recalled.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative, positive
from takagi.certificates.checker.kinds.loop_claim import NOT_DEFINITE, LoopClaim, matrix, number
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop
from takagi.certificates.checker.words import loop_words as words
from takagi.certificates.checker.words.rounded import at_least


@dataclass(frozen=True)
class Decay(LoopClaim):
    """V = x'Px decays at the rate ``decay_rate``; see the module."""

    decay_rate: Fraction = number("1/s", better="larger")
    P: Matrix = matrix("n", "n")

    def obligations(self) -> Obligations:
        yield nonnegative(self.decay_rate, "the decay rate is negative")
        yield positive(self.P, NOT_DEFINITE)
        blends = blends_of(self.loop, self.claim, self.where)
        yield from falls_along(self.loop, self.P, self.decay_rate, ((b.label, b.A) for b in blends))

    def sentence(self) -> str:
        loop = self.loop
        return (
            f"V = x'Px {falls_as(loop, self.decay_rate)} along {words.about(loop)}"
            f"{words.while_valid(loop)}{words.deviations(loop, 'x')}"
        )


def falls_as(loop: PolytopicLoop, decay_rate: Fraction) -> str:
    """Return how V falls, and without which disturbance."""
    falls = f"decays as exp(-{at_least(2 * decay_rate, 6)} t)" if decay_rate else "falls"
    return f"{falls}{words.undisturbed(loop)}"


def falls_along(
    loop: PolytopicLoop, P: Matrix, decay_rate: Fraction, matrices: Iterable[tuple[str, Matrix]]
) -> Obligations:
    """Yield the inequality of the module for each G, which has a name."""
    factor = decrease_factor(loop, decay_rate)
    for label, G in matrices:
        yield positive(decrease(loop, P, G, factor), f"the inequality fails at {label}")


def decrease_factor(loop: PolytopicLoop, decay_rate: Fraction) -> Fraction:
    """Return 2 alpha in continuous time, rho^2 <= e^(-2 alpha T) in discrete time."""
    if loop.sample_time is None:
        return 2 * decay_rate
    if not decay_rate:
        # e^0 = 1 is exact; a rounded value below 1 would claim more than stability.
        return Fraction(1)
    # Imported here: continuous time needs no exponential.
    from takagi.certificates.checker.arithmetic.exponential import exp_below

    # Rounded down: a smaller rho^2 makes the inequality stronger.
    return exp_below(2 * decay_rate * loop.sample_time)


def decrease(loop: PolytopicLoop, P: Matrix, G: Matrix, factor: Fraction) -> Matrix:
    """Return the matrix of the module's formula that must be positive definite."""
    PG = P @ G
    if loop.is_discrete:
        return factor * P - G.T @ PG
    return -(PG + PG.T + factor * P)
