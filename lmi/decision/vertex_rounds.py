"""Many vertices: give the solver few, check all, add the most violated, until none is violated.

For a common P, whose condition is never even posed over all vertices; ``item_rounds`` is for any
other condition.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from takagi.lmi.answer import Try
from takagi.lmi.condition.evaluate import smallest_eigenvalues
from takagi.lmi.condition.term import Condition
from takagi.lmi.decision.decide import decide
from takagi.lmi.decision.outcome import Outcome
from takagi.models.arrays import Floats, Indices

# Below this many vertices one solve of all is quicker than rounds.
ALL_AT_ONCE = 48
FIRST, ADDED, ROUNDS = 12, 12, 60
# A P is good enough when the left-out vertices keep this share of the margin of those given.
ENOUGH = 0.5
# Bounds the memory of the batched eigenvalues.
CHUNK = 20_000


def decide_by_rounds(
    A: Floats, alpha: float, pose: Callable[..., Condition], *, most: int = 99
) -> tuple[Condition, Outcome]:
    """Return the last condition posed and its outcome, whose margin is over all vertices.

    A no for some vertices is a no for all.  The labels of the condition's vertices are those of
    the whole set.

    Parameters
    ----------
    A : (N, n, n).
    pose : builder called as pose(vertices, decay_rate=, weight=).
    most : as for ``decide``, for each round.
    """
    weight = _weight(A)
    if len(A) <= ALL_AT_ONCE:
        condition = pose(A, decay_rate=alpha, weight=weight)
        return condition, decide(condition, most=most)
    chosen = first_vertices(A)
    tries: list[Try] = []
    for _ in range(ROUNDS):
        condition = _labelled(pose(A[chosen], decay_rate=alpha, weight=weight), chosen, len(A))
        outcome = decide(condition, most=most)
        tries += outcome.tries
        if outcome.status != "candidate":
            return condition, replace(outcome, tries=tuple(tries))
        margins = _margins(A, alpha, outcome.values["P"], pose, weight)
        worst = float(margins.min())
        if worst >= ENOUGH * outcome.margin:
            smallest_margin = min(worst, outcome.margin)
            return condition, replace(outcome, margin=smallest_margin, tries=tuple(tries))
        chosen = _more(chosen, margins)
    return condition, replace(outcome, status="unknown", margin=worst, tries=tuple(tries))


def _weight(A: Floats) -> float:
    # The Frobenius norm bounds the spectral one, and is cheap for a hundred thousand vertices.
    largest = float(np.sqrt((A * A).sum(axis=(1, 2)).max()))
    return 2.0 * largest if largest > 0 else 1.0


def first_vertices(A: Floats) -> Indices:
    """Return which vertices to begin with: the slowest and the farthest from the mean."""
    if len(A) <= ALL_AT_ONCE:
        return np.arange(len(A))
    symmetric = A + A.transpose(0, 2, 1)
    slowest = np.argsort(-_largest(symmetric))[: FIRST // 2]
    distance = np.abs(A - A.mean(axis=0)).sum(axis=(1, 2))
    return np.unique(np.concatenate([slowest, np.argsort(-distance)[: FIRST // 2]]))


def _largest(symmetric: Floats) -> Floats:
    chunks = [
        np.linalg.eigvalsh(symmetric[k : k + CHUNK])[:, -1] for k in range(0, len(symmetric), CHUNK)
    ]
    return np.concatenate(chunks)


def _margins(
    A: Floats, alpha: float, P: Floats, pose: Callable[..., Condition], weight: float
) -> Floats:
    chunks = []
    for k in range(0, len(A), CHUNK):
        condition = pose(A[k : k + CHUNK], decay_rate=alpha, weight=weight)
        vertex = condition.lmis[-1]
        chunks.append(smallest_eigenvalues(condition, vertex, {"P": P}) / vertex.weight)
    return np.concatenate(chunks)


def _more(chosen: Indices, margins: Floats) -> Indices:
    order = np.argsort(margins)
    fresh = order[~np.isin(order, chosen)][:ADDED]
    return np.concatenate([chosen, fresh])


def _labelled(condition: Condition, chosen: Indices, total: int) -> Condition:
    last = condition.lmis[-1]
    labels = tuple(f"{last.name} {k + 1} of {total}" for k in chosen)
    return replace(condition, lmis=(*condition.lmis[:-1], replace(last, labels=labels)))
