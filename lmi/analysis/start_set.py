r"""The ellipsoid {z'Pz <= 1} of a given loop, inside limits, with a large set of starts z = N x.

The states of a law start in a known way, such as an observer at rest for every state x of the
plant.  Then z = N x, and from every start in {x'Sx <= 1}, S = N'PN, the motion stays within
|r_t z| <= 1.  The P > 0 with a large set of starts solves

    least tr(W S)   subject to   G_k'P + P G_k + 2 alpha P < 0        (G_k'P G_k < e^(-2 alpha T) P)
                                 [[P, r_t'], [r_t, 1]] >= 0.

The volume of the starts grows as det S falls.  log det S is concave in S, so it
falls from round to round with W = S^-1 of the last round; the first W is that of a first guess.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 5.1 and 5.2; the rounds are those of
Fazel, Hindi, Boyd (2003), Log-det heuristic for matrix rank minimization (recalled).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from takagi.lmi.analysis.common_quadratic import common_lyapunov
from takagi.lmi.condition.term import LMI, Condition, Constant, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.decision.decide import optimise
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

ROUNDS = 3


@dataclass(frozen=True, slots=True, eq=False)
class StartSet:
    """A candidate {z'Pz <= 1}.

    Attributes
    ----------
    P : (n, n); None if none was found, then ``diagnosis`` says why.
    words : the solver's status in the last step.
    """

    P: Floats | None
    diagnosis: str
    words: str


def start_set_condition(
    G: Floats,
    rows: Floats,
    weight: Floats,
    *,
    decay_rate: float = 0.0,
    sample_time: float | None = None,
) -> Condition:
    """Pose the decrease along every G_k, the limits |r_t z| <= 1, and tr(weight P) least.

    Parameters
    ----------
    G : (N, n, n);  rows : (T, n);  weight : (n, n), symmetric.
    decay_rate : alpha [1/s];  sample_time : T in s of z+ = G z.

    Raises
    ------
    ModelError : sizes that do not fit.
    """
    count, n = G.shape[:2]
    if G.shape != (count, n, n) or rows.shape[1:] != (n,) or weight.shape != (n, n):
        raise ModelError(
            f"loops {G.shape}, limits {rows.shape}, weight {weight.shape}: (N, n, n), (T, n) and "
            "(n, n) are needed"
        )
    P = Unknown("P", n, n, symmetric=True)
    eye = np.eye(n)[None]
    if sample_time is None:
        falls = (
            Term(unknown=P, left=eye, right=G, plus_transpose=True, latex=("", "G_{k}")),
            Term(unknown=P, left=2 * decay_rate * eye, right=eye, latex=(r"2\alpha", "")),
        )
    else:
        shrink = math.exp(-2 * decay_rate * sample_time)
        back = G.transpose(0, 2, 1)
        falls = (
            Term(unknown=P, left=back, right=G, latex=(r"G_{k}^\top", "G_{k}")),
            Term(unknown=P, left=-shrink * eye, right=eye, latex=(r"-e^{-2\alpha T}", "")),
        )
    decrease = LMI(
        name="decrease",
        blocks=(n,),
        terms=falls,
        sign=-1,
        count=count,
        index=rf"k = 1, \dots, {count}",
    )
    inside = LMI(
        name="inside the limits",
        blocks=(n, 1),
        terms=(Term(unknown=P, left=eye, right=eye),),
        constants=(
            Constant(value=rows[:, :, None], at=(0, 1), latex=r"r_{t}^\top"),
            Constant(value=np.ones((1, 1, 1)), at=(1, 1), latex="1"),
        ),
        count=len(rows),
        index=rf"t = 1, \dots, {len(rows)}",
    )
    return Condition(
        name="set of starts",
        unknowns=(P,),
        lmis=(decrease, inside),
        objective={"P": weight[None]},
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 5.1 and 5.2",
    )


def start_set(
    G: Floats,
    rows: Floats,
    starts: Floats,
    *,
    decay_rate: float = 0.0,
    sample_time: float | None = None,
) -> StartSet:
    """Return a candidate {z'Pz <= 1} within |r_t z| <= 1 with many starts z = N x.

    Parameters
    ----------
    G : (N, n, n) vertices of the loop.
    rows : (T, n) of the limits, so scaled that each limit is 1; at least one.
    starts : N, (n, s).
    decay_rate : V falls at least as e^(-2 alpha t).
    sample_time : T in s of z+ = G z; None in continuous time.

    Raises
    ------
    ModelError : no limit, or sizes that do not fit.

    Source: the module's.
    """
    if not len(rows):
        raise ModelError("no limit was given, so that every start would do; give rows")
    first = common_lyapunov(G, decay_rate=decay_rate, sample_time=sample_time)
    if first.P is None:
        return StartSet(None, first.diagnosis, first.status)
    P = np.asarray(first.P, dtype=np.float64)
    P = P * float(np.einsum("ti,ij,tj->t", rows, np.linalg.inv(P), rows).max())
    words = str(first.status)
    for _ in range(ROUNDS):
        # In these coordinates the last set extends to 1 along every axis.
        units = np.sqrt(np.diag(np.linalg.inv(P)))
        N = starts / units[:, None]
        S = starts.T @ P @ starts
        weight = N @ np.linalg.inv(S) @ N.T
        condition = start_set_condition(
            G * units / units[:, None],
            rows * units,
            weight / np.trace(weight),
            decay_rate=decay_rate,
            sample_time=sample_time,
        )
        outcome = optimise(condition, slack=1e-3)
        if outcome.status != "candidate":
            break
        better = outcome.values["P"][0] / np.outer(units, units)
        words = outcome.tries[-1].solver if outcome.tries else words
        grown = np.linalg.slogdet(S)[1] - np.linalg.slogdet(starts.T @ better @ starts)[1]
        if grown <= 0:
            break
        P = better
        if grown < 0.05:
            break
    return StartSet(P, "", words)
