"""H-infinity and H2 norms of a given loop, each by one quadratic function.

The energy gain (H-infinity norm) from disturbance to output, by one quadratic function.

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

The output's variance under white noise (H2 norm), by one quadratic function.

With V = x' P x, at every vertex i,

    continuous   He(P A_i) + C_i' C_i < 0,          trace(B_i' P B_i) < nu
    discrete     A_i' P A_i - P + C_i' C_i < 0,     trace(B_i' P B_i + D_i' D_i) < nu

with P > 0 and nu least.  Both inequalities are convex in the vertex, so they hold for every blend
A(h), B(h), C(h), D(h), and what follows holds however fast the memberships vary:

- E V' <= nu - E |y|^2, or E V(x+) - E V(x) <= nu - E |y|^2, for white noise w of unit intensity, or
  of unit covariance in each sample: the mean of E |y|^2 over time is at most nu.  The memberships
  may depend on the state and on time, not on noise that is still to come.
- The energies of y after an impulse in each w_k at one instant, from rest, sum to at most nu: V is
  sum_k b_k' P b_k after it, with the columns b_k of B(h) at the memberships of that instant.

What is not bounded: E |y|^2 at a single instant, which may exceed nu.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.2.1, output energy; Scherer and
Weiland (2000), Linear Matrix Inequalities in Control, chapter 3.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.analysis.disturbance.channel import (
    ChannelUnits,
    DisturbanceChannel,
    disturbance_channel,
    moved,
    shown,
)
from takagi.lmi.analysis.disturbance.guessed_function import guessed_of_energy, guessed_of_variance
from takagi.lmi.analysis.disturbance.least_gain import least_gain, motion_of
from takagi.lmi.answer import Answer
from takagi.lmi.argument_checks import Vertices
from takagi.lmi.condition.statements import pose, positive_definite
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import added, block, matrix
from takagi.models.arrays import Floats
from takagi.models.errors import ModelError

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

    ``model``, ``B``, ``C``, ``D``, ``sample_time`` : as for ``hinf_norm``.

    Returns the condition in the model's coordinates as they are, with the unknowns ``P`` and
    ``gamma``.  Nothing is solved.

    Raises ModelError: as ``hinf_norm``.
    """
    path = disturbance_channel(model, B, C, D, sample_time=sample_time)
    r, n, q = path.B.shape
    P = Unknown("P", n, n, symmetric=True)
    gamma = Unknown("gamma", 1, 1, latex=r"\gamma")
    (xx, xw, ww), (C_i, D_i) = moved(P, path), shown(path)
    signals, outputs = np.eye(q), np.eye(C_i.shape[1])
    rows: list[list[object]] = [
        [xx, xw, C_i],
        [None, ww - gamma * signals, D_i],
        [None, None, -gamma * outputs],
    ]
    return pose(
        positive_definite(P),
        (block(rows) << 0).named("vertex", rf"i = 1, \dots, {r}"),
        minimise=gamma,
        name="energy gain, bounded real lemma",
        source=SOURCE,
    )


