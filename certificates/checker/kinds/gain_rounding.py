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

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, never, positive
from takagi.certificates.checker.kinds.decay import decrease_factor, falls_as
from takagi.certificates.checker.kinds.loop_claim import (
    NOT_DEFINITE,
    LoopClaim,
    matrix,
    number,
    numbers,
)
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.loop.polytopic_loop import bounded
from takagi.certificates.checker.words import loop_words as words
from takagi.certificates.checker.words.figure import Figure, WindProfile
from takagi.certificates.checker.words.rounded import at_least


@dataclass(frozen=True)
class GainRounding(LoopClaim):
    """The claim ``decay`` for all gains near those of the file; see the module."""

    tau: list[Fraction] = numbers("m")
    decay_rate: Fraction = number("1/s", better="larger")
    relative: Fraction = number(better="larger", label="relative rounding of gains")
    P: Matrix = matrix("n", "n")
    absolute: Matrix = matrix("m", "n")

    def obligations(self) -> Obligations:
        loop, P, tau = self.loop, self.P, self.tau
        smallest_step = min(min(row) for row in self.absolute.rows)
        if self.decay_rate < 0 or self.relative < 0 or min(tau) <= 0 or smallest_step < 0:
            yield never("rate and steps must be >= 0, and every tau > 0")
        yield positive(P, NOT_DEFINITE)
        factor = decrease_factor(loop, self.decay_rate)
        weights = Matrix.diagonal(tau)
        effects = tuple(P @ B @ weights @ (P @ B).T for B in loop.B)
        steps = tuple(_step(self.absolute, self.relative, K, tau) for K in loop.K)
        # Effect and step are convex in B and K: on a piece of the weights the means of their values
        # at the rules are upper bounds.
        blends = blends_of(replace(loop, extra_stacks=(effects, steps)), self.claim, self.where)
        bounded(len(blends), (2 if loop.is_discrete else 1) * loop.order)
        for blend in blends:
            effect, step = (blend.of(blend.loop.extra_stacks[side], side) for side in (0, 1))
            PG = P @ blend.A
            if loop.is_discrete:
                falling = Matrix.blocks([[factor * P - step, PG.T], [PG, P - effect]])
            else:
                falling = -(PG + PG.T + factor * P + effect + step)
            yield positive(falling, f"the inequality fails at {blend.label}")

    def figures(self) -> Iterator[Figure | WindProfile]:
        yield from super().figures()
        smallest = min(min(row) for row in self.absolute.rows)
        name = "absolute rounding of gains, least"
        yield Figure(name, "", Fraction(smallest, self.absolute.below))

    def sentence(self) -> str:
        loop = self.loop
        room = [f"{at_least(100 * self.relative, 6)} % of themselves"] if self.relative else []
        room += ["the stated absolute steps"] if any(map(any, self.absolute.rows)) else []
        return (
            f"V = x'Px {falls_as(loop, self.decay_rate)} along {words.about(loop)}, with "
            f"all gains off by up to {' and '.join(room) or 'nothing'}{words.while_valid(loop)}"
            f"{words.deviations(loop, 'x')}"
        )


def _step(absolute: Matrix, relative: Fraction, K: Matrix, tau: Sequence[Fraction]) -> Matrix:
    """Return sum_k S_k / tau_k."""
    m, n = K.shape
    delta = [[absolute[k, i] + relative * abs(K[k, i]) for i in range(n)] for k in range(m)]
    return Matrix.diagonal([
        sum((sum(row) * row[i] / t for row, t in zip(delta, tau, strict=True)), Fraction(0))
        for i in range(n)
    ])  # fmt: skip
