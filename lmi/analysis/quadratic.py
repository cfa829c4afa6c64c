"""Common quadratic Lyapunov function: one P for all vertices."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Answer, Floats, Status
from takagi.lmi.intake import Vertices, number, vertex_stack
from takagi.lmi.solver.balance import state_units
from takagi.lmi.solver.diagnosis import binding_items
from takagi.lmi.solver.stages import Outcome
from takagi.lmi.solver.vertex_rounds import CHUNK, decide_by_rounds
from takagi.lmi.term import LMI, Array, Condition, Constant, Term, Unknown

__all__ = ["common_lyapunov", "common_lyapunov_condition", "rate_of"]


def common_lyapunov_condition(
    model: Vertices, *, decay_rate: float | Fraction = 0.0, weight: float | None = None
) -> Condition:
    """Pose A_i' P + P A_i + 2 alpha P < 0 at every vertex, with 0 < P <= I.

    V = x' P x then decays as V' <= -2 alpha V along xdot = sum_i h_i A_i x for every h, however
    fast it varies.  P <= I only fixes the scale.  alpha is the parameter ``alpha``, so that it
    can be changed without posing anew.

    Parameters
    ----------
    model : a model (its A), (N, n, n) or (n, n); entries may be Fractions.
    decay_rate : alpha in 1/s; 0 asks for stability only.
    weight : margin of the vertex inequalities for a margin 1 of P; None takes their own size,
        max_i 2 |A_i|, so that the margin has no unit.

    Raises
    ------
    ModelError : shapes, no vertices, entries that are not finite.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1, quadratic stability.
    """
    A = vertex_stack(model)
    alpha = number("decay_rate", decay_rate)
    n = A.shape[1]
    P = Unknown("P", n, n, symmetric=True)
    one = _identity(A)
    size = vertex_weight(A) if weight is None else weight
    positive = LMI(
        name="P positive definite",
        blocks=(n,),
        terms=(Term(unknown=P, left=one, right=one),),
    )
    bounded = LMI(
        name="scale of P",
        blocks=(n,),
        terms=(Term(unknown=P, left=one, right=one),),
        constants=(Constant(value=-one, latex="-I"),),
        sign=-1,
        weight=0.0,
    )
    decay = LMI(
        name="vertex",
        blocks=(n,),
        terms=(
            Term(unknown=P, left=one, right=A, plus_transpose=True, latex=("", "A_{i}")),
            Term(unknown=P, left=2 * one, right=one, parameter="alpha", latex=(r"2\alpha", "")),
        ),
        sign=-1,
        count=len(A),
        weight=size,
        index=rf"i = 1, \dots, {len(A)}",
    )
    return Condition(
        name="common quadratic Lyapunov function",
        unknowns=(P,),
        lmis=(positive, bounded, decay),
        parameters={"alpha": float(alpha)},
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1",
    )


def common_lyapunov(
    model: Vertices, *, decay_rate: float = 0.0, scales: ArrayLike | None = None
) -> Answer:
    """Return a candidate P with A_i' P + P A_i + 2 alpha P < 0 at every vertex.

    P is the one whose smaller margin, of P in 0 < P <= I and of the vertex inequalities, is
    largest in balanced states: the best conditioned for what it shows.

    Parameters
    ----------
    model : a model (its A), or vertices (N, n, n): any number, few are given to the solver.
    decay_rate : alpha in 1/s; V' <= -2 alpha V.
    scales : (n,) engineering range of each state; None balances the vertices.

    Returns
    -------
    An ``Answer``; a no comes with multipliers and a diagnosis.  Nothing is proved: floating
    point decides, down to condition numbers of P (in the scaled states) of about 1e7.

    Raises
    ------
    ModelError : shapes, no vertices, entries that are not finite, scales that are not positive.
    """
    A = vertex_stack(model).astype(np.float64)
    alpha = float(number("decay_rate", decay_rate))
    s = state_units(A, scales)
    scaled = A * s / s[:, None]
    hopeless = slow_vertex(scaled, alpha)
    if hopeless is not None:
        return _no_by_one_vertex(scaled, alpha, s, hopeless)
    condition, outcome = decide_by_rounds(scaled, alpha, common_lyapunov_condition)
    return answer_in_states(condition, outcome, A, s)


def answer_in_states(condition: Condition, outcome: Outcome, A: Floats, s: Floats) -> Answer:
    """Return the outcome with P in the model's own states, its smallest eigenvalue made 1."""
    P, rate, status = None, None, outcome.status
    if status == "candidate":
        scaled = outcome.values["P"][0]
        scaled = scaled / np.exp2(np.floor(np.log2(np.linalg.eigvalsh(scaled)[0])))
        P = scaled / s / s[:, None]
        rate = rate_of(A * s / s[:, None], scaled)
    return Answer(
        status=status,
        P=P,
        margin=outcome.margin,
        decay_rate=rate,
        bound=outcome.bound,
        values=outcome.values,
        multipliers=outcome.multipliers,
        coordinates=s,
        condition=condition,
        diagnosis="" if status == "candidate" else _diagnosis(condition, outcome),
        tries=outcome.tries,
    )


