"""The loop whose stability is asked: a model, or a model with the gains of its rules.

From a condition on P(h) to an answer in the model's own states.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.loop_pairs import gain_stack
from takagi.lmi.analysis.slow_modes import slow_vertex
from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import Vertices, input_stack, sample_time_of, vertex_stack
from takagi.lmi.condition.rate_of_values import rate_of_values
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.cone.balance import state_units
from takagi.lmi.decision.decide import decide
from takagi.lmi.decision.diagnosis import advice_about_limit, binding_items
from takagi.lmi.decision.outcome import Outcome
from takagi.lmi.polynomials.simplex_polynomials import Basis, Known, PolynomialLyapunov, marginals
from takagi.lmi.varying.parameter_space import Space, space_of
from takagi.models.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False)
class VaryingLoop:
    """x' = A(h) x, or x' = (A(h) - B(h) K(h)) x where there are gains; x+ in discrete time.

    Attributes
    ----------
    A, B, K : (r, n, n), (r, n, m), (r, m, n); B and K are None without gains.
    space : of the memberships.
    sample_time : T in s; None for continuous time.
    """

    A: Array
    B: Array | None
    K: Array | None
    space: Space
    sample_time: float | None

    @property
    def matrix(self) -> Known:
        """Return the loop's matrix as a polynomial in h."""
        A = self.space.known(self.A)
        if self.B is None or self.K is None:
            return A
        return A - self.space.known(self.B) @ self.space.known(self.K)

    @property
    def corners(self) -> Array:
        """Return the loop's matrix at the rules, (r, n, n)."""
        return self.A if self.B is None or self.K is None else self.A - self.B @ self.K

    def units(self, scales: ArrayLike | None) -> Floats:
        """Return s, (n,): powers of two that balance the loop at its rules, or next to scales."""
        return state_units(self.corners.astype(np.float64), scales, step=self.sample_time)

    def scaled(self, s: Floats) -> VaryingLoop:
        """Return the loop in floating point, in states xhat = x / s."""
        A = self.A.astype(np.float64) * s / s[:, None]
        if self.B is None or self.K is None:
            return replace(self, A=A)
        B, K = self.B.astype(np.float64), self.K.astype(np.float64)
        return replace(self, A=A, B=B / s[:, None], K=K * s)

    def hopeless(self, alpha: float) -> str:
        """Return why no P(h) of any degree can be: a rule, or two in equal parts, too slow.

        Memberships may rest anywhere, so every blend has to decay by itself.  Empty when these do.
        """
        r, step = len(self.A), self.sample_time
        found = slow_vertex(self.corners.astype(np.float64), alpha, step=step)
        if found is not None:
            return self._said(f"rule {found[0] + 1} of {r}", found[1], alpha)
        i, j = np.triu_indices(r, 1)
        if not len(i):
            return ""
        h = (np.eye(r)[i] + np.eye(r)[j]) / 2
        matrix = self.matrix
        w = marginals(h, self.space.sizes, self.space.corners)
        blends = np.tensordot(matrix.basis.values(w), matrix.values.astype(np.float64), axes=1)
        found = slow_vertex(blends, alpha, step=step)
        if found is None:
            return ""
        a, b = int(i[found[0]]), int(j[found[0]])
        return self._said(f"the mean of rules {a + 1} and {b + 1} of {r}", found[1], alpha)

    def _said(self, which: str, eigenvalue: complex, alpha: float) -> str:
        size = "" if self.sample_time is None else f", of size {abs(eigenvalue):.6g},"
        return (
            f"{which} alone rules it out: its eigenvalue {eigenvalue:.6g}{size} does not decay "
            f"faster than {alpha:g} 1/s; stabilise it, lower the decay rate, or shrink the box"
        )


def varying_loop(
    model: Vertices, gains: ArrayLike | None = None, sample_time: float | None = None
) -> VaryingLoop:
    """Return the loop of a model, or of vertices (r, n, n); with gains its B is needed.

    Raises
    ------
    ModelError : shapes, entries that are not finite, gains without inputs, a sample time that is
        not positive or not the model's.
    """
    A = vertex_stack(model)
    step = sample_time_of(model, sample_time)
    space = space_of(model, len(A))
    if gains is None:
        return VaryingLoop(A, None, None, space, step)
    B = input_stack(model, A)
    return VaryingLoop(A, B, gain_stack(gains, *(len(A), B.shape[2], A.shape[1])), space, step)


def decided_lyapunov(
    condition: Condition, loop: VaryingLoop, s: Floats, basis: Basis, advice: str
) -> Answer:
    """Return the answer of a condition that is posed in states xhat = x / s.

    Parameters
    ----------
    basis : of P; the coefficients are the unknown ``P``.
    advice : what to do where none exists.
    """
    outcome = decide(condition)
    good = outcome.status == "candidate"
    return replace(
        outcome.as_answer(condition, s),
        lyapunov_function=lyapunov_in_states(outcome, loop, s, basis) if good else None,
        decay_rate=rate_of_values(condition, outcome.values, loop.sample_time) if good else None,
        diagnosis="" if good else _diagnosis(condition, outcome, advice),
    )


def lyapunov_in_states(
    outcome: Outcome, loop: VaryingLoop, s: Floats, basis: Basis, size: float | None = None
) -> PolynomialLyapunov:
    """Return P(h) in the model's states, times size; None makes the least eigenvalue about 1."""
    members = outcome.values["P"]
    family = PolynomialLyapunov(basis, members, loop.space.corners)
    if size is None:
        least = float(np.linalg.eigvalsh(family.vertices).min())
        size = float(np.exp2(-np.floor(np.log2(least))))
    return PolynomialLyapunov(basis, size * members / s / s[:, None], loop.space.corners)


def no_lyapunov(condition: Condition, s: Floats, why: str) -> Answer:
    """Return the no for a reason that needs no solver."""
    return Answer(
        status="infeasible",
        margin=-np.inf,
        bound=0.0,
        coordinates=s,
        condition=condition,
        diagnosis=why,
    )


def _diagnosis(condition: Condition, outcome: Outcome, advice: str) -> str:
    if outcome.status == "unknown":
        return outcome.unsettled(f"{advice_about_limit(condition)}, or give scales")
    names = [lmi.name for lmi in condition.lmis if lmi.strict]
    binding = binding_items(condition, outcome.multipliers, *names[1:])
    return f"no P(h) by these LMIs, which says nothing of others: {binding}; {advice}"
