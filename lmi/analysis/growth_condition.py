r"""The LMIs of a growing box: a generalised eigenvalue problem in 1 / s.

Of matrices G_k + s D_k (``loop_growth``) with s > 0 and mu = 1 / s,

    continuous   He(P D_k) + mu (He(P G_k) + 2 alpha P) < 0
    discrete     mu [ -He(P N_k) - (1 - rho^2) P   *  ]  +  [ -He(P D_k)   *  ]  > 0
                    [ P N_k                        P  ]     [ P D_k        0  ]

with N_k = G_k - I and rho = e^(-alpha T), mean that V = x' P x decays as V' <= -2 alpha V (V+ <=
rho^2 V) for G_k + s D_k; the terms with mu alone mean the same for the nominal matrices.  By
convexity P then serves every smaller s, so the least mu is sought.

The second is a congruence, with [I, -I; 0, I], of mu [rho^2 P, *; P G, P] + [0, *; P D, 0].  Its
first block, of the order of what happens in one step, is measured in e, about that size, so that
a model sampled ever faster gives the inequalities of continuous time, not those of A = I.
"""

from __future__ import annotations

import numpy as np

from takagi.lmi.analysis.common_quadratic import vertex_weight
from takagi.lmi.analysis.loop_growth import EnlargedLoops
from takagi.lmi.argument_checks import number
from takagi.lmi.condition.term import LMI, Array, Condition, Term, bounded, positive
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion, nearest_power
from takagi.models.arrays import Floats


def box_enlargement_condition(
    loops: EnlargedLoops, *, decay_rate: float = 0.0, sample_time: float | None = None
) -> Condition:
    """Pose the module's inequalities with 0 < P <= I; mu is the parameter ``reciprocal``.

    Parameters
    ----------
    loops : the matrices G_k, D_k and the nominal ones.
    decay_rate : alpha in 1/s.
    sample_time : T in s of x+ = A x; None for continuous time.

    Returns
    -------
    The condition at mu = 0, where it asks for theta = inf.  Nothing is solved.

    Source: derived here from Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1.
    """
    alpha = float(number("decay_rate", decay_rate))
    n = loops.base.shape[1]
    P = Unknown("P", n, n, symmetric=True)
    pose = _continuous if sample_time is None else _discrete
    rate = alpha if sample_time is None else float(-np.expm1(-2.0 * alpha * sample_time))
    return Condition(
        name="box enlargement of a common quadratic Lyapunov function",
        unknowns=(P,),
        lmis=(positive(P), bounded(P), *pose(P, loops, rate)),
        parameters={"reciprocal": 0.0},
        source="derived from Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 5.1",
    )


def _continuous(P: Unknown, loops: EnlargedLoops, alpha: float) -> tuple[LMI, LMI]:
    n, one = P.rows, np.eye(P.rows)[None]

    def decay(G: Array, index: str, parameter: str | None, before: str) -> tuple[Term, ...]:
        moved = Term(
            unknown=P,
            left=one,
            right=G,
            plus_transpose=True,
            parameter=parameter,
            latex=(before, f"G_{{{index}}}"),
        )
        rate = Term(
            unknown=P,
            left=2 * alpha * one,
            right=one,
            parameter=parameter,
            latex=(rf"2{before}\alpha", ""),
        )
        return (moved, rate) if alpha else (moved,)

    grown = Term(
        unknown=P, left=one, right=loops.direction, plus_transpose=True, latex=("", "D_{k}")
    )
    return (
        LMI(
            name="nominal",
            blocks=(n,),
            terms=decay(loops.nominal, "l", None, ""),
            sign=-1,
            count=len(loops.nominal),
            index=rf"l = 1, \dots, {len(loops.nominal)}",
            weight=vertex_weight(loops.nominal),
        ),
        LMI(
            name="enlarged vertex",
            blocks=(n,),
            terms=(grown, *decay(loops.base, "k", "reciprocal", r"\mu")),
            sign=-1,
            count=len(loops.base),
            weight=vertex_weight(loops.direction),
            labels=loops.labels,
            index=rf"k = 1, \dots, {len(loops.base)}",
        ),
    )


