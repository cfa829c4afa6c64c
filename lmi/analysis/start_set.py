"""Sets of starts: within limits, and with references that are followed.

The ellipsoid {z'Pz <= 1} of a given loop, inside limits, with a large set of starts z = N x.

The states of a law start in a known way, such as an observer at rest for every state x of the
plant.  Then z = N x, and from every start in {x'Sx <= 1}, S = N'PN, the motion stays within
|r_t z| <= 1.  The P > 0 with a large set of starts solves

    least tr(W S)   subject to   G_k'P + P G_k + 2 alpha P < 0        (G_k'P G_k < e^(-2 alpha T) P)
                                 [[P, r_t'], [r_t, 1]] >= 0.

The volume of the starts grows as det S falls.  log det S is concave in S, so it
falls from round to round with W = S^-1 of the last round; the first W is that of a first guess.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 5.1 and 5.2; the rounds are those of
Fazel, Hindi, Boyd (2003), Log-det heuristic for matrix rank minimization (recalled).

A quadratic function for a loop whose equilibrium moves with a reference.

For z' = A z + d with A in the hull of the vertices A_k, alpha > 0 and

    A_k' P + P A_k + 2 alpha P < 0,    [[P, h_i], [h_i', 1]] >= 0,    v_j' P v_j <= 1,

V = z'Pz falls at the rate 2 alpha where d = 0, and {V <= 1} lies inside |h_i' z| <= 1; the v_j are
the pushes d, each over alpha and its share, so that the set is invariant under their
sum.  Residuals |f_k| <= e_k in the rows of z' are counted by how fast their row forgets them:

    [[-(A_k' P + P A_k + 2 alpha P), P E], [E P, diag(u)]] >= 0,    sum u_k <= 2 alpha left^2

with E = diag(e) gives V' <= -2 alpha V + sum u_k, so that they leave {V <= left^2} to V.
Two objectives:

    jumps    least eta with m_j' P m_j <= eta: the largest multiples of jumps m_j within the set
    error    least eta with [[P, c_k], [c_k', eta]] >= 0: the error c_k' z on the set

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.1.3, by the triangle inequality in
the norm of P instead of the S-procedure; see ``docs/plant-theorems.md``.
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


ATTEMPTS = 3  # of solvers: many rates are tried, and slow solvers seldom find what these do not


def tracking_condition(
    A: Floats,
    alpha: float,
    rows: Floats,
    pushes: Floats,
    *,
    jumps: Floats | None = None,
    errors: Floats | None = None,
    residuals: Floats | None = None,
    left: float = 0.0,
) -> Condition:
    """Pose the module's LMIs with eta least.

    Parameters
    ----------
    A : (N, n, n);  rows : (h, n) rows h_i;  pushes : (p, n) rows v_j.
    jumps, errors : (q, n) rows m_j, or (k, n) rows c_k; one of both.
    residuals : (n,) numbers e_k > 0; None for none.  ``left`` is their share of the set.

    Raises
    ------
    ModelError : sizes that do not fit, a rate that is not positive, both objectives or none.
    """
    count, n = A.shape[:2]
    rows_given = [row_stack for row_stack in (jumps, errors) if row_stack is not None]
    if (
        any(row_stack.shape[1:] != (n,) for row_stack in (rows, pushes, *rows_given))
        or A.shape[2] != n
    ):
        raise ModelError(
            f"vertices {A.shape}, rows {rows.shape}, pushes {pushes.shape}: (N, n, n), (h, n) and "
            "(p, n) are needed, and n columns in jumps and errors"
        )
    if alpha <= 0 or len(rows_given) != 1:
        raise ModelError(f"decay rate {alpha:.4g}: give one above 0, and jumps or errors")
    P = Unknown("P", n, n, symmetric=True)
    eta = Unknown("eta", 1, 1, symmetric=True, latex=r"\eta")
    eye, unit = np.eye(n)[None], np.ones((1, 1, 1))
    falls = LMI(
        name="decay",
        blocks=(n,),
        terms=(
            Term(unknown=P, left=eye, right=A, plus_transpose=True, latex=("", "A_{k}")),
            Term(unknown=P, left=2 * alpha * eye, right=eye, latex=(r"2\alpha", "")),
        ),
        sign=-1,
        count=count,
        index=rf"k = 1, \dots, {count}",
    )
    lmis = [falls]
    if len(rows):
        lmis.append(_bordered("inside the ranges", P, rows, "h", "i"))
    if len(pushes):
        unit_bound = Constant(value=unit, at=(0, 0), latex="1")
        lmis.append(_moved("the set is kept", P, pushes, "v", "j", constants=(unit_bound,)))
    unknowns: tuple[Unknown, ...] = (P, eta)
    if residuals is not None:
        U = Unknown("u", 1, 1, symmetric=True, count=n)
        lmis += _forgotten(P, U, A, alpha, residuals, left)
        unknowns = (P, eta, U)
    if jumps is not None:
        eta_term = Term(unknown=eta, left=unit, right=unit)
        lmis.append(_moved("jumps", P, jumps, "m", "j", terms=(eta_term,)))
    if errors is not None:
        lmis.append(_bordered("the error", P, errors, "c", "k", eta))
    return Condition(
        name="tracking",
        unknowns=unknowns,
        lmis=tuple(lmis),
        objective={"eta": unit},
        source="docs/plant-theorems.md",
    )


def _forgotten(
    P: Unknown, U: Unknown, A: Floats, alpha: float, residuals: Floats, left_over: float
) -> list[LMI]:
    """Pose the two LMIs of the residuals."""
    count, n = A.shape[:2]
    eye, every = np.eye(n)[None], np.arange(n)
    diagonal = np.zeros((n, n, n))
    diagonal[every, every, every] = 1.0
    # The weight of each row stands at its place of the diagonal, in every item.
    row, item = np.tile(every, count), np.repeat(np.arange(count), n)
    weights = Term(unknown=U, left=diagonal[row], items=item, members=row, at=(1, 1))
    balance = LMI(
        name="the residuals are forgotten",
        blocks=(n, n),
        terms=(
            Term(unknown=P, left=-eye, right=A, plus_transpose=True, latex=("-", "A_{k}")),
            Term(unknown=P, left=-2 * alpha * eye, right=eye, latex=(r"-2\alpha", "")),
            Term(unknown=P, left=eye, right=np.diag(residuals)[None], at=(0, 1), latex=("", "E")),
            weights,
        ),
        count=count,
        index=rf"k = 1, \dots, {count}",
    )
    bound = Constant(value=np.full((1, 1, 1), 2 * alpha * left_over**2))
    total = Term(unknown=U, left=-np.ones((n, 1, 1)), items=0 * every, members=every)
    return [balance, LMI(name="their share", blocks=(1,), terms=(total,), constants=(bound,))]


def _moved(
    name: str,
    P: Unknown,
    rows: Floats,
    symbol: str,
    letter: str,
    *,
    terms: tuple[Term, ...] = (),
    constants: tuple[Constant, ...] = (),
) -> LMI:
    """Pose the other terms less v'Pv >= 0 for each row v."""
    latex = f"{symbol}_{{{letter}}}"
    quadratic = Term(
        unknown=P,
        left=-rows[:, None, :],
        right=rows[:, :, None],
        latex=(rf"-{latex}^\top", latex),
    )
    return LMI(
        name=name,
        blocks=(1,),
        terms=(quadratic, *terms),
        constants=constants,
        count=len(rows),
        index=rf"{letter} = 1, \dots, {len(rows)}",
    )


