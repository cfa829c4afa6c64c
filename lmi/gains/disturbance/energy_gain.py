r"""Gains with the least energy gain (H-infinity norm) from disturbance to output.

With Q = P^-1, M_j = K_j Q, u = -sum_j h_j K_j x, and Z_ij = C_i Q - D12_i M_j,

    continuous   Theta_ij = [ He(G_ij)   E_i        Z_ij'    ]
                            [ .          -gamma I   D11_i'   ]
                            [ .          .          -gamma I ]

    discrete     Theta_ij = [ He(G_ij)   E_i        G_ij'   Z_ij'    ]
                            [ .          -gamma I   E_i'    D11_i'   ]
                            [ .          .          -Q      0        ]
                            [ .          .          .       -gamma I ]

with G_ij and a scaling of the first block row as in ``disturbed_plant``.
sum_ij h_i h_j Theta_ij < 0 is, by a congruence with diag(P, I, ...) and a Schur complement, the
bounded real lemma: V', or V(x+) - V(x), is at most gamma |w|^2 - |z|^2 / gamma for V = x' P x.

Where limits are to hold on x' P x <= 1 the size of V matters.  Then the second block is -I and the
last -gamma^2 I, so V' <= |w|^2 - |z|^2 / gamma^2: from rest, x' P x <= 1 for all disturbances of an
energy of at most 1.

Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.5, for one gain; Tanaka and Wang
(2001), for the double sum.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from takagi.lmi.answer import Design
from takagi.lmi.argument_checks import number, positive_number
from takagi.lmi.condition.term import Condition
from takagi.lmi.condition.unknown import Unknown
from takagi.lmi.expressions.expression import He, block, identity, matrix
from takagi.lmi.gains.disturbance.design import asked_or_least
from takagi.lmi.gains.disturbance.disturbed_plant import (
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
)
from takagi.lmi.gains.requirements.closed_loop import gain_unknown
from takagi.lmi.gains.requirements.limits import GivenLimits, Limits
from takagi.lmi.gains.zero_gains import warns_of_zero_gains
from takagi.lmi.sums.double_sum import DoubleSum
from takagi.models.errors import ModelError

SOURCE = "Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.5; Tanaka and Wang (2001)"


def hinf_pdc_condition(
    model: Disturbed | DisturbedPlant,
    *,
    performance: Performance | None = None,
    relaxation: str = "wang-tanaka-griffin",
    decay_rate: float = 0.0,
    limits: Limits | None = None,
    sample_time: float | None = None,
) -> Condition:
    """Pose sum_ij h_i h_j Theta_ij < 0 and Q > 0; the objective is gamma.

    Parameters
    ----------
    model, performance : the plant, as for ``hinf_pdc``.
    relaxation : how the double sum is made LMIs; see ``relaxations``.
    decay_rate : alpha in 1/s of the undisturbed loop, a double sum of its own where positive.
    limits : on inputs, states and gains, in the model's coordinates; those on the ellipsoid hold
        for disturbances of an energy of at most 1, and the objective is then gamma^2.
    sample_time : T in s; None takes the model's own, continuous where it has none.

    Returns the condition in the model's coordinates as they are, with the unknowns ``Q``, ``M``,
    and ``gamma`` (``gamma2``, its square, with limits on the ellipsoid), and those of the
    relaxation.  Nothing is solved.

    Raises ModelError: shapes, entries that are not finite, no disturbance, no output, an unknown
    relaxation.
    """
    plant = plant_of(model, performance, sample_time)
    alpha = number("decay_rate", decay_rate)
    r, n, m = plant.B.shape
    Q = Unknown("Q", n, n, symmetric=True)
    M = gain_unknown(r, m, n, relaxation)
    level = limits is not None and limits.level
    name, symbol = ("gamma2", r"\gamma^2") if level else ("gamma", r"\gamma")
    gamma = Unknown(name, 1, 1, latex=symbol)
    return disturbed_condition(
        plant,
        Q,
        M,
        (_loop(plant, Q, M, gamma, unit_energy=level),),
        relaxation=relaxation,
        decay_rate=alpha,
        limits=limits,
        minimise=gamma,
        unknowns=(gamma,),
        name="energy gain",
        source=SOURCE,
    )


def _loop(
    plant: DisturbedPlant, Q: Unknown, M: Unknown, gamma: Unknown, *, unit_energy: bool
) -> DoubleSum:
    """Return the module's double sum; with -I for w, and -gamma I for z alone, on request."""
    q, p = plant.E.shape[2], plant.C.shape[1]
    loop = LoopBlocks.of(plant, Q, M)
    D11 = matrix(plant.D11, "D^{11}_{i}", over="i")
    w_bound = -identity(q) if unit_energy else -gamma * identity(q)
    z_bound = -gamma * identity(p)
    if loop.next_G is None:
        theta = block([[He(loop.G), loop.E, None], [None, w_bound, None], [loop.Z, D11, z_bound]])
    else:
        theta = block(
            [
                [He(loop.G), loop.entering, None, None],
                [None, w_bound, None, None],
                [loop.next_G, loop.E, -Q, 0],
                [loop.Z, D11, 0, z_bound],
            ]
        )
    return sum_of(plant, theta)