def _discrete(P: Unknown, loops: EnlargedLoops, lost: float) -> tuple[LMI, LMI]:
    """Return the discrete inequalities; ``lost`` is 1 - rho^2."""
    n, one = P.rows, np.eye(P.rows)[None]
    root = _root_of_step(loops)

    def moved(N: Array, parameter: str | None, factor: str, symbol: str) -> tuple[Term, ...]:
        """Return the terms of [-He(P N) / e, *; P N / sqrt(e), 0]."""
        return (
            Term(
                unknown=P,
                left=-one / root**2,
                right=N,
                plus_transpose=True,
                parameter=parameter,
                latex=(f"-{factor}" + r"\tfrac{1}{e}", symbol),
            ),
            Term(
                unknown=P,
                left=one / root,
                right=N,
                at=(1, 0),
                parameter=parameter,
                latex=(factor + r"\tfrac{1}{\sqrt{e}}", symbol),
            ),
        )

    def decay(G: Array, index: str, parameter: str | None, factor: str) -> tuple[Term, ...]:
        last = Term(
            unknown=P, left=one, right=one, at=(1, 1), parameter=parameter, latex=(factor, "")
        )
        rate = Term(
            unknown=P,
            left=-lost / root**2 * one,
            right=one,
            parameter=parameter,
            latex=(f"-{factor}" + r"\tfrac{1 - \rho^2}{e}", ""),
        )
        terms = (*moved(motion(G, 1.0), parameter, factor, f"N_{{{index}}}"), last)
        return (*terms, rate) if lost else terms

    return (
        LMI(
            name="nominal",
            blocks=(n, n),
            terms=decay(loops.nominal, "l", None, ""),
            count=len(loops.nominal),
            index=rf"l = 1, \dots, {len(loops.nominal)}",
        ),
        LMI(
            name="enlarged vertex",
            blocks=(n, n),
            terms=(
                *decay(loops.base, "k", "reciprocal", r"\mu"),
                *moved(loops.direction, None, "", "D_{k}"),
            ),
            count=len(loops.base),
            labels=loops.labels,
            index=rf"k = 1, \dots, {len(loops.base)}",
        ),
    )


def _root_of_step(loops: EnlargedLoops) -> float:
    """Return sqrt(e), a power of two: e is about the size of N."""
    size = vertex_weight(loops.nominal, step=1.0)
    return float(nearest_power(np.sqrt(np.array([size])))[0])


def growth_allowed(
    loops: EnlargedLoops, P: Floats, *, decay_rate: float = 0.0, sample_time: float | None = None
) -> Floats:
    """Return (N,), the s up to which P shows the rate of base_k + s direction_k; inf if for all s.

    By eigenvalues; nan where it does not even at s = 0.
    """
    R = np.linalg.cholesky(P).T
    inside = [
        np.linalg.solve(R.T, (R @ part).transpose(0, 2, 1)).transpose(0, 2, 1)
        for part in (loops.base, loops.direction)
    ]
    one = np.eye(len(P))
    if sample_time is None:
        room = -_he(inside[0]) - 2 * decay_rate * one
        D = _he(inside[1])
    else:
        root, lost = _root_of_step(loops), -np.expm1(-2.0 * decay_rate * sample_time)
        N = motion(inside[0], sample_time)
        room = _blocks(-(_he(N) + lost * one) / root**2, N / root, one)
        D = _blocks(_he(inside[1]) / root**2, -inside[1] / root, 0 * one)
    allowed = np.full(len(room), np.nan)
    values, vectors = np.linalg.eigh(room)
    good = values[:, 0] > 0
    root = vectors[good] / np.sqrt(values[good])[:, None, :]
    fastest = np.linalg.eigvalsh(root.transpose(0, 2, 1) @ D[good] @ root)[:, -1]
    allowed[good] = np.divide(1.0, fastest, out=np.full(len(fastest), np.inf), where=fastest > 0)
    return allowed


def _blocks(first: Floats, below: Floats, last: Floats) -> Floats:
    """Return [[first, below'], [below, last]] for every item of ``below``."""
    shape = below.shape
    return np.block(
        [
            [np.broadcast_to(first, shape), below.transpose(0, 2, 1)],
            [below, np.broadcast_to(last, shape)],
        ]
    )


def _he(X: Floats) -> Floats:
    return X + X.transpose(0, 2, 1)
