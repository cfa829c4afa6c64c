"""Searches exact evidence that no common quadratic function exists for a loop."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from takagi.certificates.checker.kernel.result import Claim, Verdict
from takagi.certificates.requests.loop.decimals import short
from takagi.certificates.requests.loop.loop import ClaimedLoop
from takagi.certificates.requests.loop.single_matrix import equation_function
from takagi.certificates.requests.loop.weight_points import Point, points_of, weights_at
from takagi.certificates.requests.request import Attempt
from takagi.models.arrays import Floats

if TYPE_CHECKING:
    from takagi.lmi.answer import Answer

# Larger numbers are not written to a certificate.
LARGEST = 1e38


def no_common_decay(loop: ClaimedLoop, rate: float, answer: Answer) -> Attempt:
    """Return DISPROVED with evidence that no common P exists at this rate, else UNDECIDED."""
    solver = str(answer.solver.get("status", ""))
    tried = [answer.diagnosis or "no candidate P"]
    for words, evidence in _evidence(loop, rate, answer.coordinates):
        tried.append(words)
        claim = {
            "name": "no common quadratic function",
            "kind": "no-common-decay",
            "decay_rate": rate,
            **evidence,
        }
        checked = loop.replay(claim)
        if checked.verdict is Verdict.DISPROVED:
            return Attempt(claim, checked, tuple(tried), solver)
    unproved = {
        "name": f"common quadratic decay of {loop.model.name or 'the model'}",
        "kind": "decay",
        "decay_rate": rate,
        "P": np.eye(loop.A.shape[1]).tolist(),
    }
    found: Claim = loop.replay(unproved)
    return Attempt(unproved, found, (*tried, "no exact reason against one was found"), solver)


def _evidence(
    loop: ClaimedLoop, rate: float, coordinates: Floats | None
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield evidence from blends that the loop takes alone: its points, or its rules.

    There is none for a law with its own weights, because its blends are not known.
    """
    if len(loop.exact.K) > 1 and not loop.exact.shared_weights:
        return
    points = loop.points or points_of(loop.exact)
    A = loop.at(points).A
    for k in _slowest(A, rate, loop.sample_time):
        P = equation_function(A[k], rate, loop.sample_time)
        if P is not None and np.abs(P).max() < LARGEST:
            # A loop without premises has one rule, and a point without rows.
            blended = any(max(row) > 1 for row in points[k])
            words = "one blend alone" if blended else "one rule alone"
            yield words, {"blend": _named(loop, points[k]), "P": short(P, 9).tolist()}
    # If the Lyapunov equation does not exclude a single matrix, that matrix decays or is a limiting
    # case. So multipliers are searched for two or more matrices only.
    s = np.ones(A.shape[1]) if coordinates is None else coordinates
    Z = _multipliers(A * s / s[:, None], rate, loop.sample_time) if len(A) > 1 else None
    if Z is not None:
        values, vectors = np.linalg.eigh(Z / np.abs(Z).max())
        factors = vectors * np.sqrt(np.maximum(values, 0.0))[:, None, :] * s[:, None]
        # Multipliers that are zero up to rounding are left out, so that the file names few rules.
        used = [k for k, value in enumerate(values[:, -1]) if value > 1e-9 * values.max()]
        if not used or not np.abs(factors).max() < LARGEST:
            return
        for digits in (6, 9, 12):
            listed = [
                {"blend": _named(loop, points[k]), "factor": _rounded(factors[k], s, digits)}
                for k in used
            ]
            yield f"multipliers of {len(used)} blends, {digits} digits", {"multipliers": listed}


def _named(loop: ClaimedLoop, point: Point) -> int | list[list[int]]:
    """Return a blend as the claim states it: the number of a rule, or shares."""
    h = weights_at(loop.exact, point)
    return h.index(Fraction(1)) if 1 in h else [list(row) for row in point]


def _slowest(A: Floats, rate: float, step: float | None) -> list[int]:
    """Return the blend with the slowest eigenvalue, if that blend alone misses the rate."""
    poles = np.linalg.eigvals(A)
    if step is None:
        excess = poles.real.max(axis=1) + rate
    else:
        excess = np.abs(poles).max(axis=1) - np.exp(-rate * step)
    worst = int(excess.argmax())
    return [worst] if excess[worst] > 0 else []


def _multipliers(A: Floats, rate: float, step: float | None) -> Floats | None:
    """Return Z_k >= 0 in floats; their sum is positive definite on the states that they use.

    If some states act on no others, multipliers of these states alone suffice. There may be no
    others: a further state that decays by itself prevents a definite sum over all states.
    """
    from takagi.lmi.analysis.impossibility import impossibility_multipliers

    for states in _closed_sets(A):
        part = A[:, states][:, :, states]
        Z = impossibility_multipliers(part, decay_rate=rate, sample_time=step)
        if Z is not None:
            whole = np.zeros_like(A)
            whole[np.ix_(range(len(A)), states, states)] = Z
            return whole
    return None


def _closed_sets(A: Floats) -> list[list[int]]:
    """Return all states, then the sets of those that one state acts on, directly or not."""
    n = A.shape[1]
    acts = (A != 0).any(axis=0) | np.eye(n, dtype=bool)
    for _ in range(n):
        acts = (acts.astype(int) @ acts.astype(int)) > 0
    columns = {tuple(np.flatnonzero(acts[:, j]).tolist()) for j in range(n)}
    smaller = sorted((set_ for set_ in columns if 1 < len(set_) < n), key=len)
    return [list(range(n)), *map(list, smaller)]


def _rounded(factor: Floats, s: Floats, digits: int) -> list[list[float]]:
    """Return the factor with so many decimals, relative to each state's size."""
    places = np.clip(digits - np.round(np.log10(s)), -30, 30).astype(int).tolist()
    return [
        [round(float(entry), place) for entry in row]
        for row, place in zip(factor, places, strict=True)
    ]
