r"""``sampled-loop``: a continuous plant whose law runs every T seconds and holds its command.

    x' = A x + B u_k   from t_k = k T to t_k + T,     u_k = -K x(t_k)

(A, B) is any blend of the (A_i, B_i) and may change within the interval; K is any blend of the K_j,
with the weights at t_k.  So the weights may change by any amount while u_k is held.  Let
xi = (x, u), M_i = [[A_i, B_i], [0, 0]], L_j = [I; -K_j], and P_0 ... P_d the Bernstein coefficients
of

    Q(s) = sum_l b_l(s) P_l,     b_l(s) = binom(d, l) s^l (1 - s)^(d - l),     s = (t - t_k) / T,

The function xi'Q xi does not increase within an interval, and V = x'Px decreases from one sample to
the next, if for every i, j and l

    flow      -(D_l + T (P_l M_i + M_i'P_l)) >= 0,
                 D_l = (d - l) (P_l+1 - P_l) + l (P_l - P_l-1)     the coefficients of dQ/ds
    end       P_d - [[P, 0], [0, 0]] >= 0
    sample    rho^2 P - L_j'P_0 L_j > 0,   P_0 >= 0,   a rational rho^2 <= e^(-2 alpha T):

    V(x(t_k + T)) <= xi'P_d xi <= xi'P_0 xi at t_k <= rho^2 V(x(t_k)).

Between samples xi'Q xi <= rho^2 c < c where V(x(t_k)) <= c.  So a state with |x_m| <= b in the
model's box does not reach b if c e_m e_m' <= b^2 P_l for every l, and the model equals its plant at
all times.  alpha = 0 claims that V decreases, without a rate.  P > 0 follows from "sample".

Proof.  While the plant is in its box, xi' = M xi with M in the hull of the M_i.  The left side of
"flow" is minus the l-th Bernstein coefficient of Q'(s) + T (Q M_i + M_i'Q).  Bernstein polynomials
are not negative, so that sum is <= 0 on [0, 1]; it is affine in M, and d/dt xi'Q xi <= 0.  At the
sample xi = L x(t_k) with L in the hull of the L_j.  As P_0 >= 0, |P_0^(1/2) L x|^2 is convex in L,
so that xi'Q(0) xi < rho^2 V(x(t_k)) unless x = 0.  In between Q(s) is a mean of the P_l, so that
x_m^2 < b^2.  If there was a first time at which the plant reached the boundary of its box, the
inequalities would hold until then, and it would be inside.  The input is constant and
V(x(t_k)) <= c, so it keeps its range.

Evidence: ``sample_time`` T, ``P``, ``level`` c, ``decay_rate`` alpha, ``functions`` P_0 ... P_d.

Source: derived here.  Functions of the time since the last sample: Briat (2013), Automatica 49(11),
recalled; coefficients of Bernstein polynomials bound them, as their weights are >= 0 with sum 1.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

from takagi.certificates.checker.arithmetic.exponential import exp_below
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative, positive
from takagi.certificates.checker.kernel.reader import read_stack
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kinds.loop_claim import LoopClaim, matrix, number
from takagi.certificates.checker.loop.box_of_validity import (
    bounded_inputs,
    disturbances_in_range,
    half_width,
    inside_box,
    reaches_at_most,
)
from takagi.certificates.checker.loop.polytopic_loop import at, bounded
from takagi.certificates.checker.words import loop_words as words
from takagi.certificates.checker.words.ellipsoid_size import rounded_size
from takagi.certificates.checker.words.rounded import at_least, exactly

HIGHEST_DEGREE = 20


@dataclass(frozen=True)
class SampledLoop(LoopClaim):
    """The command is held for ``sample_time``; V falls from sample to sample; see the module."""

    sample_time: Fraction = number("s", better="larger", positive=True)
    level: Fraction = number(positive=True)
    decay_rate: Fraction = number("1/s", better="larger")
    P: Matrix = matrix("n", "n")

    def obligations(self) -> Obligations:
        loop, where, P = self.loop, self.where, self.P
        if loop.is_discrete or not loop.K or not loop.B:
            raise CertificateError(f"{where}: inputs and gains are needed, in continuous time")
        if self.decay_rate < 0:
            raise CertificateError(f"{where}.decay_rate: a number >= 0 is needed")
        (m, n), Q = loop.K[0].shape, read_stack(self.claim, "functions", where)
        if Q[0].shape != (n + m, n + m) or not 2 <= len(Q) <= HIGHEST_DEGREE + 1:
            raise CertificateError(
                f"{where}.functions: 2 to {HIGHEST_DEGREE + 1} of order {n + m} are needed"
            )
        bounded(loop.rules * len(Q) + len(loop.K), n + m)
        # If P_0 is symmetric and semidefinite, the other inequalities imply that P > 0 and that P
        # and all functions are symmetric: these need no test of their own.
        yield nonnegative(Q[0], "the first function is not symmetric positive semidefinite")
        zero, below = Matrix.zeros(n, m), Matrix.zeros(m, n + m)
        corner = Matrix.blocks([[Matrix.blocks([[P, zero]])], [below]])
        yield nonnegative(Q[-1] - corner, "the last function may be below V")
        factor = exp_below(2 * self.decay_rate * self.sample_time)
        for j, K in enumerate(loop.K):
            L = Matrix.blocks([[Matrix.identity(n)], [-K]])
            failure = f"V may not fall from sample to sample with gain {j + 1}"
            yield positive(factor * P - L.T @ Q[0] @ L, failure)
        changes = list(_changes(Q))
        for i in range(loop.rules):
            A, B = at(loop.A, i), at(loop.B, i)
            M = self.sample_time * Matrix.blocks([[Matrix.blocks([[A, B]])], [below]])
            for function, change in zip(Q, changes, strict=True):
                flow_term = function @ M
                failure = f"the function may grow between samples at rule {i + 1}"
                yield nonnegative(-(change + flow_term + flow_term.T), failure)
        yield from self._inside_box(Q)

    def _inside_box(self, Q: Sequence[Matrix]) -> Obligations:
        """Yield what keeps the plant inside the box, at samples and between them."""
        loop = self.loop
        yield from disturbances_in_range(loop, (Fraction(0),) * len(loop.disturbances))
        yield from inside_box(loop, self.P, self.level)
        identity = Matrix.identity(len(Q[0].rows))
        for k, side in enumerate(loop.box):
            if side is None:
                continue
            failure = f"{loop.states[k]} may leave its range in the model's box between samples"
            for function in Q:
                row = identity.row(k)
                yield reaches_at_most(function, self.level, row, half_width(side), failure)

    def sentence(self) -> str:
        loop = self.loop
        rate = self.decay_rate
        falls = f"falls as exp(-{at_least(2 * rate, 6)} t)" if rate else "falls"
        inputs = f" ({', '.join(loop.inputs)})" if loop.inputs else ""
        gains = f"{len(loop.K)} gains" if len(loop.K) > 1 else "one gain"
        blends = f", along every blend of {loop.rules} rules and of {gains}"
        alone = loop.rules == len(loop.K) == 1
        limited = any(side is not None for side in loop.box) or bool(bounded_inputs(loop))
        start = f"{{x'Px <= {exactly(self.level)}}}" if limited else "anywhere"
        assumed = words.granted(loop, disturbances_too=False)
        stays = (
            f"; between samples too the plant stays in the model's box{assumed}"
            f"{rounded_size(self.P, self.level, loop.states)}"
            if limited
            else assumed
        )
        return (
            f"with a sample every {exactly(self.sample_time)} s, the command u = -Kx{inputs} held "
            f"until the next and computed in no time: from {start}, V = x'Px {falls} from sample "
            f"to sample{words.undisturbed(loop)}{'' if alone else blends}{stays}"
            f"{words.deviations(loop, 'xu')}"
        )


def _changes(Q: Sequence[Matrix]) -> Iterator[Matrix]:
    """Yield the Bernstein coefficients, of Q's own degree, of dQ/ds."""
    d = len(Q) - 1
    for k in range(d + 1):
        next_step, previous_step = Q[min(k + 1, d)] - Q[k], Q[k] - Q[max(k - 1, 0)]
        yield (d - k) * next_step + k * previous_step
