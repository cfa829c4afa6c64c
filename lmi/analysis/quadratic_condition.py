"""The condition of a common quadratic function, its coordinates, and the rates that P shows."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np

from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import (
    Vertices,
    number,
    rate_parameter,
    sample_time_of,
    vertex_stack,
)
from takagi.lmi.condition.term import LMI, Array, Condition, Term, bounded, positive
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion
from takagi.lmi.decision.outcome import Outcome, advice_about_limit, asks_for_decay, binding_items
from takagi.lmi.decision.vertex_rounds import CHUNK
from takagi.models.arrays import Floats


def common_lyapunov_condition(
    model: Vertices,
    *,
    decay_rate: float | Fraction = 0.0,
    weight: float | None = None,
    sample_time: float | None = None,
) -> Condition:
    """Pose A_i' P + P A_i + 2 alpha P < 0 at every vertex, with 0 < P <= I.

    V = x' P x then decays as V' <= -2 alpha V along xdot = sum_i h_i A_i x for every h, however
    fast it varies.  P <= I only fixes the scale.  alpha is the parameter ``alpha``; in discrete
    time, A_i' P A_i - rho^2 P < 0, it is ``contraction``, rho^2 = e^(-2 alpha T).

    Parameters
    ----------
    model : a model (its A), (N, n, n) or (n, n); entries may be Fractions.
    decay_rate : alpha in 1/s; 0 asks for stability only.
    weight : margin of the vertex inequalities for a margin 1 of P; None takes their own size,
        max_i 2 |A_i|, so that the margin has no unit; see ``vertex_weight`` for discrete time.
    sample_time : T in s of x+ = A x, where the model cannot say; None takes the model's own,
        continuous time where it has none.

    Raises
    ------
    ModelError : shapes, no vertices, entries that are not finite, a sample time that is not
        positive or not the model's.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1, quadratic stability; Tanaka
    and Wang (2001), theorem 2, for discrete time.
    """
    A = vertex_stack(model)
    alpha = number("decay_rate", decay_rate)
    step = sample_time_of(model, sample_time)
    n = A.shape[1]
    P = Unknown("P", n, n, symmetric=True)
    eye = _identity(A)
    decay = LMI(
        name="vertex",
        blocks=(n,),
        terms=_continuous(P, A, eye) if step is None else _discrete(P, A, eye),
        sign=-1,
        count=len(A),
        weight=vertex_weight(A, step=step) if weight is None else weight,
        index=rf"i = 1, \dots, {len(A)}",
    )
    return Condition(
        name="common quadratic Lyapunov function",
        unknowns=(P,),
        lmis=(positive(P), bounded(P), decay),
        parameters=rate_parameter(alpha, step),
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1"
        if step is None
        else "Tanaka and Wang (2001), theorem 2",
    )


def _continuous(P: Unknown, A: Array, eye: Array) -> tuple[Term, ...]:
    return (
        Term(unknown=P, left=eye, right=A, plus_transpose=True, latex=("", "A_{i}")),
        Term(unknown=P, left=2 * eye, right=eye, parameter="alpha", latex=(r"2\alpha", "")),
    )


def _discrete(P: Unknown, A: Array, eye: Array) -> tuple[Term, ...]:
    behind = A.transpose(0, 2, 1)
    return (
        Term(unknown=P, left=behind, right=A, latex=(r"A_{i}^\top", "A_{i}")),
        Term(unknown=P, left=-eye, right=eye, parameter="contraction", latex=(r"-\rho^2", "")),
    )


def answer_in_states(
    condition: Condition, outcome: Outcome, A: Floats, s: Floats, *, step: float | None = None
) -> Answer:
    """Return the outcome with P in the model's own states, its smallest eigenvalue made 1."""
    P, rate = None, None
    if outcome.status == "candidate":
        scaled = outcome.values["P"][0]
        scaled = scaled / np.exp2(np.floor(np.log2(np.linalg.eigvalsh(scaled)[0])))
        P = scaled / s / s[:, None]
        rate = rate_of(A * s / s[:, None], scaled, step=step)
    diagnosis = "" if P is not None else _diagnosis(condition, outcome)
    return replace(outcome.as_answer(condition, s), P=P, decay_rate=rate, diagnosis=diagnosis)


def rate_of(A: Floats, P: Floats, *, step: float | None = None) -> float:
    """Return the largest alpha that P shows at every vertex, in 1/s.

    A_i' P + P A_i + 2 alpha P <= 0, or A_i' P A_i <= e^(-2 alpha T) P where a step T is given.
    """
    return float(rates_of(A, P, step=step).min())


def rates_of(A: Floats, P: Floats, *, step: float | None = None) -> Floats:
    """Return (N,), one rate a vertex: -1/2 lambda_max(He(F_i)), F_i = L' A_i L'^-1, P = L L'.

    In discrete time -ln(sigma_max(F_i)) / T; inf for a vertex that is zero.
    """
    R = np.linalg.cholesky(P).T
    rates = []
    for k in range(0, len(A), CHUNK):
        inside = np.linalg.solve(R.T, (R @ A[k : k + CHUNK]).transpose(0, 2, 1))
        if step is None:
            symmetric = inside + inside.transpose(0, 2, 1)
            rates.append(-np.linalg.eigvalsh(symmetric)[:, -1] / 2)
        else:
            with np.errstate(divide="ignore"):
                rates.append(-np.log(np.linalg.norm(inside, 2, axis=(1, 2))) / step)
    return np.concatenate(rates)


def vertex_weight(A: Array, *, step: float | None = None) -> float:
    """Return max_i 2 |A_i| (spectral norm), the natural size of the vertex inequalities.

    In discrete time that of A_i' P A_i - P, max_i 2 |A_i - I| + |A_i - I|^2, but no more than 1,
    which the margin of rho^2 P - A_i' P A_i cannot exceed.
    """
    largest = float(np.linalg.norm(motion(A, step).astype(np.float64), 2, axis=(1, 2)).max())
    if step is not None:
        return capped(largest)
    return 2.0 * largest if largest > 0 else 1.0


def capped(change: float) -> float:
    return min(1.0, 2.0 * change + change**2) if change > 0 else 1.0


def _identity(A: Array) -> Array:
    n = A.shape[1]
    if A.dtype != object:
        return np.eye(n)[None]
    eye = np.full((1, n, n), Fraction(0), dtype=object)
    eye[:, range(n), range(n)] = Fraction(1)
    return eye


def _diagnosis(condition: Condition, outcome: Outcome) -> str:
    if outcome.status == "unknown":
        return outcome.unsettled(f"{advice_about_limit(condition)}, or give scales")
    slower = "lower the decay rate, " if asks_for_decay(condition) else ""
    return (
        f"no common P: {binding_items(condition, outcome.multipliers, 'vertex')}; {slower}"
        "shrink the box that these vertices span, or use a Lyapunov function that depends "
        "on the memberships"
    )
