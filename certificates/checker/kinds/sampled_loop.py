r"""``sampled-loop``: a continuous plant whose law runs every T seconds and holds its command.

    x' = A x + B u_k   from t_k = k T to t_k + T,     u_k = -K x(t_k)

(A, B) is any blend of the (A_i, B_i) and may change within the interval; K is any blend of the K_j,
with the weights at t_k.  So the weights may change by any amount while u_k is held.  Let
xi = (x, u), M_i = [[A_i, B_i], [0, 0]], L_j = [I; -K_j], and P_0 ... P_d the Bernstein coefficients
of

    Q(s) = sum_l b_l(s) P_l,     b_l(s) = binom(d, l) s^l (1 - s)^(d - l),     s = (t - t_k) / T,

The function xi'Q xi does not increase within an interval, and V = x'Px decreases from one sample to
the next, if for every i, j and l

    flow      -(D_l + T (P_l M_i + M_i'P_l)) >= 0,
                 D_l = (d - l) (P_l+1 - P_l) + l (P_l - P_l-1)     the coefficients of dQ/ds
    end       P_d - [[P, 0], [0, 0]] >= 0
    sample    rho^2 P - L_j'P_0 L_j > 0,   P_0 >= 0,   a rational rho^2 <= e^(-2 alpha T):

    V(x(t_k + T)) <= xi'P_d xi <= xi'P_0 xi at t_k <= rho^2 V(x(t_k)).

Between samples xi'Q xi <= rho^2 c < c where V(x(t_k)) <= c.  So a state with |x_m| <= b in the
model's box does not reach b if c e_m e_m' <= b^2 P_l for every l, and the model equals its plant at
all times.  alpha = 0 claims that V decreases, without a rate.  P > 0 follows from "sample".

Evidence: ``sample_time`` T, ``P``, ``level`` c, ``decay_rate`` alpha, ``functions`` P_0 ... P_d.

Source: derived here.  Functions of the time since the last sample: Briat (2013), Automatica 49(11),
recalled; coefficients of Bernstein polynomials bound them, as their weights are >= 0 with sum 1.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import Any

from takagi.certificates.checker.arithmetic.exponential import exp_below
from takagi.certificates.checker.kernel.matrices import Matrix, read_matrix, read_stack
from takagi.certificates.checker.kernel.reader import number, text
from takagi.certificates.checker.kernel.refusal import CertificateError
from takagi.certificates.checker.kernel.result import Claim, Found, Outcome, Verdict
from takagi.certificates.checker.loop.box_of_validity import (
    beyond_range,
    outside_of,
    reaches_at_most,
    row_of,
)
from takagi.certificates.checker.loop.polytopic_loop import PolytopicLoop, bounded

HIGHEST = 20  # degree of Q


def check_sampled_loop(claim: Any, loop: PolytopicLoop, where: str) -> Outcome:
    """Return PROVED when every inequality holds, else UNDECIDED with the first that fails."""
    name = text(claim, "name", where)
    if loop.is_discrete or not loop.K or not loop.B:
        raise CertificateError(f"{where}: inputs and gains are needed, in continuous time")
    step, level, alpha = (number(claim, k, where) for k in ("sample_time", "level", "decay_rate"))
    if step <= 0 or level <= 0 or alpha < 0:
        raise CertificateError(f"{where}: sample_time, level > 0 and decay_rate >= 0 are needed")
    m, n = loop.K[0].shape
    P, Q = read_matrix(claim, "P", where, (n, n)), read_stack(claim, "functions", where)
    if Q[0].shape != (n + m, n + m) or not 2 <= len(Q) <= HIGHEST + 1:
        raise CertificateError(f"{where}.functions: 2 to {HIGHEST + 1} of order {n + m} are needed")
    why = _why_not_falling(loop, P, Q, step, alpha) or _why_leaving(loop, P, Q, level)
    if why:
        return Claim(name, Verdict.UNDECIDED, why)
    said = {"name": name, "loop": loop, "step": step, "P": P, "level": level, "alpha": alpha}
    return Found(Verdict.PROVED, "sampled_loop", said)


def _why_not_falling(
    loop: PolytopicLoop, P: Matrix, Q: Sequence[Matrix], step: Fraction, alpha: Fraction
) -> str:
    """Return which inequality of the module fails; empty if none does."""
    m, n = loop.K[0].shape
    bounded(loop.rules * len(Q) + len(loop.K), n + m)
    # If P_0 is symmetric and semidefinite, the other inequalities imply that P > 0 and that P and
    # all functions are symmetric: these need no test of their own.
    if not Q[0].is_positive_semidefinite:
        return "the first function is not symmetric positive semidefinite"
    corner = Matrix.blocks([[P, _zeros(n, m)], [_zeros(m, n), _zeros(m, m)]])
    if not (Q[-1] - corner).is_positive_semidefinite:
        return "the last function may be below V"
    factor = exp_below(2 * alpha * step)
    for j, K in enumerate(loop.K):
        L = Matrix.blocks([[Matrix.identity(n)], [-K]])
        if not (factor * P - L.T @ Q[0] @ L).is_positive_definite:
            return f"V may not fall from sample to sample with gain {j + 1}"
    changes = list(_changes(Q))
    for i in range(loop.rules):
        A, B = (stack[i if len(stack) > 1 else 0] for stack in (loop.A, loop.B))
        M = step * Matrix.blocks([[A, B], [_zeros(m, n), _zeros(m, m)]])
        for function, change in zip(Q, changes, strict=True):
            moved = function @ M
            if not (-(change + moved + moved.T)).is_positive_semidefinite:
                return f"the function may grow between samples at rule {i + 1}"
    return ""


def _why_leaving(loop: PolytopicLoop, P: Matrix, Q: Sequence[Matrix], level: Fraction) -> str:
    """Return which range of the box may be left, at samples or between them; empty for none."""
    idle = (Fraction(0),) * len(loop.disturbances)
    why = beyond_range(loop, idle) or outside_of(loop, P, level)
    rows = Matrix.identity(len(Q[0].rows))
    for k, side in enumerate(loop.box):
        if why or side is None:
            continue
        room = min(-side[0], side[1])
        if not all(reaches_at_most(one, level, row_of(rows, k), room) for one in Q):
            why = f"{loop.states[k]} may leave its range in the model's box between samples"
    return why


def _changes(Q: Sequence[Matrix]) -> Iterator[Matrix]:
    """Yield the Bernstein coefficients, of Q's own degree, of dQ/ds."""
    d = len(Q) - 1
    for k in range(d + 1):
        after, before = Q[min(k + 1, d)] - Q[k], Q[k] - Q[max(k - 1, 0)]
        yield (d - k) * after + k * before


def _zeros(rows: int, columns: int) -> Matrix:
    return Matrix([[0] * columns for _ in range(rows)])
