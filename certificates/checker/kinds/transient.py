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

from dataclasses import dataclass
from fractions import Fraction
from typing import ClassVar

from takagi.certificates.checker.arithmetic.exponential import exp_above
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import Obligations, nonnegative, positive
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kinds.decay import falls_along
from takagi.certificates.checker.kinds.loop_claim import (
    NOT_DEFINITE,
    LoopClaim,
    matrix,
    number,
    numbers,
)
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.words import loop_words as words
from takagi.certificates.checker.words.rounded import at_least, at_most


@dataclass(frozen=True)
class Transient(LoopClaim):
    """A bound of overshoot and settling time; see the module."""

    asks: ClassVar[tuple[str, ...]] = ("scales", "settled_share")
    P: Matrix = matrix("n", "n")
    scales: list[Fraction] = numbers("n")
    decay_rate: Fraction = number("1/s", better="larger", positive=True)
    lower: Fraction = number(positive=True)
    overshoot: Fraction = number(better="smaller", positive=True)
    settled_share: Fraction = number(positive=True)
    settling_time: Fraction = number("s", better="smaller", positive=True)

    def obligations(self) -> Obligations:
        loop, P = self.loop, self.P
        if min(self.scales) <= 0:
            raise CertificateError(f"{self.where}.scales: positive numbers are needed")
        if loop.sample_time and (self.settling_time / loop.sample_time).denominator != 1:
            raise CertificateError(
                f"{self.where}.settling_time: a whole number of samples is needed"
            )
        yield positive(P, NOT_DEFINITE)
        weight = self.lower * Matrix.diagonal([1 / s**2 for s in self.scales])
        yield nonnegative(P - weight, "P is not above p S^-2")
        yield nonnegative(self.overshoot**2 * weight - P, "P is not below kappa^2 p S^-2")
        blends = blends_of(loop, self.claim, self.where)
        yield from falls_along(loop, P, self.decay_rate, ((b.label, b.A) for b in blends))
        # e^(-alpha t_s) is rounded up, which makes the test stronger.
        settled = self.overshoot * exp_above(self.decay_rate * self.settling_time)
        yield nonnegative(self.settled_share - settled, "the state may not have settled by then")

    def sentence(self) -> str:
        loop = self.loop
        units = "" if set(self.scales) == {Fraction(1)} else " in the states over their scales"
        return (
            f"|x(t)| <= {at_most(self.overshoot, 6)} exp(-{at_least(self.decay_rate, 6)} t) "
            f"|x(0)|{units}, so at most {at_most(self.settled_share, 6)} |x(0)| after "
            f"{at_most(self.settling_time, 6)} s,{words.undisturbed(loop)} "
            f"along {words.about(loop)}{words.while_valid(loop)}{words.deviations(loop, 'x')}"
        )
