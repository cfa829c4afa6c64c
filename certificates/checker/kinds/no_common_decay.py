r"""``no-common-decay``: no P > 0 makes V = x'Px decay at this rate along every blend of the loop.

The evidence uses blends G_k = G(h^k) at weights h^k that the loop can attain.  There are two kinds.

Multipliers Z_k = L_k L_k', not all zero, with

    continuous   S = sum_k (G_k Z_k + Z_k G_k' + 2 alpha Z_k) >= 0
    discrete     S = sum_k (G_k Z_k G_k' - rho^2 Z_k) >= 0,        rho^2 >= e^(-2 alpha T),

and S != 0 where alpha > 0.  If V(t) <= e^(-2 alpha t) V(0) held along these blends, the trace of
P S would be <= 0; but it is > 0.  At alpha = 0 V would have to decrease strictly, the trace would
be negative, and S = 0 is already a contradiction.  (For alpha > 0 it is not: x' = -x with V = x^2
at alpha = 1 has S = 0, and V = e^(-2t) V(0) decays.)

Or a single blend G with a symmetric P that is not positive definite and decreases along G as in
``decay``, here with the larger rho^2.  Then G has an eigenvalue with real part > -alpha, or of size
> rho (Lyapunov's and Stein's theorems), so that no V decays at this rate along G.

A loop can attain the weights of a single rule, h = e_i, and the weights h that the file states as
shares; the checker computes G(h) = A(h) - B(h) K(h).  Where weights are products of the weights of
premises, the file states the shares of each premise, and h_i = prod_k w_k,c_ik.  The mean of G_ij
and G_ji is not such a blend, because h_i h_j never occurs without h_i^2 and h_j^2.  For a law with
its own weights it is not known which gains and which rules act together, so that nothing can be
disproved.

The claim disproves a common quadratic function, not stability: another kind of function may exist.
It is about all weights; a plant contained in the model need not attain all of them.

Evidence: ``decay_rate``, and ``multipliers`` [{blend, factor}] or ``blend`` and ``P``.  A ``blend``
is the number of a rule, from 0, or the shares: one row of numbers >= 0 for each premise, or for all
rules where weights are no products; a row is divided by its sum.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 2.2; Ostrowski and Schneider (1962) on
the inertia, recalled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import prod
from typing import Any, ClassVar

from takagi.certificates.checker.arithmetic.exponential import exp_above
from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import (
    Obligations,
    never,
    nonnegative,
    not_positive,
    positive,
)
from takagi.certificates.checker.kernel.reader import Number, integer, member, numbers, read_matrix
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Verdict
from takagi.certificates.checker.kinds.decay import decrease
from takagi.certificates.checker.kinds.loop_claim import LoopClaim, number
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, Stack, bounded
from takagi.certificates.checker.words.loop_words import about
from takagi.certificates.checker.words.rounded import at_most

Weights = list[Fraction]
NOT_EXCLUDED = "the evidence does not exclude a common P"
MOST_NAMED = 4


@dataclass(frozen=True)
class NoCommonDecay(LoopClaim):
    """No P > 0 makes V = x'Px decay at ``decay_rate``; see the module."""

    shows: ClassVar[Verdict] = Verdict.DISPROVED
    decay_rate: Fraction = number("1/s")

    def obligations(self) -> Obligations:
        loop, where = self.loop, self.where
        yield nonnegative(self.decay_rate, "the decay rate is negative")
        if len(loop.K) > 1 and not loop.shared_weights:
            yield never("the law has weights of its own: which gain meets which rule is not known")
        if loop.at_other_ends:
            yield never(
                "not shown: a loop with numbers that are no fractions: tried at their ends alone"
            )
        factor = self._factor()
        if "multipliers" in self.claim:
            yield from self._multipliers_exclude(factor)
            return
        G = _closed(loop, _weights(self.claim, loop, where))
        P = read_matrix(self.claim, "P", where, (loop.order, loop.order))
        yield positive(decrease(loop, P, G, factor), NOT_EXCLUDED)
        yield not_positive(P, NOT_EXCLUDED)

    def _factor(self) -> Fraction:
        """Return 2 alpha in continuous time, rho^2 >= e^(-2 alpha T) in discrete time."""
        rate, step = self.decay_rate, self.loop.sample_time
        if step is None:
            return 2 * rate
        # Rounded up: a larger rho^2 makes it harder to disprove a common P.
        return exp_above(2 * rate * step) if rate else Fraction(1)

    def _multipliers_exclude(self, factor: Fraction) -> Obligations:
        """Yield S >= 0 with multipliers that are not all zero, and S != 0 where alpha > 0."""
        loop = self.loop
        total, size = Matrix.zeros(loop.order, loop.order), Fraction(0)
        for entry_place, entry in self._entries():
            G = _closed(loop, _weights(entry, loop, entry_place))
            L = read_matrix(entry, "factor", entry_place)
            Z = L @ L.T
            size += Z.trace
            total = (total + _dual(loop, G, Z, factor)).reduced()
        # For alpha > 0 the claimed decay allows equality, so a zero sum would not contradict it.
        if self.decay_rate > 0 and not any(map(any, total.rows)):
            yield never(NOT_EXCLUDED)
        yield positive(size, NOT_EXCLUDED)
        yield nonnegative(total, NOT_EXCLUDED)

    def _entries(self) -> list[tuple[str, Any]]:
        """Return the multipliers with their places, or the claim itself where it has none."""
        if "multipliers" not in self.claim:
            return [(self.where, self.claim)]
        entries = member(self.claim, "multipliers", self.where)
        if not entries or not isinstance(entries, list):
            raise CertificateError(f"{self.where}.multipliers: a list of them is needed")
        bounded(len(entries), self.loop.order)
        return [(f"{self.where}.multipliers[{i}]", entry) for i, entry in enumerate(entries)]

    def sentence(self) -> str:
        loop, rate = self.loop, self.decay_rate
        blends = [_weights(entry, loop, entry_place) for entry_place, entry in self._entries()]
        named_blends = ", ".join(map(_blend_name, blends[:MOST_NAMED]))
        and_more = f" and {len(blends) - MOST_NAMED} more" if len(blends) > MOST_NAMED else ""
        at_once = "falls in each sample" if loop.is_discrete else "has V' < 0"
        falls_so = f"decays at {at_most(rate, 6)} 1/s" if rate else f"{at_once} wherever x is not 0"
        return (
            f"no common quadratic function {falls_so} along {about(loop)}: "
            f"none does along {named_blends}{and_more}"
        )


