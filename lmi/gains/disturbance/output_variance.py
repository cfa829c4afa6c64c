r"""Gains with the least variance of the output (H2 norm) under white noise.

With Q = P^-1, M_j = K_j Q, u = -sum_j h_j K_j x, Z_ij = C_i Q - D12_i M_j, G_ij and a scaling of
the first block row as in ``disturbed_plant``,

    continuous   Theta_ij = [ He(G_ij)   Z_ij' ]          [ W_i   E_i' ]
                            [ .          -I    ],         [ .     Q    ]  > 0

    discrete     Theta_ij = [ He(G_ij)   G_ij'   Z_ij' ]  [ W_i   E_i'   D11_i' ]
                            [ .          -Q      0     ]  [ .     Q      0      ]  > 0
                            [ .          .       -I    ], [ .     .      I      ]

and trace W_i < nu at every vertex, nu least: form "energy".  sum_ij h_i h_j Theta_ij < 0 gives
V' <= -|z|^2, or V(x+) - V(x) <= -|z|^2, without w for V = x' P x, and
W_i > E_i' P E_i (+ D11_i' D11_i).  So the mean of |z|^2 is at most nu for white noise, as in
``takagi.lmi.analysis.disturbance.energy_and_variance``, which says what that means where the
memberships vary.

Form "gramian" has in their place, with Q the bound on the covariance of x itself,

    continuous   Theta_ij = [ He(G_ij)   E_i ]            [ V_i   Z_ij ]
                            [ .          -I  ],           [ .     Q    ]  > 0

    discrete     Theta_ij = [ He(G_ij)   G_ij   E_i ]     [ V_i   Z_ij   D11_i ]
                            [ .          -Q     0   ]     [ .     Q      0     ]  > 0
                            [ .          .      -I  ],    [ .     .      I     ]

and trace V_i < nu.  From rest on E x x' <= Q, so E |z|^2 <= nu at every instant, not only in the
mean, for memberships that are functions of time: they may not depend on the noise, as they do where
they depend on a state that it moves.  Where E differs between rules nu is often less than in the
other form; where C does, it may be more.  Of one rule both are the H2 norm.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 6.2.1 and 7.4, for one gain; Scherer
and Weiland (2000), Linear Matrix Inequalities in Control; Tanaka and Wang (2001), the double sum;
Geromel, Peres and Bernussou (1991), SIAM J. Control and Optimization 29(2), the Gramian.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from takagi.lmi.analysis.disturbance.energy_and_variance import infinite_variance
from takagi.lmi.answer import Design
from takagi.lmi.argument_checks import number
from takagi.lmi.condition.statements import lmi_of
from takagi.lmi.condition.term import LMI, Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import He, added, block, identity, matrix
from takagi.lmi.gains.disturbance.design import asked_or_least
from takagi.lmi.gains.disturbance.disturbed_plant import (
    WEIGHT,
    Disturbed,
    DisturbedPlant,
    LoopBlocks,
    Performance,
    disturbed_condition,
    plant_of,
    sum_of,
)
from takagi.lmi.gains.disturbance.request import (
    DisturbanceCoordinates,
    DisturbanceRequest,
    Norm,
    disturbance_request,
    guessed_regulator,
)
from takagi.lmi.gains.disturbance.riccati_bound import regulated
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.gains.requirements.limits import GivenLimits, Limits
from takagi.lmi.gains.zero_gains import warns_of_zero_gains
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.models.errors import ModelError

# Noise that the guess of the covariance has in every direction, a share of what there is.
NOISE_EVERYWHERE = 1e-3
SOURCE = (
    "Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 6.2.1 and 7.4; Tanaka and Wang (2001)"
)


def h2_pdc_condition(
    model: Disturbed | DisturbedPlant,
    *,
    performance: Performance | None = None,
    form: str = "energy",
    relaxation: str = "wang-tanaka-griffin",
    decay_rate: float = 0.0,
    limits: Limits | None = None,
    sample_time: float | None = None,
) -> Condition:
    """Pose the module's LMIs and Q > 0; the objective is nu, the bound on the mean of |z|^2.

    Parameters
    ----------
    model, performance : the plant, as for ``h2_pdc``.
    form : "energy" or "gramian", as for ``h2_pdc``; V takes the place of W in the second.
    relaxation : how the double sum is made LMIs; see ``relaxations``.
    decay_rate : alpha in 1/s of the undisturbed loop, a double sum of its own where positive.
    limits : on the gains only; the size of V is that of the cost, so there is no ellipsoid whose
        level could be chosen.
    sample_time : T in s; None takes the model's own, continuous where it has none.

    Returns
    -------
    The condition in the model's coordinates as they are, with the unknowns ``Q``, ``M``, ``W``,
    ``nu`` and those of the relaxation.  Nothing is solved.

    Raises
    ------
    ModelError : shapes, entries that are not finite, no disturbance, no output, an unknown
        relaxation or form, a feed-through of white noise in continuous time, limits on the
        ellipsoid.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 6.2.1 and 7.4.
    """
    plant = plant_of(model, performance, sample_time)
    why = infinite_variance(plant.D11, plant.sample_time)
    if limits is not None and limits.level:
        why = "limits on the ellipsoid x' P x <= 1 do not go with a variance; give a gain bound"
    if why:
        raise ModelError(why)
    alpha = number("decay_rate", decay_rate)
    r, n, m = plant.B.shape
    Q = Unknown("Q", n, n, symmetric=True)
    M = gain_unknown(r, m, n, relaxation)
    name, size = ("V", plant.C.shape[1]) if _is_gramian(form) else ("W", plant.E.shape[2])
    W = Unknown(name, size, size, symmetric=True, count=r)
    nu = Unknown("nu", 1, 1, latex=r"\nu")
    sums: tuple[DoubleSum, ...]
    statements: tuple[LMI, ...]
    if name == "V":
        sums, statements = (_reached(plant, Q, M), _output(plant, Q, M, W)), (_total(W, nu),)
    else:
        sums, statements = (_loop(plant, Q, M),), (_entering(plant, Q, W), _total(W, nu))
    return disturbed_condition(
        plant,
        Q,
        M,
        sums,
        *statements,
        relaxation=relaxation,
        decay_rate=alpha,
        limits=limits,
        minimise=nu,
        unknowns=(W, nu),
        name="output variance" + (", Gramian" if name == "V" else ""),
        source=SOURCE,
    )


def _is_gramian(form: str) -> bool:
    if form not in ("energy", "gramian"):
        raise ModelError(f'form is {form!r}; "energy" or "gramian" is needed')
    return form == "gramian"


def _loop(plant: DisturbedPlant, Q: Unknown, M: Unknown) -> DoubleSum:
    loop, minus_one = LoopBlocks.of(plant, Q, M), -identity(plant.C.shape[1])
    if loop.next_G is None:
        return sum_of(plant, block([[He(loop.G), None], [loop.Z, minus_one]]))
    theta = block([[He(loop.G), None, None], [loop.next_G, -Q, 0], [loop.Z, 0, minus_one]])
    return sum_of(plant, theta)


def _reached(plant: DisturbedPlant, Q: Unknown, M: Unknown) -> DoubleSum:
    """Pose the double sum of form "gramian"."""
    loop, minus_one = LoopBlocks.of(plant, Q, M), -identity(plant.E.shape[2])
    if loop.next_G is None:
        return sum_of(plant, block([[He(loop.G), loop.entering], [None, minus_one]]))
    rows = [[He(loop.G), loop.next_G, loop.entering], [None, -Q, 0], [None, 0, minus_one]]
    return sum_of(plant, block(rows))


def _output(plant: DisturbedPlant, Q: Unknown, M: Unknown, V: Unknown) -> DoubleSum:
    """Pose V_i > Z_ij Q^-1 Z_ij', or V_i > Z_ij Q^-1 Z_ij' + D11_i D11_i' in discrete time."""
    Z, V_i = LoopBlocks.of(plant, Q, M).output, V.over("i")
    if plant.sample_time is None or not plant.D11.any():
        return sum_of(plant, block([[-V_i, Z], [None, -Q]]), "output")
    D11, one = matrix(plant.D11, "D^{11}_{i}", over="i"), identity(plant.D11.shape[2])
    return sum_of(plant, block([[-V_i, Z, D11], [None, -Q, 0], [None, 0, -one]]), "output")