def hinf_norm(
    model: Vertices,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
    *,
    sample_time: float | None = None,
    scales: ArrayLike | None = None,
    tolerance: float = 1e-6,
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

    Returns an ``Answer``: ``gain`` is gamma in units of y over units of w, the least that its P
    shows, recomputed from P by eigenvalues; with it P touches the LMI.  Without a common P the
    status is "infeasible", and the diagnosis names the vertices that rule it out.  Nothing is
    proved here.  The answer's condition is posed with time, w and y in units of order one as well.

    Raises ModelError: shapes, entries that are not finite, no disturbance or no output, a path that
    is zero at every vertex, scales or a sample time that are not positive.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.3.2; Gahinet and Apkarian (1994).
    """
    path = disturbance_channel(model, B, C, D, sample_time=sample_time)
    return least_gain(
        path,
        scales,
        lambda scaled, units: hinf_norm_condition(scaled),
        _energy_gain_and_P,
        guess=guessed_of_energy,
        tolerance=tolerance,
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


def _energy_gain_and_P(
    scaled: DisturbanceChannel, units: ChannelUnits, values: Mapping[str, Floats]
) -> tuple[float, Floats]:
    P, s = values["P"][0], units.states
    # V is measured in |y|^2 / gamma times seconds, or samples.
    size = units.output * units.disturbance / units.rate
    gain = energy_gain_of(scaled, P) * units.output / units.disturbance
    return gain, size * P / s / s[:, None]


def h2_norm_condition(
    model: Vertices,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
    *,
    sample_time: float | None = None,
) -> Condition:
    """Pose He(P A_i) + C_i' C_i < 0 and trace(B_i' P B_i) < nu at every vertex; nu is least.

    In discrete time A_i' P A_i - P in the place of He(P A_i), and trace(D_i' D_i) is added.

    ``model``, ``B``, ``C``, ``D``, ``sample_time`` : as for ``h2_norm``.

    Returns the condition in the model's coordinates as they are, with the unknowns ``P`` and
    ``nu``.  Nothing is solved.

    Raises ModelError: as ``h2_norm``; or, in continuous time, a D that is not zero: then there is
    no bound to pose.
    """
    path = disturbance_channel(model, B, C, D, sample_time=sample_time)
    why = infinite_variance(path.D, path.sample_time)
    if why:
        raise ModelError(why)
    r, n, q = path.B.shape
    P = Unknown("P", n, n, symmetric=True)
    nu = Unknown("nu", 1, 1, latex=r"\nu")
    C_i, each = matrix(path.C, "C_{i}"), rf"i = 1, \dots, {r}"
    b = matrix(path.B.transpose(0, 2, 1).reshape(r * q, n, 1), "b_{ik}")
    impulses = added(b.T @ P @ b, np.repeat(np.arange(r), q), count=r, latex=r"\sum_k")
    spare = nu - impulses
    if path.sample_time is not None:
        direct = (path.D**2).sum(axis=(1, 2))[:, None, None]
        spare -= matrix(direct, r"\mathrm{tr}\left(D_{i}^\top D_{i}\right)")
    return pose(
        positive_definite(P),
        (moved(P, path)[0] + C_i.T @ C_i << 0).named("vertex", each),
        (spare >> 0).named("variance", each),
        minimise=nu,
        name="output variance",
        source="Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.2.1",
    )


def h2_norm(
    model: Vertices,
    B: ArrayLike | None = None,
    C: ArrayLike | None = None,
    D: ArrayLike | None = None,
    *,
    sample_time: float | None = None,
    scales: ArrayLike | None = None,
    tolerance: float = 5e-7,
) -> Answer:
    """Return the least sqrt(nu), and its P, with mean |y|^2 <= nu for unit white noise w.

    Of one vertex it is the H2 norm; of several an upper bound, the least that one quadratic
    function can show, on the root of the output's mean variance for every blend of the vertices,
    and on the root of the energy of all impulse responses; see the module for what varies.

    Parameters
    ----------
    model, B, C, D : the disturbance's path, as for ``hinf_norm``.
    sample_time : T in s of x+ = A x + B w, where arrays are given; a model knows its own.
    scales : (n,) engineering range of each state; None balances the vertices.
    tolerance : how far above the least sqrt(nu) the answer may be, relative: P has a margin then.

    Returns an ``Answer``: ``gain`` is sqrt(nu), recomputed from P; P is the one of the conditions
    above, to rounding.  Its unit is that of y over that of w per sqrt(s) in continuous time.  In
    discrete time it is per sample, y over w: the root of the sum of the squared impulse response,
    for noise of unit covariance in each sample, whatever T; divide by sqrt(T) where w is a sampled
    noise of unit intensity (covariance 1/T).  Without a common P, or with a direct feed-through in
    continuous time, the status is "infeasible" and the diagnosis says why.  Nothing is proved here.
    The answer's condition is posed with time, w and y in units of order one as well.

    Raises ModelError: shapes, entries that are not finite, no disturbance or no output, a path that
    is zero at every vertex, scales or a sample time that are not positive.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 6.2.1.
    """
    path = disturbance_channel(model, B, C, D, sample_time=sample_time)
    why = infinite_variance(path.D, path.sample_time)
    return least_gain(
        path,
        scales,
        lambda scaled, units: h2_norm_condition(scaled),
        _variance_and_P,
        noise=True,
        infinite=why,
        guess=guessed_of_variance,
        # The objective is nu, the square.
        tolerance=2 * tolerance,
    )


def variance_bound(channel: DisturbanceChannel, P: Floats) -> tuple[float, Floats]:
    """Return (nu, kappa P): the least multiple of P that holds at the vertices, and its bound nu.

    kappa = max_i lambda_max(C_i F_i^-1 C_i') with F_i of ``motion_of``; inf when V does not fall
    at a vertex.
    """
    B, C = channel.B, channel.C
    fall, _, _ = motion_of(channel, P)
    if np.linalg.eigvalsh(fall).min() <= 0:
        return np.inf, P
    variance = C @ np.linalg.solve(fall, C.transpose(0, 2, 1))
    kappa = float(np.linalg.eigvalsh((variance + variance.transpose(0, 2, 1)) / 2)[:, -1].max())
    direct = (channel.D**2).sum(axis=(1, 2))
    nu = float((kappa * np.einsum("ijk,jl,ilk->i", B, P, B) + direct).max())
    return nu, kappa * P


def infinite_variance(D: Floats, sample_time: float | None) -> str:
    """Return why the variance is infinite: a direct feed-through of white noise; empty if none.

    In discrete time it adds to the variance, and no more.

    ``D`` : (r, p, q), from disturbance to output.
    """
    through = np.abs(D).max(axis=(1, 2), initial=0.0)
    if sample_time is not None or not through.any():
        return ""
    vertex = int(np.argmax(through))
    return (
        f"vertex {vertex + 1} of {len(through)}: D is not zero (largest entry "
        f"{through[vertex]:.6g}), so white noise reaches the output directly, with infinite "
        "variance; put a filter into that path, or leave D out"
    )


def _variance_and_P(
    scaled: DisturbanceChannel, units: ChannelUnits, values: Mapping[str, Floats]
) -> tuple[float, Floats]:
    nu, P = variance_bound(scaled, values["P"][0])
    s = units.states
    gain = float(np.sqrt(nu * units.rate)) * units.output / units.disturbance
    return gain, units.output**2 / units.rate * P / s / s[:, None]
