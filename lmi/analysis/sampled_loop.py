r"""A law that runs every T seconds and holds its command: x'Px from one sample to the next.

    x' = A x + B u_k  for T seconds,   u_k = -K x at their beginning,

(A, B) any blend of vertices, which may move meanwhile, and K any blend of gains.  With xi = (x, u),
M_i = [[A_i, B_i], [0, 0]], L_j = [I; -K_j] and Bernstein coefficients Q_0 ... Q_d of a function of
the share of the interval that is over,

    function  Q_l > 0, so that it bounds the state between samples
    end       Q_d - [[P, 0], [0, 0]] > 0
    sample    rho^2 P - L_j' Q_0 L_j > 0,   rho = e^(-alpha T)
    flow      (d - l) (Q_l+1 - Q_l) + l (Q_l - Q_l-1) + T He(Q_l M_i) < 0        l = 0 ... d

Then xi'Q xi falls while the command is held, and x'Px from sample to sample.  For one vertex and
one gain a d that is large enough shows every T at which the exact discretisation is stable.

Source: derived here; Briat (2013), Automatica 49(11), recalled, for functions of the time since the
last sample.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from takagi.lmi.condition.statements import pose, positive_definite, scale_bound
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.decision.decide import decide
from takagi.lmi.expressions.expression import He, matrix
from takagi.models.arrays import Floats


@dataclass(frozen=True, slots=True, eq=False)
class SampledFunction:
    """P (n, n) and Q_0 ... Q_d (d + 1, n + m, n + m), in the states and inputs that were given."""

    P: Floats
    functions: Floats
    status: str


def sampled_loop_condition(
    A: Floats,
    B: Floats,
    K: Floats,
    sample_time: float,
    *,
    degree: int = 3,
    decay_rate: float = 0.0,
    smallest: float = 0.0,
) -> Condition:
    """Pose the module's LMIs with least I <= P <= I, P > 0; nothing is solved.

    Parameters
    ----------
    A, B : (r, n, n), (r, n, m) vertices.
    K : (s, m, n) gains of u = -K x.
    sample_time : T in s.
    degree : d, at least 1.
    decay_rate : alpha in 1/s, e^(-2 alpha t) for V at the samples.
    smallest : how near to I, the function of which these are the coordinates, P has to be.
    """
    r, n, m = B.shape
    d = degree
    P = Unknown("P", n, n, symmetric=True)
    Q = Unknown("Q", n + m, n + m, symmetric=True, count=d + 1)
    lift = matrix(np.eye(n + m, n), "E")
    L_j = matrix(np.concatenate([np.broadcast_to(np.eye(n), (len(K), n, n)), -K], axis=1), "L_{j}")
    contraction = matrix([[float(np.exp(-2 * decay_rate * sample_time))]], r"\rho^2")
    # What T seconds can change: the margins of one interval are as small as that.
    change = sample_time * float(np.linalg.norm(A[:, None] - B[:, None] @ K, 2, axis=(2, 3)).max())
    weight = min(1.0, change)
    M = np.zeros((r, n + m, n + m))
    M[:, :n] = sample_time * np.concatenate([A, B], axis=2)
    l = np.repeat(np.arange(d + 1), r)  # noqa: E741
    here, ahead = Q.members(l, "Q_l"), Q.members(np.minimum(l + 1, d), "Q_{l+1}")
    behind = Q.members(np.maximum(l - 1, 0), "Q_{l-1}")
    flow = (
        He(here @ matrix(np.tile(M, (d + 1, 1, 1)), "T M_i"))
        + matrix((d - l).astype(float)[:, None, None], "(d - l)") * ahead
        - matrix(l.astype(float)[:, None, None], "l") * behind
        + matrix((2 * l - d).astype(float)[:, None, None], "(2 l - d)") * here
    )
    return pose(
        positive_definite(P),
        (P >= smallest * np.eye(n)).named("P near the function given"),
        scale_bound(P),
        (Q >> 0).named("function", weight=weight),
        (Q.member(d) - lift @ P @ lift.T >> 0).named("end", weight=weight),
        (contraction * P - L_j.T @ Q.member(0) @ L_j >> 0).named("sample", weight=weight),
        (flow << 0).named("flow", weight=weight),
        unknowns=(P, Q),
        name="sampled loop",
        source="Briat (2013), Automatica 49(11)",
    )


def sampled_function(
    A: Floats,
    B: Floats,
    K: Floats,
    sample_time: float,
    *,
    near_function: Floats,
    degree: int = 3,
    decay_rate: float = 0.0,
    smallest: float = 0.0,
) -> SampledFunction | None:
    """Return a candidate of the module's condition; None where none is found.

    ``near_function`` : (n, n) P of the loop in continuous time, in whose coordinates the LMIs are
    posed: for a small T about that function is sought.
    ``others`` : as for ``sampled_loop_condition``.
    """
    n, m = B.shape[1:]
    R = np.linalg.cholesky(near_function).T
    S = np.linalg.inv(R)
    scaled = K @ S
    units = np.maximum(np.linalg.norm(scaled, axis=2).max(axis=0), 1e-300)
    condition = sampled_loop_condition(
        R @ A @ S,
        R @ B * units,
        scaled / units[:, None],
        sample_time,
        degree=degree,
        decay_rate=decay_rate,
        smallest=smallest,
    )
    outcome = decide(condition, most=2)
    if outcome.status != "candidate":
        return None
    back = np.zeros((n + m, n + m))
    back[:n, :n], back[n:, n:] = R, np.diag(1 / units)
    P, Q = outcome.values["P"][0], outcome.values["Q"]
    size = np.exp2(-np.floor(np.log2(np.linalg.eigvalsh(P)[0])))
    solver = outcome.tries[-1].status if outcome.tries else ""
    return SampledFunction(size * R.T @ P @ R, size * back.T @ Q @ back, solver)
