r"""``fuzzy-l2-gain``: the energy gain of a loop by V = x'P(w)x, P a polynomial in the weights.

    x' = G(w) x + E(w) d,   y = C(w) x + D(w) d        (x+ in the place of x' in discrete time)

is the closed loop, d the disturbance, w the weights, as for ``fuzzy-decay``.  With gamma > 0 the
following polynomials are multiplied by the power ``polya`` of the sum of the weights, which is 1;
then every coefficient must be positive definite:

    P(w) > 0
    continuous   [ -(P G + G'P + sum_kc v_kc dP/dw_kc)(w)   -P(w) E(w)   C(w)'   ]
                 [ .                                        gamma I      D(w)'   ] > 0
                 [ .                                        .            gamma I ]
                 at every corner v of the speeds |v_kc| <= rate_kc, sum_c v_kc = 0
    discrete     [ P(w)   0         C(w)'     G(w)'P_b ]
                 [ .      gamma I   D(w)'     E(w)'P_b ]
                 [ .      .         gamma I   0        ]
                 [ .      .         .         P_b      ] > 0     for every P_b

with P_b the Bernstein coefficients of P.

Theorem.  Then |y|_2 <= gamma |d|_2 from x(0) = 0; in continuous time this holds for all weights
whose rates keep their bounds.  Proof: by a Schur complement with the last row and column, the
continuous inequality says V' < gamma |d|^2 - |y|^2 / gamma for (x, d) other than 0.  Here
V' = 2 x'P (G x + E d) + x'(dP/dt)x, and dP/dt = sum_kc w_kc' dP/dw_kc is affine in the speeds,
which lie in the hull of the corners.  The integral from 0, with V(0) = 0 and V >= 0, is the claim.
In discrete time P at the next sample is a convex combination of the P_b, and the inequality is
affine in P_b: the Schur complement with that combination gives
V(x+) - V < gamma |d|^2 - |y|^2 / gamma, and the sum over all samples is the claim.  The weights may
jump.

Evidence: ``degrees``, ``P``, ``rates``, ``polya`` and ``halvings`` as for ``fuzzy-decay``;
``gain``, and the channel, ``disturbance`` and ``output``, as for ``l2-gain``.  Refused for weights
that are averages, and for a law with weights of its own.

Source: Oliveira and Peres (2007), IEEE Trans. Automatic Control 52(7), for polynomial P; Gahinet
and Apkarian (1994), Int. J. Robust and Nonlinear Control 4, for the bounded real lemma; recalled.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import ClassVar

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kinds.disturbance_channel import channel_stacks
from takagi.certificates.checker.kinds.fuzzy_decay import (
    Conditions,
    ScheduledFunction,
    WeightedFunctionClaim,
    closed_polynomial,
    scheduled_function,
    sizes_of,
)
from takagi.certificates.checker.kinds.loop_claim import number
from takagi.certificates.checker.kinds.simplex_polynomial import (
    Polynomial,
    blocks,
    constant_polynomial,
)
from takagi.certificates.checker.loop.averages import refuse_averages
from takagi.certificates.checker.words import loop_words as words
from takagi.certificates.checker.words.rounded import at_most


@dataclass(frozen=True)
class FuzzyL2Gain(WeightedFunctionClaim):
    """|y|_2 <= gain |d|_2 along the loop, by V = x'P(w)x; see the module."""

    asks: ClassVar[tuple[str, ...]] = ("disturbance", "entering", "output")
    gain: Fraction = number("-", better="smaller", positive=True)

    @cached_property
    def function(self) -> ScheduledFunction:
        loop = self.loop
        refuse_averages(loop, "function", self.where)
        loop_with_output, entering, _ = channel_stacks(self.claim, loop, self.where)
        width = entering[0].shape[1] + loop_with_output.C[0].shape[0]
        order = (2 if loop.is_discrete else 1) * loop.order + width
        count = len(loop.corners[0]) if loop.corners else 1
        return scheduled_function(self.claim, loop, self.where, order, [2] * count)

    def conditions(self) -> Conditions:
        loop, where, gain, function = self.loop, self.where, self.gain, self.function
        with_output, entering, direct = channel_stacks(self.claim, loop, where)
        P, G = function.P, closed_polynomial(loop, loop.A, loop.B, where)
        E = closed_polynomial(with_output, entering, (), where)
        C = closed_polynomial(with_output, with_output.C, with_output.D, where)
        height, width = with_output.C[0].shape[0], entering[0].shape[1]
        D = constant_polynomial(sizes_of(loop), Matrix.zeros(height, width))
        for stack in direct:
            D = D + closed_polynomial(with_output, stack, (), where)
        required: Conditions = [(P, "P is not shown to be positive:")]
        if loop.is_discrete:
            words = "the inequality at the next sample fails at"
            required += [(_jump(P, b, G, E, C, D, gain), words) for b in function.coefficients]
        else:
            words = "the inequality at a corner of the rates fails at"
            PG, PE = P @ G, P @ E
            required += [
                (_flow(-(PG + PG.T + P.derivative(v)), PE, C, D, gain), words)
                for v in function.speeds
            ]
        return [(X.raised(function.polya), words) for X, words in required]

    def sentence(self) -> str:
        loop = self.loop
        return (
            f"the energy of y is at most {at_most(self.gain, 6)}^2 times that of w, from rest, "
            f"along {words.about(loop)}, {self.motion_of_weights}, shown by V = x'P(h)x "
            f"({words.rounded_channel(self.claim, loop)}){words.while_valid(loop)}"
            f"{words.channel_deviations(self.claim, loop)}"
        )


def _flow(
    top: Polynomial, PE: Polynomial, C: Polynomial, D: Polynomial, gain: Fraction
) -> Polynomial:
    """Return the module's matrix of continuous time."""
    n, q = next(iter(PE.terms.values())).shape
    p = next(iter(C.terms.values())).shape[0]
    return blocks(
        [
            [top, -PE, C.T],
            [-PE.T, gain * Matrix.identity(q), D.T],
            [C, D, gain * Matrix.identity(p)],
        ],
        (n, q, p),
    )


def _jump(
    P: Polynomial,
    b: Matrix,
    G: Polynomial,
    E: Polynomial,
    C: Polynomial,
    D: Polynomial,
    gain: Fraction,
) -> Polynomial:
    """Return the module's matrix of discrete time, for one P_b at the next sample."""
    q, p = next(iter(E.terms.values())).shape[1], next(iter(C.terms.values())).shape[0]
    b_times_G, b_times_E = G.after(b), E.after(b)
    n = b.shape[0]
    return blocks(
        [
            [P, Matrix.zeros(n, q), C.T, b_times_G.T],
            [Matrix.zeros(q, n), gain * Matrix.identity(q), D.T, b_times_E.T],
            [C, D, gain * Matrix.identity(p), Matrix.zeros(p, n)],
            [b_times_G, b_times_E, Matrix.zeros(n, p), b],
        ],
        (n, q, p, n),
    )
