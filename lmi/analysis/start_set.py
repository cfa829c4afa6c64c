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
from takagi.lmi.analysis.decay_rate import change_of
from takagi.lmi.analysis.invariant_ellipsoid import bordered, diagonal_of
from takagi.lmi.condition.statements import pose
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.decision.decide import optimise
from takagi.lmi.expressions.expression import added, block, matrix, trace
from takagi.models.arrays import Floats, ShortRepr
from takagi.models.errors import ModelError

ROUNDS = 3


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class StartSet(ShortRepr):
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
    G_k = matrix(G, "G_{k}")
    if sample_time is None:
        rate = matrix([[decay_rate]], r"\alpha")
    else:
        rate = matrix([[math.exp(-2 * decay_rate * sample_time)]], r"e^{-2\alpha T}")
    decrease = change_of(P, G_k, rate, sample_time) << 0
    inside = bordered(P, rows, r"r_{t}^\top", np.eye(1)) >> 0
    return pose(
        decrease.named("decrease", rf"k = 1, \dots, {count}"),
        inside.named("inside the limits", rf"t = 1, \dots, {len(rows)}"),
        minimise=trace(matrix(weight, "W") @ P),
        name="set of starts",
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
    A_k, rate = matrix(A, "A_{k}"), matrix([[alpha]], r"\alpha")
    change = change_of(P, A_k, rate, None)
    each = rf"k = 1, \dots, {count}"
    statements = [(change << 0).named("decay", each)]
    if len(rows):
        ranges = bordered(P, rows, "h_{i}", np.eye(1)) >> 0
        statements.append(ranges.named("inside the ranges", rf"i = 1, \dots, {len(rows)}"))
    if len(pushes):
        v = matrix(pushes[:, :, None], "v_{j}")
        kept = -v.T @ P @ v + np.eye(1) >> 0
        statements.append(kept.named("the set is kept", rf"j = 1, \dots, {len(pushes)}"))
    if residuals is not None:
        u = Unknown("u", 1, 1, symmetric=True, count=n)
        E = matrix(np.diag(residuals), "E")
        forgotten = block([[-change, P @ E], [None, diagonal_of(u)]])
        share = np.array([[2 * alpha * left**2]]) - added(u)
        statements += [
            (forgotten >> 0).named("the residuals are forgotten", each),
            (share >> 0).named("their share"),
        ]
    if jumps is not None:
        m = matrix(jumps[:, :, None], "m_{j}")
        reached = -m.T @ P @ m + eta >> 0
        statements.append(reached.named("jumps", rf"j = 1, \dots, {len(jumps)}"))
    if errors is not None:
        seen = bordered(P, errors, "c_{k}", eta) >> 0
        statements.append(seen.named("the error", rf"k = 1, \dots, {len(errors)}"))
    return pose(
        *statements,
        minimise=eta,
        unknowns=(P, eta),
        name="tracking",
        source="docs/plant-theorems.md",
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