def _entering(plant: DisturbedPlant, Q: Unknown, W: Unknown) -> LMI:
    """Pose W_i > E_i' P E_i, or W_i > E_i' P E_i + D11_i' D11_i in discrete time."""
    r = len(plant.E)
    W_i = W.members(np.arange(r), rf"{W.symbol}_{{i}}")
    E_i, D11_i = matrix(plant.E, "E_{i}"), matrix(plant.D11, "D^{11}_{i}")
    noise = block([[W_i, E_i.T], [None, Q]])
    if plant.sample_time is not None and plant.D11.any():
        one = identity(plant.D11.shape[1])
        noise = block([[W_i, E_i.T, D11_i.T], [None, Q, 0], [None, 0, one]])
    return lmi_of((noise >> 0).named("noise", rf"i = 1, \dots, {r}", weight=WEIGHT))


def _total(W: Unknown, nu: Unknown) -> LMI:
    """Pose nu > trace W_i."""
    r, q = W.count, W.rows
    rule, k = np.divmod(np.arange(r * q), q)
    e_k, W_i = matrix(np.eye(q)[k][:, :, None], "e_k"), W.members(rule, rf"{W.symbol}_{{i}}")
    total = added(e_k.T @ W_i @ e_k, rule, count=r, latex=r"\sum_k")
    return lmi_of((nu >> total).named("variance", rf"i = 1, \dots, {r}", weight=WEIGHT))


