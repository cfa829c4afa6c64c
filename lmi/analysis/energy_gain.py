r"""The energy gain (H-infinity norm) from disturbance to output, by one quadratic function.

With V = x' P x, at every vertex i,

    [ He(P A_i)   P B_i      C_i'     ]
    [ .           -gamma I   D_i'     ]  < 0,     P > 0,     gamma least,
    [ .           .          -gamma I ]

so that V' <= gamma |w|^2 - |y|^2 / gamma along every blend of the vertices, however fast it varies,
and the energy of y is at most gamma^2 times that of w from x(0) = 0.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.3.2; Gahinet and Apkarian (1994),
Int. J. Robust and Nonlinear Control 4, for this form of the bounded real lemma.
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

__all__ = ["hinf_norm", "hinf_norm_condition"]


def hinf_norm_condition(
    model: Vertices,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
) -> Condition:
    """Pose the bounded real lemma at every vertex with one P > 0; the objective is gamma.

    Parameters
    ----------
    model, B, C, D : as for ``hinf_norm``.

    Returns
    -------
    The condition in the model's coordinates as they are, with the unknowns ``P`` and ``gamma``.
    Nothing is solved.

    Raises
    ------
    ModelError : as ``hinf_norm``.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.3.2.
    """
    path = channel_of(model, B, C, D)
    r, n, q = path.B.shape
    p = path.C.shape[1]
    P = Unknown("P", n, n, symmetric=True)
    gamma = Unknown("gamma", 1, 1, latex=r"\gamma")
    one = np.eye(n)[None]
    positive = LMI(
        name="P positive definite", blocks=(n,), terms=(Term(unknown=P, left=one, right=one),)
    )
    bounded_real = LMI(
        name="vertex",
        blocks=(n, q, p),
        terms=(
            Term(unknown=P, left=one, right=path.A, plus_transpose=True, latex=("", "A_{i}")),
            Term(unknown=P, left=one, right=path.B, at=(0, 1), latex=("", "B_{i}")),
            Term(unknown=gamma, left=-np.eye(q)[None], at=(1, 1), latex=("-", "I")),
            Term(unknown=gamma, left=-np.eye(p)[None], at=(2, 2), latex=("-", "I")),
        ),
        constants=(
            Constant(value=path.C.transpose(0, 2, 1), at=(0, 2), latex=r"C_{i}^\top"),
            Constant(value=path.D.transpose(0, 2, 1), at=(1, 2), latex=r"D_{i}^\top"),
        ),
        sign=-1,
        count=r,
        index=rf"i = 1, \dots, {r}",
    )
    return Condition(
        name="energy gain, bounded real lemma",
        unknowns=(P, gamma),
        lmis=(positive, bounded_real),
        objective={"gamma": np.ones((1, 1, 1))},
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.3.2",
    )


def hinf_norm(
    model: Vertices,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
    *,
    scales: ArrayLike | None = None,
) -> Answer:
    """Return the least gamma, and its P, with |y|_2 <= gamma |w|_2 for every blend of the vertices.

    Of one vertex it is the H-infinity norm; of several an upper bound on the energy gain, the
    least that one quadratic function can show.

    Parameters
    ----------
    model : A (r, n, n), C (r, p, n), and the disturbance's E (r, n, q); without E the input is
        the disturbance, with B (r, n, m) and D (r, p, m).  Or A itself, (r, n, n) or (n, n): then
        B, C and D (zero when left out) are arrays, (r, ., .) or (., .).
    scales : (n,) engineering range of each state; None balances the vertices.

    Returns
    -------
    An ``Answer``: ``gain`` is gamma in units of y over units of w, the least that its P shows,
    recomputed from P by eigenvalues; with it P touches the LMI.  Without a common P the status is
    "infeasible", and the diagnosis names the vertices that rule it out.  Nothing is proved here.
    The answer's condition is posed with time, w and y in units of order one as well.

    Raises
    ------
    ModelError : shapes, entries that are not finite, no disturbance or no output, a path that is
        zero at every vertex, scales that are not positive.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.3.2.
    """
    path = channel_of(model, B, C, D)
    s = state_units(path.A, scales)
    why = hopeless_vertex(path, s)
    if why:
        return Answer(status="infeasible", P=None, margin=-np.inf, coordinates=s, diagnosis=why)
    units = Units.of(path, s)
    scaled = path.scaled(units)
    condition = hinf_norm_condition(scaled)
    outcome = optimise(condition)
    if not near_least(outcome):
        return answer_without(path, s, condition, outcome)
    return _answer(scaled, units, condition, outcome)


def energy_gain_of(channel: Channel, P: Floats) -> float:
    """Return the least gamma that P shows, inf when He(P A_i) < 0 fails at a vertex.

    By a Schur complement gamma = max_i lambda_max([[0, D'], [D, 0]] + G' (-He(P A))^-1 G) with
    G = [P B, C'].
    """
    A, B, C, D = channel.A, channel.B, channel.C, channel.D
    decrease = -(P @ A + (P @ A).transpose(0, 2, 1))
    if np.linalg.eigvalsh(decrease).min() <= 0:
        return np.inf
    q = B.shape[2]
    G = np.concatenate([P @ B, C.transpose(0, 2, 1)], axis=2)
    total = G.transpose(0, 2, 1) @ np.linalg.solve(decrease, G)
    total[:, q:, :q] += D
    total[:, :q, q:] += D.transpose(0, 2, 1)
    total = (total + total.transpose(0, 2, 1)) / 2
    return float(np.linalg.eigvalsh(total)[:, -1].max())


def _answer(scaled: Channel, units: Units, condition: Condition, outcome: Outcome) -> Answer:
    P, s = outcome.values["P"][0], units.states
    gain = energy_gain_of(scaled, P) * units.output / units.disturbance
    # V is measured in |y|^2 / gamma times seconds.
    size = units.output * units.disturbance / units.rate
    return Answer(
        status=outcome.status,
        P=size * P / s / s[:, None],
        margin=outcome.margin,
        gain=gain,
        bound=outcome.bound,
        values=outcome.values,
        multipliers=outcome.multipliers,
        coordinates=s,
        condition=condition,
        tries=outcome.tries,
    )
