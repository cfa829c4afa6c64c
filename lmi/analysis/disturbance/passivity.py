r"""Passivity (positive realness) from input to output, by one quadratic storage function.

With V = x' P x, at every vertex i, and D_i + D_i' = 0 at all of them,

    continuous   He(P A_i) < 0,     P B_i = C_i',

with a direct term at every vertex

    continuous   [ He(P A_i)        P B_i - C_i'                 ]
                 [ .                -(D_i + D_i')                ]  < 0

    discrete     [ A_i' P A_i - P   A_i' P B_i - C_i'            ]
                 [ .                B_i' P B_i - (D_i + D_i')    ]  < 0

and P > 0.  Then V', or V(x+) - V(x), is less than 2 w' y along every blend of the vertices unless x
is 0 (and w, where there is a direct term): the loop stores less energy than it receives.  Of one
vertex that can be controlled and observed this is strict positive realness of C (sI - A)^-1 B + D.

The equality needs P B_i = C_i' at all vertices at once: where B or C differ from rule to rule by
more than an exact relation allows, it has no solution, which elimination over the rationals proves.
In discrete time no loop without a direct term is passive, as B' P B <= 0 leaves B = 0.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 2.7.2 and 6.3.3; Khalil (2002),
Nonlinear Systems, 3rd edition, lemmas 6.2 and 6.3 (positive real, Kalman-Yakubovich-Popov).
"""

from __future__ import annotations

from dataclasses import replace

from numpy.typing import ArrayLike

from takagi.lmi.analysis.disturbance.channel import DisturbanceChannel, disturbance_channel
from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import Vertices
from takagi.lmi.condition.statements import pose
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import state_units
from takagi.lmi.decision.decide import decide
from takagi.lmi.decision.outcome import binding_items
from takagi.lmi.expressions.expression import Equation, He, Inequality, block, matrix
from takagi.lmi.solver.time_limit import limited
from takagi.models.errors import ModelError

SOURCE = "Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 2.7.2 and 6.3.3; Khalil (2002)"


def passivity_condition(
    model: Vertices,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
    *,
    sample_time: float | None = None,
) -> Condition:
    """Pose passivity at every vertex with one P > 0; without a direct term P B_i = C_i' exactly.

    Parameters
    ----------
    model, B, C, D, sample_time : as for ``passivity``.

    Returns
    -------
    The condition in the model's coordinates as they are, with the unknown ``P``; it is not solved.

    Raises
    ------
    ModelError : as ``passivity``.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 2.7.2 and 6.3.3.
    """
    return _condition(disturbance_channel(model, B, C, D, sample_time=sample_time))


def _condition(path: DisturbanceChannel) -> Condition:
    n, q, p = path.A.shape[1], path.B.shape[2], path.C.shape[1]
    if q != p:
        raise ModelError(
            f"passivity from {q} inputs to {p} outputs; as many outputs as inputs are needed, for "
            "the power w' y"
        )
    P = Unknown("P", n, n, symmetric=True)
    A, B = matrix(path.A, "A_{i}"), matrix(path.B, "B_{i}")
    C, D = matrix(path.C, "C_{i}"), matrix(path.D, "D_{i}")
    direct = path.D + path.D.transpose(0, 2, 1)
    discrete = path.sample_time is not None
    statements: list[Inequality | Equation] = [(P >> 0).named("P positive definite")]
    if not discrete and not direct.any():
        statements += [(He(P @ A) << 0).named("vertex"), (P @ B == C.T).named("input and output")]
    else:
        falls = A.T @ P @ A - P if discrete else He(P @ A)
        reach = (A.T @ P @ B if discrete else P @ B) - C.T
        supply = B.T @ P @ B - He(D) if discrete else -He(D)
        statements += [(block([[falls, reach], [None, supply]]) << 0).named("vertex")]
    return pose(*statements, name="passivity", source=SOURCE)


@limited
def passivity(
    model: Vertices,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
    *,
    sample_time: float | None = None,
    scales: ArrayLike | None = None,
    time_limit: float | None = None,
) -> Answer:
    """Return a candidate P with which every blend of the vertices is strictly passive.

    Parameters
    ----------
    model : A (r, n, n), C (r, p, n), and the disturbance's E (r, n, p); without E the input, with
        B (r, n, p) and D (r, p, p).  Or A itself: then B, C and D (zero when left out) are arrays,
        (r, ., .) or (., .).
    sample_time : T in s of x+ = A x + B w, where arrays are given; a model knows its own.
    scales : (n,) engineering range of each state; None looks for units itself.
    time_limit : seconds for all solver calls together.

    Returns
    -------
    An ``Answer``: P of the storage function V = x' P x, in units of w' y times s (of w' y in
    discrete time).  "infeasible" where multipliers, or elimination of the equality over the
    rationals, leave no P.  Nothing is proved of a candidate here: ``exact_solution`` rounds P onto
    P B = C' and decides the rest in exact arithmetic.

    Raises
    ------
    ModelError : shapes, entries that are not finite, different numbers of inputs and outputs,
        scales or a sample time that are not positive.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 2.7.2 and 6.3.3; Khalil (2002),
    lemmas 6.2 and 6.3.
    """
    path = disturbance_channel(model, B, C, D, sample_time=sample_time)
    s = state_units(path.A, scales, step=path.sample_time)
    scaled = DisturbanceChannel(
        path.A * s / s[:, None], path.B / s[:, None], path.C * s, path.D, path.sample_time
    )
    condition = _condition(scaled)
    outcome = decide(condition)
    answer = outcome.as_answer(condition, s)
    if outcome.status == "candidate":
        return replace(answer, P=outcome.values["P"][0] / s / s[:, None])
    if outcome.status == "infeasible":
        why = outcome.reason or binding_items(condition, outcome.multipliers, "vertex")
        return replace(
            answer,
            diagnosis=f"no common storage function: {why}; a direct term D, or an output with more "
            "of the derivative in it, makes a loop more passive",
        )
    return replace(answer, diagnosis=outcome.unsettled("give scales, or move the poles a little"))
