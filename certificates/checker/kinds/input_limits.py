r"""``input-limits``: bounds of |u_k|, and of |u_k'| or |u_k(x+) - u_k(x)|, on an invariant set.

On an invariant set {x'Px <= c} of ``invariant_ellipsoid``, for u = -sum_j g_j K_j x, every gain j
and every input k,

    [[P, k_j'], [k_j, ubar_k^2 / c]] >= 0,     k_j row k of K_j,     so |k_j x| <= ubar_k,

and by convexity the blend keeps the limit.  ``input_rate`` has the conditions of ``rate_limits``.

Evidence: that of ``invariant_ellipsoid``; ``input_limits``, (m,); where rates are claimed
``rate_limits`` with the evidence of ``input_rate``.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.2.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction

from takagi.certificates.checker.kernel.obligation import Obligations
from takagi.certificates.checker.kinds.input_rate import assumed_rates, rate_obligations
from takagi.certificates.checker.kinds.invariant_ellipsoid import InvariantSet
from takagi.certificates.checker.kinds.loop_claim import numbers
from takagi.certificates.checker.loop.box_of_validity import reaches_at_most
from takagi.certificates.checker.loop.polytopic_loop import bounded
from takagi.certificates.checker.words.loop_words import about, deviations
from takagi.certificates.checker.words.rounded import at_least, at_most


@dataclass(frozen=True)
class InputLimits(InvariantSet):
    """|u_k| <= ``input_limits``_k on an invariant set; see the module."""

    input_limits: list[Fraction] = numbers("m", "", better="smaller", label="limit of input")
    rate_limits: list[Fraction] | None = numbers(
        "m", "", better="smaller", label="limit of rate of input", optional=True
    )

    def obligations(self) -> Obligations:
        loop, limits = self.loop, self.input_limits
        yield from super().obligations()
        bounded(len(loop.K) * len(limits), loop.order + 1)
        for j, gain in enumerate(loop.K):
            for k, limit in enumerate(limits):
                failure = f"gain {j + 1} may exceed the limit of input {k + 1}"
                yield reaches_at_most(self.P, self.level, gain.row(k), limit, failure)
        if self.rate_limits is not None:
            yield from rate_obligations(self, self.rate_limits)

    def sentence(self) -> str:
        return (
            f"|u_k| <= {_most(self.input_limits)} for u = -Kx, from anywhere in "
            f"{self.set_in_words}{self._rate()}, along {about(self.loop)}; the set is "
            f"invariant{self.where_valid}; {self.motion}"
            f"{deviations(self.loop, 'xu' + self.own_letter)}"
        )

    def _rate(self) -> str:
        if self.rate_limits is None:
            return ""
        move = "|u_k(x+) - u_k(x)|" if self.loop.is_discrete else "|u_k'|"
        rate_bounds = ", ".join(at_least(value, 6) for value in assumed_rates(self))
        assumed = f" for memberships with |h_j'| <= {rate_bounds}" if rate_bounds else ""
        return f" and {move} <= {_most(self.rate_limits)}{assumed}"


def _most(limits: Sequence[Fraction]) -> str:
    return ", ".join(at_most(limit, 6) for limit in limits)
