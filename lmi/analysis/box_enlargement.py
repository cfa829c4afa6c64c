r"""How much the box of a model may grow until one quadratic function no longer shows its decay.

The LMIs of a growing box: a generalised eigenvalue problem in 1 / s.

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

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.common_quadratic import common_lyapunov
from takagi.lmi.analysis.loop_growth import EnlargedLoops, Law, enlarged_loops
from takagi.lmi.analysis.quadratic_condition import rate_of, vertex_weight
from takagi.lmi.answer import Answer, Try
from takagi.lmi.argument_checks import Vertices, number, sample_time_of
from takagi.lmi.condition.term import LMI, Array, Condition, Term, bounded, positive
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion, nearest_power, state_units
from takagi.lmi.decision.item_rounds import ALL_AT_ONCE
from takagi.lmi.decision.outcome import promised
from takagi.lmi.parameter_search.largest_parameter import Extreme, extreme_parameter
from takagi.lmi.solver.time_limit import limited
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


# Tolerance of the matrices that do not change with the box; it only allows for rounding.
STILL = 1e-13
ROUNDS, ADDED = 40, 12


@limited
def max_box_enlargement(
    model: Vertices,
    *,
    gains: ArrayLike | None = None,
    law: Law = "independent",
    nominal: ArrayLike | None = None,
    decay_rate: float = 0.0,
    tolerance: float = 1e-6,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
    time_limit: float | None = None,
) -> Answer:
    """Return the largest theta, and its P, with P common to all A_0 + theta (A_i - A_0).

    V = x' P x decays as V' <= -2 alpha V (discrete: V+ <= e^(-2 alpha T) V) for every blend of
    the enlarged vertices, however fast it varies.  theta = 1 is the given model; with 1.2 its box
    may grow by a fifth about the nominal point; below 1 decay is not shown for the whole box of the
    model.  With gains u = -K x, B grows as A does, and K is, by ``law``,

    - "independent": any blend of the K_j at any time, which covers every law with these gains;
    - "stretched": sum_j h_j K_j with the memberships of the enlarged box, as if the law were made
      for it; theta is at least 1 or there is none;
    - "clamped": scheduled over the model's own box, its memberships held at the edge beyond, as
      ``model.memberships(..., clip=True)`` does; theta is at least 1 or there is none.  Only for a
      model whose vertices are affine in its premises.

    Parameters
    ----------
    model : a model, or vertices (N, n, n) where there are no gains.
    gains : K_j, (r, m, n), or (m, n) for one; None where the model has no input to close.
    law : how the gains follow the enlarged plant.
    nominal : memberships (r,) of the point about which the box grows; None takes equal shares,
        the centre of the box of a model with premises.
    decay_rate : alpha in 1/s that must hold.
    tolerance : relative to theta.
    scales : (n,) engineering range of each state; None balances.
    sample_time : T in s of x+ = A x, where vertices are given; a model knows its own.
    time_limit : seconds for all solver calls together, as they come; an answer stopped by it is
        "unknown", and its diagnosis reports it.  None for no limit.

    Returns
    -------
    An ``Answer``: ``enlargement`` is recomputed from the returned P, slightly below
    the largest; ``bound`` is above every enlargement that one P can show, to solver accuracy, and
    by the tolerance at most, or by a thousandth where less was asked for.  Where the search stops
    farther from it the status is "unknown", the diagnosis has both numbers, and ``feasible`` the P
    that shows the smaller one.
    "infeasible" if there is no P even for the nominal point, or, if theta is at least 1, for the
    box.

    Not promised: that the plant is what the vertices say outside the model's box.  The vertices
    of a sector model grow as its premises' ranges do, not as the ranges of the states.

    Raises
    ------
    ModelError : shapes, numbers, an unknown law, memberships that are none.
    """
    answer = wide_box(
        model,
        gains=gains,
        law=law,
        nominal=nominal,
        decay_rate=decay_rate,
        tolerance=tolerance,
        scales=scales,
        sample_time=sample_time,
    )
    theta, bound = answer.enlargement, answer.bound
    if theta is None or bound <= theta * (1.0 + promised(tolerance)):
        return answer
    most = f"no P shows more than {bound:.6g}" if np.isfinite(bound) else "no bound is known"
    return replace(
        answer,
        status="unknown",
        P=None,
        decay_rate=None,
        enlargement=None,
        feasible=answer.values,
        diagnosis=(
            f"the largest enlargement is not settled: a P shows {theta:.6g}, {most}; give scales, "
            "or a larger tolerance"
        ),
    )


def wide_box(
    model: Vertices,
    *,
    gains: ArrayLike | None = None,
    law: Law = "independent",
    nominal: ArrayLike | None = None,
    decay_rate: float = 0.0,
    tolerance: float = 1e-6,
    scales: ArrayLike | None = None,
    sample_time: float | None = None,
) -> Answer:
    """Return the P that shows the widest box that was found, whether or not it is the widest.

    As ``max_box_enlargement``, for callers that only need a P and its enlargement: the upper bound
    may be far above it.
    """
    alpha = float(number("decay_rate", decay_rate))
    tolerance = float(number("tolerance", tolerance, at_least=1e-12))
    step = sample_time_of(model, sample_time)
    loops = enlarged_loops(model, gains=gains, law=law, nominal=nominal)
    n = loops.base.shape[1]
    s = state_units(
        np.concatenate([loops.nominal, loops.base + loops.direction]), scales, step=step
    )
    scaled = loops.scaled(s)
    first = common_lyapunov(scaled.nominal, decay_rate=alpha, scales=np.ones(n), sample_time=step)
    if first.P is None:
        where = "the law in its own box" if scaled.begin else "the nominal point"
        why = first.diagnosis.replace("vertex", "matrix")
        return replace(first, coordinates=s, diagnosis=f"not even {where} has what is asked: {why}")
    P = first.P / np.linalg.eigvalsh(first.P)[-1]
    size = np.abs(scaled.nominal).max() + np.abs(scaled.base).max()
    if np.abs(scaled.direction).max() <= STILL * size:
        return _answer(scaled, P, s, alpha, step, replace(first, bound=np.inf))
    found, tries = _search(scaled, P, alpha, step, tolerance)
    bound = 1.0 / found.bound if found.bound > 0 else np.inf
    answer = Answer(
        status="candidate",
        margin=found.outcome.margin,
        bound=loops.begin + bound,
        values=found.outcome.values,
        multipliers=found.outcome.multipliers,
        condition=found.condition,
        tries=(*first.tries, *tries),
    )
    return _answer(scaled, found.outcome.values["P"][0], s, alpha, step, answer)


def _search(
    scaled: EnlargedLoops, P: Floats, alpha: float, step: float | None, tolerance: float
) -> tuple[Extreme, list[Try]]:
    """Return the least mu over all matrices; the solver gets a few of them, and all are checked."""
    count = len(scaled.base)
    allowed = growth_allowed(scaled, P, decay_rate=alpha, sample_time=step)
    chosen = np.arange(count) if count <= ALL_AT_ONCE else np.argsort(allowed)[:ADDED]
    tries: list[Try] = []
    for _ in range(ROUNDS):
        found = extreme_parameter(
            box_enlargement_condition(scaled.of(chosen), decay_rate=alpha, sample_time=step),
            "reciprocal",
            largest=False,
            start={"P": P[None]},
            tolerance=tolerance,
            limit=0.0,
        )
        tries.extend(found.outcome.tries)
        P = found.outcome.values["P"][0]
        allowed = growth_allowed(scaled, P, decay_rate=alpha, sample_time=step)
        order = np.argsort(allowed)
        fresh = order[~np.isin(order, chosen)][:ADDED]
        if not len(fresh) or allowed[fresh[0]] >= allowed[chosen].min() * (1 - tolerance):
            break
        chosen = np.concatenate([chosen, fresh])
    return found, tries


def _answer(
    scaled: EnlargedLoops, P: Floats, s: Floats, alpha: float, step: float | None, plain: Answer
) -> Answer:
    """Return the answer with what P shows, recomputed, and P in the model's states."""
    allowed = growth_allowed(scaled, P, decay_rate=alpha, sample_time=step)
    s_most = float(allowed.min())
    P = P / np.exp2(np.floor(np.log2(np.linalg.eigvalsh(P)[0])))
    grown = scaled.nominal
    if np.isfinite(s_most):
        grown = scaled.base + s_most * scaled.direction
    return replace(
        plain,
        P=P / s / s[:, None],
        decay_rate=rate_of(grown, P, step=step),
        enlargement=scaled.begin + s_most,
        coordinates=s,
        diagnosis="",
    )