def _bordered(
    name: str, P: Unknown, rows: Floats, symbol: str, letter: str, eta: Unknown | None = None
) -> LMI:
    """Pose [[P, row'], [row, 1]] >= 0 for each row, or with eta instead of 1."""
    n, unit = rows.shape[1], np.ones((1, 1, 1))
    corner: tuple[Term, ...] = ()
    fixed: tuple[Constant, ...] = (
        Constant(value=rows[:, :, None], at=(0, 1), latex=f"{symbol}_{{{letter}}}"),
    )
    if eta is None:
        fixed = (*fixed, Constant(value=unit, at=(1, 1), latex="1"))
    else:
        corner = (Term(unknown=eta, left=unit, right=unit, at=(1, 1)),)
    return LMI(
        name=name,
        blocks=(n, 1),
        terms=(Term(unknown=P, left=np.eye(n)[None], right=np.eye(n)[None]), *corner),
        constants=fixed,
        count=len(rows),
        index=rf"{letter} = 1, \dots, {len(rows)}",
    )


def tracking_function(
    A: Floats,
    alpha: float,
    rows: Floats,
    pushes: Floats,
    *,
    jumps: Floats | None = None,
    errors: Floats | None = None,
    residuals: Floats | None = None,
    left: float = 0.0,
) -> tuple[Floats, Floats | None] | None:
    """Return P (n, n) of the module's condition, and u (n,) where there are residuals.

    None where nothing is found.  Parameters are those of ``tracking_condition``.
    """
    # States scaled so that the entries of rows and pushes are about 1.
    bound = np.vstack([np.abs(rows), np.zeros((1, A.shape[1]))]).max(axis=0)
    row_sizes = np.vstack([np.abs(pushes), np.abs(pushes[:0] if jumps is None else jumps)])
    step = np.vstack([row_sizes, np.zeros((1, A.shape[1]))]).max(axis=0)
    unit = np.where(bound > 0, 1 / np.where(bound > 0, bound, 1.0), np.where(step > 0, step, 1.0))
    condition = tracking_condition(
        A * unit / unit[:, None],
        alpha,
        rows * unit,
        pushes / unit,
        jumps=None if jumps is None else jumps / unit,
        errors=None if errors is None else errors * unit,
        residuals=None if residuals is None else residuals / unit,
        left=left,
    )
    outcome = optimise(condition, slack=1e-3, most=ATTEMPTS)
    # Any function will do, the least eta or not: what it proves is measured afterwards.
    values = outcome.values if outcome.status == "candidate" else outcome.feasible
    if not values:
        return None
    P = np.asarray(values["P"][0] / np.outer(unit, unit), dtype=np.float64)
    u = None if residuals is None else np.asarray(values["u"], dtype=np.float64).ravel()
    return P, u