def rate_of(A: Floats, P: Floats) -> float:
    """Return the largest alpha with A_i' P + P A_i + 2 alpha P <= 0 at every vertex, P given."""
    return float(rates_of(A, P).min())


def rates_of(A: Floats, P: Floats) -> Floats:
    """Return alpha_i = -1/2 lambda_max(He(L' A_i L'^-1)), P = L L', (N,): one rate a vertex."""
    R = np.linalg.cholesky(P).T
    rates = []
    for k in range(0, len(A), CHUNK):
        inside = np.linalg.solve(R.T, (R @ A[k : k + CHUNK]).transpose(0, 2, 1))
        rates.append(-np.linalg.eigvalsh(inside + inside.transpose(0, 2, 1))[:, -1] / 2)
    return np.concatenate(rates)


def vertex_weight(A: Array) -> float:
    """Return max_i 2 |A_i| (spectral norm), the natural size of the vertex inequalities."""
    largest = float(np.linalg.norm(A.astype(np.float64), 2, axis=(1, 2)).max())
    return 2.0 * largest if largest > 0 else 1.0


def slow_vertex(A: Floats, alpha: float) -> tuple[int, complex, Floats] | None:
    """Return (vertex, eigenvalue, Z) of a vertex whose own eigenvalue has Re >= -alpha."""
    eigenvalues, vectors = np.linalg.eig(A)
    vertex, mode = np.unravel_index(int(np.argmax(eigenvalues.real)), eigenvalues.shape)
    worst = complex(eigenvalues[vertex, mode])
    if worst.real < -alpha:
        return None
    v = vectors[vertex][:, mode]
    Z = np.real(np.outer(v, v.conj()))
    return int(vertex), worst, Z / np.trace(Z)


def _no_by_one_vertex(
    A: Floats, alpha: float, s: Floats, hopeless: tuple[int, complex, Floats]
) -> Answer:
    """Answer without a solver: A Z + Z A' = 2 Re(lambda) Z rules out every P by itself."""
    vertex, eigenvalue, Z = hopeless
    condition = common_lyapunov_condition(A[[vertex]], decay_rate=alpha)
    status: Status = "infeasible"
    return Answer(
        status=status,
        P=None,
        margin=-np.inf,
        bound=0.0,
        multipliers={"vertex": Z[None]},
        coordinates=s,
        condition=condition,
        diagnosis=(
            f"vertex {vertex + 1} of {len(A)} alone rules it out: its eigenvalue "
            f"{eigenvalue:.6g} does not decay faster than {alpha:g} 1/s; stabilise it, lower the "
            "decay rate, or shrink the box so that this vertex moves"
        ),
    )


def _diagnosis(condition: Condition, outcome: Outcome) -> str:
    if outcome.status == "unknown":
        return (
            f"no solver settled it: the best margin was {outcome.margin:.2g}, the bound on it "
            f"{outcome.bound:.2g}; the condition is at its limit or badly scaled: lower the "
            "decay rate a little, or give scales"
        )
    return (
        f"no common P: {binding_items(condition, outcome.multipliers, 'vertex')}; lower the decay "
        "rate, shrink the box that these vertices span, or use a Lyapunov function that depends "
        "on the memberships"
    )


def _identity(A: Array) -> Array:
    n = A.shape[1]
    if A.dtype != object:
        return np.eye(n)[None]
    one = np.full((1, n, n), Fraction(0), dtype=object)
    one[:, range(n), range(n)] = Fraction(1)
    return one
