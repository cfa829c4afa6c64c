r"""The output's variance under white noise (H2 norm), by one quadratic function.

With V = x' P x, at every vertex i,

    He(P A_i) + C_i' C_i < 0,     trace(B_i' P B_i) < nu,     P > 0,     nu least,

so that d/dt E V <= nu - E |y|^2 along every blend of the vertices: the mean of |y|^2 over time is
at most nu for white noise w of unit intensity, and nu bounds the sum of the energies of y after
an impulse in each w_k.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.2.1, output energy; Scherer and
Weiland (2000), Linear Matrix Inequalities in Control, chapter 3.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.channel import (
    Channel,
    Units,
    answer_without,
    channel_of,
    hopeless_vertex,
    near_least,
)
from takagi.lmi.answer import Answer, Floats
from takagi.lmi.intake import Vertices
from takagi.lmi.solver.balance import state_units
from takagi.lmi.solver.stages import Outcome, optimise
from takagi.lmi.term import LMI, Condition, Constant, Term, Unknown
from takagi.models.errors import ModelError

__all__ = ["h2_norm", "h2_norm_condition"]


def h2_norm_condition(
    model: Vertices,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
) -> Condition:
    """Pose He(P A_i) + C_i' C_i < 0 and trace(B_i' P B_i) < nu at every vertex; nu is least.

    Parameters
    ----------
    model, B, C, D : as for ``h2_norm``.

    Returns
    -------
    The condition in the model's coordinates as they are, with the unknowns ``P`` and ``nu``.
    Nothing is solved.

    Raises
    ------
    ModelError : as ``h2_norm``; or a D that is not zero, then there is no bound to pose.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.2.1.
    """
    path = channel_of(model, B, C, D)
    why = _infinite(path)
    if why:
        raise ModelError(why)
    r, n, q = path.B.shape
    P = Unknown("P", n, n, symmetric=True)
    nu = Unknown("nu", 1, 1, latex=r"\nu")
    one = np.eye(n)[None]
    positive = LMI(
        name="P positive definite", blocks=(n,), terms=(Term(unknown=P, left=one, right=one),)
    )
    energy = LMI(
        name="vertex",
        blocks=(n,),
        terms=(Term(unknown=P, left=one, right=path.A, plus_transpose=True, latex=("", "A_{i}")),),
        constants=(Constant(value=path.C.transpose(0, 2, 1) @ path.C, latex=r"C_{i}^\top C_{i}"),),
        sign=-1,
        count=r,
        index=rf"i = 1, \dots, {r}",
    )
    columns = path.B.transpose(0, 2, 1).reshape(r * q, n, 1)
    variance = LMI(
        name="variance",
        blocks=(1,),
        terms=(
            Term(unknown=nu, left=np.ones((1, 1, 1))),
            Term(
                unknown=P,
                left=-columns.transpose(0, 2, 1),
                right=columns,
                items=np.repeat(np.arange(r), q),
                latex=(r"-\sum_k b_{ik}^\top", "b_{ik}"),
            ),
        ),
        count=r,
        index=rf"i = 1, \dots, {r}",
    )
    return Condition(
        name="output variance",
        unknowns=(P, nu),
        lmis=(positive, energy, variance),
        objective={"nu": np.ones((1, 1, 1))},
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.2.1",
    )


def h2_norm(
    model: Vertices,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
    *,
    scales: ArrayLike | None = None,
) -> Answer:
    """Return the least sqrt(nu), and its P, with mean |y|^2 <= nu for unit white noise w.

    Of one vertex it is the H2 norm; of several an upper bound, the least that one quadratic
    function can show, on the root of the output's mean variance for every blend of the vertices.

    Parameters
    ----------
    model, B, C, D : the disturbance's path, as for ``hinf_norm``.
    scales : (n,) engineering range of each state; None balances the vertices.

    Returns
    -------
    An ``Answer``: ``gain`` is sqrt(nu) in units of y over units of w per sqrt(s), recomputed from
    P; P is the one of the conditions above, to rounding.  Without a common P, or with a direct
    feed-through, the status is "infeasible" and the diagnosis says why.  Nothing is proved here.
    The answer's condition is posed with time, w and y in units of order one as well.

    Raises
    ------
    ModelError : shapes, entries that are not finite, no disturbance or no output, a path that is
        zero at every vertex, scales that are not positive.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.2.1.
    """
    path = channel_of(model, B, C, D)
    s = state_units(path.A, scales)
    why = hopeless_vertex(path, s) or _infinite(path)
    if why:
        return Answer(status="infeasible", P=None, margin=-np.inf, coordinates=s, diagnosis=why)
    units = Units.of(path, s)
    scaled = path.scaled(units)
    condition = h2_norm_condition(scaled)
    outcome = optimise(condition)
    if not near_least(outcome):
        return answer_without(path, s, condition, outcome)
    return _answer(scaled, units, condition, outcome)


def variance_shown(channel: Channel, P: Floats) -> tuple[float, Floats]:
    """Return (nu, kappa P): the least multiple of P that meets the vertices, and what it shows.

    kappa = max_i lambda_max(C_i (-He(P A_i))^-1 C_i'), inf when He(P A_i) < 0 fails at a vertex.
    """
    A, B, C = channel.A, channel.B, channel.C
    decrease = -(P @ A + (P @ A).transpose(0, 2, 1))
    if np.linalg.eigvalsh(decrease).min() <= 0:
        return np.inf, P
    shown = C @ np.linalg.solve(decrease, C.transpose(0, 2, 1))
    kappa = float(np.linalg.eigvalsh((shown + shown.transpose(0, 2, 1)) / 2)[:, -1].max())
    nu = kappa * float(np.einsum("ijk,jl,ilk->i", B, P, B).max())
    return nu, kappa * P


def _answer(scaled: Channel, units: Units, condition: Condition, outcome: Outcome) -> Answer:
    nu, P = variance_shown(scaled, outcome.values["P"][0])
    s = units.states
    return Answer(
        status=outcome.status,
        P=units.output**2 / units.rate * P / s / s[:, None],
        margin=outcome.margin,
        gain=float(np.sqrt(nu * units.rate)) * units.output / units.disturbance,
        bound=outcome.bound,
        values=outcome.values,
        multipliers=outcome.multipliers,
        coordinates=s,
        condition=condition,
        tries=outcome.tries,
    )


def _infinite(channel: Channel) -> str:
    """Return why the variance is infinite: a direct feed-through; empty when there is none."""
    through = np.abs(channel.D).max(axis=(1, 2))
    if not through.any():
        return ""
    vertex = int(np.argmax(through))
    return (
        f"vertex {vertex + 1} of {len(through)}: D is not zero (largest entry "
        f"{through[vertex]:.6g}), so white noise reaches the output directly, with infinite "
        "variance; put a filter into that path, or leave D out"
    )
