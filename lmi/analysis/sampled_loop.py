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

from takagi.lmi.condition.term import LMI, Condition, Constant, Term, bounded, positive
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.decision.decide import decide
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
    d, eye = degree, np.eye(n + m)[None]
    P = Unknown("P", n, n, symmetric=True)
    Q = Unknown("Q", n + m, n + m, symmetric=True, count=d + 1)
    lift = np.eye(n + m, n)[None]
    started = np.concatenate([np.broadcast_to(np.eye(n), (len(K), n, n)), -K], axis=1)
    plain = Term(unknown=P, left=np.eye(n)[None], right=np.eye(n)[None])
    contraction = float(np.exp(-2 * decay_rate * sample_time))
    # What T seconds can change: the margins of one interval are as small as that.
    change = sample_time * float(np.linalg.norm(A[:, None] - B[:, None] @ K, 2, axis=(2, 3)).max())
    weight = min(1.0, change)
    end = LMI(
        name="end",
        blocks=(n + m,),
        terms=(
            Term(unknown=Q, left=eye, right=eye, members=np.array([d]), symbol="Q_d"),
            Term(unknown=P, left=-lift, right=lift.transpose(0, 2, 1)),
        ),
        weight=weight,
    )
    sample = LMI(
        name="sample",
        blocks=(n,),
        terms=(
            Term(unknown=P, left=contraction * np.eye(n)[None], right=np.eye(n)[None]),
            Term(unknown=Q, left=-started.transpose(0, 2, 1), right=started, symbol="Q_0"),
        ),
        count=len(K),
        weight=weight,
    )
    return Condition(
        name="sampled loop",
        unknowns=(P, Q),
        lmis=(
            positive(P),
            LMI(
                name="P near the function given",
                blocks=(n,),
                terms=(plain,),
                constants=(Constant(value=-smallest * np.eye(n)[None], latex=f"-{smallest:g} I"),),
                strict=False,
            ),
            bounded(P),
            LMI(
                name="function",
                blocks=(n + m,),
                terms=(Term(unknown=Q, left=eye, right=eye, members=np.arange(d + 1)),),
                count=d + 1,
                weight=weight,
            ),
            end,
            sample,
            _flow(Q, A, B, sample_time, weight),
        ),
        source="Briat (2013), Automatica 49(11)",
    )


def _flow(Q: Unknown, A: Floats, B: Floats, sample_time: float, weight: float) -> LMI:
    r, n, m = B.shape
    d, eye = Q.count - 1, np.eye(n + m)[None]
    M = np.zeros((r, n + m, n + m))
    M[:, :n] = sample_time * np.concatenate([A, B], axis=2)
    member = np.repeat(np.arange(d + 1), r)
    items = np.arange(len(member))

    def weighed(factor: Floats, shift: int) -> Term:
        nonzero = np.flatnonzero(factor)
        return Term(
            unknown=Q,
            left=factor[nonzero, None, None] * eye,
            right=eye,
            items=items[nonzero],
            members=member[nonzero] + shift,
            symbol="Q_l" if not shift else f"Q_{{l{shift:+d}}}",
        )

    flow = Term(
        unknown=Q,
        left=eye,
        right=np.tile(M, (d + 1, 1, 1)),
        items=items,
        members=member,
        plus_transpose=True,
        latex=("T", "M_i"),
        symbol="Q_l",
    )
    terms = [flow, weighed((d - member).astype(float), 1), weighed(-member.astype(float), -1)]
    own_factor = (2 * member - d).astype(float)
    if own_factor.any():
        terms.append(weighed(own_factor, 0))
    return LMI(
        name="flow", blocks=(n + m,), terms=tuple(terms), sign=-1, count=len(member), weight=weight
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

    Parameters
    ----------
    near_function : (n, n) P of the loop in continuous time, in whose coordinates the LMIs are
        posed: for a small T about that function is sought.
    others : as for ``sampled_loop_condition``.
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
