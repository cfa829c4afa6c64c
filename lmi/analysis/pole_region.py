"""Eigenvalues of every blend in a region of the complex plane: D-stability with one P."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.decay_rate import answer_in_states
from takagi.lmi.analysis.gain_pairs import gain_stack, of_pairs, pairs_of
from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import Vertices, input_stack, sample_time_of, vertex_stack
from takagi.lmi.condition.region import EigenvalueRegion, RegionPart
from takagi.lmi.condition.statements import pose, positive_definite, scale_bound
from takagi.lmi.condition.term import Array, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import state_units
from takagi.lmi.decision.decide import decide
from takagi.lmi.decision.outcome import Outcome, binding_items
from takagi.lmi.expressions.expression import Expression, He, Inequality, matrix, symmetric_block
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError


def d_stability_condition(model: Vertices, region: EigenvalueRegion) -> Condition:
    """Pose L (x) P + M (x) (P A_i) + M' (x) (A_i' P) < 0 for every part, with 0 < P <= I.

    The coefficients of L and M are kept apart from those of A_i, so that an exact reading is of
    the given numbers and not of rounded products.

    Parameters
    ----------
    model : a model (its A), (N, n, n) or (n, n); entries may be Fractions.
    region : in the units of the eigenvalues of A, see ``EigenvalueRegion``.

    Raises
    ------
    ModelError : shapes, no vertices, entries that are not finite, no region.

    Source: Chilali and Gahinet (1996), IEEE Trans. Automatic Control 41(3), theorem 2.2, with one
    P for all vertices.
    """
    A = vertex_stack(model)
    _check_region(region)
    n = A.shape[1]
    P = Unknown("P", n, n, symmetric=True)
    parts = zip(region.parts, region.labels, strict=True)
    return pose(
        positive_definite(P),
        scale_bound(P),
        *(_part(A, P, part, label) for part, label in parts),
        name=f"eigenvalues in {region}",
        source="Chilali and Gahinet (1996), theorem 2.2",
    )


def d_stability(
    model: Vertices,
    region: EigenvalueRegion,
    *,
    gains: ArrayLike | None = None,
    sample_time: float | None = None,
    scales: ArrayLike | None = None,
) -> Answer:
    """Return a candidate P with L (x) P + M (x) (P A_i) + M' (x) (A_i' P) < 0 for every part.

    For constant memberships h every eigenvalue of sum_i h_i A_i lies in the region. For memberships
    that vary, eigenvalues say nothing about stability; P then shows the ``decay_rate`` of the
    answer, V' <= -2 alpha V (at least that of a ``half_plane`` in the region; in discrete time that
    of a ``disc`` about 0), however fast h moves.  For a single vertex P exists exactly when its
    eigenvalues lie in the region; for more it is sufficient.

    Parameters
    ----------
    model : a model (its A), or vertices (N, n, n).
    region : for x' = A x in 1/s; for x+ = A x of the eigenvalues of A itself, so that stability
        is asked for only by a region inside the unit circle.
    gains : K, (r, m, n), of u = -sum_j h_j K_j x; the vertices are then those of the closed loop,
        one for each pair of rules.  None takes the model as it is, with u = 0.
    sample_time : T in s for raw arrays of discrete time; None takes the model's own.
    scales : (n,) engineering range of each state; None balances the vertices.

    Returns an ``Answer``; ``decay_rate`` may be negative where the region does not ask for
    stability.  Nothing is proved: floating point decides.

    Raises ModelError: shapes, no vertices, entries that are not finite, no region, sample time,
    scales that are not positive.
    """
    A = vertex_stack(model).astype(np.float64)
    _check_region(region)
    if gains is not None:
        B = input_stack(model, A).astype(np.float64)
        A = pairs_of(A, B, gain_stack(gains, len(A), B.shape[2], A.shape[1]))
    step = sample_time_of(model, sample_time)
    s = state_units(A, scales)
    scaled = A * s / s[:, None]
    outside = _outside(scaled, region)
    if outside is not None:
        return of_pairs(_no_by_one_vertex(scaled, region, s, outside), gains)
    condition = d_stability_condition(scaled, region)
    answer = answer_in_states(condition, decide(condition), A, s, step=step, diagnose=_diagnosis)
    return of_pairs(answer, gains)


def region_weight(part: RegionPart, A: Array) -> float:
    """Return |L| + 2 |M| max_i |A_i| (spectral norms): the natural size of a part's LMI."""
    L, M = (np.linalg.norm(matrix.astype(np.float64), 2) for matrix in part.matrices)
    largest = np.linalg.norm(A.astype(np.float64), 2, axis=(1, 2)).max()
    return float(L + 2.0 * M * largest) or 1.0