@warns_of_zero_gains
def h2_pdc(
    model: Disturbed,
    *,
    performance: Performance | None = None,
    form: str = "energy",
    relaxation: str = "wang-tanaka-griffin",
    decay_rate: float = 0.0,
    gain_bound: float | None = None,
    norm_below: float | None = None,
    tolerance: float = 1e-4,
    sample_time: float | None = None,
) -> Design:
    """Return gains K_i for u = -sum_i h_i K_i x with the least bound sqrt(nu), mean |z|^2 <= nu.

    For white noise w, every blend of the vertices, however fast it varies; nu bounds the energies
    of z after an impulse in each w_k at one instant, too.  What is meant where the memberships
    vary, and what is not bounded, is as for ``h2_norm``.  Of one rule sqrt(nu) is the least H2 norm
    that state feedback can reach, in continuous time without a program: see ``riccati_bound``.

    Parameters
    ----------
    model, performance : the plant, as for ``hinf_pdc``.
    form : "energy", as said, for memberships that depend on time and state, and for impulses; or
        "gramian", for white noise alone and memberships that do not depend on it: then nu bounds
        E |z|^2 at every instant from rest on.  See the module.
    relaxation : as for ``pdc``.
    decay_rate : alpha in 1/s that the undisturbed loop must also show.
    gain_bound : bound on the spectral norm of every K_i, by a sufficient condition.
    norm_below : sqrt(nu) of at most this is enough: the gains are those with the largest margin,
        and "infeasible" means that by this relaxation none reach it; None asks for the least.
    tolerance : how far above the least sqrt(nu) the gains may be, relative; see ``hinf_pdc``.
    sample_time : T in s where the model cannot say.

    Returns
    -------
    A ``Design``; its ``answer.gain`` is sqrt(nu), in units of z over units of w per sqrt(s), or per
    sample in discrete time, as for ``h2_norm``.  Every LMI was checked by eigenvalues with the
    gains as they are returned; V = x' P x falls by |z|^2 at least (of form "gramian" P is the
    inverse of the bound on the covariance of x).  Nothing is proved here.

    Not promised: as for ``hinf_pdc``.

    Raises
    ------
    ModelError : shapes, numbers, an unknown relaxation or form, no disturbance, no output, inputs
        that are dependent or do nothing, a vertex with an unstable mode that no input moves, a
        direct path from w to z in continuous time.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), sections 6.2.1 and 7.4; Tanaka and Wang
    (2001); Geromel, Peres and Bernussou (1991), form "gramian".
    """
    gramian = _is_gramian(form)
    task = disturbance_request(
        model,
        GivenLimits(gain_bound=gain_bound, sample_time=sample_time),
        Norm(partial(h2_pdc_condition, form=form), _deviation, _precision if gramian else _cost),
        performance=performance,
        relaxation=relaxation,
        decay_rate=decay_rate,
        tolerance=tolerance,
    )
    why = infinite_variance(task.plant.D11, task.plant.sample_time)
    if why:
        raise ModelError(why)
    # The objective is nu, the square.
    task = replace(task, tolerance=2 * task.tolerance, noise=True)
    if gramian:
        return asked_or_least(_about_covariance(task), norm_below)
    return asked_or_least(task, norm_below, lambda: regulated(task))


def _deviation(task: DisturbanceRequest, units: DisturbanceCoordinates, objective: float) -> float:
    return float(np.sqrt(objective * units.rate)) * units.output / units.disturbance


def _cost(task: DisturbanceRequest, units: DisturbanceCoordinates) -> float:
    """Return the unit of V: |z|^2 times seconds, or samples."""
    return units.output**2 / units.rate


def _precision(task: DisturbanceRequest, units: DisturbanceCoordinates) -> float:
    """Return the unit of V = x' P x where P is the inverse of a covariance."""
    return units.disturbance**2 / units.rate


def _about_covariance(task: DisturbanceRequest) -> DisturbanceRequest:
    """Return the task with the covariance under a regulator as the guess, not its cost."""
    from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

    regulator = guessed_regulator(task.plant)
    if regulator is None:
        return task
    loop = task.plant.fed_back(regulator.gains)
    A, E = loop.A.mean(axis=0), loop.E.mean(axis=0)
    spread = E @ E.T
    # Directions that no noise enters have a little of it, so that the guess can be inverted.
    size = np.linalg.inv(regulator.P)
    spread = spread + NOISE_EVERYWHERE * float(np.sum(E * (regulator.P @ E))) * size
    discrete = task.plant.sample_time is not None
    X = solve_discrete_lyapunov(A, spread) if discrete else solve_continuous_lyapunov(A, -spread)
    return replace(task, guess=np.linalg.inv(X), feedback=regulator.gains)
