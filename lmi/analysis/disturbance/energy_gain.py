r"""The energy gain (H-infinity norm) from disturbance to output, by one quadratic function.

With V = x' P x, at every vertex i,

    continuous   [ He(P A_i)        P B_i                  C_i'     ]
                 [ .                -gamma I               D_i'     ]  < 0
                 [ .                .                      -gamma I ]

    discrete     [ A_i' P A_i - P   A_i' P B_i             C_i'     ]
                 [ .                B_i' P B_i - gamma I   D_i'     ]  < 0
                 [ .                .                      -gamma I ]

with P > 0 and gamma least.  Then V', or V(x+) - V(x), is at most gamma |w|^2 - |y|^2 / gamma along
every blend of the vertices, however fast it varies (the second is convex in the vertex), and the
energy of y, the integral or the sum of |y|^2, is at most gamma^2 times that of w from x(0) = 0.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.3.2; Gahinet and Apkarian (1994),
Int. J. Robust and Nonlinear Control 4, for these forms of the bounded real lemma.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.disturbance.channel import (
    ChannelUnits,
    DisturbanceChannel,
    disturbance_channel,
)
from takagi.lmi.analysis.disturbance.guessed_function import guessed_of_energy
from takagi.lmi.analysis.disturbance.least_gain import least_gain, motion_of
from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import Vertices
from takagi.lmi.condition.term import LMI, Condition, Constant, Term, positive
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.solver.time_limit import limited
from takagi.models.arrays import Floats

SOURCE = "Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.3.2; Gahinet and Apkarian (1994)"


def hinf_norm_condition(
    model: Vertices,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
    *,
    sample_time: float | None = None,
) -> Condition:
    """Pose the bounded real lemma at every vertex with one P > 0; the objective is gamma.

    Parameters
    ----------
    model, B, C, D, sample_time : as for ``hinf_norm``.

    Returns
    -------
    The condition in the model's coordinates as they are, with the unknowns ``P`` and ``gamma``.
    Nothing is solved.

    Raises
    ------
    ModelError : as ``hinf_norm``.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.3.2; Gahinet and Apkarian (1994).
    """
    path = disturbance_channel(model, B, C, D, sample_time=sample_time)
    r, n, q = path.B.shape
    p = path.C.shape[1]
    P = Unknown("P", n, n, symmetric=True)
    gamma = Unknown("gamma", 1, 1, latex=r"\gamma")
    bounded_real = LMI(
        name="vertex",
        blocks=(n, q, p),
        terms=(
            *(_continuous(P, path) if path.sample_time is None else _discrete(P, path)),
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
        lmis=(positive(P), bounded_real),
        objective={"gamma": np.ones((1, 1, 1))},
        source=SOURCE,
    )


def _continuous(P: Unknown, path: DisturbanceChannel) -> tuple[Term, ...]:
    eye = np.eye(P.rows)[None]
    return (
        Term(unknown=P, left=eye, right=path.A, plus_transpose=True, latex=("", "A_{i}")),
        Term(unknown=P, left=eye, right=path.B, at=(0, 1), latex=("", "B_{i}")),
    )


def _discrete(P: Unknown, path: DisturbanceChannel) -> tuple[Term, ...]:
    eye = np.eye(P.rows)[None]
    A, B = path.A.transpose(0, 2, 1), path.B.transpose(0, 2, 1)
    return (
        Term(unknown=P, left=A, right=path.A, latex=(r"A_{i}^\top", "A_{i}")),
        Term(unknown=P, left=-eye, right=eye, latex=("-", "")),
        Term(unknown=P, left=A, right=path.B, at=(0, 1), latex=(r"A_{i}^\top", "B_{i}")),
        Term(unknown=P, left=B, right=path.B, at=(1, 1), latex=(r"B_{i}^\top", "B_{i}")),
    )


@limited
def hinf_norm(
    model: Vertices,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
    *,
    sample_time: float | None = None,
    scales: ArrayLike | None = None,
    tolerance: float = 1e-6,
    time_limit: float | None = None,
) -> Answer:
    """Return the least gamma, and its P, with |y|_2 <= gamma |w|_2 for every blend of the vertices.

    Of one vertex it is the H-infinity norm; of several an upper bound on the energy gain, the
    least that one quadratic function can show.

    Parameters
    ----------
    model : A (r, n, n), C (r, p, n), and the disturbance's E (r, n, q); without E the input is
        the disturbance, with B (r, n, m) and D (r, p, m).  Or A itself, (r, n, n) or (n, n): then
        B, C and D (zero when left out) are arrays, (r, ., .) or (., .).
    sample_time : T in s of x+ = A x + B w, where arrays are given; a model knows its own.  The
        energies are then sums over samples.  gamma does not depend on T.
    scales : (n,) engineering range of each state; None looks for units itself.
    tolerance : how far above the least gamma the answer may be, relative: P has a margin then.
    time_limit : seconds for all solver calls together, as they come; an answer stopped by it is
        "unknown", and its diagnosis reports it.  None for no limit.

    Returns
    -------
    An ``Answer``: ``gain`` is gamma in units of y over units of w, the least that its P shows,
    recomputed from P by eigenvalues; with it P touches the LMI.  Without a common P the status is
    "infeasible", and the diagnosis names the vertices that rule it out.  Nothing is proved here.
    The answer's condition is posed with time, w and y in units of order one as well.

    Raises
    ------
    ModelError : shapes, entries that are not finite, no disturbance or no output, a path that is
        zero at every vertex, scales or a sample time that are not positive.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.3.2; Gahinet and Apkarian (1994).
    """
    path = disturbance_channel(model, B, C, D, sample_time=sample_time)
    return least_gain(
        path, scales, _condition, _gain_and_P, guess=guessed_of_energy, tolerance=tolerance
    )


def energy_gain_of(channel: DisturbanceChannel, P: Floats) -> float:
    """Return the least gamma that P shows, inf when V does not fall at a vertex.

    With F, G, H of ``motion_of`` a Schur complement leaves
    gamma = max_i lambda_max([[H, D'], [D, 0]] + [G, C']' F^-1 [G, C']).
    """
    C, D = channel.C, channel.D
    fall, reach, direct = motion_of(channel, P)
    if np.linalg.eigvalsh(fall).min() <= 0:
        return np.inf
    q = reach.shape[2]
    G = np.concatenate([reach, C.transpose(0, 2, 1)], axis=2)
    total = G.transpose(0, 2, 1) @ np.linalg.solve(fall, G)
    total[:, :q, :q] += direct
    total[:, q:, :q] += D
    total[:, :q, q:] += D.transpose(0, 2, 1)
    total = (total + total.transpose(0, 2, 1)) / 2
    return float(np.linalg.eigvalsh(total)[:, -1].max())


def _condition(scaled: DisturbanceChannel, units: ChannelUnits) -> Condition:
    return hinf_norm_condition(scaled)


def _gain_and_P(
    scaled: DisturbanceChannel, units: ChannelUnits, values: Mapping[str, Floats]
) -> tuple[float, Floats]:
    P, s = values["P"][0], units.states
    # V is measured in |y|^2 / gamma times seconds, or samples.
    size = units.output * units.disturbance / units.rate
    gain = energy_gain_of(scaled, P) * units.output / units.disturbance
    return gain, size * P / s / s[:, None]