def _blend_name(h: Sequence[Fraction]) -> str:
    """Return a blend by its rules, with their shares where these are few."""
    active_rules = [i for i, share in enumerate(h) if share]
    if len(active_rules) == 1:
        return f"rule {active_rules[0] + 1} alone"
    if len(active_rules) > MOST_NAMED:
        return f"a blend of {len(active_rules)} rules"
    return " + ".join(f"{h[i]} rule {i + 1}" for i in active_rules)


def _dual(loop: PolytopicLoop, G: Matrix, Z: Matrix, factor: Fraction) -> Matrix:
    GZ = G @ Z
    if loop.is_discrete:
        return GZ @ G.T - factor * Z
    return GZ + GZ.T + factor * Z


def _closed(loop: PolytopicLoop, h: Weights) -> Matrix:
    """Return G(h) = A(h) - B(h) K(h)."""
    A = _at(loop.A, h)
    return A - _at(loop.B, h) @ _at(loop.K, h) if loop.K and loop.B else A


def _weights(owner: Any, loop: PolytopicLoop, where: str) -> Weights:
    """Return h, (rules,)."""
    if isinstance(member(owner, "blend", where), Number):
        k = integer(owner, "blend", where)
        if not 0 <= k < loop.rules:
            raise CertificateError(f"{where}.blend: 0 to {loop.rules - 1} is needed")
        return [Fraction(i == k) for i in range(loop.rules)]
    corners = loop.corners or tuple((i,) for i in range(loop.rules))
    rows = owner["blend"]
    if not isinstance(rows, list) or len(rows) != len(corners[0]):
        raise CertificateError(f"{where}.blend: a rule, or {len(corners[0])} rows are needed")
    size = 2 if loop.corners else loop.rules
    w = [numbers({"blend": row}, "blend", where, size) for row in rows]
    if any(min(row) < 0 or sum(row) == 0 for row in w):
        raise CertificateError(f"{where}.blend: shares >= 0, not all 0, are needed")
    h = [
        prod((row[c] / sum(row) for row, c in zip(w, rule, strict=True)), start=Fraction(1))
        for rule in corners
    ]
    # Products of weights sum to 1 only if the rules cover every combination of corners.
    if sum(h) != 1:
        raise CertificateError(f"{where}.blend: the rules leave out a combination of corners")
    return h


def _at(stack: Stack, h: Weights) -> Matrix:
    """Return sum_i h_i X_i; a stack of one matrix is the same for all rules."""
    if len(stack) == 1:
        return stack[0]
    terms = [share * X for share, X in zip(h, stack, strict=True) if share]
    return sum(terms[1:], terms[0]).reduced()