def region_block(coefficients: tuple[Array, Array], X: Unknown, G: Expression) -> Expression:
    """Return L (x) X + M (x) G + M' (x) G' of the coefficients L and M."""
    L, M = coefficients
    cells: dict[tuple[int, int], Expression] = {}
    for a, b in np.ndindex(L.shape):
        # A block of G below the diagonal stands for its transpose above it.
        summands = [L[a, b] * X] * bool(a <= b and L[a, b])
        summands += [He(M[a, a] * G) if a == b else M[a, b] * G] * bool(M[a, b])
        if summands:
            cells[a, b] = sum(summands[1:], summands[0])
    return symmetric_block((X.rows,) * len(L), cells)


def _part(A: Array, P: Unknown, part: RegionPart, label: str) -> Inequality:
    """Pose the inequality of one part at every vertex."""
    decrease = region_block(part.matrices, P, P @ matrix(A, "A_{i}")) << 0
    return decrease.named(
        label,
        rf"i = 1, \dots, {len(A)}",
        weight=region_weight(part, A),
        labels=tuple(f"vertex {i + 1} of {len(A)} in {part.name}" for i in range(len(A))),
    )


def _check_region(region: object) -> None:
    if not isinstance(region, EigenvalueRegion):
        raise ModelError(
            f"region is {region!r}; an EigenvalueRegion is needed, such as "
            "EigenvalueRegion.half_plane(0.5) & EigenvalueRegion.sector(0.8)"
        )


def _outside(A: Floats, region: EigenvalueRegion) -> tuple[int, complex, Floats, RegionPart] | None:
    """Return (vertex, eigenvalue, eigenvector, part) of one that is farthest out of a part."""
    eigenvalues, vectors = np.linalg.eig(A)
    worst = None
    largest_excess = 0.0
    for part in region.parts:
        excess = part.excess(eigenvalues) / region_weight(part, A)
        vertex, mode = np.unravel_index(int(np.argmax(excess)), excess.shape)
        if excess[vertex, mode] >= largest_excess:
            largest_excess = float(excess[vertex, mode])
            z, v = complex(eigenvalues[vertex, mode]), vectors[vertex][:, mode]
            worst = (int(vertex), z, v, part)
    return worst


def _no_by_one_vertex(
    A: Floats, region: EigenvalueRegion, s: Floats, outside: tuple[int, complex, Floats, RegionPart]
) -> Answer:
    """Answer without a solver: Z = Re((y (x) v) (y (x) v)*) rules out every P by itself."""
    vertex, z, v, part = outside
    L, M = (matrix.astype(np.float64) for matrix in part.matrices)
    y = np.linalg.eigh(L + z * M + z.conjugate() * M.T)[1][:, -1]
    w = np.kron(y, v)
    Z = np.real(np.outer(w, w.conj()))
    # A real vertex has both conjugate eigenvalues; a real eigenvalue is written without imaginary
    # part.
    eigenvalue_text = f"{z.real:.6g}" if z.imag == 0 else f"{z.real:.6g} +- {abs(z.imag):.6g}j"
    return Answer(
        status="infeasible",
        margin=-np.inf,
        bound=0.0,
        multipliers={region.labels[region.parts.index(part)]: Z[None] / np.trace(Z)},
        coordinates=s,
        condition=d_stability_condition(A[[vertex]], region),
        diagnosis=(
            f"vertex {vertex + 1} of {len(A)} alone rules it out: its eigenvalue {eigenvalue_text} "
            f"is not in {part.name}; widen the region, or move this vertex"
        ),
    )


def _diagnosis(condition: Condition, outcome: Outcome) -> str:
    if outcome.status == "unknown":
        return outcome.unsettled("widen the region a little, or give scales")
    names = [lmi.name for lmi in condition.lmis[2:]]
    binding = binding_items(condition, outcome.multipliers, *names)
    return (
        f"no common P, though each vertex has its eigenvalues in the region: {binding}; widen the "
        "region, or shrink the box that these vertices span"
    )