@warns_of_zero_gains
def hinf_pdc(
    model: Disturbed,
    *,
    performance: Performance | None = None,
    relaxation: str = "wang-tanaka-griffin",
    decay_rate: float = 0.0,
    disturbance_energy: float | None = None,
    input_limit: ArrayLike | None = None,
    initial_box: ArrayLike | None = None,
    state_box: ArrayLike | None = None,
    gain_bound: float | None = None,
    norm_below: float | None = None,
    tolerance: float = 1e-4,
    sample_time: float | None = None,
) -> Design:
    """Return gains K_i for u = -sum_i h_i K_i x with the least gamma in |z|_2 <= gamma |w|_2.

    For every blend of the vertices, however fast it varies, and x(0) = 0.  Of one rule it is the
    least H-infinity norm that state feedback can reach.

    Parameters
    ----------
    model : A (r, n, n), B (r, n, m), and the disturbance's E (r, n, q).  Without ``performance``
        z = C x + D u, and nothing leads from w to z directly.
    performance : (C1, D12, D11) of z = C1 x + D12 u + D11 w, (r, ., .) or (., .), where the
        model's y is not what is to be kept small; the last ones may be None or left out.
    relaxation : as for ``pdc``.
    decay_rate : alpha in 1/s that the undisturbed loop must also show.
    disturbance_energy : integral (or sum) of |w|^2 for which the limits below must hold.
    input_limit, initial_box, state_box : as for ``pdc``, on x' P x <= 1, which holds
        all states that disturbances of that energy reach from rest, and those that the undisturbed
        loop reaches from the initial box and ball.
    gain_bound : bound on the spectral norm of every K_i, by a sufficient condition.
    norm_below : gamma of at most this is enough: the gains are those with the largest margin, and
        "infeasible" means that by this relaxation none reach it; None asks for the least.
    tolerance : how far above the least gamma the gains may be, relative.  The least one is often
        approached only as the gains grow without bound; 1e-2 usually makes them a thousand times
        smaller.  Of many rules or states it may be a thousandth where less was asked for.
    sample_time : T in s where the model cannot say.  Energies are then sums over samples.

    Returns a ``Design``; its ``answer.gain`` is gamma in units of z over units of w, for which
    every LMI was checked by eigenvalues with the gains as they are returned; P is that of the LMIs.
    Without gains its answer says why none were found.  The answer's condition is posed in
    coordinates where a regulator's cost is |x|^2, so it has no ``coordinates``.  Nothing is proved
    here.

    Not promised: with one relaxation gamma may be larger, or there may be no gains, where a
    richer one does better; of several rules none reaches the least gamma of the nonlinear loop.

    Raises ModelError: shapes, numbers, an unknown relaxation, no disturbance, no output, inputs
    that are dependent or do nothing, a vertex with an unstable mode that no input moves, limits
    without an energy.

    Source: Boyd, El Ghaoui, Feron, Balakrishnan (1994), section 7.5; Tanaka and Wang (2001).
    """
    limits = GivenLimits(
        input_limit=input_limit,
        initial_box=initial_box,
        state_box=state_box,
        gain_bound=gain_bound,
        sample_time=sample_time,
    )
    task = disturbance_request(
        model,
        limits,
        Norm(hinf_pdc_condition, _energy_gain, _unit_of_V),
        performance=performance,
        relaxation=relaxation,
        decay_rate=decay_rate,
        tolerance=tolerance,
    )
    task = replace(
        task,
        energy=_energy(disturbance_energy, task.level),
        # The objective is gamma^2 where limits are to hold on the ellipsoid.
        tolerance=(2 if task.level else 1) * task.tolerance,
    )
    return asked_or_least(task, norm_below)


def _energy_gain(
    task: DisturbanceRequest, units: DisturbanceCoordinates, objective: float
) -> float:
    gamma = float(np.sqrt(objective)) if task.level else objective
    return gamma * units.output / units.disturbance


def _unit_of_V(task: DisturbanceRequest, units: DisturbanceCoordinates) -> float:
    """Return |z|^2 / gamma times seconds, or samples; 1 where limits fix the level of V."""
    return 1.0 if task.level else units.output * units.disturbance / units.rate


def _energy(energy: float | None, level: bool) -> float | None:
    if energy is None:
        if level:
            raise ModelError(
                "limits were given, but not the disturbance for which they must hold; give "
                "disturbance_energy, the integral (or sum) of |w|^2"
            )
        return None
    if not level:
        raise ModelError(
            "disturbance_energy was given, but no limit that must hold for it; give input_limit, "
            "state_box or initial_box, or leave it out"
        )
    return positive_number("disturbance_energy", energy)
