r"""The peak-to-peak gain from disturbance to output, by an invariant ellipsoid.

With V = x' P x, at every vertex i and for one alpha > 0,

    continuous   [ He(P A_i) + 2 alpha P     P B_i              ]
                 [ .                         -mu I              ]  < 0

    discrete     [ A_i' P A_i - rho^2 P      A_i' P B_i         ]
                 [ .                         B_i' P B_i - mu I  ]  < 0,      rho = e^(-alpha T)

    both         [ sigma P     0               C_i'    ]
                 [ .           (gamma - mu) I  D_i'    ]  > 0,     gamma least,
                 [ .           .               gamma I ]

with sigma = 2 alpha, or 1 - rho^2.  The first gives V' <= -2 alpha V + mu |w|^2, or
V(x+) <= rho^2 V + mu |w|^2, so from rest, for |w| <= 1 at all times, sigma V <= mu: the ellipsoid
is invariant.  The last gives |y|^2 <= gamma (sigma V + (gamma - mu) |w|^2) <= gamma^2.  All of it
holds for every blend of the vertices, however fast it varies.

gamma is the *-norm of the path, at the best alpha: an upper bound on its peak-to-peak gain (of one
vertex: the L1 norm of the impulse response), equal to it for one state and no feed-through.

Source: Abedor, Nagpal, Poolla (1996), Int. J. Robust and Nonlinear Control 6, the *-norm; Scherer,
Gahinet, Chilali (1997), IEEE Trans. Automatic Control 42(7), for this form.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.disturbance.channel import DisturbanceChannel, disturbance_channel
from takagi.lmi.argument_checks import Vertices, number, rate_parameter
from takagi.lmi.condition.term import LMI, Condition, Constant, Term
from takagi.lmi.condition.unknown import Unknown
from takagi.models.errors import ModelError

SOURCE = "Abedor, Nagpal, Poolla (1996); Scherer, Gahinet, Chilali (1997)"


def peak_gain_condition(
    model: Vertices,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
    *,
    decay_rate: float,
    sample_time: float | None = None,
) -> Condition:
    """Pose the module's LMIs at one decay rate; the objective is gamma.

    Parameters
    ----------
    model, B, C, D, sample_time : as for ``peak_gain``.
    decay_rate : alpha in 1/s, positive: the parameter ``alpha``, or ``contraction`` = rho^2.

    Returns
    -------
    The condition in the model's coordinates as they are, with the unknowns ``P``, ``mu`` and
    ``gamma``.  Nothing is solved.

    Raises
    ------
    ModelError : as ``peak_gain``.

    Source: Abedor, Nagpal, Poolla (1996); Scherer, Gahinet, Chilali (1997).
    """
    path = disturbance_channel(model, B, C, D, sample_time=sample_time)
    n = path.A.shape[1]
    P = Unknown("P", n, n, symmetric=True)
    mu = Unknown("mu", 1, 1, latex=r"\mu")
    gamma = Unknown("gamma", 1, 1, latex=r"\gamma")
    return Condition(
        name="peak-to-peak gain, invariant ellipsoid",
        unknowns=(P, mu, gamma),
        lmis=(_invariance(P, mu, path), _peak(P, mu, gamma, path)),
        objective={"gamma": np.ones((1, 1, 1))},
        parameters=rate_parameter(positive_rate(decay_rate), path.sample_time),
        source=SOURCE,
    )


def _invariance(P: Unknown, mu: Unknown, path: DisturbanceChannel) -> LMI:
    r, n, q = path.B.shape
    one = np.eye(n)[None]
    noise = Term(unknown=mu, left=-np.eye(q)[None], at=(1, 1), latex=("-", "I"))
    terms: tuple[Term, ...]
    if path.sample_time is None:
        terms = (
            Term(unknown=P, left=one, right=path.A, plus_transpose=True, latex=("", "A_{i}")),
            Term(unknown=P, left=2 * one, right=one, parameter="alpha", latex=(r"2\alpha", "")),
            Term(unknown=P, left=one, right=path.B, at=(0, 1), latex=("", "B_{i}")),
        )
    else:
        A, B = path.A.transpose(0, 2, 1), path.B.transpose(0, 2, 1)
        terms = (
            Term(unknown=P, left=A, right=path.A, latex=(r"A_{i}^\top", "A_{i}")),
            Term(unknown=P, left=-one, right=one, parameter="contraction", latex=(r"-\rho^2", "")),
            Term(unknown=P, left=A, right=path.B, at=(0, 1), latex=(r"A_{i}^\top", "B_{i}")),
            Term(unknown=P, left=B, right=path.B, at=(1, 1), latex=(r"B_{i}^\top", "B_{i}")),
        )
    return LMI(
        name="vertex",
        blocks=(n, q),
        terms=(*terms, noise),
        sign=-1,
        count=r,
        index=rf"i = 1, \dots, {r}",
    )


def _peak(P: Unknown, mu: Unknown, gamma: Unknown, path: DisturbanceChannel) -> LMI:
    r, p, q = path.D.shape
    return LMI(
        name="output",
        blocks=(P.rows, q, p),
        terms=(
            *_share(P, path.sample_time),
            Term(unknown=gamma, left=np.eye(q)[None], at=(1, 1), latex=("", "I")),
            Term(unknown=mu, left=-np.eye(q)[None], at=(1, 1), latex=("-", "I")),
            Term(unknown=gamma, left=np.eye(p)[None], at=(2, 2), latex=("", "I")),
        ),
        constants=(
            Constant(value=path.C.transpose(0, 2, 1), at=(0, 2), latex=r"C_{i}^\top"),
            Constant(value=path.D.transpose(0, 2, 1), at=(1, 2), latex=r"D_{i}^\top"),
        ),
        count=r,
        index=rf"i = 1, \dots, {r}",
    )


def _share(P: Unknown, step: float | None) -> tuple[Term, ...]:
    """Return sigma P."""
    one = np.eye(P.rows)[None]
    if step is None:
        return (
            Term(unknown=P, left=2 * one, right=one, parameter="alpha", latex=(r"2\alpha", "")),
        )
    return (
        Term(unknown=P, left=one, right=one),
        Term(unknown=P, left=-one, right=one, parameter="contraction", latex=(r"-\rho^2", "")),
    )


def positive_rate(decay_rate: float) -> float:
    """Return the decay rate in 1/s.

    Raises
    ------
    ModelError : not a positive number.
    """
    rate = float(number("decay_rate", decay_rate))
    if rate <= 0:
        raise ModelError(
            f"decay_rate is {rate:g} 1/s; it must be positive, for without decay a bounded "
            "disturbance may add up without end; None looks for the best one"
        )
    return rate
