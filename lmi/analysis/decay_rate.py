"""The largest decay rate one quadratic function can show: a generalised eigenvalue problem."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from takagi.lmi.analysis.quadratic import (
    answer_in_states,
    common_lyapunov_condition,
    rate_of,
    rates_of,
    vertex_weight,
)
from takagi.lmi.answer import Answer, Floats, Try
from takagi.lmi.evaluate import margin
from takagi.lmi.intake import Vertices, number, vertex_stack
from takagi.lmi.solver.balance import state_units
from takagi.lmi.solver.solve import Session
from takagi.lmi.solver.stages import Outcome, decide
from takagi.lmi.solver.vertex_rounds import first_vertices
from takagi.lmi.term import Condition

__all__ = ["max_decay_rate", "rate_bound"]

Indices: TypeAlias = NDArray[np.intp]

STEPS, ROUNDS, ADDED = 60, 40, 12
# Reciprocal condition number of P, in balanced states, below which it is not used.
WORST = 1e-8


def max_decay_rate(
    model: Vertices, *, tolerance: float = 1e-6, scales: ArrayLike | None = None
) -> Answer:
    """Return the largest alpha, and its P, with A_i' P + P A_i + 2 alpha P <= 0 at every vertex.

    Each step poses the condition in coordinates where the last P is the identity, at the rate
    that P shows, and asks for the P with the largest margin: its rate is higher (Dinkelbach's
    iteration), and the multipliers bound every rate from above.  It ends when the two meet.

    Parameters
    ----------
    model : a model (its A), or vertices (N, n, n).
    tolerance : relative to the rate, and to the size of the vertices when the rate is near 0.
    scales : (n,) engineering range of each state; None balances the vertices.

    Returns
    -------
    An ``Answer``: ``decay_rate`` is what the returned P shows, recomputed from it, a hair below
    the largest; ``bound`` is above every rate, to solver accuracy.  The rate may be negative:
    then V grows at most that fast, and the status is still "candidate".

    Not promised: the supremum may not be attained (a defective eigenvalue); then P is badly
    conditioned near it, and the answer stops short of it by more than the tolerance.

    Raises
    ------
    ModelError : shapes, no vertices, entries that are not finite.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1.3; Crouzeix, Ferland and
    Schaible (1985), JOTA 47, for the iteration.
    """
    A = vertex_stack(model).astype(np.float64)
    tolerance = float(number("tolerance", tolerance, at_least=1e-12))
    s = state_units(A, scales)
    scaled = A * s / s[:, None]
    chosen = first_vertices(scaled)
    best = _Best(np.eye(A.shape[1]), np.inf, tolerance)
    for _ in range(ROUNDS):
        best.ascend(scaled[chosen])
        rates = rates_of(scaled, best.P)
        order = np.argsort(rates)
        fresh = order[~np.isin(order, chosen)][:ADDED]
        if not len(fresh) or rates[fresh[0]] >= rates[chosen].min() - best.step(scaled[chosen]):
            break
        chosen = np.concatenate([chosen, fresh])
    condition, outcome = best.centre(scaled, chosen)
    answer = answer_in_states(condition, outcome, A, s)
    return replace(answer, bound=best.upper, tries=(*best.tries, *outcome.tries))


def rate_bound(A: Floats, Z: Floats) -> float:
    """Return the alpha that multipliers Z_i >= 0 rule out: none above it has a common P.

    The smallest alpha with sum_i (A_i Z_i + Z_i A_i') + 2 alpha sum_i Z_i >= 0: were there a P
    for a larger one, the trace of P times this sum would be negative and nonnegative at once.
    """
    flow = (A @ Z).sum(axis=0)
    total = Z.sum(axis=0)
    eigenvalues, vectors = np.linalg.eigh(total)
    # Directions without multipliers bound nothing; a little of every direction keeps it finite.
    eigenvalues = np.maximum(eigenvalues, 1e-13 * eigenvalues[-1])
    root = vectors / np.sqrt(eigenvalues)
    inside = root.T @ (flow + flow.T) @ root
    return -float(np.linalg.eigvalsh(inside)[0]) / 2


class _Best:
    """The P found so far, with the bound on every rate and the work done."""

    def __init__(self, P: Floats, upper: float, tolerance: float) -> None:
        self.P, self.upper, self.tolerance = P, upper, tolerance
        self.tries: list[Try] = []
        self._session = Session()

    def step(self, A: Floats) -> float:
        """Return the difference in rate that does not matter."""
        return self.tolerance * max(abs(rate_of(A, self.P)), 1e-3 * vertex_weight(A))

    def ascend(self, A: Floats) -> None:
        """Climb to the largest rate of these vertices, and bound it from above."""
        self.upper = np.inf
        rate = rate_of(A, self.P)
        for _ in range(STEPS):
            found = self._solve(A, rate)
            shown = -np.inf if found is None else rate_of(A, found)
            if found is not None and shown > rate:
                gained, rate, self.P = shown - rate, shown, found
                if self.upper - rate > self.step(A) and gained > self.step(A) / 10:
                    continue
            if self.upper - rate <= self.step(A) or self._ruled_out(A, rate + self.step(A)):
                return

    def centre(self, A: Floats, chosen: Indices) -> tuple[Condition, Outcome]:
        """Return the best conditioned P a hair below the rate, with its check over all."""
        rate = float(rates_of(A, self.P).min())
        aim = rate - self.step(A[chosen])
        condition = common_lyapunov_condition(A[chosen], decay_rate=aim)
        outcome = decide(condition)
        if outcome.status != "candidate" or rates_of(A, outcome.values["P"][0]).min() < aim:
            P = self.P / np.linalg.eigvalsh(self.P)[-1]
            held = margin(condition, {"P": P[None]})
            outcome = replace(outcome, status="candidate", values={"P": P[None]}, margin=held)
        return condition, outcome

    def _solve(self, A: Floats, rate: float) -> Floats | None:
        """Return the P of the largest margin at this rate, posed where the last P is I."""
        R = np.linalg.cholesky(self.P).T
        inside = np.linalg.solve(R.T, (R @ A).transpose(0, 2, 1)).transpose(0, 2, 1)
        shifted = inside + rate * np.eye(len(R))
        condition = common_lyapunov_condition(
            inside, decay_rate=rate, weight=vertex_weight(shifted)
        )
        outcome = decide(condition, session=self._session, most=1)
        self.tries.extend(outcome.tries)
        if outcome.status == "infeasible":
            self.upper = min(self.upper, rate)
        if "vertex" in outcome.multipliers:
            self.upper = min(self.upper, rate_bound(inside, outcome.multipliers["vertex"]))
        better = outcome.values.get("P")
        if better is None:
            return None
        P = R.T @ better[0] @ R
        P = np.asarray((P + P.T) / np.linalg.norm(P))
        # Near a supremum that is not attained P degenerates; what it shows is then worth nothing.
        return P if np.linalg.eigvalsh(P)[0] > WORST else None

    def _ruled_out(self, A: Floats, rate: float) -> bool:
        """Look just above the rate: either nothing is there, or a better P."""
        found = self._solve(A, rate)
        if found is not None and rate_of(A, found) > rate_of(A, self.P):
            self.P = found
            return self.upper <= rate
        return True
