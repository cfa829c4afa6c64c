r"""The least peak-to-peak gain that one quadratic function shows, and the decay rate to show it.

The peak-to-peak gain from disturbance to output, by an invariant ellipsoid.

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

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.decay_rate import fast_decay, vertex_weight
from takagi.lmi.analysis.disturbance.channel import (
    ChannelUnits,
    DisturbanceChannel,
    disturbance_channel,
    hiding_states,
    moved,
    shown,
)
from takagi.lmi.analysis.disturbance.guessed_function import OneVertex
from takagi.lmi.analysis.disturbance.least_gain import (
    gain_of_hidden,
    least_gain,
    motion_of,
    states_of,
)
from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import Vertices, decay_parameter, number
from takagi.lmi.condition.statements import pose
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.cone.balance import motion, state_units
from takagi.lmi.decision.rounds import first_vertices
from takagi.lmi.expressions.expression import block
from takagi.lmi.parameter_search.parameter_sweep import least_over_rate, unknowns_near_least
from takagi.models.arrays import Floats
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

    model, B, C, D, sample_time : as for ``peak_gain``.
    decay_rate : alpha in 1/s, positive: the parameter ``alpha``, or ``contraction`` = rho^2.

    Returns the condition in the model's coordinates as they are, with the unknowns ``P``, ``mu``
    and ``gamma``.  Nothing is solved.

    Raises ModelError: as ``peak_gain``.
    """
    path = disturbance_channel(model, B, C, D, sample_time=sample_time)
    rate = decay_parameter(positive_rate(decay_rate), path.sample_time)
    r, n, q = path.B.shape
    P = Unknown("P", n, n, symmetric=True)
    mu = Unknown("mu", 1, 1, latex=r"\mu")
    gamma = Unknown("gamma", 1, 1, latex=r"\gamma")
    (xx, xw, ww), (C_i, D_i) = moved(P, path, rate), shown(path)
    # sigma P: what V falls by.
    share = 2 * rate * P if path.sample_time is None else P - rate * P
    eye, each = np.eye(q), rf"i = 1, \dots, {r}"
    invariance = block([[xx, xw], [None, ww - mu * eye]])
    peak = block(
        [
            [share, 0, C_i],
            [None, gamma * eye - mu * eye, D_i],
            [None, None, gamma * np.eye(C_i.shape[1])],
        ]
    )
    return pose(
        (invariance << 0).named("vertex", each),
        (peak >> 0).named("output", each),
        minimise=gamma,
        unknowns=(P, mu, gamma),
        name="peak-to-peak gain, invariant ellipsoid",
        source=SOURCE,
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


# Rates that are tried, as shares of the largest common decay rate. At the largest rate itself the
# LMI has no margin left for the disturbance.
SHARES = (0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98)
# A discrete-time loop may reach the equilibrium in a few steps, so its rate may be infinite; the
# search ends at a decay by e^-7 in one sample.
FASTEST = 7.0
# The relative increase of one vertex's gain that gives its P a margin; P only serves as
# coordinates.
ROOM = 1e-5
# The rate, in units of order one, that is used if no rate has a finite gain.
SMALLEST = 1e-6


def peak_gain(
    model: Vertices,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
    *,
    decay_rate: float | None = None,
    sample_time: float | None = None,
    scales: ArrayLike | None = None,
) -> Answer:
    """Return gamma, and its P, with sup |y| <= gamma sup |w| from rest, for every blend.

    |.| is the Euclidean norm of the vector at one instant, the largest over time is taken.  An
    upper bound: the peak-to-peak gain itself is smaller in general, even of one vertex.

    Parameters
    ----------
    model, B, C, D : the disturbance's path, as for ``hinf_norm``.
    decay_rate : alpha in 1/s, positive; None looks for the best one, by a grid and the golden
        section: of one vertex up to the rate of its slowest mode, by its Lyapunov equation; of
        several between 2 and 98 per cent of the largest common decay rate.
    sample_time : T in s of x+ = A x + B w, where arrays are given; a model knows its own.
    scales : (n,) engineering range of each state; None balances the vertices.

    Returns an ``Answer``: ``gain`` is gamma in units of y over units of w, recomputed from P and
    alpha by eigenvalues, ``decay_rate`` is alpha, and x' P x <= 1 is invariant for |w| <= 1: no
    state leaves it, from rest or from inside.  Every alpha gives a valid bound; that none gives a
    lesser one is not promised for several vertices.  Nothing is proved here.

    Raises ModelError: shapes, entries that are not finite, no disturbance or no output, a path that
    is zero at every vertex, a decay rate, scales or a sample time that are not positive.

    Source: Abedor, Nagpal, Poolla (1996); Scherer, Gahinet, Chilali (1997).
    """
    path = disturbance_channel(model, B, C, D, sample_time=sample_time)
    fixed_rate = None if decay_rate is None else positive_rate(decay_rate)
    T = hiding_states(path)
    hidden = None if T is None else _of_hidden(path.in_states(T), T, fixed_rate)
    if hidden is not None:
        return hidden
    search = _Search.of(path, state_units(path.A, scales, step=path.sample_time))
    rate = search.best() if fixed_rate is None else search.at(fixed_rate)
    answer = least_gain(
        path.in_states(search.states),
        np.ones(path.A.shape[1]),
        partial(_condition, rate=rate),
        partial(_gain_and_P, rate=rate),
        decay_rate=rate,
    )
    if answer.P is None:
        return replace(answer, decay_rate=None, coordinates=None)
    back = np.linalg.inv(search.states)
    return replace(answer, P=back.T @ answer.P @ back, decay_rate=rate, coordinates=None)


def _of_hidden(inside: DisturbanceChannel, T: Floats, fixed_rate: float | None) -> Answer | None:
    """Return the peak's gain of a path that shows none; None without a common decay rate."""
    unit_scales = np.ones(len(T))
    fast = fast_decay(inside.A, tolerance=1e-2, scales=unit_scales, sample_time=inside.sample_time)
    rate = (fast.decay_rate or 0.0) / 2 if fixed_rate is None else fixed_rate
    if inside.sample_time is not None:
        rate = min(rate, FASTEST / inside.sample_time)
    if not rate > 0:
        return None
    pose, measure = partial(_condition, rate=rate), partial(_gain_and_P, rate=rate)
    answer = gain_of_hidden(inside, T, pose, measure, rate)
    return None if answer is None else replace(answer, decay_rate=rate)


def peak_bound(channel: DisturbanceChannel, P: Floats, rate: float) -> tuple[float, Floats]:
    """Return (gamma, sigma P / mu): the least gamma, and the ellipsoid, that P and a rate show.

    With F, G, H of ``motion_of`` and F_sigma = F - sigma P > 0 (inf where it is not),
    mu = max_i lambda_max(H + G' F_sigma^-1 G).  P may be multiplied by any t > 0, and by a Schur
    complement gamma = min_t max_i lambda_max([[t mu I, -D'], [-D, C (t sigma P)^-1 C']]), which is
    convex in the logarithm of t.
    """
    C, D = channel.C, channel.D
    step = channel.sample_time
    sigma = 2.0 * rate if step is None else -np.expm1(-2.0 * rate * step)
    fall, reach, direct = motion_of(channel, P)
    margin_matrix = fall - sigma * P
    if min(np.linalg.eigvalsh(margin_matrix).min(), np.linalg.eigvalsh(P)[0]) <= 0:
        return np.inf, P
    # A disturbance that reaches no state leaves any ellipsoid, however small, invariant.
    mu = max(
        largest_eigenvalue(
            direct + reach.transpose(0, 2, 1) @ np.linalg.solve(margin_matrix, reach)
        ),
        1e-30,
    )
    spread = C @ np.linalg.solve(sigma * P, C.transpose(0, 2, 1))
    if not D.any():
        return float(np.sqrt(mu * largest_eigenvalue(spread))), sigma * P / mu
    from scipy.optimize import minimize_scalar

    q = reach.shape[2]
    total = np.zeros((len(D), q + D.shape[1], q + D.shape[1]))
    total[:, q:, :q], total[:, :q, q:] = -D, -D.transpose(0, 2, 1)

    def gamma(logarithm: float) -> float:
        t = np.exp(logarithm)
        total[:, :q, :q], total[:, q:, q:] = t * mu * np.eye(q), spread / t
        return largest_eigenvalue(total)

    middle = 0.5 * np.log(max(largest_eigenvalue(spread), 1e-300) / mu)
    # The best t is near this value; ten natural logarithms to both sides contain it.
    best = minimize_scalar(gamma, bounds=(middle - 10.0, middle + 10.0), method="bounded")
    return float(best.fun), sigma * P / mu


def largest_eigenvalue(matrices: Floats) -> float:
    """Return the largest eigenvalue of the symmetric parts of (N, n, n) matrices."""
    symmetric = (matrices + matrices.transpose(0, 2, 1)) / 2
    return float(np.linalg.eigvalsh(symmetric)[:, -1].max())


class _Search:
    """The search for the best decay rate, each time in states where the last P is the identity.

    If the matrix of a loop is far from normal, P is ill-conditioned in balanced states.
    """

    def __init__(self, path: DisturbanceChannel, states: Floats) -> None:
        self.path, self.states = path, states

    @classmethod
    def of(cls, path: DisturbanceChannel, s: Floats) -> _Search:
        """Return a search over some of the vertices, where there are many."""
        scaled_motion = motion(path.A * s / s[:, None], path.sample_time)
        return cls(path.at(first_vertices(scaled_motion)), np.diag(s))

    def best(self) -> float:
        """Return about the rate [1/s] with the least gain; a tiny one if no gain is finite."""
        if len(self.path.A) == 1 and (rate := self._of_one_vertex()) is not None:
            return rate
        ceiling = self._ceiling()
        if ceiling > 0:
            best_share = least_over_rate(self._value, [share * ceiling for share in SHARES])
            if best_share is not None:
                return self.at(best_share)
        size = vertex_weight(motion(self.path.A, self.path.sample_time)) / 2
        return SMALLEST * size / (self.path.sample_time or 1.0)

    def _of_one_vertex(self) -> float | None:
        """Return the best rate of one vertex by its Lyapunov equation, with the states adapted."""
        path = self.path
        vertex = OneVertex.of(path.A[0], path.B[0], path.C[0], path.D[0], step=path.sample_time)
        rate = vertex.best_rate()
        P = None if rate is None else vertex.with_room(rate, ROOM)
        T = None if P is None else states_of(P)
        if T is None:
            return None
        self.states = T
        return rate

    def at(self, rate: float) -> float:
        """Return the rate, with the states adapted to it."""
        if not np.isfinite(self._value(rate)) and self._ceiling() > rate:
            self._value(rate)
        return rate

    def _ceiling(self) -> float:
        step = self.path.sample_time
        inside = self.path.in_states(self.states)
        unit_scales = np.ones(len(self.states))
        fastest = fast_decay(inside.A, tolerance=1e-2, scales=unit_scales, sample_time=step)
        rate = fastest.decay_rate or 0.0
        if rate > 0 and fastest.P is not None:
            self._adapt(fastest.P)
        return rate if step is None else min(rate, FASTEST / step)

    def _adapt(self, P: Floats) -> None:
        T = states_of(P)
        if T is not None:
            self.states = self.states @ T

    def _value(self, rate: float) -> float:
        inside = self.path.in_states(self.states)
        units = ChannelUnits.of(inside, np.ones(len(self.states)))
        scaled = inside.scaled(units)
        unknowns = unknowns_near_least(_condition(scaled, units, rate=rate))
        if not unknowns:
            return np.inf
        P = unknowns["P"][0]
        gamma, _ = peak_bound(scaled, P, rate / units.rate)
        if np.isfinite(gamma):
            self._adapt(P / units.states / units.states[:, None])
        return gamma * units.output / units.disturbance


def _condition(scaled: DisturbanceChannel, units: ChannelUnits, *, rate: float) -> Condition:
    return peak_gain_condition(scaled, decay_rate=rate / units.rate)


def _gain_and_P(
    scaled: DisturbanceChannel, units: ChannelUnits, values: Mapping[str, Floats], *, rate: float
) -> tuple[float, Floats]:
    gain, P = peak_bound(scaled, values["P"][0], rate / units.rate)
    s = units.states
    # The ellipsoid of |w| <= 1 is that of |what| <= 1 over the unit of w.
    return gain * units.output / units.disturbance, units.disturbance**2 * P / s / s[:, None]
