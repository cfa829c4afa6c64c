"""One quadratic function for all vertices, and why there is none.

    continuous   A_i' P + P A_i + 2 alpha P < 0      x' = sum_i h_i A_i x,  V' <= -2 alpha V
    discrete     A_i' P A_i - rho^2 P < 0            x+ = sum_i h_i A_i x,  V+ <= rho^2 V

with V = x' P x and rho = e^(-alpha T), T the sample time.  The second is linear in P as it is, half
the size of its Schur form; for a blend of vertices it holds because |P^1/2 A x|^2 is convex in A.

States in which the mean of the vertices decays equally in all directions.

For a loop of high gain the condition number of P may be that of the gains squared, in any units of
the states. The margin is then below a solver's tolerance. In states where the P of the mean's
Lyapunov equation is |x|^2, the mean decays equally in all directions, and vertices near the mean
almost equally. This only gives coordinates; nothing is claimed from it.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 2.7 (Lyapunov's equation).

Multipliers that show that no common P exists.

    continuous   find 0 <= Z_i <= I with  sum_i (A_i Z_i + Z_i A_i' + 2 alpha Z_i) >= t I,  t > 0,
    discrete     find 0 <= Z_i <= I with  sum_i (A_i Z_i A_i' - e^(-2 alpha T) Z_i) >= t I,  t > 0.

If such Z_i exist, there is no P > 0 with A_i'P + PA_i + 2 alpha P < 0, or A_i'P A_i < e^(-2 alpha
T) P, at all vertices. The trace of P times the sum would be negative by these inequalities, and
positive by those on Z_i.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 2.2.3 (theorems of alternatives).
"""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.decay_rate import answer_in_states, capped, common_lyapunov_condition
from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import (
    Vertices,
    number,
    rate_parameter,
    sample_time_of,
    slow_vertex,
    vertex_stack,
)
from takagi.lmi.condition.evaluate import margin
from takagi.lmi.condition.statements import pose
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion, state_units
from takagi.lmi.decision.decide import decide
from takagi.lmi.decision.outcome import Outcome, exactly_held
from takagi.lmi.decision.rounds import decide_some
from takagi.lmi.expressions.expression import He, added, matrix
from takagi.lmi.solver.time_limit import out_of_time
from takagi.models.arrays import Floats

# A margin that is missed by no more may be one that no solver sees.
NEARLY_HELD_MARGIN = 1e-6
# To what share of the size of the vertices the rate of fastest decay is then found.
SLOW_MODE = 1e-9


def states_of_mean(A: Floats, alpha: float, step: float | None) -> Floats | None:
    """Return T of x = T xhat; None where the mean does not decay at the rate alpha [1/s]."""
    from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

    eye = np.eye(A.shape[1])
    if step is None:
        mean = A.mean(axis=0) + alpha * eye
        falls = np.linalg.eigvals(mean).real.max() < 0
    else:
        mean = A.mean(axis=0) / np.sqrt(rate_parameter(alpha, step)["contraction"])
        falls = np.abs(np.linalg.eigvals(mean)).max() < 1
    if not falls:
        return None
    try:
        with warnings.catch_warnings():
            # A solution with large rounding errors is detected below, and by the checks of the
            # caller.
            warnings.simplefilter("ignore")
            if step is None:
                P = solve_continuous_lyapunov(mean.T, -eye)
            else:
                P = solve_discrete_lyapunov(mean.T, eye)
        P = (P + P.T) / 2
        if not (np.isfinite(P).all() and np.diag(P).min() > 0):
            return None
        size = np.sqrt(np.diag(P))
        # Shaped, so that the factor is accurate row by row.
        R = np.linalg.cholesky(P / size / size[:, None]).T * size
        T = np.linalg.inv(R)
    except (np.linalg.LinAlgError, ValueError):
        return None
    return T if np.isfinite(T).all() else None


def common_lyapunov(
    model: Vertices,
    *,
    decay_rate: float = 0.0,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
) -> Answer:
    """Return a candidate P with A_i' P + P A_i + 2 alpha P < 0 at every vertex.

    Discrete time: A_i' P A_i - e^(-2 alpha T) P < 0.  P maximises, in balanced states, the smaller
    of two margins: that of P > 0 with P <= I, and that of the vertex inequalities. So P is well
    conditioned.

    Parameters
    ----------
    model : a model (its A), or vertices (N, n, n): any number, few are given to the solver.
    decay_rate : alpha in 1/s; V' <= -2 alpha V, or V(x+) <= e^(-2 alpha T) V(x).
    scales : (n,) engineering range of each state; None balances the vertices.
    sample_time : T in s of x+ = A x, where vertices are given; a model knows its own.

    Returns an ``Answer``; a no comes with multipliers and a diagnosis.  Nothing is proved: floating
    point decides.  If no margin is found in the scaled states, P is sought in states in which the
    mean of the vertices decays equally in all directions (``coordinates`` is None then).  Loops
    with gains of 1e5 need this.

    Raises ModelError: shapes, no vertices, entries that are not finite, scales or a sample time
    that are not positive, a sample time that is not the model's.
    """
    A = vertex_stack(model).astype(np.float64)
    alpha = float(number("decay_rate", decay_rate))
    step = sample_time_of(model, sample_time)
    s = state_units(A, scales, step=step)
    scaled = A * s / s[:, None]
    hopeless = slow_vertex(scaled, alpha, step=step)
    if hopeless is not None:
        return _no_by_one_vertex(scaled, alpha, s, hopeless, step)
    posed = _condition(scaled, alpha, step)
    # A change of states decides more cases, and in less time, than other solvers do; so other
    # solvers are called last.
    condition, outcome = decide_some(posed, most=1)
    if outcome.status == "unknown":
        there = _where_the_mean_falls(A, s, alpha, step)
        if there is not None and there.found:
            return replace(there, tries=(*outcome.tries, *there.tries))
        tries = (*outcome.tries, *(there.tries if there is not None else ()))
        condition, outcome = decide_some(posed)
        outcome = _by_its_rate(condition, replace(outcome, tries=(*tries, *outcome.tries)), A, s)
    return answer_in_states(condition, outcome, A, s, step=step)


