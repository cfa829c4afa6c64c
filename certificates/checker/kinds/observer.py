r"""``observer``: the error e = x - xhat of an observer decays, with one P > 0 for all blends.

The observer xhat' = sum_i h_i (A_i xhat + B_i u + L_i (y - yhat)) (xhat+ in discrete time) knows
the weights h of the plant, because its premises are measured.  If the model states on which
variables they depend, each must be an input, or a state that is itself an output without
feedthrough of an input.  Otherwise the claim assumes that they are measured.  The weights of a
secant embedding are averages between the equilibrium and the state, which cannot be measured: both
claims are refused for it, unless A, B, C and D are the same in all rules.  With known weights the
effect of the input cancels, and

    e' = sum_ij h_i h_j (A_i - L_j C_i) e.

With ``secants`` S_k the plant has an additional part f(x) that is not measured, and the observer
uses f(xhat).  The claim assumes f(x) - f(xhat) = S e with S in the hull of the S_k:

    e' = sum_i h_i sum_k g_k (A_i + S_k - L C_i) e,     with one L, because g is not known.

The inequalities are those of ``decay`` for these matrices.

Evidence: ``L``, one or r matrices (n, p); ``P``; ``decay_rate`` [1/s]; ``secants``.

Source: Tanaka and Wang (2001), chapter 4; secants by the mean value theorem.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.kernel.matrices import Matrix
from takagi.certificates.checker.kernel.obligation import (
    Obligations,
    never,
    nonnegative,
    positive,
)
from takagi.certificates.checker.kernel.reader import read_stack
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kinds.decay import falls_along, falls_as
from takagi.certificates.checker.kinds.loop_claim import NOT_DEFINITE, LoopClaim, matrix, number
from takagi.certificates.checker.loop.averages import refuse_averages
from takagi.certificates.checker.loop.blends import blends_of
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, Stack, at, bounded
from takagi.certificates.checker.words import loop_words as words

EXACT = "exact outputs and premises that the observer measures"


@dataclass(frozen=True)
class Observer(LoopClaim):
    """The error of the observer decays at ``decay_rate``; see the module."""

    decay_rate: Fraction = number("1/s", better="larger")
    P: Matrix = matrix("n", "n")

    def __post_init__(self) -> None:
        refuse_averages(self.loop, "observer", self.where)

    def matrices(self) -> Iterator[tuple[str, Matrix]]:
        """Yield the matrices along which V decays, each with a name."""
        loops = secant_loops if "secants" in self.claim else error_loops
        return loops(self.claim, self.loop, self.where)

    def obligations(self) -> Obligations:
        yield nonnegative(self.decay_rate, "the decay rate is negative")
        if hidden := hidden_premises(self.loop):
            yield never(f"premises depend on {hidden}, which is not measured")
        yield positive(self.P, NOT_DEFINITE)
        yield from falls_along(self.loop, self.P, self.decay_rate, self.matrices())

    def sentence(self) -> str:
        several = " and premises that the observer measures" * (self.loop.rules > 1)
        secants = f"exact outputs and secants of f in the stated hull{several}"
        assumed = secants if "secants" in self.claim else EXACT
        return self.decays("the error x - xhat of the observer", assumed)

    def decays(self, argument: str, assumed: str, letters: str = "") -> str:
        """Return that V of ``argument`` decays; ``letters`` : those of ``deviations``."""
        loop = self.loop
        return (
            f"V of {argument}, for {assumed}, {falls_as(loop, self.decay_rate)} along every blend "
            f"of {loop.rules} rules{words.while_valid(loop)}{words.deviations(loop, letters)}"
        )


def hidden_premises(loop: PolytopicLoop) -> str:
    """Return a premise variable that no output measures directly; empty if all are measured."""
    for name in loop.scheduled_by or ():
        if name in loop.inputs:
            continue
        k = loop.states.index(name) if name in loop.states else -1
        count = loop.C[0].shape[0] if loop.C else 0
        if not any(_shows(loop, i, k) for i in range(count)):
            return name
    return ""


def _shows(loop: PolytopicLoop, i: int, k: int) -> bool:
    """Return whether output i is a multiple of state k, the same in all rules, and nothing else.

    A feedthrough that differs by rule could not be subtracted from the output.
    """
    alone = all(_only(C.rows[i]) == k for C in loop.C)
    fed = any(any(row) for D in loop.D for row in D.rows[i : i + 1])
    return alone and not fed and len({C[i, k] for C in loop.C}) == 1


def _only(row: list[int]) -> int | None:
    """Return the index of the only nonzero entry; None for none or several."""
    nonzero_columns = [j for j, entry in enumerate(row) if entry]
    return nonzero_columns[0] if len(nonzero_columns) == 1 else None


def _gains(claim: Any, loop: PolytopicLoop, where: str) -> Stack:
    """Return L, and check that it fits the outputs."""
    if not loop.C:
        raise CertificateError(f"{where}: the model has no output to observe from")
    L = read_stack(claim, "L", where)
    needed = (loop.order, loop.C[0].shape[0])
    if L[0].shape != needed or len(L) not in (1, loop.rules):
        raise CertificateError(
            f"{where}.L: {needed[0]} by {needed[1]} is needed, one or {loop.rules} of them"
        )
    return L


def secant_loops(claim: Any, loop: PolytopicLoop, where: str) -> Iterator[tuple[str, Matrix]]:
    """Yield A_i + S_k - L C_i."""
    L = _gains(claim, loop, where)
    if loop.scheduled_by is not None:
        raise CertificateError(f"{where}.secants: this model is a whole plant, with no f besides")
    secants, n = read_stack(claim, "secants", where), loop.order
    if len(L) != 1 or secants[0].shape != (n, n):
        raise CertificateError(f"{where}: one L and secants of {n} by {n} are needed")
    bounded(loop.rules * len(secants), n)
    for i in range(loop.rules):
        error = at(loop.A, i) - L[0] @ at(loop.C, i)
        for k, secant in enumerate(secants):
            yield f"rule {i + 1} and secant {k + 1}", error + secant


def error_loops(claim: Any, loop: PolytopicLoop, where: str) -> Iterator[tuple[str, Matrix]]:
    """Yield the mean of A_i - L_j C_i over each group of pairs with equal weights."""
    L = _gains(claim, loop, where)
    for blend in blends_of(_of_error(loop, L), claim, where):
        yield blend.label, blend.A.T


def joint_loops(
    claim: Any, loop: PolytopicLoop, where: str, L: Stack | None = None
) -> Iterator[tuple[str, Matrix]]:
    """Yield the mean of the matrix of z = (x, e) over each group of pairs with equal weights.

    Parameters
    ----------
    L : gains of an observer that is a part of the law; None takes those of the claim.
    """
    L = _gains(claim, loop, where) if L is None else L
    if not loop.K or not loop.shared_weights:
        raise CertificateError(f"{where}: gains with the weights of the model are needed")
    zero = Matrix.zeros(loop.order, loop.order)
    error, closed_loop = _of_error(loop, L), replace(loop, C=(), D=(), E=())
    if len(closed_loop.groups()) != len(error.groups()):
        # One of the two loops is affine in h and would be tested rule by rule; both must have the
        # same groups of pairs to form one matrix.
        error, closed_loop = _pair_by_pair(error), _pair_by_pair(closed_loop)
    blends = blends_of(closed_loop, claim, where)
    bounded(len(blends), 2 * loop.order)
    for loop_blend, error_blend in zip(blends, blends_of(error, claim, where), strict=True):
        push = loop_blend.of(loop_blend.loop.A) - loop_blend.A
        yield loop_blend.label, Matrix.blocks([[loop_blend.A, push], [zero, error_blend.A.T]])


def _of_error(loop: PolytopicLoop, L: Stack) -> PolytopicLoop:
    """Return (A_i - L_j C_i)' as the closed loop of A_i' and C_i' with gains L_j'."""
    A, C, K = (tuple(M.T for M in stack) for stack in (loop.A, loop.C, L))
    return replace(loop, A=A, B=C, C=(), D=(), E=(), K=K, shared_weights=True)


def _pair_by_pair(loop: PolytopicLoop) -> PolytopicLoop:
    B, K = (stack if len(stack) > 1 else stack * loop.rules for stack in (loop.B, loop.K))
    return replace(loop, B=B, K=K)