def _by_its_rate(condition: Condition, outcome: Outcome, A: Floats, s: Floats) -> Outcome:
    """Return a candidate where the P of fastest decay holds in exact arithmetic.

    A slow mode beside fast ones leaves a margin that no solver sees; its rate is another matter.
    """
    from takagi.lmi.analysis.decay_rate import fast_decay

    all_posed = condition.lmis[-1].count == len(A)
    nearly_held = outcome.status == "unknown" and outcome.margin > -NEARLY_HELD_MARGIN
    if not (nearly_held and all_posed) or out_of_time():
        return outcome
    step = 1.0 if "contraction" in condition.parameters else None
    fast = fast_decay(A, tolerance=SLOW_MODE, scales=s, sample_time=step)
    if fast.P is None:
        return outcome
    P = fast.P * s * s[:, None]
    P = P / np.linalg.eigvalsh(P)[-1] / 2
    values = {"P": ((P + P.T) / 2)[None]}
    checked = exactly_held(
        condition, replace(outcome, values=values, margin=margin(condition, values))
    )
    tries = (*outcome.tries, *fast.tries)
    return replace(checked if checked.status == "candidate" else outcome, tries=tries)


def _where_the_mean_falls(A: Floats, s: Floats, alpha: float, step: float | None) -> Answer | None:
    """Return the answer in states in which the mean falls evenly; None where it does not fall.

    Only a candidate counts. The vertices are rounded in these states, so a no would be about
    slightly different vertices.
    """
    scaled = A * s / s[:, None]
    T = states_of_mean(scaled, alpha, step)
    if T is None or out_of_time():
        return None
    back = np.linalg.inv(T)
    inside = back @ scaled @ T
    condition, outcome = decide_some(_condition(inside, alpha, step), most=1)
    answer = answer_in_states(condition, outcome, inside, np.ones(len(T)), step=step)
    if answer.P is None:
        return answer
    P = back.T @ answer.P @ back
    P = (P + P.T) / np.exp2(np.ceil(np.log2(np.linalg.eigvalsh(P + P.T)[0])))
    return replace(answer, P=P / s / s[:, None], coordinates=None)


def _condition(A: Floats, alpha: float, step: float | None) -> Condition:
    """Pose the condition with a margin of the vertices' own size."""
    # The Frobenius norm bounds the spectral one, and is cheap for a hundred thousand vertices.
    size = float(np.sqrt((motion(A, step) ** 2).sum(axis=(1, 2)).max()))
    weight = capped(size) if step is not None else (2.0 * size or 1.0)
    return common_lyapunov_condition(A, decay_rate=alpha, weight=weight, sample_time=step)


def _no_by_one_vertex(
    A: Floats, alpha: float, s: Floats, hopeless: tuple[int, complex, Floats], step: float | None
) -> Answer:
    """Answer without a solver: one eigenvalue and its Z rule out every P by themselves.

    A Z + Z A' = 2 Re(lambda) Z, or A Z A' = |lambda|^2 Z in discrete time.
    """
    vertex, eigenvalue, Z = hopeless
    condition = common_lyapunov_condition(A[[vertex]], decay_rate=alpha, sample_time=step)
    size = "" if step is None else f", of size {abs(eigenvalue):.6g},"
    return Answer(
        status="infeasible",
        margin=-np.inf,
        bound=0.0,
        multipliers={"vertex": Z[None]},
        coordinates=s,
        condition=condition,
        diagnosis=(
            f"vertex {vertex + 1} of {len(A)} alone rules it out: its eigenvalue "
            f"{eigenvalue:.6g}{size} does not decay faster than {alpha:g} 1/s; stabilise it, "
            "lower the decay rate, or shrink the box so that this vertex moves"
        ),
    )


def impossibility_multipliers(
    A: ArrayLike, *, decay_rate: float = 0.0, sample_time: float | None = None
) -> Floats | None:
    """Return (N, n, n) multipliers Z_i of the module in floating point; None if none were found.

    Z_i <= I fixes the scale.

    Parameters
    ----------
    A : (N, n, n).
    decay_rate : alpha [1/s].
    sample_time : T in s of x+ = A x; None for x' = A x.
    """
    vertices = vertex_stack(A)
    count, n = vertices.shape[:2]
    Z = Unknown("Z", n, n, symmetric=True, count=count)
    if sample_time is None:
        shifted = matrix(vertices + decay_rate * np.eye(n), r"(A_{i} + \alpha I)")
        change = He(added(shifted @ Z))
    else:
        A_i, contraction = matrix(vertices, "A_{i}"), np.exp(-2.0 * decay_rate * sample_time)
        change = added(A_i @ Z @ A_i.T - matrix([[contraction]], r"\rho^2") * Z)
    condition = pose(
        (Z >= 0).named("multiplier"),
        (Z <= np.eye(n)).named("scale of the multiplier"),
        (change >> 0).named("alternative"),
        name="no common quadratic function",
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 2.2.3",
    )
    outcome = decide(condition)
    return outcome.values["Z"] if outcome.status == "candidate" else None
